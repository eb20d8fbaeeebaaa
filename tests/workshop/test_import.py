"""Imported objects: what is mended, what stays open, what the benchmark then gets."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image
from real_samples import real_samples
from scipy.spatial import ConvexHull

from grasp_bench.objects.catalog import Catalog
from grasp_bench.workshop.build import Listing, write_manifest
from grasp_bench.workshop.decompose import BOUNDS, MAX_HULLS, MAX_VERTICES
from grasp_bench.workshop.importing import importer, solid
from grasp_bench.workshop.importing.body import Options
from grasp_bench.workshop.importing.convex import decompose_whole
from grasp_bench.workshop.importing.discovery import find_objects
from grasp_bench.workshop.importing.folder import Folder, RefusedError
from grasp_bench.workshop.importing.importer import Job, import_shape
from grasp_bench.workshop.importing.jobs import read_masses
from grasp_bench.workshop.importing.masses import spread_mass
from grasp_bench.workshop.importing.measure import flood
from grasp_bench.workshop.importing.paint import MAX_COLORS, bake
from grasp_bench.workshop.importing.readers import read_mesh
from grasp_bench.workshop.importing.repair import border_loops, mend
from grasp_bench.workshop.importing.robot_files import import_robot_file
from grasp_bench.workshop.importing.units import choose_unit
from grasp_bench.workshop.shapes import Mesh, box, cylinder, difference, move, scale, union

BLOCK: Any = trimesh.creation.box((0.04, 0.05, 0.06))


def cup(outer: float = 40, wall: float = 3, height: float = 60, sides: int = 12) -> Mesh:
    """An open cup in metres, standing on z = 0."""
    body = difference(cylinder(outer, height, sides), move(cylinder(outer - wall, height, sides), z=2 * wall))
    return scale(body, 0.001)


def inside_hulls(hulls: list[np.ndarray], points: np.ndarray) -> np.ndarray:
    """Which of (N, 3) points lie in some hull."""
    found = np.zeros(len(points), bool)
    for hull in hulls:
        equations = ConvexHull(hull).equations
        found |= (points @ equations[:, :3].T + equations[:, 3] < 1e-9).all(1)
    return found


# ---------------------------------------------------------------- repairs


def test_a_sound_mesh_is_left_alone() -> None:
    mended = mend(BLOCK.vertices, BLOCK.faces)
    assert mended.notes == []
    assert not mended.open.any()
    body = solid.solidify(mended)
    assert body.volume == pytest.approx(BLOCK.volume, rel=1e-5)


def test_unmerged_vertices_are_welded() -> None:
    soup = BLOCK.vertices[BLOCK.faces].reshape(-1, 3)
    mended = mend(soup, np.arange(36).reshape(-1, 3))
    assert len(mended.vertices) == 8
    assert solid.solidify(mended).volume == pytest.approx(BLOCK.volume, rel=1e-5)


def test_duplicate_and_degenerate_faces_are_dropped() -> None:
    f = BLOCK.faces
    more = np.vstack([f, f[:1], f[3:4][:, [1, 2, 0]], [[0, 0, 1]]])  # once more, once more turned, a line
    mended = mend(BLOCK.vertices, more)
    assert len(mended.faces) == 12
    assert mended.notes == ["dropped 1 degenerate faces", "dropped 2 duplicate faces"]


def test_pairs_of_opposite_faces_enclose_nothing_and_go() -> None:
    fin = np.array([[0.0, 0.0, 0.05]])
    vertices = np.vstack([BLOCK.vertices, fin])
    flap = np.array([[0, 1, 8], [1, 0, 8]])
    mended = mend(vertices, np.vstack([BLOCK.faces, flap]))
    assert len(mended.faces) == 12
    assert mended.notes == ["dropped 2 duplicate faces"]


def test_faces_that_disagree_are_turned() -> None:
    f = BLOCK.faces.copy()
    f[2] = f[2][::-1]
    mended = mend(BLOCK.vertices, f)
    assert mended.notes == ["turned 1 faces to agree with their neighbours"]
    assert solid.solidify(mended).volume == pytest.approx(BLOCK.volume, rel=1e-5)


def test_inside_out_meshes_are_turned_and_cavities_are_not() -> None:
    mended = mend(BLOCK.vertices, BLOCK.faces[:, ::-1])
    assert mended.notes == ["turned 1 inside-out pieces"]
    assert solid.solidify(mended).volume == pytest.approx(BLOCK.volume, rel=1e-5)
    void = trimesh.creation.box((0.01, 0.01, 0.01))
    hollow = mend(
        np.vstack([BLOCK.vertices, void.vertices]), np.vstack([BLOCK.faces, void.faces[:, ::-1] + 8])
    )
    assert hollow.notes == []
    assert solid.solidify(hollow).volume == pytest.approx(BLOCK.volume - void.volume, rel=1e-5)


def test_specks_and_strays_are_dropped() -> None:
    fine = BLOCK.subdivide().subdivide().subdivide()
    speck = trimesh.creation.box((5e-4, 5e-4, 5e-4))
    speck.apply_translation([0.05, 0, 0])
    far = trimesh.creation.box((5e-4, 5e-4, 5e-4))
    far.apply_translation([40, 0, 0])
    few: Any = trimesh.util.concatenate([fine.subdivide(), speck, far])
    assert mend(few.vertices, few.faces).notes == [
        "dropped 12 faces that reach far outside the rest",
        "dropped 1 loose specks",
    ]


def test_small_holes_and_the_underside_are_closed() -> None:
    fine = BLOCK.subdivide().subdivide().subdivide()
    holed = Mesh(fine.vertices, fine.faces[1:], process=False)
    mended = mend(holed.vertices, holed.faces)
    assert len(mended.notes) == 1
    assert mended.notes[0].startswith("closed 1 hole (")
    assert mended.source[-1] == -1
    assert solid.solidify(mended).volume == pytest.approx(BLOCK.volume, rel=1e-5)
    under = fine.triangles_center[:, 2] < -0.0299
    scan = mend(fine.vertices, fine.faces[~under])
    assert "closed 1 hole (20.0 cm²)" in scan.notes
    assert solid.solidify(scan).volume == pytest.approx(BLOCK.volume, rel=1e-5)


def test_the_mouth_of_a_bare_surface_stays_open_and_gets_a_wall() -> None:
    fine = BLOCK.subdivide().subdivide()
    mouth = fine.triangles_center[:, 2] > 0.0299
    mended = mend(fine.vertices, fine.faces[~mouth])
    assert mended.open.all()
    assert mended.notes == ["kept an opening of 20.0 cm²: the surface around it gets a wall"]
    body = solid.solidify(mended)
    area = 2 * 0.06 * (0.04 + 0.05) + 0.04 * 0.05
    assert body.is_watertight
    assert body.volume == pytest.approx(area * solid.WALL, rel=0.1)
    assert not body.contains([[0, 0, 0], [0, 0, -0.025], [0, 0, 0.03]]).any()
    np.testing.assert_allclose(body.extents, np.array([0.04, 0.05, 0.06]) + solid.WALL, atol=0.0011)
    closed = mend(fine.vertices, fine.faces[~mouth], "fill")
    assert solid.solidify(closed).volume == pytest.approx(BLOCK.volume, rel=1e-5)


def test_what_is_no_manifold_is_rebuilt() -> None:
    # Two boxes that share an edge: four faces meet there.
    other = BLOCK.copy()
    other.apply_translation([0.04, 0.05, 0])
    both: Any = trimesh.util.concatenate([BLOCK, other])
    vertices, faces = both.vertices, both.faces
    # and a missing side wall of the second, larger than what is closed by itself
    mended = mend(vertices, faces[:-2], "keep")
    body = solid.solidify(mended)
    assert body.is_watertight
    assert any("wall" in n for n in mended.notes)


def test_the_surface_of_a_balls_distances_is_a_ball() -> None:
    x = np.linalg.norm(np.stack(np.meshgrid(*3 * [np.arange(-12.0, 13)], indexing="ij")), axis=0)
    vertices, faces = solid.isosurface(9.3 - x)
    ball = trimesh.Trimesh(vertices - 12, faces, process=False)
    assert ball.is_watertight
    assert ball.is_winding_consistent
    assert ball.volume == pytest.approx(4 / 3 * np.pi * 9.3**3, rel=0.01)
    np.testing.assert_allclose(np.linalg.norm(ball.vertices, axis=1), 9.3, atol=0.05)


def test_borders_are_walked_in_loops() -> None:
    grid = trimesh.creation.box((1, 1, 1)).subdivide().subdivide()
    hole = [i for i, c in enumerate(grid.triangles_center) if c[2] > 0.49 or c[0] > 0.49]
    loops = border_loops(np.delete(grid.faces, hole, axis=0))
    assert len(loops) == 1
    closed = border_loops(np.asarray(grid.faces))
    assert closed == []


def test_overlapping_pieces_are_one_solid() -> None:
    other = BLOCK.copy()
    other.apply_translation([0.02, 0, 0])
    both: Any = trimesh.util.concatenate([BLOCK, other])
    body = solid.solidify(mend(both.vertices, both.faces))
    assert body.volume == pytest.approx(0.06 * 0.05 * 0.06, rel=1e-4)


# ---------------------------------------------------------------- units


@pytest.mark.parametrize(
    ("longest", "mass", "unit"),
    [
        (0.2, None, "m"),
        (200.0, None, "mm"),
        (17.0, None, "mm"),
        (6.0, None, "cm"),
        (20.0, 2.0, "cm"),
        (20.0, 0.005, "mm"),
        (0.006, None, "m"),
    ],
)
def test_units_are_guessed_from_size_and_mass(longest: float, mass: float | None, unit: str) -> None:
    assert choose_unit(np.array([longest, longest, longest]), "auto", mass, longest**3)[0] == unit


def test_a_guessed_unit_is_said_with_its_rivals() -> None:
    _, note = choose_unit(np.array([50.0, 20, 20]), "auto", None, 1e4)
    assert note == "taken to be in mm: 50 mm long (cm would make it 500 mm; --units decides)"


# ---------------------------------------------------------------- mass


def test_mass_on_the_surface_of_a_box_has_the_textbooks_inertia() -> None:
    centre, inertia = spread_mass(trimesh.creation.box((1, 1, 1)), 3.0, "shell")
    np.testing.assert_allclose(centre, 0, atol=1e-12)
    # A hollow cube of mass m and edge a: 5/18 m a² about each axis.
    np.testing.assert_allclose(inertia, np.eye(3) * 3.0 * 5 / 18, atol=1e-12)


def test_mass_in_a_box_has_the_textbooks_inertia() -> None:
    _, inertia = spread_mass(BLOCK, 0.12, "solid")
    expected = 0.01 * np.array([0.05**2 + 0.06**2, 0.04**2 + 0.06**2, 0.04**2 + 0.05**2])
    np.testing.assert_allclose(inertia, np.diag(expected), atol=1e-12)


# ---------------------------------------------------------------- convex pieces


def test_a_convex_mesh_is_one_piece() -> None:
    hulls, error = decompose_whole(BLOCK)
    assert len(hulls) == 1
    assert error.volume_ratio == pytest.approx(1)


def test_a_cup_stays_open() -> None:
    body = cup()
    hulls, error = decompose_whole(body)
    assert len(hulls) <= MAX_HULLS
    assert max(len(h.vertices) for h in hulls) <= MAX_VERTICES
    assert error.mean_distance <= BOUNDS["mean_distance"][1]
    # A ray down the axis meets nothing before the inner bottom, at 6 mm.
    axis = np.column_stack([np.zeros(50), np.zeros(50), np.linspace(0.0605, 0.009, 50)])
    vertices = [np.asarray(h.vertices) for h in hulls]
    assert not inside_hulls(vertices, axis).any()
    assert inside_hulls(vertices, np.array([[0, 0, 0.003]])).all()


def test_water_stands_to_the_lowest_rim() -> None:
    ground = np.zeros((7, 7))
    ground[1:6, 1:6] = 3.0
    ground[2:5, 2:5] = 1.0
    ground[1, 3] = 2.0  # a notch
    level = flood(ground)
    assert level[3, 3] == 2.0
    assert (level - ground).sum() == pytest.approx(9 * 1.0)


# ---------------------------------------------------------------- colours


def textured_obj(directory: Path) -> None:
    """A 60 mm square plate whose texture is red on the left and blue on the right."""
    picture = np.zeros((64, 64, 3), np.uint8)
    picture[:, :32, 0] = picture[:, 32:, 2] = 255
    picture[:8] = (0, 255, 0)  # the top rows: v near 1
    Image.fromarray(picture).save(directory / "colours.png")
    (directory / "plate.mtl").write_text("newmtl m\nmap_Kd colours.png\n")
    plate = trimesh.creation.box((0.06, 0.06, 0.01))
    lines = ["mtllib plate.mtl"] + [f"v {x} {y} {z}" for x, y, z in plate.vertices]
    lines += [f"vt {x / 0.06 + 0.5} {y / 0.06 + 0.5}" for x, y, _ in plate.vertices]
    lines += ["usemtl m"] + [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in plate.faces + 1]
    (directory / "plate.obj").write_text("\n".join(lines))


def test_a_texture_is_baked_to_parts_of_one_colour(tmp_path: Path) -> None:
    textured_obj(tmp_path)
    scan = read_mesh(Folder(tmp_path), "plate.obj")
    parts = bake(scan.vertices, scan.faces, np.arange(len(scan.faces)), scan.paint)
    assert 3 <= len(parts) <= MAX_COLORS
    assert sum(len(p.faces) for p in parts) > 1000
    area = sum(trimesh.Trimesh(p.vertices, p.faces).area for p in parts)
    assert area == pytest.approx(trimesh.creation.box((0.06, 0.06, 0.01)).area, rel=1e-6)
    for part in parts:
        centres = part.vertices[part.faces].mean(1)
        if part.rgb[0] > 0.95:
            assert centres[:, 0].max() < 0.002
        if part.rgb[2] > 0.95:
            assert centres[:, 0].min() > -0.002
        if part.rgb[1] > 0.95:
            assert centres[:, 1].min() > 0.02
    areas = np.array([trimesh.Trimesh(p.vertices, p.faces).area for p in parts])
    shares = areas @ [p.rgb for p in parts] / area
    green = (0.125 * (72 + 12) + 6) / 96  # of the faces with the texture across them, and one side [cm²]
    np.testing.assert_allclose(shares, [(1 - green) / 2, green, (1 - green) / 2], atol=0.01)


def test_vertex_colours_are_kept(tmp_path: Path) -> None:
    ball: Any = trimesh.creation.icosphere(3, 0.03)
    ball.visual.vertex_colors = np.where(ball.vertices[:, 2:] > 0, [[250, 250, 0, 255]], [[0, 0, 0, 255]])
    (tmp_path / "ball.ply").write_bytes(ball.export(file_type="ply"))
    scan = read_mesh(Folder(tmp_path), "ball.ply")
    parts = bake(scan.vertices, scan.faces, np.arange(len(scan.faces)), scan.paint)
    bright = [p for p in parts if p.rgb[0] > 0.9]
    assert bright
    assert min(p.vertices[:, 2].min() for p in bright) > -0.004


@pytest.mark.parametrize("suffix", ["obj", "stl", "ply", "glb"])
def test_every_format_gives_the_same_shape(tmp_path: Path, suffix: str) -> None:
    data = BLOCK.export(file_type=suffix)
    (tmp_path / f"block.{suffix}").write_bytes(data.encode() if isinstance(data, str) else data)
    job = Job("block", tmp_path / f"block.{suffix}", tmp_path, Options(up="z", mass=0.1))
    assert import_shape(job, tmp_path / "o")
    details = json.loads((tmp_path / "o" / "block" / "shape.json").read_text())
    np.testing.assert_allclose(details["extents"], [0.04, 0.05, 0.06], atol=1e-5)
    assert details["hulls"] == 1
    assert details["mass"] == 0.1


def test_glb_files_are_y_up(tmp_path: Path) -> None:
    (tmp_path / "block.glb").write_bytes(BLOCK.export(file_type="glb"))
    import_shape(Job("block", tmp_path / "block.glb", tmp_path, Options()), tmp_path / "o")
    details = json.loads((tmp_path / "o" / "block" / "shape.json").read_text())
    np.testing.assert_allclose(details["extents"], [0.04, 0.06, 0.05], atol=1e-5)


# ---------------------------------------------------------------- finding objects, resuming


def test_objects_are_found_and_named(tmp_path: Path) -> None:
    for name in (
        "mug/textured.obj",
        "mug/nontextured.ply",
        "001_can/google_16k/textured.obj",
        "flat/a.stl",
        "flat/a.obj",
        "flat/b.stl",
        "robot/thing.urdf",
        "robot/meshes/part.stl",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text('<robot name="r"><mesh filename="meshes/part.stl"/></robot>')
    found = {n: p.relative_to(tmp_path).as_posix() for n, p, _ in find_objects(tmp_path).objects}
    assert found == {
        "mug": "mug/textured.obj",
        "001_can": "001_can/google_16k/textured.obj",
        "a": "flat/a.obj",
        "b": "flat/b.stl",
        "thing": "robot/thing.urdf",
    }
    (tmp_path / "empty").mkdir()
    with pytest.raises(RefusedError, match="holds no"):
        find_objects(tmp_path / "empty")


def test_an_import_is_done_again_only_when_something_changed(tmp_path: Path) -> None:
    textured_obj(tmp_path)
    job, out = Job("plate", tmp_path / "plate.obj", tmp_path, Options(mass=0.05)), tmp_path / "out"
    assert import_shape(job, out)
    assert not import_shape(job, out)
    (tmp_path / "other.txt").write_text("nothing to do with it")
    assert not import_shape(job, out)
    Image.new("RGB", (8, 8), "white").save(tmp_path / "colours.png")
    assert import_shape(job, out)
    assert import_shape(Job("plate", job.path, tmp_path, Options(mass=0.06)), out)
    (out / "plate" / "shape.json").write_text("{")  # torn by a kill
    assert import_shape(job, out)


def test_an_imported_object_can_be_benchmarked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from grasp_bench.predictors import load_predictor
    from grasp_bench.scenario.outcomes import Outcome
    from grasp_bench.scenario.reading import load_scenario
    from grasp_bench.trials.trial import run_trial
    from grasp_bench.trials.workcell import Workcell
    from grasp_bench.workshop import poses

    monkeypatch.setattr(poses, "TRIED", 4)
    trimesh.creation.box((40, 90, 30)).export(tmp_path / "brick.stl")
    out = tmp_path / "out"
    report = importer.import_one(Job("brick", tmp_path / "brick.stl", tmp_path, Options(mass=0.2)), out)
    assert report.status == "imported"
    assert (
        importer.import_one(Job("brick", tmp_path / "brick.stl", tmp_path, Options(mass=0.2)), out).status
        == "up to date"
    )
    assert write_manifest(out) == 1
    assert Image.open(out / "brick" / "picture.jpg").size == (768, 256)
    model = Catalog(out).load("brick")
    footing = report.details["measured"]["footing"]
    assert max(footing["gap"], footing["sunk"], *map(abs, footing["extents"])) < 1
    trial = run_trial(
        Workcell(load_scenario("table4")), model, load_predictor("oracle"), trial=0, attempt=0, seed=0
    )
    assert trial.record.outcome is Outcome.SUCCESS


def test_the_command_imports_what_it_can_and_says_what_it_cannot(tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from grasp_bench.cli import app

    (tmp_path / "in").mkdir()
    trimesh.creation.box((30, 70, 20)).export(tmp_path / "in" / "stick.stl")
    (tmp_path / "in" / "broken.obj").write_text("v 0 0 0\nf 1 1 1\n")
    (tmp_path / "masses.csv").write_text("name,mass_kg\nstick,0.05\n")
    command = [
        "objects",
        "import",
        str(tmp_path / "in"),
        "--masses",
        str(tmp_path / "masses.csv"),
        "--out",
        str(tmp_path / "out"),
        "--units",
        "mm",
        "--workers",
        "2",
    ]
    first = CliRunner().invoke(app, command)
    assert first.exit_code == 1
    assert "broken: not imported: " in first.output
    assert "stick: imported, 30 × 70 × 20 mm, 50 g, 1 convex pieces" in first.output
    assert "1 of 2 objects imported" in first.output
    again = CliRunner().invoke(app, [*command, "--json"])
    assert again.exit_code == 1
    assert Catalog(tmp_path / "out").names == ["stick"]
    found = {r["name"]: r["status"] for r in json.loads(again.stdout)}
    assert found == {"stick": "up to date", "broken": "failed"}
    refused = CliRunner().invoke(app, ["objects", "import", str(tmp_path / "gone.obj")])
    assert isinstance(refused.exception, RefusedError)


def test_what_does_not_fit_the_gripper_is_kept_and_marked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from grasp_bench.workshop import poses

    monkeypatch.setattr(poses, "MAX_POSES", 1)
    trimesh.creation.box((100, 110, 105)).export(tmp_path / "crate.stl")
    job = Job("crate", tmp_path / "crate.stl", tmp_path, Options(mass=0.5))
    report = importer.import_one(job, tmp_path / "out")
    assert (report.status, report.graspable) == ("imported", False)
    listed = Listing(tmp_path / "out")
    assert (listed.write(), listed.graspable) == (1, 0)
    assert Catalog(tmp_path / "out").ungraspable(["crate"]) == ["crate"]


# ---------------------------------------------------------------- robot descriptions


def write_l_shape(directory: Path) -> Mesh:
    """Two convex parts of an L in ``meshes/``, and its whole mesh."""
    (directory / "meshes").mkdir()
    foot, leg = scale(box(60, 30, 20), 0.001), scale(move(box(20, 30, 40), x=-20, z=20), 0.001)
    for name, part in (("foot", foot), ("leg", leg)):
        part.export(directory / "meshes" / f"{name}.stl")
    whole = union(scale(foot, 1000), scale(leg, 1000))
    scale(whole, 0.001).export(directory / "meshes" / "whole.obj")
    return scale(whole, 0.001)


MJCF = """<mujoco><compiler meshdir="meshes" angle="degree"/><option gravity="0 0 -1"/>
<default><default class="shown"><geom contype="0" conaffinity="0" group="2"/></default></default>
<asset><mesh file="foot.stl"/><mesh file="leg.stl"/><mesh name="look" file="whole.obj"/>
<material name="red" rgba=".9 .1 .1 1"/></asset>
<worldbody><body name="l" pos="1 2 3"><freejoint/>
<inertial mass="0.3" pos="0 0 0.015" diaginertia="1e-4 2e-4 2e-4"/>
<geom class="shown" type="mesh" mesh="look" material="red"/>
<geom type="mesh" mesh="foot"/><geom type="mesh" mesh="leg"/></body></worldbody></mujoco>"""

URDF = """<robot name="l"><link name="base"><inertial><origin xyz="0 0 0.015"/><mass value="0.3"/>
<inertia ixx="1e-4" iyy="2e-4" izz="2e-4" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><mesh filename="package://some/meshes/whole.obj"/></geometry>
<material name="red"><color rgba=".9 .1 .1 1"/></material></visual>
<collision><geometry><mesh filename="package://some/meshes/foot.stl"/></geometry></collision></link>
<link name="upper"><collision><origin xyz="-0.02 0 0.02"/><geometry><box size="0.02 0.03 0.04"/></geometry>
</collision></link>
<joint name="j" type="fixed"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.02"/></joint>
</robot>"""


@pytest.mark.parametrize("text", [MJCF, URDF], ids=["mjcf", "urdf"])
def test_ready_convex_parts_are_kept(tmp_path: Path, text: str) -> None:
    whole = write_l_shape(tmp_path)
    (tmp_path / "l.xml").write_text(text)
    body = import_robot_file(Folder(tmp_path), "l.xml", Options())
    assert len(body.hulls) == 2
    assert sum(h.volume for h in body.hulls) == pytest.approx(whole.volume, rel=1e-4)
    assert body.error.volume_ratio == pytest.approx(1, abs=1e-3)
    assert body.solid.volume == pytest.approx(whole.volume, rel=1e-4)
    assert body.mass == pytest.approx(0.3)
    assert body.inertia is not None
    assert body.centre is not None
    np.testing.assert_allclose(np.linalg.eigvalsh(body.inertia), [1e-4, 2e-4, 2e-4], rtol=1e-6)
    offset = body.centre - body.solid.bounds.mean(0)
    np.testing.assert_allclose(offset, [0, 0, -0.015], atol=1e-5)
    assert len(body.visual) == 1
    np.testing.assert_allclose(body.visual[0].rgb, (0.9, 0.1, 0.1), atol=0.01)
    np.testing.assert_allclose(np.ptp(body.visual[0].vertices, axis=0), [0.06, 0.03, 0.06], atol=1e-5)


def test_a_part_that_is_not_convex_is_decomposed(tmp_path: Path) -> None:
    write_l_shape(tmp_path)
    (tmp_path / "l.urdf").write_text(
        '<robot name="l"><link name="a"><collision><geometry>'
        '<mesh filename="meshes/whole.obj"/></geometry></collision></link>'
        "</robot>"
    )
    body = import_robot_file(Folder(tmp_path), "l.urdf", Options())
    assert len(body.hulls) >= 2
    assert "1 of its parts are not convex: decomposed" in body.notes
    assert body.mass is None


# ---------------------------------------------------------------- real scans


def ycb_import(name: str, out: Path) -> dict[str, Any]:
    scans = real_samples("ycb")
    masses = read_masses(scans / "masses.csv")
    job = Job(name, scans / name / "textured.obj", scans / name, Options(mass=masses[name].mass))
    return importer.import_one(job, out).details


@pytest.mark.parametrize("name", ["banana", "bowl", "dice"])
def test_real_scans_rest_as_they_were_scanned_and_are_lifted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    from grasp_bench.predictors import load_predictor
    from grasp_bench.scenario.reading import load_scenario
    from grasp_bench.trials.trial import run_trial
    from grasp_bench.trials.workcell import Workcell
    from grasp_bench.workshop import poses

    monkeypatch.setattr(poses, "TRIED", 5)
    details = ycb_import(name, tmp_path)
    assert details["faces"] >= 16_000
    assert details["hulls"] <= MAX_HULLS
    footing, cavity = details["measured"]["footing"], details["measured"]["cavity"]
    assert max(footing["gap"], footing["sunk"], *map(abs, footing["extents"])) < 2  # mm
    write_manifest(tmp_path)
    model = Catalog(tmp_path).load(name)
    assert max(len(h) for h in model.hulls) <= MAX_VERTICES
    if name == "bowl":
        assert cavity["hulls"] > 0.85 * cavity["scan"] > 400  # ml
        assert any(not p.grasps for p in model.poses)  # upside down it does not fit the gripper
        shown = np.vstack([p.vertices for p in model.visual])
        axis = shown[:, :2].min(0) / 2 + shown[:, :2].max(0) / 2
        bottom = shown[np.linalg.norm(shown[:, :2] - axis, axis=1) < 0.004][:, 2].max()
        ray = np.column_stack([np.tile(axis, (40, 1)), np.linspace(shown[:, 2].max(), bottom + 0.003, 40)])
        assert not inside_hulls(model.hulls, ray).any()
    cell, oracle = Workcell(load_scenario("table4")), load_predictor("oracle")
    done = [run_trial(cell, model, oracle, trial=i, attempt=i, seed=0).record for i in range(2)]
    assert all(r.success for r in done), [r.detail for r in done]


@pytest.mark.parametrize(
    ("geom", "volume"),
    [
        ('type="sphere" size="0.02"', 4 / 3 * np.pi * 0.02**3),
        ('type="ellipsoid" size="0.02 0.015 0.01"', 4 / 3 * np.pi * 3e-6),
        ('type="cylinder" size="0.02 0.01"', np.pi * 0.02**2 * 0.02),
        ('type="capsule" size="0.01 0.02"', np.pi * 1e-4 * 0.04 + 4 / 3 * np.pi * 1e-6),
    ],
)
def test_primitive_geoms_are_parts(tmp_path: Path, geom: str, volume: float) -> None:
    (tmp_path / "it.xml").write_text(
        f"<mujoco><worldbody><body><freejoint/><geom {geom}/></body></worldbody></mujoco>"
    )
    body = import_robot_file(Folder(tmp_path), "it.xml", Options())
    assert len(body.hulls) == 1
    assert body.solid.volume == pytest.approx(volume, rel=0.06)  # facets cut corners
