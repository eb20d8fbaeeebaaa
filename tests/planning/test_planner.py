"""From a grasp in a depth image to the arm's motion, on depth images of known geometry."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from grasp_bench.camera import RgbdImage
from grasp_bench.grasps import Grasp
from grasp_bench.planning.depth import grasp_pose, widening
from grasp_bench.planning.planner import Planner
from grasp_bench.planning.refusals import Blocked, Unreachable
from grasp_bench.planning.seen import SeenScene
from grasp_bench.robot.robot import EC66_PARALLEL_85
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Execution, Motion, Scenario, Table

CAMERA = load_scenario("table4").camera
K, POSE = CAMERA.intrinsics, CAMERA.pose
HIGH = CAMERA.position[2]
MOTION = Motion()


def ground(*boxes: tuple[float, float, float, float, float]) -> np.ndarray:
    """Perfect depth image of level boxes (x, y, length in x, length in y, height) on the table."""
    rays = K.rays() @ POSE.rotation.T
    depth = np.full((K.height, K.width), HIGH)
    for x, y, along_x, along_y, height in sorted(boxes, key=lambda b: b[4]):
        at = POSE.position + rays * (HIGH - height)
        on = (np.abs(at[..., 0] - x) < along_x / 2) & (np.abs(at[..., 1] - y) < along_y / 2)
        depth[on] = HIGH - height
    return depth


def look(depth: np.ndarray) -> SeenScene:
    rgb = np.zeros((K.height, K.width, 3), np.uint8)
    return SeenScene(RgbdImage(rgb, depth.astype(np.float32), K), POSE)


def grasp_at(x: float, y: float, height: float, yaw: float, opening: float) -> Grasp:
    """The image-plane grasp that a camera sees of a world grasp in the plane z = ``height``."""
    half = opening / 2 * np.array([math.cos(yaw), math.sin(yaw), 0])
    ends = K.project(POSE.to_camera(np.array([x, y, height]) + [-half, half]))
    (dx, dy), (u, v) = ends[1] - ends[0], ends.mean(0)
    return Grasp(u, v, math.atan2(-dy, dx), math.hypot(dx, dy))


@pytest.mark.parametrize(
    ("x", "y", "yaw"), [(0.5, 0.0, 0.0), (0.45, 0.06, 0.6), (0.56, -0.05, -1.2), (0.5, 0.1, 1.5)]
)
def test_position_yaw_and_opening_come_back_from_the_image(x: float, y: float, yaw: float) -> None:
    scene = look(ground((x, y, 0.05, 0.05, 0.06)))
    pose, top = grasp_pose(scene, grasp_at(x, y, 0.06, yaw, 0.08), MOTION)
    assert top == pytest.approx(0.06, abs=1e-4)
    np.testing.assert_allclose(pose.position[:2], [x, y], atol=2e-4)
    assert pose.opening == pytest.approx(0.08, abs=2e-4)
    assert abs(math.sin(math.atan2(pose.rotation[1, 0], pose.rotation[0, 0]) - yaw)) < 1e-3


@pytest.mark.parametrize(("height", "tip"), [(0.10, 0.072), (0.06, 0.032), (0.029, 0.002), (0.02, 0.002)])
def test_tips_go_down_by_the_insertion_but_never_into_the_table(height: float, tip: float) -> None:
    scene = look(ground((0.5, 0, 0.04, 0.08, height)))
    pose, _ = grasp_pose(scene, grasp_at(0.5, 0, height, 0, 0.06), MOTION)
    assert pose.position[2] == pytest.approx(tip, abs=1e-4)


def test_insertion_and_clearance_are_the_scenarios() -> None:
    motion = MOTION.model_copy(update={"insertion": 0.01, "table_clearance": 0.005})
    scene = look(ground((0.5, 0, 0.04, 0.08, 0.06)))
    pose, _ = grasp_pose(scene, grasp_at(0.5, 0, 0.06, 0, 0.06), motion)
    assert pose.position[2] == pytest.approx(0.05, abs=1e-4)
    low, _ = grasp_pose(look(ground((0.5, 0, 0.04, 0.08, 0.012))), grasp_at(0.5, 0, 0.012, 0, 0.06), motion)
    assert low.position[2] == pytest.approx(0.005)


def test_the_jaws_open_no_wider_than_they_can() -> None:
    pose, _ = grasp_pose(look(ground((0.5, 0, 0.04, 0.08, 0.06))), grasp_at(0.5, 0, 0.06, 0, 0.15), MOTION)
    assert pose.opening == pytest.approx(EC66_PARALLEL_85.gripper.opening)


@pytest.mark.parametrize("side", [-1, 1])
def test_tips_stay_above_what_is_seen_under_an_open_finger(side: int) -> None:
    # A step, 45 mm high, where one of the fingers comes down: 13 mm above the tip's usual place.
    scene = look(ground((0.5, 0, 0.03, 0.08, 0.06), (0.5 + side * 0.05, 0, 0.04, 0.08, 0.045)))
    pose, _ = grasp_pose(scene, grasp_at(0.5, 0, 0.06, 0, 0.06), MOTION)
    assert pose.position[2] == pytest.approx(0.045 + MOTION.table_clearance, abs=1e-3)


def test_a_thin_rod_under_the_corner_of_a_finger_is_seen() -> None:
    # 5 mm thick and 12 mm high, it reaches 6 mm under one finger: a few pixels of many.
    scene = look(ground((0.5, 0, 0.03, 0.08, 0.06), (0.534, 0.02, 0.005, 0.02, 0.04)))
    pose, _ = grasp_pose(scene, grasp_at(0.5, 0, 0.06, 0, 0.06), MOTION)
    assert pose.position[2] > 0.04 or pose.opening > 0.075


def test_what_stands_beside_the_fingers_does_not_raise_them() -> None:
    scene = look(ground((0.5, 0, 0.03, 0.03, 0.06), (0.5, 0.05, 0.1, 0.04, 0.045)))
    pose, _ = grasp_pose(scene, grasp_at(0.5, 0, 0.06, 0, 0.06), MOTION)
    assert pose.position[2] == pytest.approx(0.032, abs=1e-3)


def test_a_grasp_of_bare_table_closes_just_above_it() -> None:
    scene = look(ground((0.6, 0.1, 0.04, 0.04, 0.05)))
    pose, top = grasp_pose(scene, grasp_at(0.45, -0.1, 0, 0, 0.06), MOTION)
    assert top == 0
    np.testing.assert_allclose(pose.position, [0.45, -0.1, MOTION.table_clearance], atol=1e-4)


def test_the_jaws_open_wider_where_the_prediction_is_too_narrow() -> None:
    pose, _ = grasp_pose(look(ground((0.5, 0, 0.04, 0.08, 0.06))), grasp_at(0.5, 0, 0.06, 0, 0.03), MOTION)
    assert 0.04 < pose.opening < 0.06
    assert pose.position[2] == pytest.approx(0.06 - MOTION.insertion, abs=0.004)


@pytest.mark.parametrize("clearance", [0.0, 0.006])
def test_as_predicted_the_jaws_open_by_the_clearance_and_no_wider(clearance: float) -> None:
    scene = look(ground((0.5, 0, 0.04, 0.08, 0.06)))
    execution = Execution(protocol="as-predicted", clearance=clearance)
    grasp = grasp_at(0.5, 0, 0.06, 0.2, 0.06)
    pose, top = grasp_pose(scene, grasp, MOTION, execution=execution)
    assert pose.opening == pytest.approx(0.06 + clearance, abs=2e-4)
    assert widening(scene, grasp, pose, top) == pytest.approx(clearance, abs=1e-9)
    helped, _ = grasp_pose(scene, grasp, MOTION)
    np.testing.assert_array_equal(pose.rotation, helped.rotation)
    np.testing.assert_array_equal(pose.position[:2], helped.position[:2])
    with pytest.raises(Blocked, match="as something is under a finger"):  # which assisted is opened wider
        grasp_pose(scene, grasp_at(0.5, 0, 0.06, 0, 0.03), MOTION, execution=execution)


def test_what_is_too_flat_is_said_to_be() -> None:
    with pytest.raises(Blocked, match="is only 5 mm high, too flat for fingers"):
        grasp_pose(look(ground((0.5, 0, 0.04, 0.08, 0.0047))), grasp_at(0.5, 0, 0, 0, 0.05), MOTION)


def test_a_grasp_within_a_flat_top_is_blocked() -> None:
    with pytest.raises(Blocked, match="its top, as something is under"):
        grasp_pose(look(ground((0.5, 0, 0.12, 0.12, 0.06))), grasp_at(0.5, 0, 0.06, 0, 0.06), MOTION)


@pytest.mark.parametrize(
    ("away", "yaw", "tip"),
    [
        (0.075, 0.0, 0.062),  # the tower's near side is 55 mm from the middle: under the hand, 66 mm long
        (0.095, 0.0, 0.032),  # 75 mm: beside it
        (0.075, math.pi / 2, 0.032),  # the hand is only 25 mm wide across
        (0.045, math.pi / 2, 0.062),
    ],
)
def test_the_hand_stays_above_what_stands_beside_the_grasp(away: float, yaw: float, tip: float) -> None:
    scene = look(ground((0.5, 0, 0.03, 0.03, 0.07), (0.5 + away, 0, 0.04, 0.04, 0.125)))
    motion = MOTION.model_copy(update={"insertion": 0.038})
    pose, _ = grasp_pose(scene, grasp_at(0.5, 0, 0.07, yaw, 0.05), motion)
    assert pose.position[2] == pytest.approx(tip, abs=1e-3)


def test_a_hand_that_cannot_get_down_blocks_the_grasp() -> None:
    scene = look(ground((0.5, 0, 0.03, 0.03, 0.03), (0.575, 0, 0.04, 0.04, 0.15)))
    with pytest.raises(Blocked, match="its top, as something is under"):
        grasp_pose(scene, grasp_at(0.5, 0, 0.03, 0, 0.05), MOTION)


def test_a_grasp_without_depth_is_blocked() -> None:
    depth = ground((0.5, 0, 0.04, 0.08, 0.06))
    depth[160:320, 240:400] = 0
    with pytest.raises(Blocked, match="no depth"):
        grasp_pose(look(depth), grasp_at(0.5, 0, 0.06, 0, 0.06), MOTION)


@pytest.mark.parametrize(("x", "y"), [(0, 0), (640, 0), (0, 480), (640, 480), (639.9, 240)])
def test_a_grasp_at_the_images_edge_is_planned_or_blocked(x: float, y: float) -> None:
    scene = look(ground((0.5, 0, 0.04, 0.08, 0.06)))
    try:
        pose, _ = grasp_pose(scene, Grasp(x, y, 0.7, 60), MOTION)
    except Blocked:
        return
    assert np.isfinite(pose.position).all()
    assert pose.position[2] >= MOTION.table_clearance


@pytest.mark.parametrize("width", [1e-6, 1e4, 1e9, 1e300])
def test_absurd_widths_are_planned_or_blocked(width: float) -> None:
    scene = look(ground((0.5, 0, 0.04, 0.08, 0.06)))
    try:
        pose, _ = grasp_pose(scene, Grasp(320, 240, 0.3, width), MOTION)
    except Blocked:
        return
    assert np.isfinite(pose.position).all()
    assert 0 <= pose.opening <= EC66_PARALLEL_85.gripper.opening


def test_a_pixel_above_the_horizon_is_blocked() -> None:
    camera = CAMERA.model_copy(
        update={"position": (0.0, 0.0, 0.5), "target": (1.0, 0.0, 0.5), "image_up": (0.0, 0.0, 1.0)}
    )
    rgb, depth = np.zeros((480, 640, 3), np.uint8), np.full((480, 640), 1.0, np.float32)
    with pytest.raises(Blocked, match="does not meet the table"):
        SeenScene(RgbdImage(rgb, depth, K), camera.pose).on_plane(np.array([320.0, 100.0]), 0.0)


def test_noise_moves_a_grasp_by_less_than_a_millimetre() -> None:
    grasp = grasp_at(0.48, 0.04, 0.06, 0.5, 0.08)
    clean, _ = grasp_pose(look(ground((0.48, 0.04, 0.05, 0.05, 0.06))), grasp, MOTION)
    for seed in range(5):
        rng = np.random.default_rng(seed)
        depth = ground((0.48, 0.04, 0.05, 0.05, 0.06)) + rng.normal(0, 0.0007, (480, 640))
        depth[rng.random(depth.shape) < 0.05] = 0
        spikes = (rng.random(depth.shape) < 0.001) & (depth > 0)  # three under a finger are a thing
        depth[spikes] -= 0.05
        noisy, _ = grasp_pose(look(depth), grasp, MOTION)
        assert np.abs(noisy.position[:2] - clean.position[:2]).max() < 0.001
        assert abs(noisy.position[2] - clean.position[2]) < 0.002
        assert abs(noisy.opening - clean.opening) < 0.001


def test_single_wild_pixels_are_not_the_highest_thing() -> None:
    depth = ground((0.5, 0, 0.04, 0.08, 0.06))
    depth[100, 100:110] = 0.2
    assert look(depth).highest(Table()) == pytest.approx(0.06, abs=1e-3)
    assert look(ground()).highest(Table()) == pytest.approx(0, abs=1e-6)


# ---------------------------------------------------------------- the motion


@pytest.fixture(scope="module")
def scene() -> SeenScene:
    return look(ground((0.52, 0.03, 0.05, 0.05, 0.06), (0.4, -0.15, 0.04, 0.04, 0.18)))


GRASP = grasp_at(0.52, 0.03, 0.06, 0.4, 0.07)


def test_a_plan_leads_from_home_over_the_grasp_to_the_hold(planner: Planner, scene: SeenScene) -> None:
    plan = planner.plan(scene, GRASP)
    motion = planner.scenario.motion
    forward = planner.ik.forward
    assert np.abs(plan.reach.positions[0] - EC66_PARALLEL_85.arm.home).max() < 0.01
    above, at, lifted, carried = (
        forward(t.end).position for t in (plan.reach, plan.approach, plan.lift, plan.carry)
    )
    np.testing.assert_allclose(at, plan.pose.position, atol=2e-4)
    np.testing.assert_allclose(above[:2], at[:2], atol=2e-4)
    np.testing.assert_allclose(lifted - at, [0, 0, motion.lift_height], atol=3e-4)
    np.testing.assert_allclose(carried[:2], motion.carry_to[:2], atol=3e-4)
    assert carried[2] == pytest.approx(lifted[2] + motion.carry_to[2], abs=3e-4)
    assert plan.grasp == GRASP


def test_the_reach_stays_above_the_highest_thing_seen(planner: Planner, scene: SeenScene) -> None:
    above = planner.ik.forward(planner.plan(scene, GRASP).reach.end).position[2]
    assert above >= 0.18 + 0.03 - 1e-3


def test_the_motions_of_a_plan_join_without_a_jump(planner: Planner, scene: SeenScene) -> None:
    plan = planner.plan(scene, GRASP)
    motions = (plan.reach, plan.approach, plan.lift, plan.carry)
    for before, after in pairwise(motions):
        assert np.abs(after.positions[0] - before.end).max() < 0.01
    for motion in motions:
        assert np.abs(np.diff(motion.positions, axis=0)).max() < 0.02


def test_the_approach_is_straight_down(planner: Planner, scene: SeenScene) -> None:
    plan = planner.plan(scene, GRASP)
    for q in plan.approach.positions[::10]:
        pose = planner.ik.forward(q)
        np.testing.assert_allclose(pose.position[:2], plan.pose.position[:2], atol=0.001)
        assert pose.rotation[2, 2] < -math.cos(math.radians(0.5))


def test_planning_the_same_grasp_again_gives_the_same_motion(planner: Planner, scene: SeenScene) -> None:
    first = planner.plan(scene, GRASP)
    planner.plan(scene, replace(GRASP, angle=-0.8))
    again = planner.plan(scene, GRASP)
    np.testing.assert_array_equal(first.carry.positions, again.carry.positions)
    np.testing.assert_array_equal(first.approach.positions, again.approach.positions)


def test_a_hold_out_of_reach_is_unreachable(table4: Scenario, scene: SeenScene) -> None:
    motion = table4.motion.model_copy(update={"carry_to": (1.5, 0.0, 0.0)})
    with pytest.raises(Unreachable, match=r"TCP at \(0\.520, 0\.030, 0\.032\) m"):
        Planner(table4.model_copy(update={"motion": motion})).plan(scene, GRASP)
