"""Arms against their published tables, which stand here a second time."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from grasp_bench.grasps import GraspPose
from grasp_bench.robot.arm import load_arm
from grasp_bench.robot.kinematics import InverseKinematics
from grasp_bench.robot.robot import load_robot
from grasp_bench.system.paths import assets_dir
from grasp_bench.workshop.robot_models import write_models

HALF = math.pi / 2
UR5E = [  # standard DH: a, d, alpha
    (0.0, 0.1625, HALF),
    (-0.425, 0.0, 0.0),
    (-0.3922, 0.0, 0.0),
    (0.0, 0.1333, HALF),
    (0.0, 0.0997, -HALF),
    (0.0, 0.0996, 0.0),
]
PANDA = [  # Craig's: a, d, alpha, all before the joint; the flange last
    (0.0, 0.333, 0.0),
    (0.0, 0.0, -HALF),
    (0.0, 0.316, HALF),
    (0.0825, 0.0, HALF),
    (-0.0825, 0.384, -HALF),
    (0.0, 0.0, HALF),
    (0.088, 0.0, HALF),
    (0.0, 0.107, 0.0),
]


def shift(x: float = 0.0, z: float = 0.0) -> np.ndarray:
    matrix = np.eye(4)
    matrix[[0, 2], 3] = x, z
    return matrix


def turn(axis: int, angle: float) -> np.ndarray:
    matrix = np.eye(4)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[[i, j, i, j], [i, j, j, i]] = math.cos(angle), math.cos(angle), -math.sin(angle), math.sin(angle)
    return matrix


def ur5e(q: np.ndarray) -> np.ndarray:
    pose = turn(2, math.pi)  # the maker's base frame looks backwards
    for angle, (a, d, alpha) in zip(q, UR5E, strict=True):
        pose = pose @ turn(2, angle) @ shift(z=d) @ shift(x=a) @ turn(0, alpha)
    return pose


def panda(q: np.ndarray) -> np.ndarray:
    pose = np.eye(4)
    for angle, (a, d, alpha) in zip([*q, 0.0], PANDA, strict=True):
        pose = pose @ turn(0, alpha) @ shift(x=a) @ turn(2, angle) @ shift(z=d)
    return pose


@pytest.mark.parametrize(("name", "table"), [("ur5e", ur5e), ("panda", panda)])
def test_the_flange_is_where_the_table_says(name: str, table: Callable[[np.ndarray], np.ndarray]) -> None:
    """Within 0.01 mm, at any joint angles."""
    arm = load_arm(name)
    model = mujoco.MjModel.from_xml_path(str(arm.path))
    data = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    for _ in range(50):
        data.qpos[:] = rng.uniform(model.jnt_range[:, 0], model.jnt_range[:, 1])
        mujoco.mj_kinematics(model, data)
        wanted, site = table(data.qpos), data.site(arm.flange)
        np.testing.assert_allclose(site.xpos, wanted[:3, 3], atol=1e-5)
        np.testing.assert_allclose(site.xmat.reshape(3, 3), wanted[:3, :3], atol=1e-5)


def test_limits_are_the_published_ones() -> None:
    ur, franka = load_arm("ur5e"), load_arm("panda")
    assert ur.torque_limits == (150, 150, 150, 28, 28, 28)
    np.testing.assert_allclose(ur.velocity_limits, math.pi)
    assert franka.torque_limits == (87, 87, 87, 87, 12, 12, 12)
    np.testing.assert_allclose(franka.velocity_limits, [2.175] * 4 + [2.61] * 3, atol=1e-5)
    np.testing.assert_allclose(
        np.array(franka.position_limits)[[3, 5]], [[-3.0718, -0.0698], [-0.0175, 3.7525]]
    )


@pytest.mark.parametrize("name", ["ur5e", "panda"])
def test_inverse_kinematics_finds_what_a_trial_asks_for(name: str) -> None:
    """All over the places where objects are put, at any yaw; on a straight way up, without a jump."""
    ik = InverseKinematics(load_robot(name, "parallel-85"))
    rng = np.random.default_rng(1)
    for _ in range(30):
        x, y = rng.uniform(-0.09, 0.09, 2) + [0.5, 0]
        pose = GraspPose.top_down([x, y, 0.02], rng.uniform(-math.pi, math.pi), 0.05)
        found = ik.solve_grasp(pose)
        assert found
        candidate, q = found[0]
        reached = ik.forward(q)
        assert np.linalg.norm(reached.position - pose.position) < 2e-4
        above = [
            GraspPose(pose.position + [0, 0, z], candidate.rotation, 0.0) for z in (0.05, 0.1, 0.15, 0.2)
        ]
        path = ik.follow(above, q)
        assert path is not None
        limits = np.array(ik.robot.arm.position_limits)
        assert ((np.array(path) >= limits[:, 0] - 1e-9) & (np.array(path) <= limits[:, 1] + 1e-9)).all()


def test_the_shipped_models_are_what_the_workshop_writes(tmp_path: Path) -> None:
    for path in write_models(tmp_path):
        assert path.read_text() == (assets_dir() / path.relative_to(tmp_path)).read_text()
