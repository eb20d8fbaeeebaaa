"""Inverse kinematics with mink: several starts, an iteration cap, and a verdict.

Differential IK is local, so it is started from an elbow-up posture turned towards the target, once
for each jaw orientation (a half turn of the gripper is the same grasp); what is left over is
reported as unreachable rather than executed nearly.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property, lru_cache

import mink
import mujoco
import numpy as np
import qpsolvers
from numpy.typing import NDArray

from grasp_bench.grasps import GraspPose
from grasp_bench.robot.arm import Arm
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.postures import Postures
from grasp_bench.robot.robot import EC66_PARALLEL_85, Robot

Joints = NDArray[np.float64]

POSITION_TOLERANCE = 1e-4
"""Accepted TCP error [m]; the executed trial must then come within 1 mm."""
ANGLE_TOLERANCE = math.radians(0.05)
MAX_ITERATIONS = 60
SAME = 0.05
"""Solutions whose joints differ by less than this are one [rad]."""
STEP = 0.1
"""Pseudo-time of one iteration [s]; with the velocity limits it bounds the joint step."""


@lru_cache
def arm_model(arm: Arm) -> mujoco.MjModel:
    """Compile the arm alone, without visual meshes: all that kinematics needs."""
    spec = mujoco.MjSpec.from_file(str(arm.path))
    for geom in [g for g in spec.geoms if g.type == mujoco.mjtGeom.mjGEOM_MESH]:
        spec.delete(geom)
    for mesh in list(spec.meshes):
        spec.delete(mesh)
    return spec.compile()


def flange_target(pose: GraspPose, gripper: Gripper) -> mink.SE3:
    """Return where the flange must be for the TCP to be at ``pose``."""
    matrix = np.eye(4)
    matrix[:3, :3] = pose.rotation
    matrix[:3, 3] = pose.position - gripper.flange_to_tcp * pose.rotation[:, 2]
    return mink.SE3.from_matrix(matrix)


class JointLimits(mink.Limit):
    """Mink's limits of the positions and velocities of an arm of hinges, which are set up only once.

    Args:
        model: of the arm.
        speeds: greatest velocity of every joint, by its name [rad/s].
    """

    def __init__(self, model: mujoco.MjModel, speeds: Mapping[str, float]) -> None:
        self._position = mink.ConfigurationLimit(model)
        limits = self._position, mink.VelocityLimit(model, speeds)
        both = mink.build_ik(mink.Configuration(model), [], STEP, limits=limits)
        self._rows, self._bounds = np.asarray(both.G), np.asarray(both.h)

    def compute_qp_inequalities(self, configuration: mink.Configuration, dt: float) -> mink.Constraint:
        """See :class:`mink.Limit`; ``dt`` is :data:`STEP`."""
        q, position = configuration.data.qpos, self._position
        room = position.gain * np.concatenate([position.upper - q, q - position.lower])
        self._bounds[: len(room)] = room
        return mink.Constraint(self._rows, self._bounds)


class InverseKinematics:
    """Solver for TCP poses of a robot standing at the world's origin; N is the number of its joints."""

    def __init__(self, robot: Robot = EC66_PARALLEL_85) -> None:
        self.robot = robot
        arm = robot.arm
        self.model = arm_model(arm)
        self.configuration = mink.Configuration(self.model)
        self.task = mink.FrameTask(
            arm.flange, "site", position_cost=1.0, orientation_cost=0.3, lm_damping=1e-6
        )
        self.limits = [JointLimits(self.model, dict(zip(arm.joints, arm.velocity_limits, strict=True)))]

    def forward(self, q: Joints) -> GraspPose:
        """Return the TCP pose at joint angles ``q`` (N,) [rad]; the opening is left 0."""
        self.configuration.update(np.asarray(q, dtype=float))
        flange = self.configuration.get_transform_frame_to_world(self.robot.arm.flange, "site").as_matrix()
        return GraspPose(
            flange[:3, 3] + self.robot.gripper.flange_to_tcp * flange[:3, 2], flange[:3, :3], 0.0
        )

    def solve(self, pose: GraspPose, start: Joints) -> Joints | None:
        """Return joint angles (N,) [rad] that bring the TCP to ``pose``, descending from ``start``.

        Returns None when the error is not within tolerance after :data:`MAX_ITERATIONS`.
        """
        self.task.set_target(flange_target(pose, self.robot.gripper))
        self.configuration.update(np.asarray(start, dtype=float))
        for _ in range(MAX_ITERATIONS):
            error = self.task.compute_error(self.configuration)
            if np.linalg.norm(error[:3]) < POSITION_TOLERANCE and np.linalg.norm(error[3:]) < ANGLE_TOLERANCE:
                return self.configuration.q.copy()
            problem = mink.build_ik(self.configuration, [self.task], STEP, damping=1e-6, limits=self.limits)
            change = qpsolvers.solve_problem(problem, solver="daqp").x
            if change is None:
                return None
            self.configuration.integrate_inplace(change / STEP, STEP)
        return None

    def solve_grasp(self, pose: GraspPose) -> list[tuple[GraspPose, Joints]]:
        """Return solutions for ``pose`` and its half turn, least wrist travel from the ready posture first.

        Empty when neither can be reached from any start.
        """
        arm, ready = self.robot.arm, np.array(self.robot.arm.ready)
        bearing = math.atan2(pose.position[1], pose.position[0])
        found: list[tuple[float, GraspPose, Joints]] = []
        for candidate in (pose, pose.flipped()):
            start = ready.copy()
            reach = float(np.hypot(*pose.position[:2]))
            aside = math.asin(min(1.0, max(-1.0, arm.shape.shoulder / max(0.2, reach))))
            start[0] += arm.shape.turn * (bearing - aside - arm.shape.ahead)
            start[-1] = _wrist_guess(self, start, candidate)
            q = self.solve(candidate, start)
            if q is not None:
                found.append((float(np.abs(q - ready).max()), candidate, q))
        return [(g, q) for _, g, q in sorted(found, key=lambda f: f[0])]

    @cached_property
    def postures(self) -> Postures:
        """Starts for a tilted tool."""
        return Postures(self.model, self.robot.arm, self.robot.gripper.flange_to_tcp)

    def solve_tilted(self, pose: GraspPose) -> Iterator[tuple[GraspPose, Joints]]:
        """Give solutions for ``pose`` and its half turn whose approach may have any direction, least travel
        from the ready posture first among those of one way round."""
        ready = np.array(self.robot.arm.ready)
        for found in (self._solutions(pose), self._solutions(pose.flipped())):
            yield from sorted(found, key=lambda f: float(np.abs(f[1] - ready).max()))

    def _solutions(self, pose: GraspPose) -> list[tuple[GraspPose, Joints]]:
        found: list[Joints] = []
        for start in self.postures.near(pose):
            q = self.solve(pose, start)
            if q is None:
                continue
            turned = q - 2 * math.pi * np.round((q - self.robot.arm.ready) / (2 * math.pi))
            low, high = np.transpose(self.robot.arm.position_limits)
            q = np.where((turned > low) & (turned < high), turned, q)
            if all(np.abs(q - other).max() > SAME for other in found):
                found.append(q)
        return [(pose, q) for q in found]

    def follow(self, poses: list[GraspPose], start: Joints) -> list[Joints] | None:
        """Return joint angles along a chain of close poses, each solved from the one before; None where one
        is not."""
        path: list[Joints] = []
        q = start
        for pose in poses:
            solved = self.solve(pose, q)
            if solved is None or np.abs(solved - q).max() > 1.0:  # a jump to another branch
                return None
            path.append(solved)
            q = solved
        return path


def _wrist_guess(ik: InverseKinematics, start: Joints, pose: GraspPose) -> float:
    """Return the angle of the last joint that turns the jaws nearest to the wanted direction."""
    now = ik.forward(start).rotation
    error = math.atan2(float(now[:, 1] @ pose.rotation[:, 0]), float(now[:, 0] @ pose.rotation[:, 0]))
    low, high = ik.robot.arm.position_limits[-1]
    guess = math.remainder(float(start[-1]) + ik.robot.arm.shape.wrist * error, 2 * math.pi)
    return min(high, max(low, guess))
