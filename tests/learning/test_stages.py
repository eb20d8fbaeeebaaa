"""Scenes as cameras see them: their cameras, surroundings, sensors, pictures and labels."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from grasp_bench.camera import RgbdImage
from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.grasps import Grasp, angle_difference
from grasp_bench.learning.data import generate, random_solids, synthetic
from grasp_bench.learning.data.random_shapes import RandomObject, assemble
from grasp_bench.learning.data.scenes import load_scene
from grasp_bench.learning.data.stages import around
from grasp_bench.learning.data.stages.annotating import annotated
from grasp_bench.learning.data.stages.owning import OBJECTS_ONLY, only_of_objects
from grasp_bench.learning.data.stages.shot import Shot, shoot
from grasp_bench.learning.data.stages.staging import Stage, draw_camera, draw_sensor, draw_stage
from grasp_bench.learning.data.stages.style import ColourStyle, Style, SurroundingsStyle, read_style
from grasp_bench.learning.data.synthetic import SynthConfig, make_scene, record
from grasp_bench.planning import heightfield
from grasp_bench.planning.depth import grasp_pose
from grasp_bench.planning.seen import SeenScene
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.sensors import Sensor
from grasp_bench.scenario.surroundings import Fixture, Surroundings
from grasp_bench.scene.builder import compile_mjcf, compose
from grasp_bench.scene.floating import FloatingGripper, compile_floating
from grasp_bench.workshop.poses import measure_heights
from grasp_bench.workshop.shapes import box

BASE = load_scenario("table4")
CENTER = np.array(BASE.table.center)
STYLE = Style()
CONFIG = SynthConfig(tries=2, style=STYLE)
PLACE = around.Place(CENTER, np.array([0.5, -0.5, 0.6]), 0.3, (0.6, 0.6, 0.6))


def long_box() -> RandomObject:
    return assemble(np.random.default_rng(1), [[random_solids.convex(box(120, 30, 40))]], "box")


def put_down(scenario: Scenario, model: RandomObject, x: float = 0.5, y: float = 0.0) -> FloatingGripper:
    gripper = FloatingGripper(compile_floating(scenario, [model]), scenario)
    q = gripper.object_q[0]
    gripper.data.qpos[q : q + 3] = x, y, 0.0005 - min(h[:, 2].min() for h in model.hulls)
    assert gripper.settle(1.0)
    mujoco.mj_forward(gripper.model, gripper.data)
    return gripper


def tilted(degrees: float, *fixtures: Fixture, **sensor: object) -> Scenario:
    """A camera 0.6 m away that looks at the table's middle from beside, without noise."""
    lean = math.radians(degrees)
    camera = BASE.camera.model_copy(
        update={"position": (0.5, -0.6 * math.sin(lean), 0.6 * math.cos(lean)), "image_up": (0.0, 1.0, 0.0)}
    )
    stage = draw_stage(BASE, STYLE, 320, np.random.default_rng(0)).scenario
    return BASE.model_copy(
        update={
            "camera": camera,
            "sensor": Sensor.model_validate({"preset": "ideal", **sensor}),
            "look": stage.look,
            "surroundings": Surroundings(fixtures=fixtures),
        }
    )


# ---------------------------------------------------------------- what is drawn


def test_cameras_are_within_the_styles_ranges_and_fill_them() -> None:
    rng, style = np.random.default_rng(0), STYLE.camera
    heights, tilts, fovs, scales = [], [], [], []
    for _ in range(300):
        camera, scale = draw_camera(BASE.camera, style, CENTER, rng)
        pose = camera.pose
        heights.append(pose.position[2])
        tilts.append(math.degrees(math.acos(-pose.rotation[2, 2])))
        fovs.append(camera.horizontal_fov_deg)
        scales.append(camera.intrinsics.fx / np.linalg.norm(pose.position - camera.target))
        assert scales[-1] == pytest.approx(scale, rel=0.01)
        assert np.abs(np.array(camera.target[:2]) - CENTER).max() <= style.off_centre
    for values, (low, high) in (
        (heights, style.height),
        (tilts, style.tilt_deg),
        (fovs, style.fov_deg),
        (scales, style.pixels_per_metre),
    ):
        assert low - 0.5 <= min(values) < low + 0.3 * (high - low)
        assert high - 0.3 * (high - low) < max(values) <= high + 0.5


def test_ranges_that_no_camera_meets_are_refused() -> None:
    style = STYLE.camera.model_copy(update={"width": (5.0, 6.0)})
    with pytest.raises(GraspBenchError, match="No camera"):
        draw_camera(BASE.camera, style, CENTER, np.random.default_rng(0))


@pytest.mark.parametrize("kind", ["walls", "bin", "tray", "shelf", "things", "large", "robot", "flat"])
def test_each_surrounding_compiles_and_leaves_room_for_the_objects(kind: str) -> None:
    style, colour = SurroundingsStyle(corner=1.0), ColourStyle()
    kinds: dict[str, Callable[[np.random.Generator], list[Fixture]]] = {
        "walls": lambda rng: around.walls(rng, style, colour, PLACE),
        "bin": lambda rng: around.rims(rng, PLACE, high=True),
        "tray": lambda rng: around.rims(rng, PLACE, high=False),
        "shelf": lambda rng: around.shelf(rng, PLACE),
        "things": lambda rng: around.things(rng, PLACE),
        "large": lambda rng: around.large_things(rng, PLACE),
        "robot": lambda rng: around.robot_links(rng, PLACE),
        "flat": lambda rng: around.flat_things(rng, PLACE),
    }
    made = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        fixtures = kinds[kind](rng)
        made += bool(fixtures)
        scenario = BASE.model_copy(update={"surroundings": Surroundings(fixtures=tuple(fixtures))})
        model = compile_mjcf(compose(scenario, None, robot=None))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        # Where objects are put down nothing is higher than a sheet of paper, whatever stands around.
        field = measure_heights(model, data, (0.5, 0.0), (0.5, 0.0), 0.07)
        if kind != "robot":
            assert field.heights.max() < 0.003, seed
        tops = {"walls": (0.08, 1.6), "bin": (0.04, 0.12), "tray": (0.008, 0.03), "flat": (0.0, 0.002)}.get(
            kind
        )
        if tops and fixtures:
            heights = [f.position[2] + f.size[2] / 2 for f in fixtures]
            assert tops[0] <= max(heights) <= tops[1]
    assert made >= 8


def test_edges_end_the_table_and_show_the_floor() -> None:
    style = SurroundingsStyle(edge_distance=(0.5, 0.8))
    sides = around.table_edges(np.random.default_rng(3), style, PLACE)
    scenario = BASE.model_copy(update={"surroundings": Surroundings(table=sides, floor_height=-0.5)})
    model = compile_mjcf(compose(scenario, None, robot=None))
    near = np.abs(np.array(sides) - np.tile(CENTER, 2)) < 0.3
    assert 1 <= near.sum() <= 3
    side = int(np.flatnonzero(near)[0])
    beyond = CENTER.copy()
    beyond[side % 2] = sides[side] + (0.02 if side >= 2 else -0.02)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    seen = mujoco.mj_ray(
        model, data, np.array([*beyond, 1.0]), np.array([0.0, 0, -1]), np.array([1, 1, 1, 0, 0, 0], np.uint8),
        True, -1, np.zeros(1, np.int32),
    )  # fmt: skip
    assert seen == pytest.approx(1.5)


def test_every_sensor_of_the_style_is_drawn_and_some_are_filled() -> None:
    rng = np.random.default_rng(0)
    sensors = [draw_sensor(STYLE.depth, STYLE.colour, rng) for _ in range(200)]
    assert {s.preset for s in sensors} == set(STYLE.depth.presets)
    assert 0.25 < np.mean([s.filled for s in sensors]) < 0.55
    assert 0.3 < np.mean([s.jpeg_quality > 0 for s in sensors]) < 0.7
    assert all(s == Sensor.model_validate(s.model_dump()) for s in sensors)  # within its bounds


# ---------------------------------------------------------------- styles


def test_a_style_is_a_preset_or_a_file_of_what_differs(tmp_path: Path) -> None:
    assert read_style("plain") is None
    assert read_style("camera-like") == Style()
    path = tmp_path / "mine.yaml"
    path.write_text("camera: {tilt_deg: [0, 10]}\nsurroundings: {bin: 1.0}\n")
    style = read_style(str(path))
    assert style is not None
    assert (style.camera.tilt_deg, style.surroundings.bin, style.camera.height) == ((0, 10), 1, (0.4, 1.2))


BOMB = [f"{c}: &{c} [{','.join(['*' + b] * 9)}]\n" for b, c in zip("abcdefgh", "bcdefghi", strict=True)]
"""300 bytes that stand for 400 million values."""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("camera: {tilt: [0, 1]}", "camera.tilt"),
        ("camera: {tilt_deg: [9, 1]}", "camera.tilt_deg"),
        ("depth: {presets: {kinect: 1}}", "depth.presets"),
        ("depth: {presets: {ideal: 0}}", "a share above 0"),
        ("camera: [", "cannot be read"),
        ("camra: {tilt_deg: [0, 1]}", "Unknown key 'camra'. Did you mean camera?"),
        ("camera: {tilt_dg: [0, 1]}", "Did you mean tilt_deg"),
        ("camera: {}\ncamera: {}", "cannot be read"),
        ("&a [*a]", "cannot be read"),
        ("a: &a [x,x,x,x,x,x,x,x,x]\n" + "".join(BOMB), "cannot be read"),
    ],
)
def test_what_is_wrong_with_a_style_is_said(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(GraspBenchError, match=r"mine\.yaml") as caught:
        read_style(str(path))
    assert words in str(caught.value)
    with pytest.raises(UnknownNameError, match="Did you mean camera-like"):
        read_style("camera-lke")


def test_the_style_is_recorded_and_plain_data_sets_stay_what_they_were(tmp_path: Path) -> None:
    made = generate.generate(tmp_path / "a", 1, 3, CONFIG, workers=1)
    assert not made.failed
    told = json.loads((tmp_path / "a" / "config.json").read_text())
    assert Style.model_validate(told["config"].pop("style")) == STYLE
    assert told["config"] == SynthConfig(tries=2).described()
    assert "style" not in SynthConfig().described()
    with pytest.raises(GraspBenchError, match="another folder"):
        generate.generate(tmp_path / "a", 1, 3, SynthConfig(tries=2), workers=1)
    annotations = load_scene(tmp_path / "a" / made.entries[0]["file"]).annotated
    assert annotations is not None
    assert annotations.shape[1] == 6


def test_scenes_depend_on_seed_and_index_only() -> None:
    first, again, other = make_scene(4, 2, CONFIG), make_scene(4, 2, CONFIG), make_scene(4, 3, CONFIG)
    assert first.keys() == again.keys()
    assert all(np.array_equal(first[k], again[k]) for k in first)
    assert not np.array_equal(first["rgb"], other["rgb"])


# ---------------------------------------------------------------- pictures and labels


def scene_of(
    stage: Stage, gripper: FloatingGripper, model: RandomObject, tries: int = 10
) -> tuple[dict, Shot]:
    shot = shoot(stage, gripper.model, gripper.data, 320, np.random.default_rng(0))
    assert shot.usable(gripper.model)
    return record(gripper, [model], SynthConfig(tries=tries), np.random.default_rng(0), shot), shot


@pytest.mark.parametrize("detrended", [False, True])
@pytest.mark.parametrize("degrees", [0.0, 35.0])
def test_labels_are_where_the_planner_reads_the_grasp_back(detrended: bool, degrees: float) -> None:
    model = long_box()
    scenario = tilted(degrees)
    gripper = put_down(scenario, model, 0.52, 0.02)
    scene, shot = scene_of(Stage(scenario, detrended), gripper, model)
    down = math.degrees(math.acos(-shot.pose.rotation[2, 2]))
    assert down == pytest.approx(degrees if detrended else 0.0, abs=0.5)
    seen = SeenScene(RgbdImage(shot.rgb, shot.truth.depth, shot.intrinsics), shot.pose)
    row, column = np.unravel_index(np.argmax(scene["quality"]), scene["quality"].shape)
    grasp = Grasp(
        column + 0.5, row + 0.5, float(scene["angle"][row, column]), float(scene["width"][row, column])
    )
    read, top = grasp_pose(seen, grasp, scenario.motion)
    assert abs(read.position[1] - 0.02) < 0.004  # on the long axis, which is along the world's x
    assert angle_difference(math.atan2(read.rotation[1, 0], read.rotation[0, 0]), math.pi / 2) < 0.11
    assert top == pytest.approx(0.04, abs=0.003)
    assert 0.030 < read.opening < 0.060


@pytest.mark.parametrize("origin", [None, (0.3, 0.2, -0.1)])
def test_a_detrended_table_is_level_and_the_object_stands_out(
    origin: tuple[float, float, float] | None,
) -> None:
    model = long_box()
    scenario = tilted(40.0)
    gripper = put_down(scenario, model)
    shot = shoot(Stage(scenario, True, origin), gripper.model, gripper.data, 320, np.random.default_rng(0))
    middle = slice(80, 240)
    height = (np.median(shot.depth) - shot.depth)[middle, middle]
    rays = shot.intrinsics.rays() @ shot.pose.rotation[2]
    true = (shot.pose.position[2] + rays * shot.truth.depth)[middle, middle]
    assert np.abs(height[np.abs(true) < 1e-3]).mean() < 0.004
    assert height[true > 0.035].mean() > 0.015


def test_a_picture_of_a_wall_and_one_without_the_object_are_of_no_use() -> None:
    model = long_box()
    wall = Fixture(size=(2.0, 0.02, 2.0), position=(0.5, -0.1, 0.5))
    hidden = tilted(40.0, wall)
    gripper = put_down(hidden, model, 0.5, 0.05)
    shot = shoot(Stage(hidden, False), gripper.model, gripper.data, 320, np.random.default_rng(0))
    assert not shot.usable(gripper.model)


def test_nothing_around_is_labelled_and_objects_beside_it_are() -> None:
    model = long_box()
    rim = Fixture(size=(0.3, 0.02, 0.05), position=(0.5, 0.1, 0.025))
    scenario = tilted(20.0, rim)
    gripper = put_down(scenario, model)
    field = measure_heights(gripper.model, gripper.data, (0.5, 0.0), (0.5, 0.0), 0.17)
    found = heightfield.analyse(field, gripper=gripper.gripper)
    rows = np.rint((0.1 - field.origin[1]) / heightfield.CELL).astype(int)
    assert found.quality[rows - 3 : rows + 4].max() > 0.1  # a rim can be held, by its shape
    objects = measure_heights(gripper.model, gripper.data, (0.5, 0.0), (0.5, 0.0), 0.17, OBJECTS_ONLY)
    own = only_of_objects(found, field, objects)
    assert own.quality[rows - 6 : rows + 7].max() == 0
    assert own.quality.max() == found.quality.max()
    scene, shot = scene_of(Stage(scenario, False), gripper, model)
    fixture = shot.truth.geom == gripper.model.geom("fixture0").id
    assert fixture.sum() > 500
    assert not scene["quality"][fixture].any()
    assert scene["quality"].any()


def test_a_grasp_of_a_wall_does_not_hold() -> None:
    model = long_box()
    rim = Fixture(size=(0.3, 0.02, 0.05), position=(0.5, 0.15, 0.025))
    scenario = tilted(0.0, rim)
    gripper = put_down(scenario, model)
    ended = gripper.attempt(gripper.state(), np.array([0.5, 0.15, 0.02]), math.pi / 2, 0.06)
    assert not ended.held


def test_people_draw_across_the_object_and_a_little_beyond() -> None:
    mask = np.zeros((100, 100), bool)
    mask[20:80, 40:60] = True  # 20 px wide; 500 px a metre
    off = np.array(
        [[46.0, 50.0, 0.0, 40.0, 1.0], [10.0, 50.0, 0.0, 40.0, 1.0], [50.0, 50.0, np.pi / 2, 40.0, 1.0]]
    )
    drawn = annotated(off, mask, 500.0)
    assert len(drawn) == 1  # one beside the object, and one along it that the jaws do not span, are left out
    x, y, angle, width, height, _ = drawn[0]
    assert (x, y) == pytest.approx((50, 50), abs=1)
    assert angle == 0
    assert 24 < width < 30
    assert height == pytest.approx(0.045 * 500, abs=2)
    mask[52:] = False  # near the end the rectangle is lower and its middle moves away from the end
    assert annotated(off[:1], mask, 500.0)[0, 1] < 48


def test_plain_scenes_do_not_know_of_stages() -> None:
    scene = make_scene(11, 1, SynthConfig(tries=2))
    assert "annotated" not in scene
    assert synthetic.SynthConfig().style is None
