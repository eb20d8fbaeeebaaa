"""Inverse kinematics: reached poses, both jaw orientations, refusals and straight lines."""

from __future__ import annotations

import math

import mink
import numpy as np
import pytest

from grasp_bench.grasps import GraspPose
from grasp_bench.robot.ec66 import EC66
from grasp_bench.robot.kinematics import STEP, InverseKinematics

PLACES = [(0.36, -0.15), (0.36, 0.15), (0.5, 0.0), (0.64, -0.15), (0.64, 0.15)]
YAWS = np.radians([-80, -35, 0, 50, 90])


@pytest.fixture(scope="module")
def ik() -> InverseKinematics:
    return InverseKinematics()


def pose_at(x: float, y: float, z: float = 0.02, yaw: float = 0.3) -> GraspPose:
    return GraspPose.top_down([x, y, z], yaw, 0.05)


def angle_between(first: np.ndarray, second: np.ndarray) -> float:
    return math.acos(min(1.0, (np.trace(first.T @ second) - 1) / 2))


@pytest.mark.parametrize("place", PLACES)
def test_the_whole_workspace_is_reached_to_a_tenth_of_a_millimetre(ik: InverseKinematics, place) -> None:
    for yaw in YAWS:
        wanted = pose_at(*place, yaw=yaw)
        solutions = ik.solve_grasp(wanted)
        assert solutions, f"yaw {math.degrees(yaw):.0f}°"
        for pose, q in solutions:
            reached = ik.forward(q)
            assert np.linalg.norm(reached.position - wanted.position) < 1e-4
            assert angle_between(reached.rotation, pose.rotation) < math.radians(0.05)
            for angle, (low, high) in zip(q, EC66.position_limits, strict=True):
                assert low <= angle <= high


def test_both_jaw_orientations_are_offered_and_the_handier_comes_first(ik: InverseKinematics) -> None:
    wanted = pose_at(0.5, 0.0)
    (first, q), (second, other) = ik.solve_grasp(wanted)
    np.testing.assert_allclose(first.rotation[:, 0], -second.rotation[:, 0], atol=1e-12)
    assert {round(float(p.rotation[0, 0]), 6) for p in (first, second)} == {
        round(float(s * wanted.rotation[0, 0]), 6) for s in (1, -1)
    }
    assert np.abs(q[5] - other[5]) > 1.0
    assert abs(math.remainder(q[5], 2 * math.pi)) <= math.pi


@pytest.mark.parametrize("place", [(1.3, 0.0, 0.02), (0.5, 0.0, 1.6), (0.05, 0.02, 0.02)])
def test_what_is_out_of_reach_has_no_solution(ik: InverseKinematics, place) -> None:
    assert ik.solve_grasp(pose_at(*place)) == []


def test_forward_kinematics_of_home_is_where_home_says(ik: InverseKinematics) -> None:
    home = ik.forward(np.array(EC66.home))
    np.testing.assert_allclose(home.rotation[:, 2], [0, 0, -1], atol=1e-6)
    assert 0.1 < home.position[2] < 0.5


def line(start: np.ndarray, end: np.ndarray, count: int) -> list[GraspPose]:
    return [pose_at(*(start + (end - start) * i / count)) for i in range(1, count + 1)]


def test_following_a_line_stays_on_it_without_jumps(ik: InverseKinematics) -> None:
    start, end = np.array([0.5, 0.0, 0.02]), np.array([0.4, 0.25, 0.22])
    _, q = ik.solve_grasp(pose_at(*start))[0]
    wanted = line(start, end, 14)
    pose = ik.solve_grasp(pose_at(*start))[0][0]
    wanted = [GraspPose(p.position, pose.rotation, 0.0) for p in wanted]
    path = ik.follow(wanted, q)
    assert path is not None
    for target, angles in zip(wanted, path, strict=True):
        assert np.linalg.norm(ik.forward(angles).position - target.position) < 1e-4
    assert np.abs(np.diff([q, *path], axis=0)).max() < 0.25


def test_following_a_line_out_of_reach_is_refused(ik: InverseKinematics) -> None:
    pose, q = ik.solve_grasp(pose_at(0.5, 0.0))[0]
    wanted = [
        GraspPose(p.position, pose.rotation, 0.0)
        for p in line(np.array([0.5, 0, 0.02]), np.array([1.4, 0, 0.02]), 20)
    ]
    assert ik.follow(wanted, q) is None


def test_a_jump_to_another_branch_is_refused(ik: InverseKinematics) -> None:
    pose, q = ik.solve_grasp(pose_at(0.5, 0.0))[0]
    assert ik.follow([pose.flipped()], q) is None


def test_solving_does_not_depend_on_what_was_solved_before(ik: InverseKinematics) -> None:
    fresh = InverseKinematics().solve_grasp(pose_at(0.45, 0.1))
    ik.solve_grasp(pose_at(0.6, -0.1, yaw=1.2))
    again = ik.solve_grasp(pose_at(0.45, 0.1))
    for (_, a), (_, b) in zip(fresh, again, strict=True):
        np.testing.assert_array_equal(a, b)


def test_limits_put_together_once_are_those_of_mink(ik: InverseKinematics) -> None:
    speeds = dict(zip(EC66.joints, EC66.velocity_limits, strict=True))
    limits = mink.ConfigurationLimit(ik.model), mink.VelocityLimit(ik.model, speeds)
    for q in np.random.default_rng(0).uniform(-7, 7, (20, 6)):
        at = mink.Configuration(ik.model, q)
        each = mink.build_ik(at, [], STEP, limits=limits)
        once = mink.build_ik(at, [], STEP, limits=ik.limits)
        assert np.array_equal(np.asarray(once.G), np.asarray(each.G))
        assert np.array_equal(np.asarray(once.h), np.asarray(each.h))
