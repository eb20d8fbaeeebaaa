"""From a grasp in the image to a motion of the arm.

Nothing here knows the simulator: the planner sees what the camera saw, and the arm's kinematics.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import ArrayLike

from grasp_bench.grasps import Grasp, GraspPose, KnownGrasp, SpatialGrasp
from grasp_bench.planning.depth import WIDENING_GAIN, grasp_pose, openings, wanted_tip, widening
from grasp_bench.planning.obstacles import Obstacles
from grasp_bench.planning.refusals import Blocked, Unreachable
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
CLEAR = 0.03
"""Height above everything seen at which the hand comes [m]."""
DOWN = np.array([0.0, 0.0, -1.0])
UPRIGHT = -1 + 1e-9
"""A hand whose approach has a lesser z than this points straight down."""
ENTRY = 24
"""Postures on the way from home that are looked at."""


@dataclass(frozen=True)
class Plan:
    """A grasp turned into motions.

    Attributes:
        grasp: the grasp that is planned, as it looks in the image.
        pose: TCP pose at the grasp.
        top: height of what is grasped, above the table [m].
        shortfall: how far above their wanted depth the tips are kept by what is seen under them [m].
        widening: how much wider the jaws open than predicted [m].
        reach: motion from home to above the grasp.
        approach, lift: motions along the approach to the grasp, and straight up from it.
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


@dataclass(frozen=True)
class Aim:
    """Where a grasp is, before the arm's motion to it is known.

    Attributes:
        grasp, pose, top, shortfall, widening: as of a :class:`Plan`.
        points: (N, 3) seen points that the arm must not meet [m]; None where it was planned on heights.
    """

    grasp: Grasp
    pose: GraspPose
    top: float
    shortfall: float = 0.0
    widening: float = 0.0
    points: Floats | None = None


def _upright(pose: GraspPose) -> bool:
    """Return whether the hand points straight down."""
    return bool(pose.approach[2] < UPRIGHT)


def _turned(posture: ArrayLike, end: Floats) -> Floats:
    """Return a posture (N,) whose first joint is turned as in another [rad]."""
    return np.array([end[0], *np.asarray(posture)[1:]])


def straight(start: Floats, end: Floats) -> list[Floats]:
    """Return points on a line every :data:`WAYPOINT`, without the start."""
    count = max(1, int(np.ceil(np.linalg.norm(end - start) / WAYPOINT)))
    return [start + (end - start) * i / count for i in range(1, count + 1)]


class Planner:
    """Plans motions of a robot, the scenario's by default; keeps the IK solver between trials."""

    def __init__(self, scenario: Scenario, robot: Robot | None = None) -> None:
        self.scenario, self.robot = scenario, robot or scenario.robot.loaded
        self.ik = InverseKinematics(self.robot)

    @cached_property
    def obstacles(self) -> Obstacles:
        """What a grasp in six degrees of freedom is checked against."""
        return Obstacles(self.robot)

    def varied(self, scenario: Scenario, robot: Robot) -> Planner:
        """Return a planner of another scenario, and of a robot that differs in its fingers at most; the two
        share the IK solver."""
        other = copy(self)
        other.scenario, other.robot = scenario, robot
        other.__dict__.pop("obstacles", None)
        return other

    def plan(self, scene: SeenScene, grasp: Grasp) -> Plan:
        """Plan the motion for one grasp.

        Raises:
            Blocked: when the fingers cannot get down to it.
            Unreachable: when the arm cannot carry it out.
        """
        motion, gripper = self.scenario.motion, self.robot.gripper
        if isinstance(grasp, KnownGrasp):
            short = grasp.pose.position[2] - self._wanted(grasp.top) if _upright(grasp.pose) else 0.0
            return self._motion(scene, Aim(grasp, grasp.pose, grasp.top, short))
        if isinstance(grasp, SpatialGrasp):
            pose, wider = self._clear(scene, grasp.pose.moved(scene.camera.rotation, scene.camera.position))
            aim = Aim(grasp, pose, float(pose.position[2]), widening=wider, points=scene.points)
            return self._motion(scene, aim)
        if isinstance(gripper, SuctionCup):
            (pose, top), wider = cup_pose(scene, grasp, motion, gripper), 0.0
        else:
            pose, top = grasp_pose(scene, grasp, motion, gripper, self.scenario.execution)
            wider = widening(scene, grasp, pose, top, gripper)
        return self._motion(scene, Aim(grasp, pose, top, pose.position[2] - self._wanted(top), wider))

    def _wanted(self, top: float) -> float:
        """Return the height at which the TCP is wanted for a thing that is ``top`` high [m]."""
        motion, gripper = self.scenario.motion, self.robot.gripper
        if isinstance(gripper, SuctionCup):
            return wanted_height(top, motion, gripper)
        return wanted_tip(top, motion)

    def _clear(self, scene: SeenScene, pose: GraspPose) -> tuple[GraspPose, float]:
        """Return a grasp's pose with an opening at which the hand gets there, and how much wider that is [m].

        Raises:
            Blocked: where it does not.
        """
        gripper, execution = self.robot.gripper, self.scenario.execution
        predicted, met = min(pose.opening, gripper.opening), ""
        for opening in openings(pose.opening, gripper.opening, execution):
            opened = replace(pose, opening=opening)
            in_the_way = self.obstacles.hand(scene.points, opened, self.scenario.motion.approach_height)
            if not in_the_way:
                return opened, opening - predicted
            met = met or in_the_way
        raise Blocked(f"on its way to the grasp the hand would meet {met}; the arm did not move")

    def _motion(self, scene: SeenScene, aim: Aim) -> Plan:
        """Plan the motion to where a grasp is, and with it from there.

        Raises:
            Unreachable: when the arm cannot carry it out.
        """
        pose = aim.pose
        upright = _upright(pose)
        solutions = self.ik.solve_grasp(pose) if upright else self.ik.solve_tilted(pose)
        why = ""
        for candidate, q in solutions:
            try:
                return self._way(scene, aim, candidate, q, upright)
            except Unreachable as error:
                why = why or str(error)  # empty where no joint angles were found
        x, y, z = pose.position
        none = f"no joint angles for the TCP at ({x:.3f}, {y:.3f}, {z:.3f}) m and the motion from it"
        raise Unreachable(why or none)

    def _way(self, scene: SeenScene, aim: Aim, candidate: GraspPose, q: Floats, upright: bool) -> Plan:
        """Plan the motion through one solution of inverse kinematics.

        Raises:
            Unreachable: where it does not go through.
        """
        motion, place = self.scenario.motion, aim.pose.position
        timed = partial(through, limits=self.robot.arm.velocity_limits)
        period = self.scenario.physics.timestep * self.scenario.physics.control_steps
        fraction = motion.speed_fraction
        drop = 0.0 if upright else self.obstacles.drop(candidate)
        stand_off = place - motion.approach_height * (DOWN if upright else candidate.approach)
        above = max(stand_off[2], scene.highest(self.scenario.table) + CLEAR + drop)
        raised = np.array([*stand_off[:2], above])
        if upright:
            raised[:2] = place[:2]
        lifted = place + [0, 0, motion.lift_height]
        target = np.array([*motion.carry_to[:2], lifted[2] + motion.carry_to[2]])

        def chain(start: Floats, end: Floats, from_q: Floats) -> list[Floats]:
            line = [GraspPose(p, candidate.rotation, 0.0) for p in straight(start, end)]
            found = self.ik.follow(line, from_q)
            if found is None:
                raise Unreachable
            return found

        back = chain(place, raised if upright else stand_off, q)
        up: list[Floats] = []
        if not upright and above - stand_off[2] > 1e-6:
            with suppress(Unreachable):  # then straight to the stand-off, where nothing is in the way
                up = chain(stand_off, raised, back[-1])
        lift = chain(place, lifted, q)
        carry = chain(lifted, target, lift[-1])
        reach = timed([np.asarray(self.robot.arm.home), (up or back)[-1]], period, fraction)
        if aim.points is not None or not upright:
            self._check(aim, [q, *back, *up, *lift, *carry])
            reach = self._entry(aim, (up or back)[-1], lambda stops: timed(stops, period, fraction))
        shake = self.shake(GraspPose(lifted, candidate.rotation, 0.0), lift[-1], period)
        if shake is None:
            raise Unreachable
        speed = motion.approach_speed
        length = above - place[2] if upright else motion.approach_height
        approach = timed([*back[::-1], q], period, fraction, length, speed)
        if up:
            down = timed([*up[::-1], back[-1]], period, fraction, above - stand_off[2], speed)
            approach = down.then(approach)
        return Plan(
            aim.grasp,
            candidate,
            aim.top,
            aim.shortfall,
            aim.widening,
            reach,
            approach,
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

    def _entry(self, aim: Aim, end: Floats, reach: Callable[[list[Floats]], Trajectory]) -> Trajectory:
        """Return a motion from home to ``end`` (N,): straight, or by a posture that is turned towards it.

        Args:
            reach: makes the motion through postures.

        Raises:
            Unreachable: where it meets something any way.
        """
        home, why = np.asarray(self.robot.arm.home), Unreachable()
        for via in ([], *([_turned(q, end)] for q in (self.robot.arm.ready, home))):
            motion = reach([home, *via, end])
            looks = np.linspace(0, len(motion.positions) - 1, ENTRY).astype(int)
            try:
                self._check(aim, motion.positions[looks])
                return motion
            except Unreachable as error:
                why = error
        raise why

    def _check(self, aim: Aim, postures: Sequence[Floats] | Floats) -> None:
        """Refuse a way on which the arm meets something.

        Raises:
            Unreachable: where it does.
        """
        points = np.zeros((0, 3)) if aim.points is None else aim.points
        for q in postures:
            met = self.obstacles.arm(points, q, aim.pose.opening)
            if met:
                raise Unreachable(f"on its way the arm would meet {met}")

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
