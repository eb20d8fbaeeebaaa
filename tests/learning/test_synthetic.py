"""Synthetic scenes: reproducible, well-formed, and labelled with grasps that the planner reads back."""

from __future__ import annotations

import math
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from filelock import FileLock

from grasp_bench.camera import CameraPose, Intrinsics, RgbdImage
from grasp_bench.cli import data as cli
from grasp_bench.errors import GraspBenchError
from grasp_bench.grasps import Grasp, angle_difference
from grasp_bench.learning.data import generate, random_solids, synthetic
from grasp_bench.learning.data.candidates import SOURCES
from grasp_bench.learning.data.random_shapes import RandomObject, assemble, random_object
from grasp_bench.learning.data.scenes import DEPTH_UNIT, load_scenes
from grasp_bench.learning.data.stages.plain import plain_shot
from grasp_bench.learning.data.synthetic import SynthConfig, make_scene, record
from grasp_bench.planning.depth import grasp_pose
from grasp_bench.planning.seen import SeenScene
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.floating import FloatingGripper, compile_floating
from grasp_bench.workshop.shapes import Mesh, box, union

QUICK = SynthConfig(tries=2)


def same(first: dict[str, np.ndarray], second: dict[str, np.ndarray]) -> bool:
    return first.keys() == second.keys() and all(np.array_equal(first[k], second[k]) for k in first)


@pytest.fixture(scope="module")
def scenes() -> list[dict[str, np.ndarray]]:
    return [make_scene(11, i, QUICK) for i in range(3)]


# ---------------------------------------------------------------- scenes


def test_scene_depends_on_seed_and_index_only(scenes: list[dict[str, np.ndarray]]) -> None:
    assert same(make_scene(11, 1, QUICK), scenes[1])
    assert not same(make_scene(12, 1, QUICK), scenes[1])


def test_arrays_have_their_types_and_ranges(scenes: list[dict[str, np.ndarray]]) -> None:
    for scene in scenes:
        assert scene["rgb"].shape == (320, 320, 3)
        assert scene["rgb"].dtype == np.uint8
        for name, kind in (
            ("depth", np.uint16),
            ("depth_true", np.uint16),
            ("quality", np.uint8),
            ("angle", np.float16),
            ("width", np.float16),
        ):
            assert scene[name].shape == (320, 320)
            assert scene[name].dtype == kind
        assert np.isfinite(scene["angle"]).all()
        assert (np.abs(scene["angle"]) <= math.pi / 2).all()
        on = scene["quality"] > 0
        assert (scene["width"][on] > 4).all()
        assert (scene["width"] < 90).all()
        assert not scene["angle"][~on].any()
        assert not scene["width"][~on].any()
        assert scene["tried"].shape[1] == 6
        assert len(scene["tried"]) <= 2
        assert len(scene["grasps"]) == scene["tried"][:, 5].sum()
        assert (scene["grasps"][:, 4] == 1).all()
        assert 0.4 < np.median(scene["depth_true"]) * DEPTH_UNIT < 0.7


# ---------------------------------------------------------------- files


def test_files_do_not_depend_on_workers_and_are_kept(tmp_path: Path) -> None:
    one, two = tmp_path / "one", tmp_path / "two"
    generate.generate(two, 2, 7, QUICK, workers=2)
    shutil.copytree(two, one)
    kept, broken = (one / "scenes" / f"00000{i}.npz" for i in range(2))
    stamp = kept.stat().st_mtime_ns
    broken.write_bytes(broken.read_bytes()[:-100])
    (one / "index.jsonl").unlink()
    made = generate.generate(one, 2, 7, QUICK, workers=1)
    assert not made.failed
    assert kept.stat().st_mtime_ns == stamp
    assert (one / "index.jsonl").read_text() == (two / "index.jsonl").read_text()
    with np.load(broken) as a, np.load(two / "scenes" / broken.name) as b:
        assert same(dict(a), dict(b))
    loaded = load_scenes([two])
    assert [s.name for s in loaded.val] == ["000000"]
    assert [s.name for s in loaded.train] == ["000001"]
    sheet = tmp_path / "sheet.png"
    cli.show_command(two, 2, sheet)
    assert sheet.stat().st_size > 10000
    with pytest.raises(GraspBenchError, match="another folder"):
        generate.generate(two, 2, 8, QUICK)


def test_two_generations_into_one_folder_are_refused(tmp_path: Path) -> None:
    with FileLock(tmp_path / ".lock"), pytest.raises(GraspBenchError, match="are being generated into"):
        generate.generate(tmp_path, 1, 7, QUICK, workers=1)
    assert not (tmp_path / "index.jsonl").exists()


# ---------------------------------------------------------------- labels


def on_table(
    model: RandomObject, scenario: Scenario, x: float, y: float, tries: int = 10
) -> dict[str, np.ndarray]:
    """Scene of one object put down as it is modelled, unturned."""
    gripper = FloatingGripper(compile_floating(scenario, [model]), scenario)
    q = gripper.object_q[0]
    gripper.data.qpos[q : q + 3] = x, y, 0.0005 - min(h[:, 2].min() for h in model.hulls)
    assert gripper.settle(1.0)
    rng = np.random.default_rng(0)
    shot = plain_shot(gripper.scenario, gripper.model, gripper.data, 320, rng)
    return record(gripper, [model], SynthConfig(tries=tries), rng, shot)


@pytest.mark.parametrize("roll", [0.0, 20.0])
def test_best_grasp_of_a_box_is_across_it(roll: float) -> None:
    base = load_scenario("table4")
    up = (math.cos(math.radians(roll)), math.sin(math.radians(roll)), 0.0)
    camera = base.camera.model_copy(update={"image_up": up, "position": (0.508, -0.006, 0.55)})
    scenario = base.model_copy(update={"camera": camera})
    model = assemble(np.random.default_rng(1), [[random_solids.convex(box(120, 30, 40))]], "box")
    x, y = 0.54, 0.05
    scene = on_table(model, scenario, x, y)
    fx, fy, cx, cy = scene["intrinsics"]
    pose = CameraPose(scene["camera_position"], scene["camera_rotation"])
    intrinsics = Intrinsics(320, 320, fx, fy, cx, cy)
    depth = (scene["depth_true"] * DEPTH_UNIT).astype(np.float32)
    seen = SeenScene(RgbdImage(scene["rgb"], depth, intrinsics), pose)

    row, column = np.unravel_index(np.argmax(scene["quality"]), scene["quality"].shape)
    assert scene["quality"][row, column] > 100
    angle, width = (float(scene[k][row, column]) for k in ("angle", "width"))
    label = Grasp(column + 0.5, row + 0.5, angle, width)
    best = scene["tried"][(scene["source"] == SOURCES.index("maximum")) & (scene["tried"][:, 5] == 1), :5]
    assert len(best)
    for grasp in (label, *(Grasp(*g) for g in best.tolist())):
        read, top = grasp_pose(seen, grasp, scenario.motion)
        assert abs(read.position[1] - y) < (0.003 if grasp is label else 0.016)  # on the long axis
        assert abs(read.position[0] - x) < 0.06
        assert angle_difference(math.atan2(read.rotation[1, 0], read.rotation[0, 0]), math.pi / 2) < 0.11
        assert top == pytest.approx(0.04, abs=0.002)
        assert 0.030 < read.opening < (0.055 if grasp is label else 0.075)
    # Across the box is world y, along the image's rows; a camera turned to the left turns it to the right.
    assert angle_difference(label.angle, -math.radians(roll)) < 0.11
    assert len(scene["grasps"]) == scene["tried"][:, 5].sum()


def test_candidates_are_good_poor_and_wrong_and_physics_tells_them_apart() -> None:
    scenario = load_scenario("table4")
    model = assemble(np.random.default_rng(1), [[random_solids.convex(box(120, 30, 40))]], "box")
    scene = on_table(model, scenario, 0.5, 0.0, tries=40)
    angle, held = scene["tried"][:, 2], scene["tried"][:, 5] == 1
    of = {name: scene["source"] == i for i, name in enumerate(SOURCES)}
    assert all(mask.any() for mask in of.values()), {k: int(v.sum()) for k, v in of.items()}
    assert held[of["maximum"]].mean() > 0.8
    # The image's up is the arm's forward, so the box lies along the image's columns: across it is angle 0.
    assert (np.abs(np.sin(angle[of["antipodal"]])) < 0.36).all()  # within the friction cone of the sides
    assert held[of["antipodal"]].any()
    along = np.abs(np.sin(angle)) > 0.9  # 120 mm do not fit the jaws
    assert along.any()
    assert not held[along].any()


# ---------------------------------------------------------------- shapes


def test_what_a_try_says_does_not_hang_on_the_time_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """With stiff pads, tries at 4 ms lose a quarter of the grasps that hold: labels would be wrong."""
    said: dict[float, list[bool]] = {1.0: [], 0.5: []}

    def attempts(gripper: FloatingGripper, *what: Any) -> np.ndarray:
        own, (qpos, qvel) = gripper.model.opt.timestep, gripper.state()
        answers = {}
        for part in said:
            gripper.model.opt.timestep = part * own
            gripper.data.qpos[:], gripper.data.qvel[:] = qpos, qvel
            answers[part] = really(gripper, *what)
            said[part] += answers[part].tolist()
        gripper.model.opt.timestep = own
        return answers[1.0]

    really = synthetic._attempts
    monkeypatch.setattr(synthetic, "_attempts", attempts)
    for index in range(5):
        make_scene(1, index, SynthConfig(tries=12))
    whole, half = np.array(said[1.0]), np.array(said[0.5])
    assert len(whole) >= 60
    assert 0.2 < whole.mean() < 0.95
    assert (whole == half).mean() >= 0.9
    assert abs(whole.mean() - half.mean()) <= 0.06


def test_shapes_are_closed_and_their_pieces_fill_them() -> None:
    errors, kinds = [], set()
    for i in range(80):
        model = random_object(np.random.default_rng([5, i]))
        kinds.add(model.kind)
        parts = [Mesh(v.vertices, v.faces, process=False) for v in model.visual]
        assert all(p.is_watertight and p.volume > 0 for p in parts), model.kind
        assert len(model.hulls) <= 40
        size = np.ptp(np.vstack([p.vertices for p in parts]), axis=0).max()
        assert 0.0149 < size < 0.3001
        assert 0.01 <= model.mass <= 1.2
        assert 0.45 <= model.friction <= 0.95
        assert (np.linalg.eigvalsh(model.inertia) > 0).all()
        if i < 40:
            solid = union(*(trimesh.convex.convex_hull(1000 * h) for h in model.hulls))
            shown = union(*(Mesh(1000 * p.vertices, p.faces, process=False) for p in parts))
            errors.append(abs(solid.volume / shown.volume - 1))
    assert np.median(errors) < 0.25
    assert len(kinds) > 8


def test_generator_knows_nothing_of_the_benchmarks_objects() -> None:
    code = (
        "import sys, grasp_bench.learning.data.synthetic, grasp_bench.learning.data.generate; "
        "sys.exit(any('household' in m for m in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
