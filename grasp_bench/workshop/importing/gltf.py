"""Binary glTF 2.0, read as its specification has it, as far as shape and base colour go.

trimesh's reader passes over normalised integers, further sets of texture coordinates, texture transforms,
vertex colours beside a material and instancing; each moves or colours the mesh, so the file's numbers are
decoded here (Khronos, *glTF 2.0 Specification*, sections 3.6 to 3.9; extensions as registered there).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from grasp_bench.system.arrays import Floats, Ints
from grasp_bench.workshop.importing.folder import RefusedError
from grasp_bench.workshop.importing.paint import PLAIN, Paint
from grasp_bench.workshop.importing.textures import Textures

MAX_NODES = 2000
"""Greatest number of nodes of a scene, and of copies that instancing makes."""
GLTF_EXTENSIONS = frozenset(
    """
    KHR_materials_unlit KHR_texture_transform KHR_materials_specular KHR_materials_pbrSpecularGlossiness
    KHR_mesh_quantization EXT_mesh_gpu_instancing EXT_texture_webp KHR_materials_ior
    KHR_materials_emissive_strength KHR_materials_clearcoat KHR_materials_sheen
    KHR_materials_transmission KHR_materials_volume
    """.split()
)
"""Extensions a GLB may require; others change what its data mean."""
INSTANCING = "EXT_mesh_gpu_instancing"
DTYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
TRIANGLES, STRIP, FAN = 4, 5, 6


@dataclass(frozen=True)
class Shape:
    """One primitive in the scene's coordinates: vertices (V, 3), faces (F, 3), its paint and node's name."""

    vertices: Floats
    faces: Ints
    paint: Paint
    name: str


def glb_parts(content: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the JSON and the binary part of a binary glTF 2.0 file.

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
    return tree, content[20 + json_length + 8 :]


def natural(value: Any) -> int:
    """Return ``value`` if it is a natural number.

    Raises:
        RefusedError: for anything else.
    """
    if not isinstance(value, int) or value < 0:
        raise RefusedError(f"the GLB holds {value!r} where a natural number belongs")
    return value


def nodes_shown(tree: dict[str, Any]) -> list[int]:
    """Return the roots of the scene that is shown by default; of all nodes where there is no scene."""
    nodes, scenes = tree.get("nodes", []), tree.get("scenes", [])
    if scenes:
        return list(scenes[tree.get("scene", 0)].get("nodes", ()))
    children = {c for n in nodes for c in n.get("children", ())}
    return [i for i in range(len(nodes)) if i not in children]


def read_glb(content: bytes, textures: Textures) -> list[Shape]:
    """Read the triangles of the default scene.

    Args:
        content: of a file whose counts and nodes have been checked.
        textures: reads the pictures, and takes notes of what is not read.

    Raises:
        RefusedError: for data that are not there.
    """
    return list(_Reader(*glb_parts(content), textures).shapes())


class _Reader:
    def __init__(self, tree: dict[str, Any], binary: bytes, textures: Textures) -> None:
        self.tree, self.binary, self.textures = tree, binary, textures

    def shapes(self) -> Iterator[Shape]:
        waiting = [(i, np.eye(4)) for i in reversed(nodes_shown(self.tree))]
        while waiting:
            index, above = waiting.pop()
            node = self.tree["nodes"][index]
            place = above @ _transform(node)
            waiting += [(c, place) for c in reversed(node.get("children", ()))]
            if "mesh" in node:
                mesh = self.tree["meshes"][node["mesh"]]
                name = str(node.get("name", mesh.get("name", f"node {index}")))[:60]
                for copy in self._copies(node):
                    for primitive in mesh["primitives"]:
                        shape = self._shape(primitive, place @ copy, name)
                        if shape is not None:
                            yield shape

    def _copies(self, node: dict[str, Any]) -> list[Floats]:
        """Return the transforms (4, 4) of a node's instances; the identity where it has none."""
        given = node.get("extensions", {}).get(INSTANCING, {}).get("attributes")
        if not given:
            return [np.eye(4)]
        read = {k: self._accessor(v) for k, v in given.items() if k in ("TRANSLATION", "ROTATION", "SCALE")}
        count = min((len(v) for v in read.values()), default=0)
        keys = {"TRANSLATION": "translation", "ROTATION": "rotation", "SCALE": "scale"}
        return [_transform({keys[k]: v[i].tolist() for k, v in read.items()}) for i in range(count)]

    def _shape(self, primitive: dict[str, Any], place: Floats, name: str) -> Shape | None:
        mode = primitive.get("mode", TRIANGLES)
        attributes = primitive.get("attributes", {})
        if mode not in (TRIANGLES, STRIP, FAN) or "POSITION" not in attributes:
            return None  # points and lines have no surface
        points = self._accessor(attributes["POSITION"])
        if "indices" in primitive:
            order = self._accessor(primitive["indices"], whole=True).ravel().astype(np.int64)
        else:
            order = np.arange(len(points))
        if len(order) and order.max() >= len(points):
            raise RefusedError("a face names a vertex that is not there")
        faces = _triangles(order, mode)
        if not len(faces):
            return None
        turned = faces[:, ::-1] if np.linalg.det(place[:3, :3]) < 0 else faces
        paint = self._paint(primitive, len(points), turned)
        return Shape(points @ place[:3, :3].T + place[:3, 3], turned, paint, name)

    def _accessor(self, index: Any, whole: bool = False) -> NDArray:
        """Return an accessor's rows, as float64 in its meaning; as they are stored if ``whole``."""
        accessor = self.tree["accessors"][natural(index)]
        dtype, columns = (
            np.dtype(DTYPES[accessor["componentType"]]).newbyteorder("<"),
            COLUMNS[accessor["type"]],
        )
        count = natural(accessor["count"])
        if "bufferView" in accessor:
            rows = self._rows(accessor["bufferView"], accessor.get("byteOffset", 0), count, columns, dtype)
        else:
            rows = np.zeros((count, columns), dtype)
        if "sparse" in accessor:
            sparse, rows = accessor["sparse"], rows.copy()
            several = natural(sparse["count"])
            where, values = sparse["indices"], sparse["values"]
            at = self._rows(
                where["bufferView"],
                where.get("byteOffset", 0),
                several,
                1,
                np.dtype(DTYPES[where["componentType"]]).newbyteorder("<"),
            )
            rows[at.ravel()] = self._rows(
                values["bufferView"], values.get("byteOffset", 0), several, columns, dtype
            )
        if whole:
            return rows
        found = rows.astype(float)
        if accessor.get("normalized") and dtype.kind in "iu":
            found = np.maximum(found / np.iinfo(dtype).max, -1.0)
        return found

    def _rows(self, view: Any, offset: Any, count: int, columns: int, dtype: np.dtype) -> NDArray:
        given = self.tree["bufferViews"][natural(view)]
        if natural(given.get("buffer", 0)):
            raise RefusedError(
                "the GLB refers to another file or address; export it with everything embedded"
            )
        width = columns * dtype.itemsize
        stride = natural(given.get("byteStride", width)) or width
        start = natural(given.get("byteOffset", 0)) + natural(offset)
        end = start + (count - 1) * stride + width
        if count and (
            stride < width or end > len(self.binary) or natural(offset) + end - start > given["byteLength"]
        ):
            raise RefusedError("the GLB's accessors promise more than the file holds")
        if not count:
            return np.zeros((0, columns), dtype)
        return np.ndarray((count, columns), dtype, self.binary, start, (stride, dtype.itemsize))

    def _paint(self, primitive: dict[str, Any], count: int, faces: Ints) -> Paint:
        materials = self.tree.get("materials", [])
        attributes = primitive.get("attributes", {})
        given = materials[natural(primitive["material"])] if "material" in primitive else None
        base, texture, factor, roughness = _base_colour(given or {})
        rgb = np.ones((len(faces), 3, 3)) * factor
        uv, which, pictures = np.full((len(faces), 3, 2), np.nan), np.full(len(faces), -1), []
        if texture is not None:
            picture = self._picture(texture)
            coordinates = self._coordinates(texture, attributes)
            if picture is not None and coordinates is not None and len(coordinates) == count:
                uv, which[:], pictures = coordinates[faces], 0, [picture]
        coloured = False
        if "COLOR_0" in attributes:
            colours = self._accessor(attributes["COLOR_0"])[:, :3]
            if len(colours) == count and np.isfinite(colours).all():
                rgb, coloured = rgb * colours[faces], True
        if not (base or pictures or coloured):
            rgb = np.ones((len(faces), 3, 3)) * PLAIN
        return Paint(np.clip(rgb, 0, 1), uv, which, pictures, roughness)

    def _coordinates(self, texture: dict[str, Any], attributes: dict[str, Any]) -> Floats | None:
        """Return texture coordinates (V, 2), transformed, origin at the picture's lower left."""
        change = texture.get("extensions", {}).get("KHR_texture_transform", {})
        key = f"TEXCOORD_{change.get('texCoord', texture.get('texCoord', 0))}"
        if key not in attributes:
            self.textures.say(f"the texture's coordinates {key} are missing: imported without it")
            return None
        uv = self._accessor(attributes[key])[:, :2]
        angle = float(change.get("rotation", 0))
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        uv = (uv * np.asarray(change.get("scale", (1, 1)), float)) @ turn.T
        uv = uv + np.asarray(change.get("offset", (0, 0)), float)
        if uv.shape[1] != 2 or not np.isfinite(uv).all():
            return None
        return np.column_stack([uv[:, 0], 1 - uv[:, 1]])

    def _picture(self, texture: dict[str, Any]) -> NDArray[np.uint8] | None:
        given = self.tree["textures"][natural(texture["index"])]
        choices = [given.get("extensions", {}).get("EXT_texture_webp", {}).get("source"), given.get("source")]
        for source in (c for c in choices if c is not None):
            image = self.tree["images"][natural(source)]
            name = str(image.get("name", "in the GLB"))[:60]
            if "bufferView" not in image:
                continue
            view = self.tree["bufferViews"][natural(image["bufferView"])]
            start = natural(view.get("byteOffset", 0))
            picture = self.textures.pixels(self.binary[start : start + natural(view["byteLength"])], name)
            if picture is not None:
                return picture
        if all(c is None for c in choices):
            named = ", ".join(sorted(given.get("extensions", {}))) or "no picture"
            self.textures.say(f"a texture is only there as {named}, which is not read: imported without it")
        return None


def _base_colour(material: dict[str, Any]) -> tuple[bool, dict[str, Any] | None, Floats, float]:
    """Return whether a material gives a colour; its texture, factor (3,) and roughness."""
    metal = material.get("pbrMetallicRoughness", {})
    gloss = material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness", {})
    if gloss.get("diffuseTexture") or gloss.get("diffuseFactor"):
        texture, factor = gloss.get("diffuseTexture"), gloss.get("diffuseFactor")
    else:
        texture, factor = metal.get("baseColorTexture"), metal.get("baseColorFactor")
    rough = metal.get("roughnessFactor")
    roughness = float(np.clip(rough, 0, 1)) if isinstance(rough, (int, float)) else 0.5
    rgb = np.ones(3) if factor is None else np.asarray(factor, float)[:3]
    return factor is not None, texture, rgb, roughness


def _transform(node: dict[str, Any]) -> Floats:
    """Return a node's own transform (4, 4)."""
    if "matrix" in node:
        return np.asarray(node["matrix"], float).reshape(4, 4).T
    result = np.eye(4)
    turn = np.asarray(node.get("rotation", (0, 0, 0, 1)), float)
    if not np.linalg.norm(turn) > 0:
        raise RefusedError("the GLB holds a rotation that is none")
    result[:3, :3] = Rotation.from_quat(turn).as_matrix() * np.asarray(node.get("scale", (1, 1, 1)), float)
    result[:3, 3] = node.get("translation", (0, 0, 0))
    return result


def _triangles(order: Ints, mode: int) -> Ints:
    """Return the faces (F, 3) that indices mean in a mode."""
    if mode == TRIANGLES:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    if len(order) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == FAN:
        return np.column_stack([np.full(len(order) - 2, order[0]), order[1:-1], order[2:]])
    faces = np.column_stack([order[:-2], order[1:-1], order[2:]])
    faces[1::2] = faces[1::2, [1, 0, 2]]
    return faces
