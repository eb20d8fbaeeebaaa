"""Simple bodies in a trial's own scene, held by its gripper or lying on its table."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from grasp_bench.objects.catalog import VisualPart
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import compile_mjcf, compose
from grasp_bench.scene.world import World

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Body:
    """A convex solid for the scene builder, with any centre of mass.

    Attributes:
        points: (V, 3) vertices relative to the centre of mass [m].
        mass: mass [kg].
        inertia: (3, 3) about the centre of mass [kg m²].
        friction: coefficient of friction against the pads.
    """

    points: Floats
    mass: float
    inertia: Floats
    friction: float

    @property
    def visual(self) -> list[VisualPart]:
        """No visible parts."""
        return []

    @property
    def hulls(self) -> list[Floats]:
        """The one convex piece."""
        return [self.points]


def block(
    size: tuple[float, float, float],
    mass: float,
    friction: float,
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Body:
    """Return a uniform box of ``size`` [m] whose middle lies at ``centre`` from the centre of mass."""
    corners = np.array(list(itertools.product(*((-s / 2, s / 2) for s in size)))) + centre
    a, b, c = np.square(size)
    return Body(corners, mass, mass / 12 * np.diag([b + c, a + c, a + b]), friction)


class Rig:
    """A body in the scene of a trial, the arm at its home posture.

    Args:
        scenario: scenario of the trial.
        body: the body that takes the place of an object.
    """

    def __init__(self, scenario: Scenario, body: Body) -> None:
        self.scenario, self.body = scenario, body
        self.world = World(compile_mjcf(compose(scenario, body)), scenario)
        self.model, self.data = self.world.model, self.world.data
        self._gravity = self.model.opt.gravity.copy()
        robot = self.world.robot
        self._jaw = self.model.actuator(robot.gripper_prefix + robot.gripper.actuator).id

    @property
    def dt(self) -> float:
        """Time step [s]."""
        return float(self.model.opt.timestep)

    def reset(self, opening: float | None = None) -> None:
        """Go back home, at rest, under full gravity, with jaws ``opening`` apart [m], or wide open."""
        mujoco.mj_resetData(self.model, self.data)
        self.model.opt.gravity[:] = self._gravity
        self.world.go_home(opening)
        mujoco.mj_forward(self.model, self.data)

    def run(self, seconds: float) -> None:
        """Step on for ``seconds`` of simulated time."""
        self.world.step(round(seconds / self.dt))

    def load(self, gravity: Floats, seconds: float = 0.3) -> None:
        """Bring gravity (3,) [m/s²] linearly to a new value, slowly, so that nothing swings."""
        before = self.model.opt.gravity.copy()
        steps = round(seconds / self.dt)
        for i in range(1, steps + 1):
            self.model.opt.gravity[:] = before + (gravity - before) * i / steps
            self.world.step(1)

    def grip(self, force: float, at: tuple[float, float] = (0.0, 0.0)) -> None:
        """Hold the body, weightless first, by ``force`` [N] per pad; then load it with its weight.

        Args:
            force: force of each pad, as the scenario key ``gripper.force`` sets it.
            at: where the pads' centre meets the body [m], in the body's y and z, which are the gripper's y
                and the reverse of its direction of approach.
        """
        if isinstance(self.world.robot.gripper, SuctionCup):
            self.stick(force)
            self.load(self._gravity)
            return
        thickness = float(np.ptp(self.body.points[:, 0]))
        self.reset(thickness + 0.002)
        self.model.opt.gravity[:] = 0
        hand = self.world.robot.gripper
        self.model.actuator_forcerange[self._jaw] = hand.actuator_range(force)
        tcp = self.world.tcp
        turn = tcp.rotation @ np.diag([1.0, -1.0, -1.0])  # upright: body z against the approach
        place = tcp.position + turn @ np.array([0.0, -at[0], hand.pad[2] / 2 - at[1]])
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, turn.ravel())
        self.world.place_object(place, quaternion)
        # Closed at the speed of a trial: thrown shut, the fingers would hit the body at more than 1 m/s.
        gripper = self.scenario.gripper
        for jaw in np.arange(thickness / 2 + 0.001, -gripper.squeeze, -gripper.closing_speed * self.dt):
            self.data.ctrl[self._jaw] = hand.command(float(jaw))
            self.world.step(1)
        self.data.ctrl[self._jaw] = hand.command(-gripper.squeeze)
        self.run(gripper.settle_time)
        self.load(self._gravity)

    def stick(self, force: float) -> None:
        """Hold the weightless body by a cup on the middle of its upper side, vacuum of ``force`` [N]."""
        self.reset()
        self.model.opt.gravity[:] = 0
        hand = self.world.robot.gripper
        self.model.actuator_forcerange[self._jaw] = hand.actuator_range(force)
        tcp = self.world.tcp
        turn = tcp.rotation @ np.diag([1.0, -1.0, -1.0])
        low, high = self.body.points.min(0), self.body.points.max(0)
        top = np.array([*((low + high) / 2)[:2], high[2]])
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, turn.ravel())
        self.world.place_object(tcp.position - turn @ top, quaternion)
        self.data.ctrl[self._jaw] = hand.command(-1.0)
        self.run(self.scenario.gripper.settle_time)

    def relative(self) -> tuple[Floats, Floats]:
        """Return position (3,) [m] and rotation (3, 3) of the body in the gripper's frame."""
        position, rotation = self.world.object_pose
        tcp = self.world.tcp
        return tcp.rotation.T @ (position - tcp.position), tcp.rotation.T @ rotation

    def moved(self, seconds: float) -> tuple[float, float]:
        """Return how far [m] and through which angle [rad] the body slides in the gripper in ``seconds``."""
        before, turned = self.relative()
        self.run(seconds)
        after, now = self.relative()
        cosine = (float(np.trace(turned.T @ now)) - 1) / 2
        return float(np.linalg.norm(after - before)), float(np.arccos(np.clip(cosine, -1, 1)))


def threshold(fails: Callable[[float], bool], low: float, high: float, steps: int = 10) -> float:
    """Find where ``fails`` changes from true (at ``low``) to false (at ``high``), by bisection.

    Raises:
        ValueError: when it does not change between them.
    """
    if not fails(low) or fails(high):
        raise ValueError(f"nothing changes between {low:g} and {high:g}")
    for _ in range(steps):
        middle = (low + high) / 2
        if fails(middle):
            low = middle
        else:
            high = middle
    return (low + high) / 2
