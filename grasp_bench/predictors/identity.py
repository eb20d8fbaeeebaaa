"""What identifies a predictor of another's making, so that a run is not resumed with a changed one."""

from __future__ import annotations

import json
import shlex
import sys
from importlib.metadata import packages_distributions, version
from pathlib import Path
from typing import Any

from grasp_bench.errors import PredictorError
from grasp_bench.predictors import ADDRESSES, BUILT_IN, COMMAND, installed, load_predictor, python_path
from grasp_bench.system.integrity import check_manifest, missing_weights, sha256


def identify(name: str, predictor: object = None) -> dict[str, Any] | None:
    """Facts that change when the predictor changes; None for a shipped one, which its version identifies.

    Args:
        name: of the predictor.
        predictor: itself where it is made already; otherwise it is loaded, and closed again.

    Returns:
        ``files``: SHA-256 of each source file, by name (see :func:`sources`), or of those a command names;
        ``distribution``: name and version of the package it was installed with;
        ``info``: what it says of itself, or its server at ``GET /info``.

    Raises:
        PredictorError: as :func:`grasp_bench.predictors.load_predictor` does, or when ``info`` fails.
    """
    if predictor is not None:
        return describe(name, predictor)
    if _intact(name):
        return None
    predictor = load_predictor(name)
    try:
        if name in BUILT_IN:
            return None
        return describe(name, predictor)
    finally:
        close = getattr(predictor, "close", None)
        if callable(close):
            close()


def _intact(name: str) -> bool:
    """Whether a predictor has weights and they are those shipped: it then loads, as surely as if tried.

    Raises:
        AssetError: when they are missing or altered.
    """
    path = BUILT_IN[name].file if name in BUILT_IN else None
    if path is None:
        return False
    if not path.is_file():
        raise missing_weights(path)
    return check_manifest(path)


def describe(name: str, predictor: object) -> dict[str, Any]:
    """The facts of a predictor that is loaded."""
    facts: dict[str, Any] = {}
    if name in BUILT_IN:
        weights = BUILT_IN[name].file
        facts["software"] = f"grasp-bench {version('grasp-bench')}"
        if weights is not None:
            facts["files"] = {weights.name: sha256(weights)}
    elif name.startswith(COMMAND):
        program, *words = shlex.split(name.removeprefix(COMMAND))
        if not Path(program).is_absolute():  # an interpreter may differ between the machines of one run
            words.insert(0, program)
        facts["files"] = {word: sha256(Path(word)) for word in words if Path(word).is_file()}
    elif not name.startswith(ADDRESSES):
        module = python_path(name).partition(":")[0]
        facts["files"] = sources(module) | sources(type(predictor).__module__)
        distribution = _distribution(name, module)
        if distribution:
            facts["distribution"] = distribution
    info = getattr(predictor, "info", None)
    if callable(info):
        facts["info"] = _plain(name, info)
    return facts


def sources(module_name: str) -> dict[str, str]:
    """SHA-256 by relative path of a module's file and of the modules of its folder that it has imported.

    A module of an installed package does not count its neighbours: its distribution's version does. Nor do
    neighbours count whose files vanish meanwhile: libraries load modules from temporary folders.

    Raises:
        PredictorError: when the module's own file is missing, or one cannot be read.
    """
    module = sys.modules.get(module_name)
    file = getattr(module, "__file__", None)
    if file is None or module_name.partition(".")[0] in ("grasp_bench", "__main__"):
        return {}
    # A package's modules are its neighbours wherever among them the class is.
    folder = Path(file).resolve().parents[module_name.count(".") + (Path(file).name == "__init__.py")]
    own = Path(file).resolve()
    found = {own}
    for name, other in list(sys.modules.items()):
        path = str(getattr(other, "__file__", None))
        if (
            name.partition(".")[0] in ("grasp_bench", "__main__")
            or not path.endswith(".py")
            or ("site-packages" in path)
        ):
            continue
        neighbour = Path(path).resolve()
        if neighbour.is_relative_to(folder) and neighbour.is_file():  # some modules name no real file
            found.add(neighbour)
    hashes: dict[str, str] = {}
    for path in sorted(found):
        try:
            hashes[path.relative_to(folder).as_posix()] = sha256(path)
        except OSError as error:
            if path != own and isinstance(error, FileNotFoundError):
                continue
            raise PredictorError(
                f"{path}, a file of {module_name}, cannot be read ({error.strerror}); restore it."
            ) from error
    return hashes


def _plain(name: str, info: Any) -> Any:
    try:
        return json.loads(json.dumps(info(), allow_nan=False))
    except PredictorError:
        raise
    except (Exception, SystemExit) as error:  # a foreign method, or something that is not JSON
        raise PredictorError(
            f"info() of {name} failed or is not JSON: {type(error).__name__}: {error}"
        ) from error


def _distribution(name: str, module_name: str) -> str | None:
    """Name and version of the package that an installed module came with."""
    for point in installed().get(name, []):
        return f"{point.dist.name} {point.dist.version}" if point.dist else None
    file = getattr(sys.modules.get(module_name), "__file__", None) or ""
    if "site-packages" not in Path(file).parts:
        return None
    found = packages_distributions().get(module_name.partition(".")[0])
    return f"{found[0]} {version(found[0])}" if found else None
