"""Which files of users' models are read: meshes in the model's folder, or in a URDF's ROS package."""

from __future__ import annotations

from pathlib import Path

MESH_KINDS = (".stl", ".obj", ".msh")
UP = 3
"""So many folders above a URDF are looked at for the ``package.xml`` of its package."""


def package_of(path: Path) -> Path | None:
    """Return the folder of the ROS package that a URDF lies in; None for other files, and outside of any."""
    if path.suffix.lower() != ".urdf":
        return None
    return next((f for f in path.resolve().parents[: UP + 1] if (f / "package.xml").is_file()), None)


def inside(found: Path, source: Path) -> bool:
    """Return whether a file lies in the folder of a model, or in the package that its URDF is part of."""
    roots = [source.resolve().parent, package_of(source)]
    return any(root is not None and found.resolve().is_relative_to(root) for root in roots)
