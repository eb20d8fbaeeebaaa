"""Places of the files that travel with the package: in a checkout or inside an installed wheel."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from grasp_bench.errors import AssetError

_PACKAGE = Path(__file__).resolve().parents[1]


def _shared(name: str) -> Path:
    for base in (_PACKAGE / "_data", _PACKAGE.parent):
        if (base / name).is_dir():
            return base / name
    raise AssetError(f"The folder {name}/ is missing beside or inside {_PACKAGE}; reinstall grasp-bench.")


def assets_dir() -> Path:
    """Return the folder with ``ec66/``, ``objects/`` and ``weights/``."""
    return _shared("assets")


def rivals_dirs() -> list[Path]:
    """Return the folders with weights of ``grasp-bench-rivals``: the checkout's, then the installed one's."""
    spec = find_spec("grasp_bench_rivals")
    installed = [Path(p) for p in (spec and spec.submodule_search_locations) or ()]
    packages = [_PACKAGE.parent / "rivals" / "grasp_bench_rivals", *installed]
    return [package / "weights" for package in packages if (package / "weights").is_dir()]


def scenarios_dir() -> Path:
    """Return the folder with the shipped scenario files."""
    return _shared("scenarios")


def constraints_file() -> Path:
    """Return the file with the exact versions of the tested stack, in pip's format."""
    for path in (_PACKAGE / "_data" / "constraints.txt", _PACKAGE.parent / "constraints.txt"):
        if path.is_file():
            return path
    raise AssetError(f"constraints.txt is missing beside or inside {_PACKAGE}; reinstall grasp-bench.")
