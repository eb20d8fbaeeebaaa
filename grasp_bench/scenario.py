"""Scenarios: all that defines a trial, read from ``scenarios/*.yaml`` and validated.

SI units throughout; angles in the file are degrees where the key says so, and a calibration's lengths are
millimetres where the key says so. Unknown keys and impossible values are refused, naming the file, the key
and what would be valid.
"""

from __future__ import annotations

import math
import types
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import yaml
from pydantic import Field, ValidationError, field_validator, model_validator

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.errors import ScenarioError, UnknownNameError
from grasp_bench.fields import Fraction, NonNegative, Positive, Section, Vector
from grasp_bench.paths import scenarios_dir
from grasp_bench.sensors import Sensor


class Camera(Section):
    """A fixed pinhole camera."""

    width: Annotated[int, Field(ge=64, le=4096)] = 640
    height: Annotated[int, Field(ge=64, le=4096)] = 480
    horizontal_fov_deg: Annotated[float, Field(gt=5, lt=170)] = 90.0
    position: Vector = (0.5, 0.0, 0.55)
    target: Vector = (0.5, 0.0, 0.0)
    image_up: Vector = (1.0, 0.0, 0.0)

    @property
    def intrinsics(self) -> Intrinsics:
        """Pinhole intrinsics."""
        return Intrinsics.from_fov(self.width, self.height, math.radians(self.horizontal_fov_deg))

    @property
    def pose(self) -> CameraPose:
        """Pose in the world."""
        return CameraPose.look_at(self.position, self.target, self.image_up)


class Calibration(Section):
    """How wrong the camera's pose is known: planner and predictors believe the nominal ``camera``.

    The true optical centre lies ``position_mm`` beside the nominal one, in a direction drawn uniformly from
    the sphere, and the true camera is turned by ``rotation_deg`` about an axis drawn alike. Both are drawn
    once for a whole run, as a robot is calibrated once, or anew for every trial.
    """

    position_mm: NonNegative = 0.0
    rotation_deg: Annotated[float, Field(ge=0, le=20)] = 0.0
    drawn: Literal["run", "trial"] = "trial"

    @property
    def exact(self) -> bool:
        """There is no error at all."""
        return self.position_mm == 0 and self.rotation_deg == 0


class Light(Section):
    """Lamps over the table; ``level`` 1 is the light of the reference scenario.

    It changes colours only: depth cameras bring their own light.
    """

    level: Positive = 1.0


class Objects(Section):
    """Which objects a run takes unless it names others, and what is changed in them.

    Attributes:
        names: object → why it is here; empty for all.
        mass_scale: factor on every mass and inertia.
    """

    names: dict[str, str] = Field(default_factory=dict)
    mass_scale: Positive = 1.0

    @field_validator("names", mode="before")
    @classmethod
    def _from_list(cls, given: Any) -> Any:
        return dict.fromkeys(given, "") if isinstance(given, list) else given


class Clutter(Section):
    """Many objects at once, taken away one after another; see :mod:`grasp_bench.clutter`.

    Attributes:
        fewest, most: how many objects an episode has, drawn uniformly.
        workspace: they are put down within ± this of the table's centre [m].
        failures: failed attempts in a row that end an episode.
    """

    fewest: Annotated[int, Field(ge=1, le=20)] = 5
    most: Annotated[int, Field(ge=1, le=20)] = 10
    workspace: tuple[NonNegative, NonNegative] = (0.13, 0.13)
    failures: Annotated[int, Field(ge=1, le=20)] = 3

    @model_validator(mode="after")
    def _ordered(self) -> Clutter:
        if self.fewest > self.most:
            raise ValueError("clutter.fewest must not be above clutter.most")
        return self


class Table(Section):
    """The table top at z = 0, and where objects are put."""

    size: tuple[Positive, Positive] = (0.7, 1.0)
    center: tuple[float, float] = (0.5, 0.0)
    friction: Positive = 0.5
    color: tuple[Fraction, Fraction, Fraction] = (0.62, 0.60, 0.57)
    workspace: tuple[NonNegative, NonNegative] = (0.06, 0.06)


class Settling(Section):
    """Bringing the object to rest before it is seen."""

    clearance: NonNegative = 0.001
    timeout: Positive = 3.0
    linear_speed: Positive = 0.002
    angular_speed: Positive = 0.05
    still_time: Positive = 0.1


class Gripper(Section):
    """The parallel gripper."""

    force: Annotated[float, Field(ge=20, le=235)] = 60.0
    closing_speed: Annotated[float, Field(gt=0, le=0.15)] = 0.075
    squeeze: Annotated[float, Field(ge=0, le=0.03)] = 0.025
    friction_scale: Positive = 1.0
    torsional_friction: NonNegative = 0.005
    settle_time: NonNegative = 0.25


class Shake(Section):
    """Shaking after the lift, along the three axes of the gripper; see :mod:`grasp_bench.motion.shake`."""

    acceleration: Annotated[float, Field(ge=0, le=20)] = 0.0
    frequency: Annotated[float, Field(ge=1, le=20)] = 4.0
    cycles: Annotated[int, Field(ge=1, le=100)] = 2


class Motion(Section):
    """Where and how fast the arm moves."""

    approach_height: Positive = 0.10
    insertion: Positive = 0.028
    table_clearance: Positive = 0.002
    speed_fraction: Annotated[float, Field(gt=0, le=1)] = 0.5
    approach_speed: Positive = 0.25
    lift_height: Positive = 0.20
    lift_speed: Positive = 0.25
    carry_to: Vector = (0.40, 0.25, 0.0)
    carry_speed: Positive = 0.50
    hold_time: Positive = 1.0
    collision_force: Positive = 40.0
    tcp_tolerance: Positive = 0.001
    tcp_tolerance_deg: Positive = 0.5
    shake: Shake = Shake()


class Success(Section):
    """When a trial is a success (paper, section 4.4)."""

    minimum_lift: Positive = 0.10


class Physics(Section):
    """Solver settings; see docs/design.md for the reasons."""

    timestep: Annotated[float, Field(gt=0, le=0.005)] = 0.002
    control_steps: Annotated[int, Field(ge=1, le=20)] = 2
    impratio: Positive = 10.0
    noslip_iterations: Annotated[int, Field(ge=0, le=20)] = 3
    max_hulls: Annotated[int, Field(ge=0)] = 0
    """Convex pieces an object has at most, neighbours being merged; 0 for all there are."""


class Scenario(Section):
    """A whole scenario."""

    name: str
    description: str = ""
    version: Literal[1] = 1
    camera: Camera = Camera()
    sensor: Sensor = Sensor()
    calibration: Calibration = Calibration()
    light: Light = Light()
    table: Table = Table()
    settling: Settling = Settling()
    gripper: Gripper = Gripper()
    motion: Motion = Motion()
    success: Success = Success()
    physics: Physics = Physics()
    objects: Objects = Objects()
    clutter: Clutter | None = None
    trial_timeout: Positive = 60.0

    @model_validator(mode="after")
    def _consistent(self) -> Scenario:
        if self.success.minimum_lift >= self.motion.lift_height:
            raise ValueError("success.minimum_lift must be below motion.lift_height")
        _ = self.camera.pose  # a degenerate view raises here
        return self


def scenario_names() -> list[str]:
    """Names of the shipped scenarios."""
    return sorted(p.stem for p in scenarios_dir().glob("*.yaml"))


def load_scenario(name: str) -> Scenario:
    """Scenario by shipped name or by path of a YAML file.

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
        if not path.is_file():
            raise ScenarioError(f"Scenario file {path} does not exist.")
        return path
    if name in scenario_names():
        return scenarios_dir() / f"{name}.yaml"
    raise UnknownNameError("scenario", name, scenario_names())


def _read(path: Path, below: tuple[Path, ...]) -> dict[str, Any]:
    """Content of a file, laid over what it extends; ``below`` are the files that led here."""
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{path} is not valid YAML: {error}") from error
    if not isinstance(content, dict):
        raise ScenarioError(f"{path} must hold keys and values, like scenarios/table4.yaml.")
    parent = content.pop("extends", None)
    if parent is None:
        return content
    if not isinstance(parent, str):
        raise ScenarioError(f"{path}: extends: must name a scenario or a YAML file (got {parent!r})")
    try:
        base = _find(parent, path.parent)
    except UnknownNameError as error:
        raise ScenarioError(f"{path}: extends: {error}") from error
    if base.resolve() in [p.resolve() for p in (path, *below)]:
        raise ScenarioError(f"{path}: extends: {parent} extends this file in turn")
    inherited = _read(base, (path, *below))
    return {k: v for k, v in inherited.items() if k not in ("name", "description")} | {
        k: _laid_over(inherited.get(k), v) for k, v in content.items()}


def _laid_over(inherited: Any, own: Any) -> Any:
    """A section's own values over the inherited ones."""
    if isinstance(inherited, dict) and isinstance(own, dict) and "preset" not in own:
        return inherited | own
    return own


def parse_scenario(content: dict[str, Any], origin: str) -> Scenario:
    """Validated scenario from plain data; ``origin`` is named in errors."""
    try:
        return Scenario.model_validate(content)
    except ValidationError as error:
        raise ScenarioError("\n".join(_explain(origin, e) for e in error.errors())) from error


def parameters(model: type[Section] = Scenario, prefix: str = "") -> list[str]:
    """Dotted names of all values of a scenario, such as ``gripper.force``."""
    names = []
    for key, field in model.model_fields.items():
        section = _section(field.annotation)
        names += [prefix + key] if section is None else parameters(section, f"{prefix}{key}.")
    return names


def with_value(scenario: Scenario, parameter: str, value: Any) -> Scenario:
    """The scenario with one value replaced, and named after it.

    Args:
        scenario: to change.
        parameter: dotted name, one of :func:`parameters`; a ``preset`` resets its whole section.
        value: plain data.

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


def _section(annotation: Any) -> type[Section] | None:
    """The section an annotation stands for, optional or not; None for a plain value."""
    options = get_args(annotation) if get_origin(annotation) in (Union, types.UnionType) else (annotation,)
    found = [o for o in options if isinstance(o, type) and issubclass(o, Section)]
    return found[0] if found else None


def _explain(origin: str, error: Any) -> str:
    keys = [str(k) for k in error["loc"]]
    where = ".".join(keys) or "scenario"
    if error["type"] == "extra_forbidden":
        model: Any = Scenario
        for key in keys[:-1]:
            model = _section(model.model_fields[key].annotation)
        return f"{origin}: {UnknownNameError(f'key in {where!r}:', keys[-1], model.model_fields)}"
    given = "" if isinstance(error["input"], dict) else f" (got {error['input']!r})"
    return f"{origin}: {where}: {error['msg']}{given}"
