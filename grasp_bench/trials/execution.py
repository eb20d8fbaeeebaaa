"""A plan carried out in physics and judged: approach, close, lift, shake, carry, hold."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from grasp_bench.grasps import GraspPose
from grasp_bench.planning.planner import Plan
from grasp_bench.planning.shake import AXES
from grasp_bench.robot.trajectory import Trajectory
from grasp_bench.runs.record import TcpError
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scene.world import UnstableError, World
from grasp_bench.system.arrays import Floats

Verdict = tuple[Outcome, str]
"""An outcome, and why in words."""


@dataclass(frozen=True)
class Execution:
    """How a plan went; what was not reached is None or 0.

    Attributes:
        outcome, detail: the verdict, and why in words.
        tcp_error: that of the TCP before the fingers closed.
        lift_height: height of the object above its place, after lifting [m].
        contact_force: mean normal force of the two fingers at the end [N].
    """

    outcome: Outcome
    detail: str
    tcp_error: TcpError | None
    lift_height: float
    contact_force: float

    @property
    def measured(self) -> dict[str, Any]:
        """What a record takes over."""
        return {k: getattr(self, k) for k in ("tcp_error", "lift_height", "contact_force")}


def execute(world: World, plan: Plan) -> Execution:
    """Carry out a plan with the world's arm, up to the phase that ends it."""
    motion = _Phases(world, plan)
    try:
        outcome, detail = motion.run()
    except UnstableError as error:
        outcome, detail = Outcome.UNSTABLE, str(error)
    return Execution(outcome, detail, motion.tcp_error, motion.lift_height, motion.contact_force)


class _Phases:
    """The phases of an execution; each returns a verdict where it ends the attempt, and None where not."""

    def __init__(self, world: World, plan: Plan) -> None:
        self.world, self.plan = world, plan
        self.scenario = world.scenario
        self.period = self.scenario.physics.timestep * self.scenario.physics.control_steps
        self.open_at = plan.pose.opening / 2
        self.squeeze = -self.scenario.gripper.squeeze
        self.tcp_error: TcpError | None = None
        self.lift_height = self.contact_force = 0.0

    def run(self) -> Verdict:
        self.world.mark()
        self.world.spare()
        return (
            self.approach()
            or self.close()
            or self.lift()
            or self.shake()
            or self.carry_and_hold()
            or (Outcome.SUCCESS, "")
        )

    def approach(self) -> Verdict | None:
        world, plan, motion = self.world, self.plan, self.scenario.motion
        speed = self.scenario.gripper.closing_speed
        preshape = np.maximum(
            self.open_at,
            self.world.robot.gripper.stroke
            - speed * self.period * np.arange(1, len(plan.reach.positions) + 1),
        )
        world.follow(plan.reach, preshape)
        for chunk in chunks(plan.approach, 5):
            world.follow(chunk, self.open_at)
            force, what = world.collision_force()
            if force > motion.collision_force:
                why = f"the gripper met the {what} with {force:.0f} N on its way down"
                return Outcome.APPROACH_COLLISION, why
        world.follow(still(plan.approach.end, 0.05, self.period), self.open_at)
        self.tcp_error = distance, angle = tcp_error(world.tcp, plan.pose)
        if distance > motion.tcp_tolerance or angle > math.radians(motion.tcp_tolerance_deg):
            return Outcome.APPROACH_COLLISION, (
                f"the gripper was held up {1000 * distance:.1f} mm and "
                f"{math.degrees(angle):.1f}° from the planned grasp"
            )
        return None

    def close(self) -> Verdict | None:
        world, gripper, q = self.world, self.scenario.gripper, self.plan.approach.end
        if fault := world.seal_fault():
            return Outcome.MISSED, fault
        closing = np.arange(self.open_at, -gripper.squeeze, -gripper.closing_speed * self.period)
        world.follow(still(q, len(closing) * self.period, self.period, len(closing)), closing)
        world.follow(still(q, gripper.settle_time, self.period), self.squeeze)
        world.aim_at_held()
        if not world.touch().held:
            return Outcome.MISSED, "the fingers closed without holding the object"
        return None

    def lift(self) -> Verdict | None:
        self.world.hold()
        self.world.follow(self.plan.lift, self.squeeze)
        self.lift_height = self.world.rise()
        if not self.world.touch().held or self.lift_height < self.scenario.success.minimum_lift:
            return Outcome.SLIPPED, f"lost while lifting, {whole_mm(self.lift_height)} mm above its place"
        return None

    def shake(self) -> Verdict | None:
        for axis, burst in zip(AXES, self.plan.shake, strict=False):
            self.world.follow(burst, self.squeeze)
            if not self.world.touch().held:
                hardness = self.scenario.motion.shake.acceleration
                return Outcome.DROPPED, f"lost while shaken {axis} with ±{hardness:g} m/s²"
        return None

    def carry_and_hold(self) -> Verdict | None:
        world, plan = self.world, self.plan
        world.follow(plan.carry, self.squeeze)
        world.follow(still(plan.carry.end, self.scenario.motion.hold_time, self.period), self.squeeze)
        touch, height = world.touch(), world.rise()
        self.contact_force = (touch.left + touch.right) / 2
        if not touch.held or height < self.scenario.success.minimum_lift:
            return Outcome.DROPPED, f"lost while carried or held, {whole_mm(height)} mm above its place"
        if touch.elsewhere:
            return Outcome.DROPPED, f"still touching {', '.join(touch.elsewhere)} at the end"
        return None


def whole_mm(metres: float) -> int:
    """Return whole millimetres, for sentences: there is no −0 among them."""
    return round(1000 * metres)


def chunks(motion: Trajectory, size: int) -> Iterator[Trajectory]:
    """Cut a trajectory into pieces of ``size`` samples."""
    for i in range(0, len(motion.positions), size):
        yield Trajectory(motion.positions[i : i + size], motion.velocities[i : i + size])


def still(q: Floats, seconds: float, period: float, count: int | None = None) -> Trajectory:
    """Return a trajectory that stands still at ``q``."""
    samples = max(1, round(seconds / period)) if count is None else count
    return Trajectory(np.repeat(q[None], samples, axis=0), np.zeros((samples, len(q))))


def tcp_error(actual: GraspPose, wanted: GraspPose) -> TcpError:
    """Return how far a TCP pose is from another."""
    cosine = (np.trace(actual.rotation.T @ wanted.rotation) - 1) / 2
    return TcpError(
        float(np.linalg.norm(actual.position - wanted.position)),
        float(math.acos(min(1.0, max(-1.0, float(cosine))))),
    )
