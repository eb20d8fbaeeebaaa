"""Meshes as programs and people really leave them: odd text, odd headers, colours, glTF's finer points."""

from __future__ import annotations

import base64
import io
import json
import re
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.exchange.stl import export_stl_ascii

from grasp_bench.workshop.importing import textures
from grasp_bench.workshop.importing.folder import Folder, RefusedError
from grasp_bench.workshop.importing.obj_text import map_options
from grasp_bench.workshop.importing.paint import CHUNK, Paint, bake
from grasp_bench.workshop.importing.readers import Scan, read_mesh

BOX: Any = trimesh.creation.box((0.06, 0.04, 0.03))
V = "".join(f"v {x:.5f} {y:.5f} {z:.5f}\n" for x, y, z in BOX.vertices)
F = "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in BOX.faces)
RED = (200, 30, 30)


def colours(scan: Scan) -> np.ndarray:
    """Mean colour (3,) of the surface after baking, 0 to 255, weighted by area."""
    parts = bake(scan.vertices, scan.faces, np.arange(len(scan.faces)), scan.paint)
    areas = np.array([trimesh.Trimesh(p.vertices, p.faces, process=False).area for p in parts])
    return 255 * (areas @ np.array([p.rgb for p in parts])) / areas.sum()


# ---------------------------------------------------------------- OBJ text


@pytest.mark.parametrize(
    "content",
    [
        b"\xef\xbb\xbf" + (V + F).encode(),
        (V + F).encode("utf-16"),
        (V + F).replace("\n", "\r\n").encode(),
        (V + F).replace("\n", "\r").encode(),
        (V + F).replace(".", ",").encode(),
        (V + "".join(f"f {a - 8} {b - 8} {c - 8}\n" for a, b, c in BOX.faces)).encode(),
        (V + "".join(f"f {a + 1} \\\n {b + 1} {c + 1}\n" for a, b, c in BOX.faces)).encode(),
        b"# gr\xf6\xdfe\n" + (V + F).encode(),
    ],
    ids=["bom", "utf16", "crlf", "cr", "comma", "relative", "continued", "latin1"],
)
def test_obj_text_of_every_program_gives_the_same_box(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.obj").write_bytes(content)
    scan = read_mesh(Folder(tmp_path), "a.obj")
    np.testing.assert_allclose(np.ptp(scan.vertices[scan.faces].reshape(-1, 3), axis=0), [0.06, 0.04, 0.03])
    assert trimesh.Trimesh(scan.vertices, scan.faces).volume == pytest.approx(0.06 * 0.04 * 0.03)


# ---------------------------------------------------------------- STL headers


def stl(count: int | None = None, tail: bytes = b"", header: bytes = b"") -> bytes:
    """The box as binary STL with a count, a tail and a header of choice."""
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *t.reshape(-1), 0) for t in BOX.triangles)
    return header.ljust(80, b" ") + struct.pack("<I", 12 if count is None else count) + rows + tail


@pytest.mark.parametrize(
    ("content", "note"),
    [
        (stl(tail=bytes(10)), "10 bytes after the last face"),
        (stl(count=0), "promises no faces, but the file holds 12"),
        (stl(header=b"solid facet exported binary"), ""),
        (export_stl_ascii(BOX).upper().encode(), ""),
        (b"\xef\xbb\xbf" + export_stl_ascii(BOX).encode(), ""),
        (export_stl_ascii(BOX).replace("\n", "\r\n").encode(), ""),
    ],
    ids=["trailing", "count zero", "solid binary", "upper case", "bom", "crlf"],
)
def test_stl_files_with_odd_headers_are_read_and_said(tmp_path: Path, content: bytes, note: str) -> None:
    (tmp_path / "a.stl").write_bytes(content)
    scan = read_mesh(Folder(tmp_path), "a.stl")
    assert len(scan.faces) == 12
    assert bool(note) == bool(scan.notes)
    assert note in " ".join(scan.notes)


# ---------------------------------------------------------------- textures of OBJ files


def textured(directory: Path, line: str, file: str = "wood.png") -> Scan:
    """The box with one material, whose ``map_Kd`` line and picture's place are given."""
    (directory / file).parent.mkdir(parents=True, exist_ok=True)
    Image.new("RGB", (16, 16), RED).save(directory / file)
    (directory / "a.mtl").write_text(f"newmtl m\nKd 1 1 1\nmap_Kd {line}\n")
    faces = "".join(f"f {a + 1}/1 {b + 1}/2 {c + 1}/3\n" for a, b, c in BOX.faces)
    (directory / "a.obj").write_text(f"mtllib a.mtl\nusemtl m\n{V}vt 0 0\nvt 1 0\nvt 1 1\n{faces}")
    return read_mesh(Folder(directory), "a.obj")


@pytest.mark.parametrize(
    ("line", "file"),
    [
        ("my wood.png", "my wood.png"),
        ("textures\\wood.png", "textures/wood.png"),
        ("C:\\Users\\me\\Desktop\\wood.png", "wood.png"),
        ("/home/me/wood.png", "wood.png"),
        ("file:///home/me/wood.png", "wood.png"),
        ("Wood.PNG", "wood.png"),
        ("wood.png", "deep/er/wood.png"),
        ("-s 1 1 1 -o 0 0 0 wood.png", "wood.png"),
        ("-bm 0.5 wood.png", "wood.png"),
        ("-clamp on -blendu off wood.png", "wood.png"),
        ("100%25wood.png", "100%25wood.png"),
        ("wood.tif", "wood.tif"),
        ("wood.gif", "wood.gif"),
    ],
)
def test_textures_are_found_whatever_the_line_says(tmp_path: Path, line: str, file: str) -> None:
    np.testing.assert_allclose(colours(textured(tmp_path, line, file)), RED, atol=1)


def test_the_options_of_a_texture_move_it(tmp_path: Path) -> None:
    name, scale, offset = map_options("-s 0.5 0.25 1 -o 0.1 -bm 2 my wood.png")
    assert name == "my wood.png"
    assert (scale.tolist(), offset.tolist()) == ([0.5, 0.25], [0.1, 0])
    scan = textured(tmp_path, "-s 0.5 0.5 -o 0.25 0.25 wood.png")
    uv = scan.paint.corner_uv
    assert (uv.min(), uv.max()) == (0.25, 0.75)


@pytest.mark.parametrize("content", [b"", b"not a picture", b"\x89PNG\r\n\x1a\n" + bytes(40), b"GIF89a"])
def test_a_broken_texture_is_a_note(tmp_path: Path, content: bytes) -> None:
    textured(tmp_path, "wood.png")
    (tmp_path / "wood.png").write_bytes(content)
    scan = read_mesh(Folder(tmp_path), "a.obj")
    assert len(scan.faces) == 12
    assert "imported without it" in scan.notes[0]


def test_several_pictures_of_one_name_are_none(tmp_path: Path) -> None:
    textured(tmp_path, "gone/wood.png", "one/wood.png")
    (tmp_path / "two").mkdir()
    Image.new("RGB", (16, 16), "blue").save(tmp_path / "two" / "wood.png")
    (note,) = read_mesh(Folder(tmp_path), "a.obj").notes
    assert "may be any of 2 files" in note


def test_a_texture_that_turns_up_later_is_asked_for(tmp_path: Path) -> None:
    textured(tmp_path, "wood.png")
    (tmp_path / "wood.png").unlink()
    folder = Folder(tmp_path)
    read_mesh(folder, "a.obj")
    assert "wood.png" in folder.asked


def test_pictures_have_one_limit_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(textures, "MAX_PIXELS", 600)
    found = textures.Textures(Folder(tmp_path))
    for i in range(3):
        content = io.BytesIO()
        Image.new("RGB", (16, 16), (i, 0, 0)).save(content, "PNG")
        assert (found.image(content.getvalue(), f"{i}.png") is None) == (i == 2)
    assert "2.png has 16 × 16 pixels after 512 of others" in found.notes[0]


def test_small_areas_of_colour_are_kept_and_specks_are_not() -> None:
    faces = BOX.faces
    rgb = np.zeros((12, 3, 3))
    rgb[:6, :, 0] = 0.9
    rgb[6:, :, 2] = 0.9
    paint = Paint(rgb, np.full((12, 3, 2), np.nan), np.full(12, -1), [])
    assert len(bake(BOX.vertices, faces, np.arange(12), paint)) == 2


def test_parts_are_small_enough_for_the_simulator() -> None:
    ball = trimesh.creation.icosphere(6, 0.03)
    count = len(ball.faces)
    paint = Paint(np.ones((count, 3, 3)), np.full((count, 3, 2), np.nan), np.full(count, -1), [])
    parts = bake(np.asarray(ball.vertices), np.asarray(ball.faces), np.arange(count), paint)
    assert sum(len(p.faces) for p in parts) == count == 81_920
    assert max(len(p.faces) for p in parts) <= CHUNK


# ---------------------------------------------------------------- GLB


class Glb:
    """A box as GLB, built number by number; its upper left texture quarter is red, the rest blue."""

    def __init__(self) -> None:
        box = BOX.copy()
        box.unmerge_vertices()
        self.points = box.vertices.astype("<f4")
        self.faces = box.faces.astype("<u2")
        self.uv = np.tile(np.array([[0.1, 0.1], [0.4, 0.1], [0.4, 0.4]], "<f4"), (12, 1))
        self.binary, self.views, self.accessors = b"", [], []
        picture = Image.new("RGB", (32, 32), (20, 20, 200))
        picture.paste((200, 20, 20), (0, 0, 16, 16))
        content = io.BytesIO()
        picture.save(content, "PNG")
        self.tree: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": "thing"}],
            "meshes": [
                {
                    "primitives": [
                        {
                            "attributes": {
                                "POSITION": self.add(self.points, "VEC3"),
                                "TEXCOORD_0": self.add(self.uv, "VEC2"),
                            },
                            "indices": self.add(self.faces.reshape(-1), "SCALAR"),
                            "material": 0,
                        }
                    ]
                }
            ],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "textures": [{"source": 0}],
            "images": [{"bufferView": self.view(content.getvalue()), "mimeType": "image/png"}],
        }

    def view(self, data: bytes) -> int:
        self.binary += bytes(-len(self.binary) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data
        return len(self.views) - 1

    def add(self, rows: np.ndarray, kind: str, **more: Any) -> int:
        code = {"f4": 5126, "u2": 5123, "i2": 5122, "u1": 5121}[rows.dtype.str[1:]]
        view = self.view(rows.tobytes())
        self.accessors.append(
            {"bufferView": view, "componentType": code, "count": len(rows), "type": kind, **more}
        )
        return len(self.accessors) - 1

    @property
    def primitive(self) -> dict[str, Any]:
        return self.tree["meshes"][0]["primitives"][0]

    @property
    def texture(self) -> dict[str, Any]:
        return self.tree["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]

    def read(self, directory: Path) -> Scan:
        tree = self.tree | {
            "bufferViews": self.views,
            "accessors": self.accessors,
            "buffers": [{"byteLength": len(self.binary)}],
        }
        text = json.dumps(tree).encode()
        text += b" " * (-len(text) % 4)
        rest = struct.pack("<I4s", len(self.binary), b"BIN\0") + self.binary
        head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON")
        (directory / "a.glb").write_bytes(head + text + rest)
        return read_mesh(Folder(directory), "a.glb")


def size(scan: Scan) -> list[float]:
    return np.round(np.ptp(scan.vertices[scan.faces].reshape(-1, 3), axis=0), 5).tolist()


def second_uv(glb: Glb) -> None:
    attributes = glb.primitive["attributes"]
    attributes["TEXCOORD_1"] = attributes["TEXCOORD_0"]
    attributes["TEXCOORD_0"] = glb.add(glb.uv + np.float32(0.5), "VEC2")
    glb.texture["texCoord"] = 1


def normalised_uv(glb: Glb) -> None:
    glb.primitive["attributes"]["TEXCOORD_0"] = glb.add(
        np.round(glb.uv * 65535).astype("<u2"), "VEC2", normalized=True
    )


def transformed_uv(glb: Glb) -> None:
    glb.primitive["attributes"]["TEXCOORD_0"] = glb.add(2 * glb.uv, "VEC2")
    glb.texture["extensions"] = {"KHR_texture_transform": {"scale": [0.5, 0.5]}}


def turned_uv(glb: Glb) -> None:
    # A quarter turn takes (u, v) to (v, −u), which the offset brings back into the red quarter.
    glb.texture["extensions"] = {"KHR_texture_transform": {"rotation": np.pi / 2, "offset": [0, 0.5]}}


def quantised(glb: Glb) -> None:
    whole = np.round(glb.points / glb.points.max() * 32767).astype("<i2")
    glb.primitive["attributes"]["POSITION"] = glb.add(whole, "VEC3", normalized=True)
    glb.tree["nodes"][0]["scale"] = [float(glb.points.max())] * 3
    glb.tree["extensionsRequired"] = ["KHR_mesh_quantization"]


def webp(glb: Glb) -> None:
    picture, content = Image.new("RGB", (8, 8), (200, 20, 20)), io.BytesIO()
    picture.save(content, "WEBP", lossless=True)
    glb.tree["images"].append({"bufferView": glb.view(content.getvalue()), "mimeType": "image/webp"})
    glb.tree["textures"][0] = {"extensions": {"EXT_texture_webp": {"source": 1}}}


def basis_beside_png(glb: Glb) -> None:
    view = glb.view(b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(200))
    glb.tree["images"].append({"bufferView": view, "mimeType": "image/ktx2"})
    glb.tree["textures"][0]["extensions"] = {"KHR_texture_basisu": {"source": 1}}


def idle_accessor(glb: Glb) -> None:
    glb.accessors.append({"componentType": 5126, "count": 4, "type": "VEC3"})


def mirrored(glb: Glb) -> None:
    glb.tree["nodes"][0]["scale"] = [-1, 1, 1]


def by_matrix(glb: Glb) -> None:
    glb.tree["nodes"] = [
        {"children": [1], "matrix": np.diag([0.001, 0.001, 0.001, 1]).T.ravel().tolist()},
        {"mesh": 0, "scale": [1000, 1000, 1000]},
    ]


def other_scene(glb: Glb) -> None:
    glb.tree["nodes"].append({"mesh": 0, "translation": [0.5, 0, 0]})
    glb.tree["scenes"].append({"nodes": [0, 1]})
    glb.tree["scene"] = 0


@pytest.mark.parametrize(
    "change",
    [
        lambda glb: None,
        second_uv,
        normalised_uv,
        transformed_uv,
        turned_uv,
        quantised,
        webp,
        basis_beside_png,
        idle_accessor,
        mirrored,
        by_matrix,
        other_scene,
    ],
)
def test_glb_files_mean_what_gltf_says(tmp_path: Path, change: Any) -> None:
    glb = Glb()
    change(glb)
    scan = glb.read(tmp_path)
    assert size(scan) == pytest.approx([0.06, 0.04, 0.03], abs=1e-5)
    assert trimesh.Trimesh(scan.vertices, scan.faces).volume == pytest.approx(0.06 * 0.04 * 0.03, rel=1e-3)
    np.testing.assert_allclose(colours(scan), (200, 20, 20), atol=2)


def test_vertex_colours_multiply_the_material(tmp_path: Path) -> None:
    glb = Glb()
    rows = np.tile(np.array([[0, 255, 0, 255]], np.uint8), (len(glb.points), 1))
    glb.primitive["attributes"]["COLOR_0"] = glb.add(rows, "VEC4", normalized=True)
    glb.tree["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 1, 1]}}]
    np.testing.assert_allclose(colours(glb.read(tmp_path)), (0, 127.5, 0), atol=2)


def test_instances_are_there(tmp_path: Path) -> None:
    glb = Glb()
    moves = glb.add(np.array([[-0.07, 0, 0], [0, 0, 0], [0.07, 0, 0]], "<f4"), "VEC3")
    extension = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moves}}}
    glb.tree["nodes"][0]["extensions"] = extension
    assert size(glb.read(tmp_path)) == pytest.approx([0.2, 0.04, 0.03], abs=1e-5)


@pytest.mark.parametrize("mode", [5, 6])
def test_strips_and_fans_are_triangles(tmp_path: Path, mode: int) -> None:
    glb = Glb()
    glb.primitive["mode"] = mode
    order = [0, 1, 2, 3, 0, 1] if mode == 5 else [0, 1, 2, 3, 1]
    points = np.array([[0, 0, 0], [0.05, 0, 0], [0.025, 0, 0.043], [0.025, 0.04, 0.014]], "<f4")
    glb.primitive["attributes"] = {"POSITION": glb.add(points, "VEC3")}
    glb.primitive["indices"] = glb.add(np.array(order, "<u2"), "SCALAR")
    scan = glb.read(tmp_path)
    assert len(scan.faces) == len(order) - 2


def test_points_and_lines_are_no_shape(tmp_path: Path) -> None:
    glb = Glb()
    glb.primitive["mode"] = 1
    with pytest.raises(RefusedError, match="no faces"):
        glb.read(tmp_path)


def test_a_texture_that_is_there_in_no_readable_form_is_named(tmp_path: Path) -> None:
    glb = Glb()
    glb.tree["textures"] = [{"extensions": {"KHR_texture_basisu": {"source": 0}}}]
    assert "KHR_texture_basisu" in glb.read(tmp_path).notes[0]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("bufferView", 99),
        ("byteOffset", 10**9),
        ("componentType", 1),
        ("type", "MAT4"),
        ("count", 10**5),
        ("sparse", {"count": 10**6, "indices": {"bufferView": 0, "componentType": 5123}, "values": {}}),
    ],
)
def test_accessors_that_lie_are_refused(tmp_path: Path, key: str, value: Any) -> None:
    glb = Glb()
    glb.accessors[glb.primitive["attributes"]["POSITION"]][key] = value
    with pytest.raises(RefusedError):
        glb.read(tmp_path)


# ---------------------------------------------------------------- DAE


def dae(unit: str = "0.01", axis: str = "Z_UP") -> str:
    """A box of 6 by 4 by 3 units."""
    points = " ".join(f"{100 * x:.6f}" for x in BOX.vertices.ravel())
    indices = " ".join(str(i) for i in BOX.faces.ravel())
    source = (
        f'<source id="s"><float_array id="a" count="24">{points}</float_array><technique_common>'
        '<accessor source="#a" count="8" stride="3"><param name="X" type="float"/><param name="Y" '
        'type="float"/><param name="Z" type="float"/></accessor></technique_common></source>'
    )
    mesh = (
        f'{source}<vertices id="v"><input semantic="POSITION" source="#s"/></vertices><triangles count="12">'
        f'<input semantic="VERTEX" source="#v" offset="0"/><p>{indices}</p></triangles>'
    )
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        f'<asset><unit meter="{unit}"/><up_axis>{axis}</up_axis></asset><library_geometries>'
        f'<geometry id="g"><mesh>{mesh}</mesh></geometry></library_geometries><library_visual_scenes>'
        '<visual_scene id="w"><node id="n"><instance_geometry url="#g"/></node></visual_scene>'
        '</library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>'
    )


def test_dae_files_say_their_unit_and_axis(tmp_path: Path) -> None:
    (tmp_path / "a.dae").write_text(dae())
    scan = read_mesh(Folder(tmp_path), "a.dae")
    assert (scan.metres, scan.up, len(scan.faces)) == (0.01, "z", 12)
    assert size(scan) == pytest.approx([6, 4, 3])


@pytest.mark.parametrize(
    ("content", "why"),
    [
        ("<COLLADA/>", "shows no geometry"),
        ("<svg/>", "not COLLADA"),
        ("<COLLADA", "not valid XML"),
        ('<!DOCTYPE x [<!ENTITY a "b">]><COLLADA>&a;</COLLADA>', "entities"),
        (dae().replace('<triangles count="12">', '<triangles count="99999999">'), "faces"),
        (dae().replace('url="#g"', 'url="http://localhost:1/g"'), "no faces|not a readable"),
    ],
)
def test_hostile_dae_files_are_refused(tmp_path: Path, content: str, why: str) -> None:
    (tmp_path / "a.dae").write_text(content)
    with pytest.raises(RefusedError, match=why):
        read_mesh(Folder(tmp_path), "a.dae")


# ---------------------------------------------------------------- glTF of text, with files beside it


def as_text(glb: Glb, directory: Path, inline: bool = False) -> dict[str, Any]:
    """Write ``a.gltf`` with its buffer and picture as files in a folder of their own, or within it."""
    image = glb.tree["images"][0]
    view = glb.views[image.pop("bufferView")]
    parts = {
        "parts/all%20of.bin": glb.binary,
        "parts/paint.png": glb.binary[view["byteOffset"] :][: view["byteLength"]],
    }
    for name, data in parts.items():
        path = directory / name.replace("%20", " ")
        path.parent.mkdir(exist_ok=True)
        if not inline:
            path.write_bytes(data)
    kind = "data:application/octet-stream;base64,"
    uris = [kind + base64.b64encode(d).decode() for d in parts.values()] if inline else list(parts)
    image["uri"] = uris[1]
    buffers = [{"byteLength": len(glb.binary), "uri": uris[0]}]
    tree = glb.tree | {"bufferViews": glb.views, "accessors": glb.accessors, "buffers": buffers}
    (directory / "a.gltf").write_text(json.dumps(tree))
    return tree


@pytest.mark.parametrize("inline", [False, True], ids=["files", "inline"])
def test_gltf_with_its_files_is_the_same_as_glb(tmp_path: Path, inline: bool) -> None:
    whole = Glb().read(tmp_path)
    as_text(Glb(), tmp_path, inline)
    scan = read_mesh(Folder(tmp_path), "a.gltf")
    np.testing.assert_array_equal(scan.vertices, whole.vertices)
    np.testing.assert_array_equal(scan.faces, whole.faces)
    np.testing.assert_allclose(colours(scan), (200, 20, 20), atol=2)
    assert (scan.metres, scan.up, scan.notes) == (whole.metres, whole.up, ())


def test_gltf_without_its_picture_is_imported_without_it(tmp_path: Path) -> None:
    as_text(Glb(), tmp_path)
    (tmp_path / "parts" / "paint.png").unlink()
    scan = read_mesh(Folder(tmp_path), "a.gltf")
    assert size(scan) == pytest.approx([0.06, 0.04, 0.03], abs=1e-5)
    assert "parts/paint.png is missing: imported without it" in scan.notes


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (
            lambda tree: tree["buffers"][0].update(uri="none.bin"),
            "none.bin, which the glTF names, is not there",
        ),
        (lambda tree: tree["buffers"][0].update(uri="../../etc/passwd"), "leads outside"),
        (lambda tree: tree["buffers"][0].update(uri="https://example.com/a.bin"), "is an address"),
        (lambda tree: tree["buffers"][0].update(byteLength=10**9), "and promises 1000000000"),
        (lambda tree: tree["buffers"][0].update(uri=None), "a buffer without a file"),
        (lambda tree: tree["buffers"][0].update(uri="data:x;base64,%%"), "not base64"),
        (lambda tree: tree["bufferViews"][0].update(buffer=7), "cannot be read"),
        (lambda tree: tree["bufferViews"][0].update(byteOffset="1"), "cannot be read"),
        (lambda tree: tree.pop("asset"), "no glTF object"),
    ],
)
def test_gltf_that_cannot_be_read_says_why(tmp_path: Path, change: Any, why: str) -> None:
    tree = as_text(Glb(), tmp_path)
    change(tree)
    (tmp_path / "a.gltf").write_text(json.dumps(tree))
    with pytest.raises(RefusedError, match=re.escape(why)):
        read_mesh(Folder(tmp_path), "a.gltf")


# ---------------------------------------------------------------- one picture for many materials


def sharing_glb(directory: Path) -> Scan:
    glb = Glb()
    view = glb.views[glb.tree["images"][0]["bufferView"]]
    content = glb.binary[view["byteOffset"] :][: view["byteLength"]]
    for i in range(1, 4):
        glb.tree["images"].append({"bufferView": glb.view(content), "mimeType": "image/png"})
        glb.tree["textures"].append({"source": i})
        glb.tree["materials"].append({"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}})
        glb.tree["meshes"][0]["primitives"].append(glb.primitive | {"material": i})
    return glb.read(directory)


def sharing_obj(directory: Path) -> Scan:
    Image.new("RGB", (32, 32), RED).save(directory / "p.png")
    (directory / "a.mtl").write_text("".join(f"newmtl m{i}\nmap_Kd p.png\n" for i in range(4)))
    lines = F.splitlines()
    faces = "".join(
        f"usemtl m{i}\n"
        + "".join(re.sub(r"(\d+)", r"\1/1", line) + "\n" for line in lines[3 * i : 3 * i + 3])
        for i in range(4)
    )
    (directory / "a.obj").write_text(f"mtllib a.mtl\n{V}vt 0.5 0.5\n{faces}")
    return read_mesh(Folder(directory), "a.obj")


@pytest.mark.parametrize("make", [sharing_glb, sharing_obj])
def test_materials_share_a_picture_in_memory(tmp_path: Path, make: Callable[[Path], Scan]) -> None:
    scan = make(tmp_path)
    assert len(scan.paint.pictures) == 4
    assert len({id(p) for p in scan.paint.pictures}) == 1
    np.testing.assert_allclose(colours(scan), RED if make is sharing_obj else (200, 20, 20), atol=2)
