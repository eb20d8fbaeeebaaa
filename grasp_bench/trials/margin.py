"""How firmly is it held? Forces on a held object, raised until the grip breaks.

From the state at the end of the hold, a force on the object's centre of mass is raised in steps along one
direction of the gripper after another, each time from the same state, then a torque about the jaw axis. A
step ends as soon as the object rests again; the grip is broken when the object has moved too far in it.
Only the grip is measured, not the arm's servos: the arm stands still meanwhile.

Why in steps: while something slides fast, MuJoCo's contacts open for single steps, and what a ramp measures
depends on its speed. From rest, a load holds or it does not; closed forms are met within 2.5 %
(:mod:`grasp_bench.doctor.physics.margin`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import mujoco
import numpy as np

from grasp_bench.runs.record import MarginRecord
from grasp_bench.scenario.sections import Margin
from grasp_bench.scene.world import World
from grasp_bench.system.arrays import Floats

STEP = 1.01
"""Factor between neighbouring loads: a breaking load is known within half a per cent."""
STRIDES = (70, 9, 1)
"""Loads are first raised by so many factors at once; then, from the last that held, by fewer."""
LEAST_FORCE, LEAST_TORQUE = 0.1, 0.002
"""First loads [N, N m]; what does not bear the second is said to bear none."""
PERIOD = 0.01
"""The object is looked at every so often [s]."""
RESTING = 1e-5, math.radians(0.02)
"""It rests where it moved [m] and turned [rad] less than this in a period."""
LONGEST = 12
SLIDING = 5e-4, math.radians(1.0)
"""What does not rest after so many periods slides where it moved [m] or turned [rad] more than this under a
load, and creeps otherwise, as some grips do in the simulation without any load: those hold."""
IMMOVABLE = 1e3
"""Armature of the arm's joints meanwhile [kg m²]."""
TORQUE = "torque"


@dataclass(frozen=True)
class Load:
    """A direction in which the grip is loaded.

    Attributes:
        name: what it is called in records.
        axis: 0, 1 or 2: the TCP's jaw axis, the one across it, and the approach.
        sign: 1 or −1.
        torque: about the axis instead of a force along it.
    """

    name: str
    axis: int
    sign: int
    torque: bool = False


FORCES = tuple(
    Load(f"{mark}{name}", axis, sign)
    for axis, name in ((2, "approach"), (1, "across"), (0, "jaws"))
    for mark, sign in (("+", 1), ("-", -1))
)
TORQUES = tuple(Load(f"{mark}{TORQUE}", 0, sign, torque=True) for mark, sign in (("+", 1), ("-", -1)))
LOADS = (*FORCES, *TORQUES)


def measure(world: World, margin: Margin, loads: Sequence[Load] = LOADS) -> MarginRecord:
    """Measure how firmly the world's target is held, on a copy of its state.

    Args:
        world: the object is held, and at rest.
        margin: when a grip counts as broken, and the greatest loads.
        loads: forces and torques to try, in any order: the result does not depend on it.

    Returns:
        The least of the breaking forces, with its direction, and the least of the breaking torques.
    """
    grip = _Grip(world, margin)
    force, direction = grip.weakest([load for load in loads if not load.torque])
    torque, _ = grip.weakest([load for load in loads if load.torque])
    weight = float(world.model.body_mass[world.object_body] * np.linalg.norm(world.model.opt.gravity))
    return MarginRecord(force=force, factor=force / weight, direction=direction, torque=torque)


class _Grip:
    """A held object, in a copy of its world's state."""

    def __init__(self, world: World, margin: Margin) -> None:
        self.world, self.margin = world, margin
        self.model, self.data = world.model, copy(world.data)
        joint = self.model.body_jntadr[world.object_body]
        self._q = int(self.model.jnt_qposadr[joint])
        arm = world.robot
        self._arm = [int(self.model.joint(arm.arm_prefix + n).dofadr[0]) for n in arm.arm.joints]
        self._axes = world.tcp.rotation.T.copy()
        self._period = max(1, round(PERIOD / self.model.opt.timestep))
        self._start = self._place()
        self._limits = margin.distance, math.radians(margin.angle_deg)

    def weakest(self, loads: Sequence[Load]) -> tuple[float, str]:
        """Return the least load that breaks the grip [N or N m], half a step above one that held; its name.

        0 where the second of all loads breaks it, the greatest load where none does. Of equal ones, the first
        in the order of :data:`LOADS`.
        """
        if not loads:
            return 0.0, ""
        least, cap = LEAST_FORCE, self.margin.force_cap
        if loads[0].torque:
            least, cap = LEAST_TORQUE, self.margin.torque_cap
        weakest = top = math.ceil(math.log(cap / least) / math.log(STEP))
        found: list[tuple[int, int]] = []
        for load in loads:
            found.append((self._greatest_held(load, least, weakest), LOADS.index(load)))
            weakest = min(found)[0]
        level, which = min(found)
        size = cap if level >= top else least * STEP ** (level + 0.5) if level else 0.0
        return size, LOADS[which].name

    def _greatest_held(self, load: Load, least: float, enough: int) -> int:
        """Return the number of the greatest load that holds, or of one that does and is above ``enough``.

        Which loads are tried does not depend on ``enough``, but for where it ends.
        """
        start = held = self._state()
        armature = self.model.dof_armature.copy()
        self.model.dof_armature[self._arm] = IMMOVABLE
        low, high = 0, enough + 1 + STRIDES[0]
        try:
            for stride in STRIDES:
                for level in range(low + stride, high, stride):
                    if not self._holds(load, least * STEP**level):
                        high = level
                        break
                    low, held = level, self._state()
                    if low > enough:
                        return low
                self._restore(held)
        finally:
            self.model.dof_armature[:] = armature
            self._restore(start)
        return low

    def _holds(self, load: Load, size: float) -> bool:
        """Load the resting object, and return whether it comes to rest again, still held."""
        self.data.qvel[:] = 0
        self.data.xfrc_applied[:] = 0
        place = slice(3, 6) if load.torque else slice(0, 3)
        self.data.xfrc_applied[self.world.object_body, place] = size * load.sign * self._axes[load.axis]
        loaded = self._place()
        for _ in range(LONGEST):
            before = self._place()
            mujoco.mj_step(self.model, self.data, self._period)
            if self.data.warning.number.any():
                self.data.warning.number[:] = 0
                return False
            if not _within(self._limits, self._start, self._place()):
                return False
            if _within(RESTING, before, self._place()):
                return True
        return _within(SLIDING, loaded, self._place())

    def _place(self) -> Floats:
        """Return position (3) [m] and quaternion (4) of the object; the gripper does not move."""
        return self.data.qpos[self._q : self._q + 7].copy()

    def _state(self) -> tuple[Floats, Floats]:
        full = mujoco.mjtState.mjSTATE_FULLPHYSICS
        state = np.empty(mujoco.mj_stateSize(self.model, full))
        mujoco.mj_getState(self.model, self.data, state, full)
        return state, self.data.qacc_warmstart.copy()

    def _restore(self, state: tuple[Floats, Floats]) -> None:
        mujoco.mj_setState(self.model, self.data, state[0], mujoco.mjtState.mjSTATE_FULLPHYSICS)
        self.data.qacc_warmstart[:] = state[1]


def _within(limits: tuple[float, float], first: Floats, second: Floats) -> bool:
    """Return whether two places (7) are less than a distance [m] and an angle [rad] apart."""
    cosine = min(1.0, abs(float(first[3:] @ second[3:])))
    return bool(np.linalg.norm(second[:3] - first[:3]) < limits[0]) and 2 * math.acos(cosine) < limits[1]
