"""Joint trajectories: where they start and end, and how fast they may be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from grasp_bench.grasps import GraspPose
from grasp_bench.robot.ec66 import EC66
from grasp_bench.robot.kinematics import InverseKinematics
from grasp_bench.robot.trajectory import NaturalSpline, Trajectory, through

PERIOD = 0.004
LIMITS = np.array(EC66.velocity_limits)
joints = st.lists(st.floats(-2, 2), min_size=6, max_size=6).map(np.array)


def top_speeds(motion: Trajectory, start: np.ndarray) -> np.ndarray:
    """Greatest speed of each joint, by differences of positions."""
    return np.abs(np.diff(np.vstack([start, motion.positions]), axis=0)).max(0) / PERIOD


@given(st.lists(joints, min_size=2, max_size=5), st.floats(0.05, 1))
def test_motions_begin_and_end_at_rest_within_the_velocity_limits(waypoints, fraction: float) -> None:
    motion = through(waypoints, PERIOD, fraction)
    np.testing.assert_allclose(motion.end, waypoints[-1], atol=1e-9)
    np.testing.assert_allclose(motion.velocities[-1], 0, atol=1e-9)
    assert (np.abs(motion.velocities) <= fraction * LIMITS * 1.02).all()
    assert (top_speeds(motion, waypoints[0]) <= fraction * LIMITS * 1.02).all()
    assert motion.positions.shape == motion.velocities.shape


def test_the_first_sample_is_next_to_the_start() -> None:
    start = np.zeros(6)
    motion = through([start, np.ones(6)], PERIOD, 0.5)
    assert np.abs(motion.positions[0] - start).max() < 1e-4


def test_velocities_are_the_slope_of_positions() -> None:
    rng = np.random.default_rng(1)
    motion = through(list(rng.uniform(-1, 1, (4, 6))), PERIOD, 0.3)
    slope = np.gradient(motion.positions, PERIOD, axis=0)
    np.testing.assert_allclose(motion.velocities[2:-2], slope[2:-2], atol=0.01 * slope.max())


def test_some_joint_uses_what_it_may() -> None:
    motion = through([np.zeros(6), np.array([1.0, 0.2, 0, 0, 0, 0])], PERIOD, 0.5)
    assert np.abs(motion.velocities[:, 0]).max() == pytest.approx(0.5 * LIMITS[0], rel=0.02)


def test_every_waypoint_is_passed() -> None:
    waypoints = list(np.random.default_rng(2).uniform(-0.5, 0.5, (5, 6)))
    motion = through(waypoints, PERIOD, 0.1)
    for point in waypoints[1:]:
        assert np.abs(motion.positions - point).max(1).min() < 0.005


def test_no_motion_is_one_sample_at_rest() -> None:
    motion = through([np.ones(6), np.ones(6)], PERIOD, 0.5)
    np.testing.assert_array_equal(motion.positions, np.ones((1, 6)))
    np.testing.assert_array_equal(motion.velocities, np.zeros((1, 6)))


def test_a_slower_tcp_takes_longer() -> None:
    ends = [np.zeros(6), np.full(6, 0.1)]
    slow, slower = (through(ends, PERIOD, 1.0, 0.2, v) for v in (0.2, 0.1))
    assert len(slower.positions) == pytest.approx(2 * len(slow.positions), abs=1)
    assert len(slow.positions) * PERIOD == pytest.approx(1.875 * 0.2 / 0.2, rel=0.01)


def test_the_tcp_keeps_its_speed_and_its_line() -> None:
    ik = InverseKinematics()
    start, height, speed = np.array([0.5, 0.05, 0.02]), 0.2, 0.15
    pose, q = ik.solve_grasp(GraspPose.top_down(start, 0.4, 0.05))[0]
    path = ik.follow([GraspPose(start + [0, 0, height * i / 8], pose.rotation, 0.0) for i in range(1, 9)], q)
    assert path is not None
    motion = through([q, *path], PERIOD, 0.5, height, speed)
    places = np.array([start, *(ik.forward(q).position for q in motion.positions)])
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=1) / PERIOD
    assert speeds.max() == pytest.approx(speed, rel=0.1)
    assert np.abs(places[:, :2] - start[:2]).max() < 0.0005
    assert places[-1, 2] - start[2] == pytest.approx(height, abs=2e-4)


@pytest.mark.parametrize("seed", range(20))
def test_splines_are_scipys_to_the_bit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 30))
    knots = np.concatenate([[0.0], np.cumsum(np.maximum(rng.random(count - 1) ** 3, 1e-9))])
    knots /= knots[-1]
    points = rng.normal(size=(count, 6)).cumsum(0)
    at = np.concatenate([np.linspace(0, 1, 65), rng.random(50), knots])
    own, theirs = NaturalSpline(knots, points), CubicSpline(knots, points, bc_type="natural")
    for order in (0, 1):
        np.testing.assert_array_equal(own(at, order), theirs(at, order))
