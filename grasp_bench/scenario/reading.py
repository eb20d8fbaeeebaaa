"""Scenarios read from ``scenarios/*.yaml`` and validated.

Unknown keys and impossible values are refused, naming the file, the key and what would be valid.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from grasp_bench.errors import ScenarioError, UnknownNameError
from grasp_bench.scenario.faults import fault_lines, section_of
from grasp_bench.scenario.fields import Section
from grasp_bench.scenario.sections import VERSION, Clutter, Motion, Robot, Scenario, Table
from grasp_bench.system.files import read_text
from grasp_bench.system.paths import scenarios_dir
from grasp_bench.system.texts import legible, legible_all, shown
from grasp_bench.system.yaml_text import read_yaml


def scenario_names() -> list[str]:
    """Return the names of the shipped scenarios."""
    return sorted(p.stem for p in scenarios_dir().glob("*.yaml"))


def load_scenario(name: str) -> Scenario:
    """Load a scenario by shipped name or by path of a YAML file.

    A file may say ``extends: NAME`` (or a path beside it) and hold only what differs. A section with a
    ``preset`` starts from the preset, not from the extended file.

    Raises:
        UnknownNameError: for a name that is neither.
        ScenarioError: for a file with wrong syntax, keys or values.
    """
    path = _find(name)
    content = _read(path, ())
    return parse_scenario(content | {"name": content.get("name", path.stem)}, str(path))


def _find(name: str, folder: Path = Path()) -> Path:
    if Path(name).suffix in (".yaml", ".yml"):
        path = folder / name
        if "\0" in name or not path.exists():
            raise ScenarioError(f"Scenario file {legible(str(path))} does not exist.")
        return path
    if name in scenario_names():
        return scenarios_dir() / f"{name}.yaml"
    raise UnknownNameError("scenario", name, scenario_names())


def _read(path: Path, below: tuple[Path, ...]) -> dict[str, Any]:
    """Read a file, laid over what it extends; ``below`` are the files that led here."""
    try:
        content = legible_all(read_yaml(read_text(path)))
    except OSError as error:
        raise ScenarioError(f"{path} cannot be read ({error.strerror}).") from error
    except ValueError as error:
        raise ScenarioError(f"{path} is not valid YAML: {error}") from error
    if not isinstance(content, dict):
        raise ScenarioError(f"{path} must hold keys and values, like scenarios/table4.yaml.")
    _find_robot(content, path.parent)
    parent = content.pop("extends", None)
    if parent is None:
        return content
    if not isinstance(parent, str):
        raise ScenarioError(f"{path}: extends: must name a scenario or a YAML file (got {shown(parent)})")
    try:
        base = _find(parent, path.parent)
    except (UnknownNameError, ScenarioError) as error:
        raise ScenarioError(f"{path}: extends: {error}") from error
    if base.resolve() in [p.resolve() for p in (path, *below)]:
        raise ScenarioError(f"{path}: extends: {parent} extends this file in turn")
    inherited = _read(base, (path, *below))
    return {k: v for k, v in inherited.items() if k not in ("name", "description")} | {
        k: _laid_over(inherited.get(k), v) for k, v in content.items()
    }


def _find_robot(content: dict[str, Any], folder: Path) -> None:
    """Make paths of a robot's parts, which are relative to the file's ``folder``, absolute."""
    robot = content.get("robot")
    if not isinstance(robot, dict):
        return
    for key, name in robot.items():
        if isinstance(name, str) and ("/" in name or "\\" in name or name.startswith(".")):
            robot[key] = str((folder / name).resolve())


def _laid_over(inherited: Any, own: Any) -> Any:
    """Lay a section's own values over the inherited ones."""
    if isinstance(inherited, dict) and isinstance(own, dict) and "preset" not in own:
        return inherited | own
    return own


def check_current(scenario: Scenario) -> None:
    """Refuse to carry out trials of an earlier version of the definition.

    Raises:
        ScenarioError: saying what to do.
    """
    if scenario.version != VERSION:
        raise ScenarioError(
            f"Scenario {scenario.name!r} is of version {scenario.version} of the definition, and this "
            f"grasp-bench carries out version {VERSION}: its trials would not be the same. Set version: "
            f"{VERSION} for new runs; docs/definition.md says what changed."
        )


def parse_scenario(content: dict[str, Any], origin: str) -> Scenario:
    """Validate a scenario from plain data; ``origin`` is named in errors."""
    if not isinstance(content, dict) or not all(isinstance(key, str) for key in content):
        raise ScenarioError(f"{origin}: a scenario's keys must be text, such as name")
    try:
        return Scenario.model_validate(content)
    except ValidationError as error:
        raise ScenarioError("\n".join(fault_lines(error, origin, Scenario))) from error
    except (RecursionError, OverflowError) as error:
        raise ScenarioError(f"{origin}: a number or a list in it is too large") from error


def known_within_reach(scenario: Scenario) -> bool:
    """Return whether a test knows the arm to reach all places: robot and places are those of ``table4`` or
    ``clutter``, and no wrist moves the camera. Asking takes as long as all else that a run checks."""
    own, usual = scenario.motion, Motion()
    around = scenario.table if scenario.clutter is None else scenario.clutter
    return (
        scenario.robot == Robot()
        and scenario.camera.mount == "fixed"
        and scenario.table.center == Table().center
        and (own.lift_height, own.carry_to) == (usual.lift_height, usual.carry_to)
        and around.workspace in (Table().workspace, Clutter().workspace)
    )


def parameters(model: type[Section] = Scenario, prefix: str = "") -> list[str]:
    """Return the dotted names of all values of a scenario, such as ``gripper.force``."""
    names = []
    for key, field in model.model_fields.items():
        section = section_of(field.annotation)
        names += [prefix + key] if section is None else parameters(section, f"{prefix}{key}.")
    return names


def with_value(scenario: Scenario, parameter: str, value: Any) -> Scenario:
    """Return the scenario with one value replaced, and named after it.

    Args:
        parameter: dotted name, one of :func:`parameters`; a ``preset`` resets its whole section.
        value: the new value, as plain data.

    Raises:
        UnknownNameError: for a parameter that there is not.
        ScenarioError: for a value that is not valid.
    """
    valid = [n for n in parameters() if n not in ("name", "description", "version")]
    if parameter not in valid:
        raise UnknownNameError("scenario parameter", parameter, valid)
    content = scenario.model_dump(mode="json")
    *sections, key = parameter.split(".")
    place: dict[str, Any] = content
    for section in sections:
        place[section] = {} if key == "preset" else place[section] or {}
        place = place[section]
    place[key] = value
    content["name"] = f"{scenario.name}+{parameter}={value}"
    return parse_scenario(content, parameter)
