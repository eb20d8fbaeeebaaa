"""Files that somebody else wrote, at their worst: refused with a reason, and nothing outside is read."""

from __future__ import annotations

import io
import json
import os
import re
import struct
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.workshop.importing import folder as folders
from grasp_bench.workshop.importing import headers
from grasp_bench.workshop.importing.body import Options
from grasp_bench.workshop.importing.discovery import find_objects
from grasp_bench.workshop.importing.folder import Folder, RefusedError
from grasp_bench.workshop.importing.importer import Job, import_all, import_shape
from grasp_bench.workshop.importing.jobs import plan_jobs, read_masses
from grasp_bench.workshop.importing.naming import clean_name
from grasp_bench.workshop.importing.readers import read_mesh
from grasp_bench.workshop.importing.robot_files import import_robot_file
from grasp_bench.workshop.importing.textures import Textures

BOX: Any = trimesh.creation.box((0.04, 0.05, 0.06))


def obj_text(extra: str = "") -> str:
    lines = [extra, *(f"v {x} {y} {z}" for x, y, z in BOX.vertices), "vt 0 0", "vt 1 0", "vt 0 1"]
    return "\n".join([*lines, "usemtl m", *(f"f {a}/1 {b}/2 {c}/3" for a, b, c in BOX.faces + 1)]) + "\n"


def png(width: int = 4, height: int = 4) -> bytes:
    buffer = io.BytesIO()
    Image.new("1", (width, height)).save(buffer, "PNG")
    return buffer.getvalue()


@pytest.fixture
def inside(tmp_path: Path) -> Path:
    """An object's folder, with a secret and a sound texture beside it."""
    (tmp_path / "secret.mtl").write_text("newmtl m\nmap_Kd secret.png\n")
    (tmp_path / "secret.png").write_bytes(png())
    (tmp_path / "box").mkdir()
    return tmp_path / "box"


def refused(directory: Path, name: str) -> str:
    with pytest.raises(RefusedError) as caught:
        read_mesh(Folder(directory), name)
    return str(caught.value)


# ---------------------------------------------------------------- references


@pytest.mark.parametrize(
    "library",
    [
        "../secret.mtl",
        "..\\secret.mtl",
        "%2e%2e/secret.mtl",
        "/etc/passwd",
        "~/secret.mtl",
        "file:///etc/passwd",
        "http://localhost:1/a.mtl",
        "//server/share/a.mtl",
        "C:\\secret.mtl",
    ],
)
def test_material_libraries_outside_are_not_read(inside: Path, library: str) -> None:
    (inside / "box.obj").write_text(obj_text(f"mtllib {library}"))
    assert re.search("outside|address", only_note(inside, "box.obj"))


def only_note(directory: Path, name: str) -> str:
    """The one note on a file's colours, without which it is read, and without reading anything else."""
    folder = Folder(directory)
    scan = read_mesh(folder, name)
    assert len(scan.faces) == 12
    assert not scan.paint.pictures
    assert all("secret" not in f for f in folder.read_files)
    (note,) = scan.notes
    return note


@pytest.mark.parametrize("texture", ["../secret.png", "/tmp/secret.png", "https://localhost:1/a.png"])
def test_textures_outside_are_not_read(inside: Path, texture: str) -> None:
    (inside / "box.mtl").write_text(f"newmtl m\nmap_Kd {texture}\n")
    (inside / "box.obj").write_text(obj_text("mtllib box.mtl"))
    assert "reference" in only_note(inside, "box.obj")


def test_links_that_lead_outside_are_refused(inside: Path) -> None:
    (inside / "a.png").symlink_to(inside.parent / "secret.png")
    (inside / "box.mtl").write_text("newmtl m\nmap_Kd a.png\n")
    (inside / "box.obj").write_text(obj_text("mtllib box.mtl"))
    assert "leads outside" in only_note(inside, "box.obj")
    (inside / "linked.obj").symlink_to("/etc/passwd")
    assert "leads outside" in refused(inside, "linked.obj")


def test_linked_folders_are_not_entered(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "other.obj").write_text(obj_text())
    (tmp_path / "mine" / "link").symlink_to(tmp_path / "theirs")
    (tmp_path / "mine" / "box.obj").write_text(obj_text())
    assert [n for n, _, _ in find_objects(tmp_path / "mine").objects] == ["box"]


def test_a_missing_texture_is_said_and_lived_without(inside: Path) -> None:
    (inside / "box.mtl").write_text("newmtl m\nmap_Kd gone.png\n")
    (inside / "box.obj").write_text(obj_text("mtllib box.mtl"))
    assert read_mesh(Folder(inside), "box.obj").notes == ("gone.png is missing: imported without it",)


# ---------------------------------------------------------------- kinds and sizes of files


def test_a_named_pipe_is_refused_without_waiting(inside: Path) -> None:
    os.mkfifo(inside / "pipe.obj")
    assert "not a plain file" in refused(inside, "pipe.obj")


@pytest.mark.parametrize(("magic", "kind"), [(b"\x1f\x8b\x08", "gzip"), (b"7z\xbc\xaf\x27", "7z")])
def test_archives_in_disguise_are_refused(inside: Path, magic: bytes, kind: str) -> None:
    (inside / "box.stl").write_bytes(magic + bytes(100))
    assert f"is a {kind} archive; unpack it" in refused(inside, "box.stl")


def test_zip_archives_are_refused_by_name_and_content(inside: Path) -> None:
    with zipfile.ZipFile(inside / "box.zip", "w") as archive:
        archive.writestr("../escaped.obj", obj_text())
    with pytest.raises(RefusedError, match=r"\.zip is not read; choose from \.glb.*unpack archives first"):
        find_objects(inside / "box.zip")
    (inside / "box.zip").rename(inside / "box.obj")
    assert "ZIP archive" in refused(inside, "box.obj")
    assert not (inside.parent / "escaped.obj").exists()


def test_large_files_are_not_read(inside: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (inside / "box.obj").write_text(obj_text())
    monkeypatch.setattr(folders, "MAX_FILE", 100)
    assert "are read" in refused(inside, "box.obj")


def test_too_many_faces_are_refused_before_parsing(inside: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (inside / "box.obj").write_text(obj_text())
    monkeypatch.setattr(headers, "MAX_FACES", 5)
    assert "12 faces; at most 5 faces" in refused(inside, "box.obj")


def test_picture_bombs_are_refused_by_their_header(inside: Path) -> None:
    header = b"IHDR" + struct.pack(">IIBBBBB", 60_000, 60_000, 8, 2, 0, 0, 0)
    data = b"IDAT" + bytes(8)
    bomb = b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(chunk) - 4) + chunk + struct.pack(">I", zlib.crc32(chunk))
        for chunk in (header, data)
    )
    textures = Textures(Folder(inside))
    assert textures.image(bomb, "bomb.png") is None
    assert "too large" in textures.notes[0]
    (inside / "bomb.png").write_bytes(png(9000, 8000))
    (inside / "box.mtl").write_text("newmtl m\nmap_Kd bomb.png\n")
    (inside / "box.obj").write_text(obj_text("mtllib box.mtl"))
    assert "9000 × 8000 pixels" in only_note(inside, "box.obj")


def test_a_texture_that_is_no_picture_is_a_note(inside: Path) -> None:
    (inside / "a.png").write_text("%!PS postscript is not read")
    (inside / "box.mtl").write_text("newmtl m\nmap_Kd a.png\n")
    (inside / "box.obj").write_text(obj_text("mtllib box.mtl"))
    assert "not a readable picture" in only_note(inside, "box.obj")


# ---------------------------------------------------------------- contents


@pytest.mark.parametrize(
    ("content", "why"),
    [
        ("", "is empty"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no faces"),
        ("v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", "not finite|not a readable"),
        ("v 0 0 0\nv 1 0 0\nv 1e999 1 0\nf 1 2 3\n", "not finite|not a readable"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "not there|not a readable"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "index of 0"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 -2 -1\n", "before the first"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", "not there|not a readable"),
        ("v 0 0 0\nv one two three\nf 1 2 3\n", "not a readable|no faces"),
        ("v 0 0 0\n\0\0\0\nf 1 1 1\n", "binary"),
    ],
)
def test_broken_obj_files_are_refused(inside: Path, content: str, why: str) -> None:
    (inside / "box.obj").write_text(content)
    assert re.search(why, refused(inside, "box.obj"))


@pytest.mark.parametrize(
    "content",
    [
        bytes(80) + struct.pack("<I", 4_000_000_000) + bytes(50),
        bytes(40),
        bytes(84) + b"x" * 49,
        BOX.export(file_type="stl")[:-20],
    ],
)
def test_stl_files_that_promise_what_they_do_not_hold_are_refused(inside: Path, content: bytes) -> None:
    (inside / "box.stl").write_bytes(content)
    assert "STL file" in refused(inside, "box.stl")


@pytest.mark.parametrize(
    ("header", "why"),
    [
        ("ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nend_header\n", "promises"),
        ("ply\nformat binary_little_endian 1.0\nelement vertex -3\nend_header\n", "promises"),
        ("ply\nformat ascii 1.0\nelement face 1e9\nend_header\n", "promises"),
        ("ply\nformat ascii 1.0\n", "no header"),
        ("plain text", "no header"),
    ],
)
def test_ply_files_that_promise_what_they_do_not_hold_are_refused(
    inside: Path, header: str, why: str
) -> None:
    (inside / "box.ply").write_text(header + "0 0 0\n")
    assert why in refused(inside, "box.ply")


def glb(change: dict | None = None, raw: bytes | None = None) -> bytes:
    """A box as GLB, top-level keys of its JSON replaced."""
    whole = BOX.export(file_type="glb")
    length = struct.unpack("<I", whole[12:16])[0]
    tree = json.loads(whole[20 : 20 + length]) | (change or {})
    text = raw if raw is not None else json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    rest = whole[20 + length :]
    return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON") + text + rest


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"buffers": [{"uri": "../secret.bin", "byteLength": 10}]}, "another file"),
        ({"buffers": [{"uri": "http://localhost:1/a.bin", "byteLength": 10}]}, "another file"),
        ({"images": [{"uri": "file:///etc/passwd"}]}, "another file"),
        ({"accessors": [{"count": 10**12, "componentType": 5126, "type": "VEC3"}]}, "accessors"),
        (
            {"accessors": [{"count": 10**12, "bufferView": 0, "componentType": 5126, "type": "VEC3"}]},
            "accessors",
        ),
        ({"accessors": [{"count": -1, "bufferView": 0}]}, "natural number"),
        ({"nodes": [{"children": [1]}, {"children": [0]}]}, "circle"),
        ({"nodes": [{"children": [1, 1]}, {"mesh": 0}]}, "not a tree"),
        ({"nodes": [{"mesh": 0}] * 3000}, "3000 nodes"),
        ({"nodes": [{"mesh": 5}]}, "structure is broken"),
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "KHR_draco"),
        ({"bufferViews": 3}, "structure is broken|not a readable"),
    ],
)
def test_hostile_glb_files_are_refused(inside: Path, change: dict, why: str) -> None:
    (inside / "box.glb").write_bytes(glb(change))
    assert re.search(why, refused(inside, "box.glb"))


@pytest.mark.parametrize(
    "content",
    [b"glTF", glb()[:-10], glb(raw=b"not json"), glb(raw=b"[1]"), glb(raw=b"[" * 100_000), b"x" * 100],
)
def test_what_is_no_glb_is_refused(inside: Path, content: bytes) -> None:
    (inside / "box.glb").write_bytes(content)
    assert "cannot be read" in refused(inside, "box.glb")


def test_a_scene_that_shows_one_mesh_too_often_is_refused(
    inside: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(headers, "MAX_FACES", 100)
    (inside / "box.glb").write_bytes(glb({"nodes": [{"mesh": 0}] * 20}))
    assert "shows 240 faces" in refused(inside, "box.glb")


def test_a_sound_glb_is_read(inside: Path) -> None:
    (inside / "box.glb").write_bytes(glb())
    assert len(read_mesh(Folder(inside), "box.glb").faces) == 12


# ---------------------------------------------------------------- shapes and sizes


def shape_refused(directory: Path, mesh: trimesh.Trimesh, **options: object) -> str:
    mesh.export(directory / "thing.stl")
    with pytest.raises(RefusedError) as caught:
        import_shape(
            Job("thing", directory / "thing.stl", directory, Options(**options)),  # type: ignore[arg-type]
            directory / "out",
        )
    assert not (directory / "out" / "thing" / "shape.json").exists()
    return str(caught.value)


def test_sizes_that_make_no_sense_are_refused(inside: Path) -> None:
    assert "in any of m, cm, mm" in shape_refused(inside, trimesh.creation.box((3000, 1000, 1000)))
    assert "in any of m, cm, mm" in shape_refused(inside, trimesh.creation.box((1e-4, 1e-4, 1e-4)))
    assert "with --units m" in shape_refused(inside, trimesh.creation.box((40, 50, 60)), units="m")


def test_shapes_without_volume_are_refused(inside: Path) -> None:
    sheet = trimesh.Trimesh(
        [[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0], [0.05, 0.05, 0]],
        [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
        process=False,
    )
    assert "flat" in shape_refused(inside, sheet)
    point = trimesh.Trimesh(np.zeros((4, 3)), [[0, 1, 2], [0, 2, 3]], process=False)
    assert "one place" in shape_refused(inside, point)
    line = trimesh.Trimesh(
        [[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0], [0.3, 0, 0]],
        [[0, 1, 2], [1, 2, 3], [0, 1, 3], [0, 2, 3]],
        process=False,
    )
    assert shape_refused(inside, line)


def test_masses_that_cannot_be_lifted_are_refused(inside: Path) -> None:
    block = trimesh.creation.box((0.2, 0.2, 0.2))
    assert "give --mass" in shape_refused(inside, block, density=8000.0)
    assert "give --mass" in shape_refused(inside, trimesh.creation.box((0.006, 0.006, 0.006)), density=1.0)


def test_one_bad_mesh_fails_alone(inside: Path) -> None:
    (inside / "bad.obj").write_text("v 0 0 0\nf 1 1 1\n")
    out = inside / "out"
    reports = list(import_all([Job("bad", inside / "bad.obj", inside, Options())], out, 1, 60))
    assert [r.status for r in reports] == ["failed"]
    assert reports[0].why
    assert not (out / "bad" / "object.json").exists()


# ---------------------------------------------------------------- robot descriptions


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><mujoco>&b;</mujoco>', "entities"),
        ('<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]><robot>&a;</robot>', "entities"),
        ('<mujoco><include file="../other.xml"/></mujoco>', "<include>"),
        ('<mujoco><extension><plugin plugin="x"/></extension></mujoco>', "<extension>"),
        ('<mujoco><asset><mesh name="m" file="../secret.obj"/></asset></mujoco>', "leads outside"),
        (
            '<mujoco><compiler meshdir="/etc"/><asset><mesh name="m" file="passwd"/></asset></mujoco>',
            "outside",
        ),
        (
            '<mujoco><compiler meshdir=".."/><asset><mesh name="m" file="secret.obj"/></asset></mujoco>',
            "outside",
        ),
        (
            '<mujoco><asset><texture name="t" type="2d" file="../secret.png"/><material name="m" '
            'texture="t"/></asset></mujoco>',
            "no shape",
        ),
        ('<mujoco><asset><hfield name="h" file="h.png" size="1 1 1 1"/></asset></mujoco>', "<hfield>"),
        (
            '<robot name="r"><link name="a"><collision><geometry><mesh filename="package://x/../../secret.obj"/>'
            "</geometry></collision></link></robot>",
            "outside",
        ),
        (
            '<robot name="r"><link name="a"><collision><geometry><mesh filename="http://localhost:1/a.obj"/>'
            "</geometry></collision></link></robot>",
            "address",
        ),
        (
            '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent '
            'link="a"/><child link="b"/></joint></robot>',
            "joint",
        ),
        (
            '<mujoco><worldbody><body><joint type="hinge"/><geom size=".01"/></body></worldbody></mujoco>',
            "joint",
        ),
        (
            '<mujoco><worldbody><body><geom size=".01"/></body><body><geom size=".01"/></body></worldbody>'
            "</mujoco>",
            "2 bodies",
        ),
        (
            '<mujoco><worldbody><body><geom type="mesh" mesh="gone"/></body></worldbody></mujoco>',
            "does not compile",
        ),
        ("<mujoco><worldbody/></mujoco>", "no shape"),
        ('<svg xmlns="http://www.w3.org/2000/svg"/>', "neither"),
        ("<mujoco>", "not valid XML"),
        ("<mujoco>" + "<default>" * 25_000 + "</default>" * 25_000 + "</mujoco>", "elements|deeply"),
        ('<mujoco><worldbody><body><geom type="box" size="5 5 5"/></body></worldbody></mujoco>', "mm long"),
    ],
)
def test_hostile_robot_descriptions_are_refused(inside: Path, text: str, why: str) -> None:
    (inside.parent / "secret.obj").write_text(obj_text())
    (inside / "thing.xml").write_text(text)
    with pytest.raises(RefusedError) as caught:
        import_robot_file(Folder(inside), "thing.xml", Options())
    assert re.search(why, str(caught.value))


# ---------------------------------------------------------------- the command


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ("../../etc/passwd", "etc_passwd"),
        ("Ein Becher!", "ein_becher"),
        ("a" * 200, "a" * 60),
        ("CON:aux", "con_aux"),
    ],
)
def test_names_become_plain_folder_names(given: str, name: str) -> None:
    assert clean_name(given) == name


def test_names_of_nothing_are_refused() -> None:
    with pytest.raises(RefusedError, match="--name"):
        clean_name("../..")


@pytest.mark.parametrize("row", ["box,nan", "box,-1", "box,1e9", "box,", "box", "../..,0.1"])
def test_wrong_masses_are_refused_by_line(tmp_path: Path, row: str) -> None:
    (tmp_path / "masses.csv").write_text(f"name,mass_kg\ncup,0.2\n{row}\n")
    with pytest.raises(GraspBenchError, match=r"masses\.csv, line 3"):
        read_masses(tmp_path / "masses.csv")


@pytest.mark.parametrize(
    ("settings", "why"),
    [
        ({"units": "yd"}, "Unknown unit 'yd'"),
        ({"mass": -1.0}, "--mass"),
        ({"mass": float("nan")}, "--mass"),
        ({"density": 0.0}, "--density"),
        ({"friction": 40.0}, "--friction"),
        ({"holes": "all"}, "way with holes"),
        ({"mass": 1.0, "density": 3.0}, "one of --mass"),
        ({"inertia": "none"}, "inertia"),
        ({"name": "../"}, "--name"),
        ({"masses": Path("gone.csv")}, "does not exist"),
    ],
)
def test_wrong_settings_are_refused(inside: Path, settings: dict, why: str) -> None:
    (inside / "box.obj").write_text(obj_text())
    with pytest.raises(GraspBenchError, match=why):
        plan_jobs(inside, inside / "out", **settings)


def test_imports_do_not_mix_with_modelled_objects(inside: Path, toy_catalog: Path) -> None:
    (inside / "box.obj").write_text(obj_text())
    with pytest.raises(GraspBenchError, match="not imported; choose another --out"):
        plan_jobs(inside, toy_catalog)


def test_masses_for_none_of_the_objects_are_refused(inside: Path) -> None:
    (inside / "box.obj").write_text(obj_text())
    (inside / "masses.csv").write_text("name,mass_kg\nbex,0.1\n")
    with pytest.raises(UnknownNameError, match="Did you mean box"):
        plan_jobs(inside, inside / "out", masses=inside / "masses.csv")
