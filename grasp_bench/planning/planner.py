"""From a grasp in the image to a motion of the arm.

Nothing here knows the simulator: the planner sees what the camera saw, and the arm's kinematics.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import partial

import numpy as np

from grasp_bench.grasps import Grasp, GraspPose, KnownGrasp
from grasp_bench.planning.depth import WIDENING_GAIN, grasp_pose, wanted_tip, widening
from grasp_bench.planning.refusals import Unreachable
from grasp_bench.planning.seen import SeenScene
from grasp_bench.planning.shake import amplitude, shaken
from grasp_bench.planning.suction import cup_pose, wanted_height
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.kinematics import InverseKinematics
from grasp_bench.robot.robot import Robot
from grasp_bench.robot.trajectory import Trajectory, through
from grasp_bench.scenario.sections import Scenario
from grasp_bench.system.arrays import Floats

WAYPOINT = 0.025
"""Spacing of waypoints on straight lines [m]."""


@dataclass(frozen=True)
class Plan:
    """A grasp turned into motions.

    Attributes:
        grasp: the image-plane grasp that is planned.
        pose: TCP pose at the grasp.
        top: height of what is grasped, above the table [m].
        shortfall: how far above their wanted depth the tips are kept by what is seen under them [m].
        widening: how much wider the jaws open than predicted [m].
        reach: motion from home to above the grasp.
        approach, lift: motions straight down and up.
        carry: motion to the place of the hold.
        shake: bursts along the axes of the TCP, between lift and carry; empty where there are none.
    """

    grasp: Grasp
    pose: GraspPose
    top: float
    shortfall: float
    widening: float
    reach: Trajectory
    approach: Trajectory
    lift: Trajectory
    carry: Trajectory
    shake: tuple[Trajectory, ...] = ()

    @property
    def deep(self) -> bool:
        """Whether the tips get down to the wanted depth, or so near that no wider opening was tried."""
        return self.shortfall <= WIDENING_GAIN + 1e-6


def straight(start: Floats, end: Floats) -> list[Floats]:
    """Return points on a line every :data:`WAYPOINT`, without the start."""
    count = max(1, int(np.ceil(np.linalg.norm(end - start) / WAYPOINT)))
    return [start + (end - start) * i / count for i in range(1, count + 1)]


class Planner:
    """Plans motions of a robot, the scenario's by default; keeps the IK solver between trials."""

    def __init__(self, scenario: Scenario, robot: Robot | None = None) -> None:
        self.scenario, self.robot = scenario, robot or scenario.robot.loaded
        self.ik = InverseKinematics(self.robot)

    def varied(self, scenario: Scenario, robot: Robot) -> Planner:
        """Return a planner of another scenario, and of a robot that differs in its fingers at most; the two
        share the IK solver."""
        other = copy(self)
        other.scenario, other.robot = scenario, robot
        return other

    def plan(self, scene: SeenScene, grasp: Grasp) -> Plan:
        """Plan the motion for one grasp.

        Raises:
            Blocked: when the fingers cannot get down to it.
            Unreachable: when the arm cannot carry it out.
        """
        motion, gripper = self.scenario.motion, self.robot.gripper
        if isinstance(grasp, KnownGrasp):
            pose, top, wider = grasp.pose, grasp.top, 0.0
        elif isinstance(gripper, SuctionCup):
            (pose, top), wider = cup_pose(scene, grasp, motion, gripper), 0.0
        else:
            pose, top = grasp_pose(scene, grasp, motion, gripper, self.scenario.execution)
            wider = widening(scene, grasp, pose, top, gripper)
        if isinstance(gripper, SuctionCup):
            wanted = wanted_height(top, motion, gripper)
        else:
            wanted = wanted_tip(top, motion)
        timed = partial(through, limits=self.robot.arm.velocity_limits)
        period = self.scenario.physics.timestep * self.scenario.physics.control_steps
        above = max(pose.position[2] + motion.approach_height, scene.highest(self.scenario.table) + 0.03)
        raised = np.array([*pose.position[:2], above])
        lifted = pose.position + [0, 0, motion.lift_height]
        target = np.array([*motion.carry_to[:2], lifted[2] + motion.carry_to[2]])
        for candidate, q in self.ik.solve_grasp(pose):

            def chain(
                start: Floats, end: Floats, from_q: Floats, rotation: Floats = candidate.rotation
            ) -> list[Floats] | None:
                return self.ik.follow([GraspPose(p, rotation, 0.0) for p in straight(start, end)], from_q)

            up = chain(pose.position, raised, q)
            lift = chain(pose.position, lifted, q)
            carry = chain(lifted, target, lift[-1]) if lift else None
            if not (up and lift and carry):
                continue
            shake = self.shake(GraspPose(lifted, candidate.rotation, 0.0), lift[-1], period)
            if shake is None:
                continue
            fraction = motion.speed_fraction
            reach = timed([np.asarray(self.robot.arm.home), up[-1]], period, fraction)
            down = timed([*up[::-1], q], period, fraction, above - pose.position[2], motion.approach_speed)
            return Plan(
                grasp,
                candidate,
                top,
                pose.position[2] - wanted,
                wider,
                reach,
                down,
                timed([q, *lift], period, fraction, motion.lift_height, motion.lift_speed),
                timed(
                    [lift[-1], *carry],
                    period,
                    fraction,
                    float(np.linalg.norm(target - lifted)),
                    motion.carry_speed,
                ),
                shake,
            )
        x, y, z = pose.position
        raise Unreachable(
            f"no joint angles for the TCP at ({x:.3f}, {y:.3f}, {z:.3f}) m and the motion from it"
        )

    def shake(self, pose: GraspPose, q: Floats, period: float) -> tuple[Trajectory, ...] | None:
        """Plan bursts along the axes of the TCP at ``pose``, reached with joints ``q``; empty where the
        scenario has none, None where the arm cannot do them."""
        shake = self.scenario.motion.shake
        if shake.acceleration == 0:
            return ()
        bursts = []
        for axis in pose.rotation.T:
            ends = [
                self.ik.follow(
                    [GraspPose(pose.position + side * amplitude(shake) * axis, pose.rotation, 0.0)], q
                )
                for side in (-1, 1)
            ]
            if ends[0] is None or ends[1] is None:
                return None
            bursts.append(shaken((ends[0][0], ends[1][0]), q, shake, period))
            if (np.abs(bursts[-1].velocities) > self.robot.arm.velocity_limits).any():
                return None
        return tuple(bursts)
