"""Predictors from foreign code: how they are imported and made, and where they come from."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import sys
from importlib.metadata import packages_distributions, version
from pathlib import Path
from typing import Any

from grasp_bench.errors import PredictorError, UnknownNameError
from grasp_bench.predictors.guard import Guard
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.system.integrity import sha256
from grasp_bench.system.texts import shown


def make(path: str, name: str) -> Predictor:
    """Make the predictor at ``module:Class``, on Python's path or in the current folder.

    Args:
        path: leads to a class or a function that is called, with the arguments in parentheses after it, or to
            a predictor.
        name: what messages call it.

    Raises:
        PredictorError: for a module that cannot be imported, or what makes no predictor.
    """
    plain, positional, named = arguments_of(path)
    maker = resolve(plain)
    with Guard(f"{name} could not be made:"):
        is_maker = isinstance(maker, type) or not hasattr(maker, "predict")
        if not is_maker and plain != path:
            raise PredictorError(f"{plain} is a predictor already and takes no arguments")
        predictor: Any = maker(*positional, **named) if is_maker else maker
        if not callable(getattr(predictor, "predict", None)):
            raise PredictorError(f"{name} has no method predict(image: RgbdImage) -> list[Grasp]")
    return predictor


def arguments_of(path: str) -> tuple[str, list[Any], dict[str, Any]]:
    """Return ``module:Class`` of a path, and the literal arguments in parentheses after it.

    Raises:
        PredictorError: for arguments that are not literals, such as 224, 'text' or [1, 2].
    """
    plain, bracket, _ = path.partition("(")
    if not bracket:
        return path, [], {}
    try:
        call = ast.parse(f"f{path[len(plain) :]}", mode="eval").body
        if (
            not isinstance(call, ast.Call)
            or not isinstance(call.func, ast.Name)
            or any(k.arg is None for k in call.keywords)
        ):
            raise ValueError("not arguments")
        named = {str(k.arg): ast.literal_eval(k.value) for k in call.keywords}
        return plain, [ast.literal_eval(a) for a in call.args], named
    except (SyntaxError, ValueError, TypeError, RecursionError, MemoryError) as error:
        raise PredictorError(
            f"The arguments of {shown(path, 200)} must be literals, such as {plain}(size=224, name='a')."
        ) from error


def module_of(path: str) -> str:
    """Return the name of the module that ``module:Class`` or ``./file.py:Class`` names."""
    name = path.partition("(")[0].rpartition(":")[0]
    return Path(name).stem if name.endswith(".py") else name


def _from_file(file: Path) -> Any:
    """Import a module from its file, beside which it may import others."""
    if not file.is_file():
        raise PredictorError(f"There is no file {file}.")
    known = sys.modules.get(file.stem)
    if known is not None and Path(getattr(known, "__file__", None) or "").absolute() == file:
        return known
    if str(file.parent) not in sys.path:
        sys.path.append(str(file.parent))
    spec = importlib.util.spec_from_file_location(file.stem, file)
    if spec is None or spec.loader is None:
        raise PredictorError(f"{file} is no Python file.")
    module = importlib.util.module_from_spec(spec)
    sys.modules[file.stem] = module
    spec.loader.exec_module(module)
    return module


def resolve(path: str) -> Any:
    """Import what ``module:Class`` names, on Python's path or in the current folder.

    Raises:
        PredictorError: for a module that cannot be imported, or that has no such name.
    """
    module_name, _, attribute = path.rpartition(":")
    folder = str(Path.cwd())
    if folder not in sys.path:
        sys.path.append(folder)
    with Guard(f"The module {module_name!r} of predictor {path!r} cannot be imported:"):
        try:
            if module_name.endswith(".py"):
                module = _from_file(Path(module_name).absolute())
            else:
                module = importlib.import_module(module_name)
        except ModuleNotFoundError as error:
            if error.name != module_name.partition(".")[0]:
                raise
            raise PredictorError(
                f"The module {module_name!r} of predictor {path!r} was not found: neither in {folder} nor on "
                f"Python's path. A file elsewhere is named as ./folder/{module_name}.py:{attribute}."
            ) from error
        if not hasattr(module, attribute):
            names = [n for n in dir(module) if not n.startswith("_")]
            raise PredictorError(str(UnknownNameError(f"name in module {module_name!r}:", attribute, names)))
        return getattr(module, attribute)


def sources(module_name: str) -> dict[str, str]:
    """Return the SHA-256 by relative path of a module's file and of the modules of its folder that it has
    imported.

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


def distribution(module_name: str) -> str | None:
    """Return name and version of the package that an imported module was installed with."""
    file = getattr(sys.modules.get(module_name), "__file__", None) or ""
    if "site-packages" not in Path(file).parts:
        return None
    found = packages_distributions().get(module_name.partition(".")[0])
    return f"{found[0]} {version(found[0])}" if found else None
