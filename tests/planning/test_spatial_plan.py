"""Hands in any direction: what is in their way, and the motion to and from where they grasp."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from test_planner import POSE, K, ground, look

from grasp_bench.grasps import GraspPose, SpatialGrasp
from grasp_bench.planning.obstacles import Obstacles
from grasp_bench.planning.planner import Planner
from grasp_bench.planning.refusals import Blocked, Unreachable
from grasp_bench.planning.seen import steady
from grasp_bench.robot.robot import EC66_PARALLEL_85, load_robot
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Execution

PLANNER = Planner(load_scenario("table4"))


def level(place: list[float], azimuth: float, dip: float = 0.0, opening: float = 0.06) -> GraspPose:
    """A hand that comes from the side, jaws level, its approach ``dip`` below the horizontal [rad]."""
    a = np.array([math.cos(azimuth) * math.cos(dip), math.sin(azimuth) * math.cos(dip), -math.sin(dip)])
    x = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    return GraspPose(np.array(place), np.column_stack([x, np.cross(a, x), a]), opening)


def seen(pose: GraspPose) -> SpatialGrasp:
    turn = POSE.rotation.T
    return SpatialGrasp.of(pose.moved(turn, -turn @ POSE.position), K.project)


@pytest.mark.parametrize(
    ("azimuth", "dip"), [(math.pi / 2, 0.0), (-math.pi / 2, 0.0), (0.0, 0.35), (0.8, 0.35), (math.pi, 0.6)]
)
def test_a_hand_from_the_side_comes_straight_and_lifts_straight(azimuth: float, dip: float) -> None:
    pose = level([0.5, 0.0, 0.12], azimuth, dip)
    plan = PLANNER.plan(look(ground((0.5, 0, 0.03, 0.03, 0.16))), seen(pose))
    np.testing.assert_allclose(plan.pose.position, pose.position, atol=1e-12)
    assert plan.pose.approach @ pose.approach == pytest.approx(1)
    places = np.array([PLANNER.ik.forward(q).position for q in plan.approach.positions])
    last = places[np.linalg.norm(places - pose.position, axis=1) < 0.0999]
    beside = (last - pose.position) - np.outer((last - pose.position) @ pose.approach, pose.approach)
    assert np.linalg.norm(beside, axis=1).max() < 2e-3, "the last 0.1 m are a straight line"
    assert PLANNER.ik.forward(plan.approach.end).position == pytest.approx(pose.position, abs=1.5e-4)
    up = np.array([PLANNER.ik.forward(q).position for q in plan.lift.positions]) - pose.position
    assert np.abs(up[:, :2]).max() < 2e-3
    assert up[-1, 2] == pytest.approx(0.2, abs=2e-4)
    np.testing.assert_allclose(plan.carry.positions[0], plan.lift.end, atol=0.05)
    np.testing.assert_allclose(plan.reach.positions[-1], plan.approach.positions[0], atol=0.05)


def test_the_hand_meets_neither_table_nor_what_was_seen() -> None:
    tall = (0.5, 0.0, 0.03, 0.03, 0.16)
    scene = look(ground(tall, (0.36, 0.0, 0.04, 0.2, 0.12)))
    with pytest.raises(Blocked, match="what was seen"):
        PLANNER.plan(scene, seen(level([0.5, 0, 0.12], 0.0)))
    assert PLANNER.plan(look(ground(tall)), seen(level([0.5, 0, 0.12], math.pi / 2)))
    with pytest.raises(Blocked, match="the table"):
        PLANNER.plan(look(ground(tall)), seen(level([0.5, 0, 0.015], 0.0)))
    with pytest.raises(Blocked, match="the table"):
        PLANNER.plan(look(ground(tall)), seen(level([0.5, 0, 0.12], 0.0, dip=-1.2)))


def test_jaws_that_are_too_narrow_open_wider_only_with_help() -> None:
    scene = look(ground((0.5, 0.0, 0.05, 0.05, 0.16)))
    narrow = seen(replace(GraspPose.top_down([0.5, 0, 0.13], 0.0, 0.04)))
    plan = PLANNER.plan(scene, narrow)
    assert plan.pose.opening > 0.05
    assert plan.widening == pytest.approx(plan.pose.opening - 0.04)
    strict = PLANNER.scenario.model_copy(update={"execution": Execution(protocol="as-predicted")})
    with pytest.raises(Blocked, match="a finger meets"):
        PLANNER.varied(strict, PLANNER.robot).plan(scene, narrow)


def test_what_the_arm_cannot_reach_says_so() -> None:
    with pytest.raises(Unreachable, match="no joint angles"):
        PLANNER.plan(look(ground((0.5, 0, 0.03, 0.03, 0.1))), seen(level([1.2, 0.3, 0.3], 0.0)))


def test_an_arm_in_itself_or_in_the_table_is_told() -> None:
    obstacles, none = Obstacles(EC66_PARALLEL_85), np.zeros((0, 3))
    home = np.array(EC66_PARALLEL_85.arm.home)
    assert obstacles.arm(none, home, 0.085) == ""
    assert "the table" in obstacles.arm(none, np.radians([0, 20, 0, 0, 90, 0]), 0.085)
    assert "itself" in obstacles.arm(none, np.radians([0, -90, 159, 0, 90, 0]), 0.085)
    cloud = np.random.default_rng(0).uniform([0.0, -0.3, 0.3], [0.3, 0.3, 0.6], (20_000, 3))
    assert "what was seen" in obstacles.arm(cloud, home, 0.085)


@pytest.mark.parametrize("arm", ["ur5e", "panda"])
def test_other_arms_reach_from_the_side_too(arm: str) -> None:
    robot = load_robot(arm, "parallel-85")
    planner = Planner(load_scenario("table4"), robot)
    for azimuth in (math.pi / 2, -math.pi / 2):
        plan = planner.plan(
            look(ground((0.5, 0, 0.03, 0.03, 0.16))), seen(level([0.5, 0, 0.12], azimuth, 0.3))
        )
        assert planner.ik.forward(plan.approach.end).position == pytest.approx(plan.pose.position, abs=1.5e-4)


def test_flying_pixels_are_no_cloud() -> None:
    depth = ground((0.5, 0, 0.1, 0.1, 0.1)).astype(np.float32)
    assert steady(depth)[1:-1, 1:-1].all()
    flying = depth.copy()
    flying[10::20, 10::20] -= 0.05
    assert not steady(flying)[10::20, 10::20].any()
    assert steady(flying)[15, 15]
