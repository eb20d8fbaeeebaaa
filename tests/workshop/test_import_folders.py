"""Folders as data sets and people have them: what is selected, what is left out, names, masses, kills."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image
from typer.testing import CliRunner

import grasp_bench as gb
from grasp_bench.cli import app
from grasp_bench.errors import AssetError, GraspBenchError, UnknownNameError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.system.locking import Lock
from grasp_bench.workshop.build import write_manifest
from grasp_bench.workshop.importing import importer
from grasp_bench.workshop.importing.body import Options
from grasp_bench.workshop.importing.discovery import find_objects
from grasp_bench.workshop.importing.folder import Folder, RefusedError
from grasp_bench.workshop.importing.importer import STAGING, Job, import_shape
from grasp_bench.workshop.importing.jobs import plan_jobs
from grasp_bench.workshop.importing.naming import clean_name
from grasp_bench.workshop.importing.plausible import check_density, check_inertia
from grasp_bench.workshop.importing.robot_files import import_robot_file
from grasp_bench.workshop.importing.units import check_length, choose_unit, figure

SIDES = (0.06, 0.04, 0.03)
BOX: Any = trimesh.creation.box(SIDES)
GEOMETRY = '<geometry><box size=".06 .04 .03"/></geometry>'
SHAPE = f"<visual>{GEOMETRY}</visual><collision>{GEOMETRY}</collision>"


def inertial(mass: str = "0.1", moment: str = "2e-5", place: str = "0 0 0") -> str:
    moments = f'ixx="{moment}" iyy="{moment}" izz="{moment}" ixy="0" ixz="0" iyz="0"'
    return f'<inertial><origin xyz="{place}"/><mass value="{mass}"/><inertia {moments}/></inertial>'


def urdf(inner: str, more: str = "") -> str:
    return f'<robot name="r"><link name="base">{inner}{SHAPE}</link>{more}</robot>'


def put(root: Path, *names: str) -> None:
    """Write the box as meshes of these names, and whatever text else a name asks for."""
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        BOX.export(root / name)


def textured(path: Path, library: str, picture: str) -> None:
    """A red box as OBJ, whose library names a picture."""
    path.parent.mkdir(parents=True, exist_ok=True)
    v = "".join(f"v {x:.5f} {y:.5f} {z:.5f}\n" for x, y, z in BOX.vertices)
    f = "".join(f"f {a + 1}/1 {b + 1}/2 {c + 1}/3\n" for a, b, c in BOX.faces)
    path.write_text(f"mtllib {library}\nusemtl m\n{v}vt 0 0\nvt 1 0\nvt 1 1\n{f}")
    (path.parent / library).write_text(f"newmtl m\nmap_Kd {picture}\n")


def found(root: Path) -> dict[str, str]:
    return {n: p.relative_to(root).as_posix() for n, p, _ in find_objects(root).objects}


def shape_of(root: Path, name: str, **options: Any) -> dict[str, Any]:
    """Import an object's shape out of a folder; its ``shape.json``."""
    (job,) = [j for j in plan_jobs(root, root.parent / "out", **options).jobs if j.name == name]
    import_shape(job, root.parent / "out")
    return json.loads((root.parent / "out" / name / "shape.json").read_text())


# ---------------------------------------------------------------- layouts


@pytest.mark.parametrize(
    ("mesh", "picture", "named", "name"),
    [
        ("037/1a1c/models/model_normalized.obj", "037/1a1c/images/t0.jpg", "../images/t0.jpg", "1a1c"),
        ("Milk/meshes/model.obj", "Milk/materials/textures/texture.png", "texture.png", "milk"),
        ("can/google_16k/textured.obj", "can/google_16k/texture_map.png", "texture_map.png", "can"),
        ("mug/mug.obj", "textures/mug.png", "../textures/mug.png", "mug"),
    ],
)
def test_textures_are_read_from_anywhere_in_the_named_folder(
    tmp_path: Path, mesh: str, picture: str, named: str, name: str
) -> None:
    root = tmp_path / "in"
    textured(root / mesh, "m.mtl", named)
    (root / picture).parent.mkdir(parents=True, exist_ok=True)
    Image.new("RGB", (16, 16), "red").save(root / picture)
    assert found(root) == {name: mesh}
    details = shape_of(root, name)
    assert picture in details["import"]["files"]
    assert not any("without it" in note for note in details["import"]["notes"])


@pytest.mark.parametrize(
    "reference", ["package://my_pkg/meshes/block.stl", "../meshes/block.stl", "package://meshes/block.stl"]
)
@pytest.mark.parametrize("suffix", ["urdf", "urdf.xacro"])
def test_ros_packages_are_read_whole(tmp_path: Path, reference: str, suffix: str) -> None:
    root = tmp_path / "in"
    put(root, "my_pkg/meshes/block.stl")
    (root / "my_pkg" / "package.xml").write_text("<package><name>my_pkg</name></package>")
    (root / "my_pkg" / "urdf").mkdir()
    mesh = f'<geometry><mesh filename="{reference}"/></geometry>'
    (root / "my_pkg" / "urdf" / f"thing.{suffix}").write_text(
        f'<robot name="r"><link name="l">{inertial()}<collision>{mesh}</collision></link></robot>'
    )
    assert found(root) == {"thing": f"my_pkg/urdf/thing.{suffix}"}
    assert any("package.xml: no robot description but <package>" in n for n in find_objects(root).notes)
    np.testing.assert_allclose(shape_of(root, "thing")["extents"], SIDES, atol=1e-5)


def test_an_xml_file_beside_meshes_hides_none(tmp_path: Path) -> None:
    put(tmp_path, "mug.stl", "plate.stl", "more/fork.stl")
    (tmp_path / "labels.xml").write_text("<?xml version='1.0'?><!-- x --><annotation/>")
    (tmp_path / "broken.xml").write_text("nothing")
    result = find_objects(tmp_path)
    assert sorted(n for n, _, _ in result.objects) == ["fork", "mug", "plate"]
    assert result.notes == [
        "broken.xml: no robot description but no XML, left out",
        "labels.xml: no robot description but <annotation>, left out",
    ]


def test_a_generic_name_beside_others_hides_none(tmp_path: Path) -> None:
    put(tmp_path, "object.stl", "mug.stl", "plate.stl")
    assert sorted(found(tmp_path)) == ["mug", "object", "plate"]


def test_meshes_beside_a_description_are_objects_unless_they_are_its_parts(tmp_path: Path) -> None:
    put(tmp_path, "part.stl", "part.obj", "mug.stl", "old/part2.stl", "pieces/a.stl", "pieces/b.stl")
    (tmp_path / "thing.urdf").write_text(
        '<robot name="r"><mesh filename="part.stl"/><mesh filename="pieces/a.stl"/></robot>'
    )
    result = find_objects(tmp_path)
    assert sorted(n for n, _, _ in result.objects) == ["mug", "part2", "thing"]
    assert result.notes == [
        "left out part.obj: no robot description refers to them",
        "pieces: left out b.stl: no robot description refers to them",
    ]


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    put(tmp_path, "mug/textured.obj", "mug/nontextured.ply", "a.stl", "a.obj", "1/2/3/4/5/deep.stl")
    (tmp_path / "scene.fbx").write_text("x")
    (tmp_path / "link").symlink_to(tmp_path / "mug")
    notes = "\n".join(find_objects(tmp_path).notes)
    for part in (
        "left out a.stl: another format",
        "mug: left out nontextured.ply: textured.obj is taken for mug",
        "left out scene.fbx: of a format that is not read",
        "link: a linked folder, not entered",
        "1/2/3/4/5: more than 4 folders deep, not entered",
    ):
        assert part in notes


# ---------------------------------------------------------------- names


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ("krügel", "krugel"),
        ("杯子", "u676f_u5b50"),
        ("Straße", "strasse"),
        ("mug 杯", "mug_u676f"),
        ("чашка", "u0447_u0430_u0448_u043a_u0430"),
        ("Café №5", "cafe_no5"),
        ("001_can", "001_can"),
    ],
)
def test_names_of_every_script_become_names(given: str, name: str) -> None:
    assert clean_name(given) == name


def test_a_name_that_says_nothing_stops_no_folder(tmp_path: Path) -> None:
    put(tmp_path, "---.stl", "mug.stl", "杯子.stl")
    assert sorted(found(tmp_path)) == ["mug", "object", "u676f_u5b50"]


def test_a_given_name_is_looked_at_first(tmp_path: Path) -> None:
    put(tmp_path, "---.stl")
    assert [n for n, _, _ in find_objects(tmp_path / "---.stl", "cup").objects] == ["cup"]
    assert [n for n, _, _ in find_objects(tmp_path, "cup").objects] == ["cup"]
    put(tmp_path, "mug.stl")
    with pytest.raises(RefusedError, match=r"--name is for one object, but .* holds 2"):
        find_objects(tmp_path, "cup")


def test_names_that_differ_in_case_are_both_taken_and_said(tmp_path: Path) -> None:
    put(tmp_path, "Mug.stl", "mug.obj", "x/mug.stl")
    result = find_objects(tmp_path)
    assert len({n for n, _, _ in result.objects}) == len(result.objects) == 3
    assert len(result.notes) == 3
    assert all("is called" in n and "mug is the name of 3" in n for n in result.notes)


# ---------------------------------------------------------------- masses and sizes


def test_every_unmatched_line_of_a_table_is_an_error(tmp_path: Path) -> None:
    put(tmp_path / "in", "mug.stl", "plate.stl")
    table = tmp_path / "masses.csv"
    table.write_text("name,mass_kg\nmug,0.3\nplte,0.4\n")
    with pytest.raises(UnknownNameError, match=r"line 3.*plte.*Did you mean plate"):
        plan_jobs(tmp_path / "in", tmp_path / "out", masses=table)
    table.write_text("name,mass_kg\nmug,0.3\nMug,0.4\n")
    with pytest.raises(GraspBenchError, match=r"line 3: mug is there twice, first in line 2"):
        plan_jobs(tmp_path / "in", tmp_path / "out", masses=table)
    table.write_text("name,mass_kg\nmug,0.05\n")
    plan = plan_jobs(tmp_path / "in", tmp_path / "out", masses=table)
    assert [j.options.mass for j in plan.jobs] == [0.05, None]
    assert plan.notes == [f"{table} has no mass for plate: assumed"]


@pytest.mark.parametrize(
    ("sides", "mass", "why"),
    [
        ((0.8, 0.5, 0.5), None, r"scaled to the length 1.*--length"),
        ((1.0, 0.6, 0.6), None, r"scaled to the length 1.*--length"),
        ((0.8, 0.5, 0.5), 0.3, r"make no sense in any unit \(8 mm and .* kg/m³ in cm, 20"),
        ((0.012, 0.006, 0.006), 5.0, "make no sense in any unit"),
        ((0.5, 0.4, 0.3), None, r"give --mass, or check the size \(--units, --length"),
    ],
)
def test_meshes_without_a_unit_are_asked_for_one(
    tmp_path: Path, sides: tuple[float, float, float], mass: float | None, why: str
) -> None:
    (tmp_path / "in").mkdir()
    trimesh.creation.box(sides).export(tmp_path / "in" / "a.stl")
    with pytest.raises(RefusedError, match=why):
        shape_of(tmp_path / "in", "a", mass=mass)


@pytest.mark.parametrize(
    "options",
    [{"length": 0.12}, {"scale": 0.15}, {"length": 0.12, "mass": 0.3}, {"scale": 0.15, "mass": 0.3}],
)
def test_a_length_or_a_scale_sizes_a_mesh(tmp_path: Path, options: dict) -> None:
    (tmp_path / "in").mkdir()
    trimesh.creation.box((0.8, 0.5, 0.5)).export(tmp_path / "in" / "a.stl")
    details = shape_of(tmp_path / "in", "a", **options)
    np.testing.assert_allclose(details["extents"], [0.12, 0.075, 0.075], atol=1e-5)


def test_inches_are_a_unit_and_guessed_by_a_mass(tmp_path: Path) -> None:
    assert choose_unit(np.array([2.36, 1.57, 1.18]), "in", None, 4.4)[0] == "in"
    unit, note = choose_unit(np.array([2.36, 1.57, 1.18]), "auto", None, 4.4)
    assert (unit, "in would make it 60 mm" in note) == ("cm", True)
    assert choose_unit(np.array([2.36, 1.57, 1.18]), "auto", 0.4, 4.4)[0] == "in"


@pytest.mark.parametrize(
    ("settings", "why"),
    [
        ({"length": 120.0}, r"--length 120 is not between.*120 mm are 0\.12"),
        ({"length": float("nan")}, "--length"),
        ({"scale": 0.0}, "--scale"),
        ({"scale": float("inf")}, "--scale"),
        ({"length": 0.1, "units": "mm"}, "one of --units, --length and --scale"),
        ({"length": 0.1, "scale": 1.0}, "one of --units, --length and --scale"),
    ],
)
def test_wrong_lengths_are_refused(tmp_path: Path, settings: dict, why: str) -> None:
    put(tmp_path, "a.stl")
    with pytest.raises(GraspBenchError, match=why):
        plan_jobs(tmp_path, tmp_path / "out", **settings)


def test_one_length_is_for_one_object(tmp_path: Path) -> None:
    put(tmp_path, "a.stl", "b.stl")
    with pytest.raises(GraspBenchError, match="--length is for one object"):
        plan_jobs(tmp_path, tmp_path / "out", length=0.1)


def test_separate_pieces_are_said(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    parts = [BOX.copy().apply_translation((0.08 * i, 0, 0)) for i in range(3)]
    trimesh.util.concatenate(parts).export(tmp_path / "in" / "a.stl")
    details = shape_of(tmp_path / "in", "a")
    assert any(
        n.startswith("3 separate pieces: taken as one rigid object") for n in details["import"]["notes"]
    )
    assert details["hulls"] == 3


# ---------------------------------------------------------------- mass properties


def test_inertias_that_can_be_pass() -> None:
    own = np.asarray(BOX.moment_inertia) * 0.1 / BOX.volume
    check_inertia(0.1, np.zeros(3), own, BOX)
    check_inertia(0.1, np.array([0.02, 0, 0]), own, BOX)
    check_density(0.1, BOX.volume, 0.06, 0.036)


@pytest.mark.parametrize(
    ("centre", "moments", "why"),
    [
        ((1, 0, 0), (2e-5, 2e-5, 2e-5), "outside of its shape; that of the shape is at"),
        ((0, 0, -0.03), (2e-5, 2e-5, 2e-5), "outside of its shape"),
        ((0, 0, 0), (1, 1, 1), "more than 100 g have .* its shape gives about"),
        ((0, 0, 0), (1e-5, 1e-5, 9e-5), "larger than the two others together"),
        ((0, 0, 0), (-1e-5, 1e-5, 1e-5), "not all positive"),
        ((0, 0, 0), (0, 1e-5, 1e-5), "not all positive"),
        ((float("nan"), 0, 0), (1e-5, 1e-5, 1e-5), "not finite"),
        ((0, 0, 0), (float("inf"), 1e-5, 1e-5), "not finite"),
    ],
)
def test_mass_properties_that_no_body_has_are_refused(centre: tuple, moments: tuple, why: str) -> None:
    with pytest.raises(RefusedError, match=why):
        check_inertia(0.1, np.array(centre, float), np.diag(np.array(moments, float)), BOX)


@pytest.mark.parametrize("mass", [5.0, 1e-4])
def test_densities_that_no_object_has_are_refused(mass: float) -> None:
    with pytest.raises(RefusedError, match=r"kg/m³.*about 36 g would be usual"):
        check_density(mass, BOX.volume, 0.06, 0.036)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (urdf(inertial(place="1 0 0")), "centre of mass"),
        (urdf(inertial(moment="1")), "its shape gives about"),
        (urdf(inertial(mass="1000")), "kg/m³|5 kg"),
        (urdf(inertial(mass="-1")), "mass of -1 kg"),
        (urdf(inertial(mass="heavy")), "no number"),
        (urdf(inertial(mass="nan")), "mass of nan kg"),
        (urdf(inertial(moment="-1e-5")), "not all positive"),
        (urdf(inertial(mass="${m}")), r"xacro template.*xacro thing\.urdf"),
        ('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="m"/></robot>', "xacro"),
        ('<robot name="r"><xacro:macro name="m"/></robot>', "xacro template"),
        (urdf(inertial().replace('ixx="2e-5"', 'ixx="9e-5"')), "two others together"),
    ],
)
def test_descriptions_with_impossible_masses_are_refused_in_words(
    tmp_path: Path, text: str, why: str
) -> None:
    (tmp_path / "thing.urdf").write_text(text)
    with pytest.raises(RefusedError, match=why) as caught:
        import_shape(Job("thing", tmp_path / "thing.urdf", tmp_path, Options()), tmp_path / "out")
    assert "\n" not in str(caught.value)


WORLD = (
    '<link name="world"/><joint name="j" type="fixed"><parent link="world"/><child link="base"/>'
    '<origin xyz="0 0 1"/></joint>'
)


@pytest.mark.parametrize(
    ("text", "mass", "note"),
    [
        (urdf(inertial()), 0.1, ""),
        (urdf(inertial(), WORLD), 0.1, ""),
        (urdf(inertial(mass="0")), None, "has a mass of 0: taken as not given"),
        (urdf(inertial(moment="0")), 0.1, "no inertia: that of the shape"),
        (urdf(""), None, ""),
        ("\ufeff" + urdf(inertial()), 0.1, ""),
    ],
    ids=["plain", "world", "zero mass", "zero inertia", "none", "bom"],
)
def test_descriptions_by_the_conventions_of_ros(
    tmp_path: Path, text: str, mass: float | None, note: str
) -> None:
    (tmp_path / "thing.urdf").write_text(text)
    body = import_robot_file(Folder(tmp_path), "thing.urdf", Options())
    assert body.mass == (mass if mass is None else pytest.approx(mass))
    assert note in " ".join(body.notes)
    assert bool(note) == bool(body.notes)


@pytest.mark.parametrize(
    ("inner", "note"),
    [
        ('<geom type="box" size=".03 .02 .015" mass=".1"/>', ""),
        (
            '<geom type="plane" size="1 1 .1"/><body><freejoint/><geom type="box" size=".03 .02 .015" '
            'mass=".1"/></body>',
            "left out 1 geoms that belong to the world",
        ),
        (
            '<body><freejoint/><inertial pos="0 0 0" mass="0" diaginertia="0 0 0"/>'
            '<geom type="box" size=".03 .02 .015" mass=".1"/></body>',
            "mass of 0",
        ),
    ],
    ids=["in the world", "on a floor", "zero inertial"],
)
def test_mjcf_masses_wherever_they_are(tmp_path: Path, inner: str, note: str) -> None:
    (tmp_path / "a.xml").write_text(f"<mujoco><worldbody>{inner}</worldbody></mujoco>")
    body = import_robot_file(Folder(tmp_path), "a.xml", Options())
    assert body.mass == pytest.approx(0.1)
    assert note in " ".join(body.notes)


def test_a_description_without_any_mass_is_weighed_by_its_shape(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text(
        '<mujoco><worldbody><body><freejoint/><geom type="box" size=".03 .02 .015" mass="0"/></body>'
        "</worldbody></mujoco>"
    )
    body = import_robot_file(Folder(tmp_path), "a.xml", Options())
    assert body.mass is None
    assert "its mass or inertia is 0: taken as not given" in body.notes


@pytest.mark.parametrize("name", ["M.STL", "file:///home/me/m.stl", "C:\\parts\\m.stl", "sub\\m.stl"])
def test_mesh_files_are_found_by_their_base_name_and_said(tmp_path: Path, name: str) -> None:
    put(tmp_path, "m.stl")
    (tmp_path / "a.urdf").write_text(
        f'<robot name="r"><link name="l">{inertial()}<collision><geometry><mesh filename="{name}"/>'
        "</geometry></collision></link></robot>"
    )
    body = import_robot_file(Folder(tmp_path), "a.urdf", Options())
    assert any(n.startswith("m.stl taken for") for n in body.notes)


def test_a_mesh_too_fine_for_the_simulator_is_refused_at_the_door(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from grasp_bench.workshop.importing import robot_parts

    monkeypatch.setattr(robot_parts, "MAX_MESH_FACES", 10)
    put(tmp_path, "m.stl")
    (tmp_path / "a.urdf").write_text(
        '<robot name="r"><link name="l"><collision><geometry><mesh filename="m.stl"/></geometry></collision>'
        "</link></robot>"
    )
    with pytest.raises(RefusedError, match=r"m\.stl has 12 faces; at most 10"):
        import_robot_file(Folder(tmp_path), "a.urdf", Options())


def test_a_description_in_millimetres_is_told_of_scale(tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text(
        '<robot name="r"><link name="l"><collision><geometry><box size="60 40 30"/></geometry></collision>'
        "</link></robot>"
    )
    with pytest.raises(RefusedError, match=r"--scale 0\.001"):
        import_robot_file(Folder(tmp_path), "a.urdf", Options())
    body = import_robot_file(Folder(tmp_path), "a.urdf", Options(scale=0.001))
    np.testing.assert_allclose(np.ptp(body.solid.vertices, axis=0), SIDES, atol=1e-6)


# ---------------------------------------------------------------- kills, empty results


def test_an_import_cut_off_half_way_is_never_up_to_date(tmp_path: Path) -> None:
    put(tmp_path, "a.stl")
    out = tmp_path / "out"
    first, second = (Job("a", tmp_path / "a.stl", tmp_path, Options(mass=m)) for m in (0.05, 0.06))
    assert import_shape(first, out)
    assert not import_shape(first, out)
    sound = (out / "a" / "visual.glb").read_bytes()
    import_shape(second, out)
    (out / "a" / "visual.glb").write_bytes(sound[:-10])  # torn
    assert import_shape(second, out)


def test_a_kill_while_an_object_is_made_anew_leaves_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from grasp_bench.workshop import poses

    monkeypatch.setattr(poses, "TRIED", 1)
    monkeypatch.setattr(poses, "MAX_POSES", 1)
    put(tmp_path, "a.stl", "b.stl")
    out = tmp_path / "out"
    importer.import_one(Job("a", tmp_path / "a.stl", tmp_path, Options(mass=0.05), "a.stl"), out)
    assert write_manifest(out) == 1
    with monkeypatch.context() as patch:
        patch.setattr(poses, "build_rest", lambda *_, **__: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            importer.import_one(Job("a", tmp_path / "b.stl", tmp_path, Options(mass=0.06), "b.stl"), out)
    assert Catalog(out).load("a").mass == 0.05
    assert (out / STAGING / "a" / "shape.json").is_file()
    report = importer.import_one(Job("a", tmp_path / "b.stl", tmp_path, Options(mass=0.06), "b.stl"), out)
    assert (report.status, report.replaced) == ("imported", "a.stl")
    (out / "half").mkdir()
    (out / "half" / "object.json").write_text("{")
    assert write_manifest(out) == 1
    assert Catalog(out).load("a").mass == 0.06


def test_what_a_stopped_import_had_finished_can_be_run(
    tmp_path: Path, toy_catalog: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As it ends, an object is entered in the manifest; a second import waits for none that goes on."""
    put(tmp_path, "block.stl", "second.stl")
    out = tmp_path / "out"

    def stopped(jobs: list[Job], out: Path, *_: object) -> Iterator[importer.Report]:
        out.mkdir()
        shutil.copytree(toy_catalog / "block", out / "block")
        file = out / "block" / "object.json"
        file.write_text(json.dumps(json.loads(file.read_text()) | {"family": importer.FAMILY}))
        yield importer.Report("block", "failed", "only its files count here")
        raise KeyboardInterrupt

    command = ["objects", "import", str(tmp_path), "--out", str(out)]
    with monkeypatch.context() as patch:
        patch.setattr(importer, "import_all", stopped)
        assert CliRunner().invoke(app, command).exit_code == 130
    assert Catalog(out).names == ["block"]
    assert Catalog(out).load("block").poses
    with Lock(out / ".lock", AssertionError()):
        refused = CliRunner().invoke(app, command)
    assert "Another import is writing to" in str(refused.exception)
    assert Catalog(out).names == ["block"]


def test_a_mesh_of_more_faces_than_the_simulator_reads_in_one_is_imported_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """327,680 faces: fewer than are read, more than MuJoCo takes in one mesh."""
    from grasp_bench.workshop import poses

    monkeypatch.setattr(poses, "TRIED", 1)
    monkeypatch.setattr(poses, "MAX_POSES", 1)
    ball = trimesh.creation.icosphere(7, 0.03)
    ball.vertices *= [1, 0.8, 0.6]
    ball.export(tmp_path / "pebble.stl")
    out = tmp_path / "out"
    report = importer.import_one(Job("pebble", tmp_path / "pebble.stl", tmp_path, Options()), out)
    assert (report.status, report.details["faces"], report.details["hulls"]) == ("imported", 327_680, 1)
    assert report.graspable
    assert write_manifest(out) == 1
    parts = Catalog(out).load("pebble").visual
    assert sum(len(p.faces) for p in parts) == 327_680
    assert max(len(p.faces) for p in parts) < 200_000


def test_figures_are_written_without_an_exponent() -> None:
    told = [figure(x) for x in (30_000.4, 0.2159, -970.0, 1234.5, 0.0)]
    assert told == ["30000", "0.216", "-970", "1230", "0"]
    with pytest.raises(RefusedError, match=r"^60000 mm long"):
        check_length(60.0, "as it is")


def test_an_import_of_nothing_recommends_no_run(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    trimesh.creation.box((0.012, 0.006, 0.006)).export(tmp_path / "in" / "pill.stl")
    out = tmp_path / "out"
    command = ["objects", "import", str(tmp_path / "in" / "pill.stl"), "--mass", "5", "--out", str(out)]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 1
    assert "grasp-bench run" not in result.output
    assert "There is nothing to run" in result.output
    with pytest.raises(AssetError, match="lists no object"):
        Catalog(out)
    new = tmp_path / "new"
    for line in EMPTY:
        failed = CliRunner().invoke(app, line.format(out=out, new=new).split())
        assert isinstance(failed.exception, AssetError), (line, failed.output, failed.exception)
        assert "lists no object" in str(failed.exception), line
    with pytest.raises(AssetError, match="lists no object"):
        gb.run(objects=out, predictor="oracle", trials=1, out=new)
    assert not new.exists()


EMPTY = (
    "run --predictor oracle --objects {out} --out {new}",
    "rank oracle centroid --objects {out} --out {new}",
    "sweep --parameter gripper.force --values 30,60 --predictor oracle --objects {out} --out {new}",
    "objects list --folder {out}",
    "objects show mug --folder {out}",
    "objects verify --folder {out}",
    "objects grasps mug --out {new} --folder {out}",
    "grippers prepare parallel-50 --objects {out}",
)
"""What is asked of a folder into which nothing was imported."""
