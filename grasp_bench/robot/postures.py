"""Starts for inverse kinematics of a tilted tool: a table of postures, asked for those nearest to a pose.

Differential IK descends into one solution only, and a posture with the tool down is a bad start for a tool
held sideways. The table holds random postures with their TCP poses, each turned about the base's axis to one
azimuth, as the first joint can turn it to any other (the idea of reachability maps: Zacharias et al., 2007).
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from grasp_bench.grasps import GraspPose
from grasp_bench.robot.arm import Arm
from grasp_bench.system.arrays import Floats

COUNT = 20_000
"""Postures that are drawn."""
NEAREST = 8
"""Starts that are tried for one pose."""
METRE = 5.0
"""What a metre counts against a radian: 0.1 m as much as half a radian."""
FARTHEST, LOWEST, HIGHEST = 1.0, -0.05, 0.7
"""TCPs further from the base's axis, below or above these are left out [m]."""


class Postures:
    """Postures of an arm of N joints, by the pose of its TCP.

    Args:
        model: of the arm alone.
        arm: the arm.
        flange_to_tcp: distance of the TCP before the flange [m].
    """

    def __init__(self, model: mujoco.MjModel, arm: Arm, flange_to_tcp: float) -> None:
        self._arm = arm
        limits = np.clip(arm.position_limits, -math.pi, math.pi)
        rng = np.random.default_rng(0)
        drawn = rng.uniform(limits[:, 0], limits[:, 1], (COUNT, len(limits)))
        drawn[:, 0] = arm.ready[0]
        data, site = mujoco.MjData(model), model.site(arm.flange).id
        place, turn = np.empty((COUNT, 3)), np.empty((COUNT, 3, 3))
        for i, q in enumerate(drawn):
            data.qpos[:] = q
            mujoco.mj_kinematics(model, data)
            turn[i] = data.site_xmat[site].reshape(3, 3)
            place[i] = data.site_xpos[site] + flange_to_tcp * turn[i, :, 2]
        radius = np.hypot(place[:, 0], place[:, 1])
        kept = (radius < FARTHEST) & (place[:, 2] > LOWEST) & (place[:, 2] < HIGHEST)
        azimuth = np.arctan2(place[kept, 1], place[kept, 0])
        self._joints, self._azimuth = drawn[kept], azimuth
        self._cylinder = np.column_stack([radius[kept], place[kept, 2]])
        self._turn = _about_vertical(-azimuth) @ turn[kept]

    def near(self, pose: GraspPose, count: int = NEAREST) -> list[Floats]:
        """Return the ``count`` postures (N,) [rad] whose TCP is nearest to ``pose``, nearest first."""
        azimuth = math.atan2(pose.position[1], pose.position[0])
        turn = _about_vertical(np.array([-azimuth]))[0] @ pose.rotation
        cosine = (np.einsum("nij,ij->n", self._turn, turn) - 1) / 2
        away = self._cylinder - [math.hypot(*pose.position[:2]), pose.position[2]]
        far = np.arccos(np.clip(cosine, -1, 1)) + METRE * np.linalg.norm(away, axis=1)
        starts = []
        for i in np.argsort(far)[:count]:
            q = self._joints[i].copy()
            q[0] += self._arm.shape.turn * math.remainder(azimuth - float(self._azimuth[i]), 2 * math.pi)
            low, high = self._arm.position_limits[0]
            starts.append(np.array([min(high, max(low, q[0])), *q[1:]]))
        return starts


def _about_vertical(angles: Floats) -> Floats:
    """Return the rotations (N, 3, 3) by ``angles`` (N,) about the world's z axis."""
    turns = np.zeros((len(angles), 3, 3))
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(angles)
    turns[:, 1, 0] = np.sin(angles)
    turns[:, 0, 1], turns[:, 2, 2] = -turns[:, 1, 0], 1.0
    return turns
