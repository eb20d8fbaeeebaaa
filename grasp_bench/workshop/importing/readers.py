"""OBJ, STL, PLY and GLB files as one mesh with its colours, each by its own loader.

Counts that a header promises are checked against the file's size before anything is allocated.
"""

from __future__ import annotations

import io
import json
import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image
from trimesh.resolvers import Resolver

from grasp_bench.system.arrays import Floats, Ints
from grasp_bench.workshop.importing.folder import Folder, RefusedError, check_image
from grasp_bench.workshop.importing.paint import Paint, join, read_paint

MAX_FACES = 1_000_000
MAX_VERTICES = 2_000_000
MAX_NODES = 2000
"""Greatest number of nodes of a GLB's scene."""
GLTF_EXTENSIONS = frozenset(
    {
        "KHR_materials_unlit",
        "KHR_texture_transform",
        "KHR_materials_specular",
        "KHR_materials_pbrSpecularGlossiness",
        "KHR_mesh_quantization",
    }
)
"""Extensions a GLB may require; others change what its data mean."""


@dataclass(frozen=True)
class Scan:
    """A mesh as it was read, in the file's units.

    Attributes:
        vertices: (V, 3), not merged.
        faces: (F, 3).
        paint: the colours of the faces.
        notes: what was missing or left out.
    """

    vertices: Floats
    faces: Ints
    paint: Paint
    notes: tuple[str, ...] = ()


class _Resolver(Resolver):
    """Gives trimesh what a mesh refers to, by way of :class:`Folder`; remembers what it refused."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.refused: list[str] = []
        self.missing: list[str] = []

    def get(self, key: str) -> bytes:
        name = key.strip()
        try:
            content = self.folder.read(name)
            if not name.lower().endswith(".mtl"):
                check_image(content, name)
        except RefusedError as error:
            self.refused.append(str(error))
            raise
        except FileNotFoundError:
            self.missing.append(name)
            raise
        return content

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
            f"{name}: the format {suffix or '(none)'} is not read; choose from {', '.join(sorted(CHECKS))}"
        )
    try:
        content = folder.read(name)
    except FileNotFoundError:
        raise RefusedError(f"{name} does not exist") from None
    CHECKS[suffix](content)
    resolver = _Resolver(folder)
    try:
        loaded = trimesh.load_scene(
            io.BytesIO(content), file_type=suffix[1:], resolver=resolver, process=False
        )
        meshes = [m for m in loaded.dump() if isinstance(m, trimesh.Trimesh)] if loaded.geometry else []
    except (RefusedError, MemoryError):
        raise
    except Exception as error:
        raise RefusedError(
            f"{Path(name).name} is not a readable {suffix[1:].upper()} file "
            f"({type(error).__name__}: {str(error)[:120]})"
        ) from error
    if resolver.refused:
        raise RefusedError(resolver.refused[0])
    meshes = [m for m in meshes if len(m.faces)]
    if not meshes:
        raise RefusedError(f"{Path(name).name} holds no faces")
    faces = sum(len(m.faces) for m in meshes)
    if faces > MAX_FACES or sum(len(m.vertices) for m in meshes) > MAX_VERTICES:
        raise RefusedError(
            f"{Path(name).name} has {faces} faces; at most {MAX_FACES} faces and "
            f"{MAX_VERTICES} vertices are read: simplify it first"
        )
    start = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    index = [np.asarray(m.faces, np.int64) + s for m, s in zip(meshes, start, strict=False)]
    for mesh in meshes:
        if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
            raise RefusedError(f"{Path(name).name}: a face names a vertex that is not there")
    vertices = np.concatenate([np.asarray(m.vertices, float) for m in meshes])
    joined = np.concatenate(index)
    if not np.isfinite(vertices[joined]).all():
        raise RefusedError(f"{Path(name).name}: coordinates are not finite numbers")
    notes = tuple(f"{missing} is missing: imported without it" for missing in dict.fromkeys(resolver.missing))
    return Scan(np.nan_to_num(vertices), joined, join([read_paint(m, picture) for m in meshes]), notes)


# ---------------------------------------------------------------- what headers promise


def _check_obj(content: bytes) -> None:
    faces = content.count(b"\nf ") + content.startswith(b"f ")
    if faces > MAX_FACES or content.count(b"\nv ") > MAX_VERTICES:
        raise RefusedError(
            f"{faces} faces; at most {MAX_FACES} faces and {MAX_VERTICES} vertices are read: "
            "simplify the mesh first"
        )
    if b"\0" in content:
        raise RefusedError("not an OBJ file: it holds binary data")
    if re.search(rb"^f[^\n]*[\s/](?:-\d|0+(?=[\s/]|$))", content, re.MULTILINE):
        raise RefusedError(
            "faces with indices of 0, or relative (negative) ones, are not read; export with "
            "absolute ones from 1"
        )


def _check_stl(content: bytes) -> None:
    if content.lstrip()[:5].lower() == b"solid" and b"facet" in content[:2000]:
        if content.count(b"endfacet") > MAX_FACES:
            raise RefusedError(f"more than {MAX_FACES} faces: simplify the mesh first")
        return
    if len(content) < 84:
        raise RefusedError("the STL file is truncated")
    count = struct.unpack("<I", content[80:84])[0]
    if 84 + 50 * count != len(content):
        raise RefusedError(
            f"the STL file promises {count} faces but its size is that of {(len(content) - 84) / 50:.1f}"
        )


def _check_ply(content: bytes) -> None:
    end = content.find(b"end_header")
    if not content.startswith(b"ply") or not 0 < end < 100_000:
        raise RefusedError("the PLY file has no header")
    for kind, number in re.findall(rb"^element\s+(\S+)\s+(\S+)\s*$", content[:end], re.MULTILINE):
        if not number.isdigit() or int(number) > min(MAX_VERTICES, len(content)):
            raise RefusedError(
                f"the PLY header promises {number[:20].decode(errors='replace')} "
                f"{kind[:20].decode(errors='replace')} elements, more than the file can hold "
                f"or are read ({MAX_VERTICES})"
            )


def _check_glb(content: bytes) -> None:
    tree = glb_tree(content)
    required = set(tree.get("extensionsRequired", ())) - GLTF_EXTENSIONS
    if required:
        raise RefusedError(
            f"the GLB requires the extension {sorted(required)[0]}, which is not read; export "
            "it without compression"
        )
    for key in ("buffers", "images"):
        for entry in tree.get(key, ()):
            if entry.get("uri") is not None:
                raise RefusedError(
                    "the GLB refers to another file or address; export it with everything embedded"
                )
    views, accessors = tree.get("bufferViews", []), tree.get("accessors", [])
    total = sum(_natural(a.get("count", 0)) for a in accessors)
    if total > 4 * (MAX_VERTICES + 3 * MAX_FACES) or any("bufferView" not in a for a in accessors):
        raise RefusedError("the GLB's accessors promise more than is read, or hold no data")
    json_length = struct.unpack("<I", content[12:16])[0]
    binary = content[20 + json_length + 8 :]
    for image in tree.get("images", ()):
        view = views[image["bufferView"]]
        start = _natural(view.get("byteOffset", 0))
        check_image(
            binary[start : start + _natural(view["byteLength"])], str(image.get("name", "in the GLB"))
        )
    _check_nodes(tree)


def _natural(value: Any) -> int:
    if not isinstance(value, int) or value < 0:
        raise RefusedError(f"the GLB holds {value!r} where a natural number belongs")
    return value


def glb_tree(content: bytes) -> dict[str, Any]:
    """Read the JSON part of a binary glTF 2.0 file.

    Raises:
        RefusedError: where it is not one.
    """
    try:
        magic, version, length, json_length, kind = struct.unpack("<4sIII4s", content[:20])
        if magic != b"glTF" or version != 2 or kind != b"JSON" or length != len(content):
            raise ValueError("not a whole binary glTF 2.0 file")
        tree = json.loads(content[20 : 20 + json_length])
        if not isinstance(tree, dict):
            raise ValueError("no glTF object")
    except (ValueError, struct.error, RecursionError) as error:
        raise RefusedError(f"the GLB cannot be read ({str(error)[:120]})") from error
    return tree


def _check_nodes(tree: dict[str, Any]) -> None:
    """Refuse nodes that form no trees, or that show too many faces together."""
    nodes, meshes, accessors = (tree.get(k, []) for k in ("nodes", "meshes", "accessors"))
    if len(nodes) > MAX_NODES:
        raise RefusedError(f"the GLB has {len(nodes)} nodes; at most {MAX_NODES} are read")
    children = [c for n in nodes for c in n.get("children", ())]
    if len(children) != len(set(children)):
        raise RefusedError("the GLB's nodes are not a tree")
    above = {c: i for i, n in enumerate(nodes) for c in n.get("children", ())}
    for node in range(len(nodes)):
        steps, at = 0, node
        while at in above:
            at, steps = above[at], steps + 1
            if steps > 100:
                raise RefusedError("the GLB's nodes are nested in a circle, or more than 100 deep")
    shown = 0
    for node in nodes:
        if "mesh" in node:
            for primitive in meshes[node["mesh"]]["primitives"]:
                which = primitive.get("indices", primitive.get("attributes", {}).get("POSITION"))
                shown += _natural(accessors[which]["count"]) // 3
    if shown > MAX_FACES:
        raise RefusedError(f"the GLB's scene shows {shown} faces; at most {MAX_FACES} are read")


def _guarded(check: Callable[[bytes], None]) -> Callable[[bytes], None]:
    """Let a header check run on anything at all: what trips it is not a file of that kind."""

    def run(content: bytes) -> None:
        try:
            check(content)
        except (KeyError, IndexError, TypeError, AttributeError, ValueError, struct.error) as error:
            raise RefusedError(
                f"the file's structure is broken ({type(error).__name__}: {str(error)[:80]})"
            ) from error

    return run


CHECKS = {
    ".obj": _guarded(_check_obj),
    ".stl": _guarded(_check_stl),
    ".ply": _guarded(_check_ply),
    ".glb": _guarded(_check_glb),
}
