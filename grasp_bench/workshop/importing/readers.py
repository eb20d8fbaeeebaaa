"""OBJ, STL, PLY, DAE and GLB files as one mesh with its colours, each by its own loader.

Counts that a header promises are checked against the file's size before anything is allocated.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from defusedxml import ElementTree as SafeTree
from PIL import Image
from trimesh.resolvers import Resolver

from grasp_bench.system.arrays import Floats, Ints
from grasp_bench.workshop.importing.folder import MESH_SUFFIXES, Folder, RefusedError
from grasp_bench.workshop.importing.gltf import Shape, read_glb
from grasp_bench.workshop.importing.headers import CHECKS, MAX_FACES, MAX_VERTICES, plain_stl
from grasp_bench.workshop.importing.obj_text import map_options, plain_obj, plain_text
from grasp_bench.workshop.importing.packing import packed
from grasp_bench.workshop.importing.paint import Paint, join, read_paint
from grasp_bench.workshop.importing.textures import Textures

GLTF = (".glb", ".gltf")
"""Formats that say themselves that they are in metres, with y up."""


@dataclass(frozen=True)
class Scan:
    """A mesh as it was read, in the file's units.

    Attributes:
        vertices: (V, 3), not merged.
        faces: (F, 3).
        paint: the colours of the faces.
        notes: what was missing, found elsewhere or left out.
        longest: name of the longest of several parts; empty where there is one.
        metres: the unit that the file declares [m]; None where it declares none.
        up: the upward axis that it declares; None where it declares none.
    """

    vertices: Floats
    faces: Ints
    paint: Paint
    notes: tuple[str, ...] = ()
    longest: str = ""
    metres: float | None = None
    up: str | None = None


class _Resolver(Resolver):
    """Gives trimesh what a mesh refers to, by way of :class:`Textures`."""

    def __init__(self, textures: Textures) -> None:
        self.textures = textures

    def get(self, key: str) -> bytes:
        name, _, _ = map_options(key.strip())
        content = self.textures.find(name)
        if content is None:
            raise FileNotFoundError(name)
        if name.lower().endswith(".mtl"):
            return plain_text(content)
        token = self.textures.token(content, name)
        if token is None:
            raise FileNotFoundError(name)
        return token

    def write(self, name: str, data: Any) -> None:
        raise NotImplementedError

    def namespaced(self, namespace: str) -> Resolver:
        raise NotImplementedError

    def keys(self) -> list[str]:
        return []


def read_mesh(folder: Folder, name: str, picture: Image.Image | None = None) -> Scan:
    """Read the mesh file ``name`` in ``folder``.

    Args:
        folder: the only folder that is read from.
        name: the file's name in the folder.
        picture: its texture, where the file has texture coordinates but names no picture.

    Raises:
        RefusedError: with the reason, for whatever cannot be read as a mesh.
    """
    suffix = Path(name).suffix.lower()
    if suffix not in CHECKS:
        raise RefusedError(
            f"{name}: the format {suffix or '(none)'} is not read; choose from {', '.join(MESH_SUFFIXES)}"
        )
    try:
        content = folder.read(name)
    except FileNotFoundError:
        raise RefusedError(f"{name} does not exist") from None
    textures = Textures(folder)
    notes: list[str] = []
    try:
        if suffix == ".obj":
            content = plain_obj(content, notes)
        elif suffix == ".stl":
            content = plain_stl(content, notes)
        elif suffix == ".gltf":
            content = packed(content, folder, textures)
        CHECKS[suffix](content)
        shapes = read_glb(content, textures) if suffix in GLTF else _load(content, suffix, textures, picture)
    except (RefusedError, MemoryError):
        raise
    except Exception as error:
        raise RefusedError(
            f"{Path(name).name} is not a readable {suffix[1:].upper()} file "
            f"({type(error).__name__}: {str(error)[:120]})"
        ) from error
    shapes = [s for s in shapes if len(s.faces)]
    if not shapes:
        raise RefusedError(f"{Path(name).name} holds no faces")
    faces = sum(len(s.faces) for s in shapes)
    if faces > MAX_FACES or sum(len(s.vertices) for s in shapes) > MAX_VERTICES:
        raise RefusedError(
            f"{Path(name).name} has {faces} faces; at most {MAX_FACES} faces and "
            f"{MAX_VERTICES} vertices are read: simplify it first"
        )
    start = np.cumsum([0, *(len(s.vertices) for s in shapes)])
    for shape in shapes:
        if shape.faces.min() < 0 or shape.faces.max() >= len(shape.vertices):
            raise RefusedError(f"{Path(name).name}: a face names a vertex that is not there")
    vertices = np.concatenate([s.vertices for s in shapes])
    joined = np.concatenate([s.faces + i for s, i in zip(shapes, start, strict=False)])
    if not np.isfinite(vertices[joined]).all():
        raise RefusedError(f"{Path(name).name}: coordinates are not finite numbers")
    longest = max(shapes, key=lambda s: float(np.ptp(s.vertices[s.faces].reshape(-1, 3), axis=0).max()))
    metres, up = (1.0, "y") if suffix in GLTF else _dae_asset(content) if suffix == ".dae" else (None, None)
    return Scan(
        np.nan_to_num(vertices),
        joined,
        join([s.paint for s in shapes]),
        (*notes, *textures.notes),
        longest.name if len(shapes) > 1 else "",
        metres,
        up,
    )


def _dae_asset(content: bytes) -> tuple[float | None, str | None]:
    """Return unit [m] and upward axis of a DAE file; those of the format, y, where it names none."""
    tree = SafeTree.fromstring(content, forbid_dtd=True)
    space = str(tree.tag).removesuffix("COLLADA")
    unit, axis = tree.find(f"{space}asset/{space}unit"), tree.findtext(f"{space}asset/{space}up_axis")
    try:
        metres = 1.0 if unit is None else float(unit.get("meter", "1"))
    except ValueError:
        metres = None
    if metres is not None and not 1e-9 < metres < 1e9:
        metres = None
    return metres, (axis or "Y_UP").strip()[:1].lower()


def _load(content: bytes, suffix: str, textures: Textures, picture: Image.Image | None) -> list[Shape]:
    """Read a file by trimesh; what it says of a scene's units is left to the importer."""
    loaded: Any = trimesh.load_scene(
        io.BytesIO(content), file_type=suffix[1:], resolver=_Resolver(textures), process=False
    )
    meshes = [m for m in loaded.dump() if isinstance(m, trimesh.Trimesh)] if loaded.geometry else []
    return [
        Shape(
            np.asarray(m.vertices, float),
            np.asarray(m.faces, np.int64),
            read_paint(m, textures, picture),
            str(m.metadata.get("name", f"part {i + 1}"))[:60],
        )
        for i, m in enumerate(meshes)
        if len(m.faces)
    ]
