"""Whether a grasp holds, decided after a tenth of a :data:`QUICK` try where that is clear.

Nearly all grasps that hold sit firm from the first centimetre of the lift, and fingers that met without
touching anything have missed. A brief try looks for these two. A step of it is cheaper as well: objects sleep
until they are touched, and nothing is held long enough to creep. What it leaves open is tried to its end, as
:meth:`FloatingGripper.attempt` does it. ``benchmarks/synth.py`` measures how often both agree.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from grasp_bench.scene.contacts import touching
from grasp_bench.scene.floating import QUICK, FloatingGripper
from grasp_bench.system.arrays import Floats

ASLEEP_BELOW = 0.1
"""Objects at rest fall asleep below this speed [m/s, rad/s]; they have been still before."""
FALL_ASLEEP = 30
"""Steps in which they must; else they stay awake, which costs time only."""
PAUSE = 0.02
"""Time of standing still after the fingers have met resistance [s]."""
RISE, RISES = 0.03, 3
"""Time of the lift that is looked at [s], and how often: its sudden start pulls at the object with several g,
and what shifts then may sit firm after it."""
CHUNK = 5
"""Steps between two commands."""
SHIFT, TURN, SPEED, SPIN = 0.0008, 0.02, 0.03, 0.5
"""A grasp is firm when the object moved and turned less than this in the gripper during a rise [m, rad] and
is slower than this against it at the end [m/s, rad/s]; the gripper itself then gives way by 0.4 mm."""
MET = 0.001
"""Fingers nearer to their closed position than this have met [m]."""


class BriefTries:
    """Tells which grasps hold in one scene at rest.

    Args:
        gripper: parked beside objects that have settled; their state now is where every try starts from.
    """

    def __init__(self, gripper: FloatingGripper) -> None:
        self._gripper, self._state = gripper, gripper.state()
        self._asleep = mujoco.MjData(gripper.model)
        with self._thrifty():
            self._put_to_sleep(self._asleep)

    def holds(self, tip: Floats, yaw: float, opening: float) -> bool:
        """Try a grasp; the arguments are those of :meth:`FloatingGripper.attempt`."""
        with self._thrifty():
            verdict = self._brief(tip, yaw, opening)
        if verdict is None:
            return self._gripper.attempt(self._state, tip, yaw, opening, QUICK).held
        return verdict

    @contextmanager
    def _thrifty(self) -> Iterator[None]:
        """Let what lies untouched sleep, and leave the no-slip iterations out."""
        option = self._gripper.model.opt
        before = option.enableflags, option.noslip_iterations, option.sleep_tolerance
        option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        option.noslip_iterations, option.sleep_tolerance = 0, ASLEEP_BELOW
        try:
            yield
        finally:
            option.enableflags, option.noslip_iterations, option.sleep_tolerance = before

    def _put_to_sleep(self, data: mujoco.MjData) -> None:
        gripper, model = self._gripper, self._gripper.model
        mujoco.mj_resetData(model, data)
        data.qpos[:] = self._state[0]
        data.ctrl[gripper.carrier_u] = data.qpos[gripper.carrier_q]
        fingers = gripper.gripper.positions(data.qpos[gripper.fingers])
        data.ctrl[gripper.jaw] = gripper.gripper.command(float(fingers.mean()))
        trees = [int(model.dof_treeid[v]) for v in gripper.object_v]
        for _ in range(FALL_ASLEEP):
            mujoco.mj_step(model, data)
            if (data.tree_asleep[trees] >= 0).all():
                break

    def _brief(self, tip: Floats, yaw: float, opening: float) -> bool | None:
        """Return whether the grasp holds, None where it must be tried to its end."""
        gripper = self._gripper
        model, data = gripper.model, gripper.data
        mujoco.mj_copyData(data, model, self._asleep)
        gripper.put([*tip[:2], tip[2] + gripper.gripper.flange_to_tcp, yaw], opening)
        mujoco.mj_forward(model, data)
        if gripper.penetrates():
            return False
        squeeze = -gripper.scenario.gripper.squeeze
        most = model.actuator_forcerange[gripper.jaw, 0]
        for jaw in np.arange(opening / 2, squeeze, -QUICK.closing_speed * model.opt.timestep * CHUNK):
            data.ctrl[gripper.jaw] = gripper.gripper.command(float(jaw))
            mujoco.mj_step(model, data, CHUNK)
            if data.actuator_force[gripper.jaw] <= most:  # commanding more would change nothing
                break
        data.ctrl[gripper.jaw] = gripper.gripper.command(squeeze)
        model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        mujoco.mj_step(model, data, round(PAUSE / model.opt.timestep))
        grip = gripper.held()
        if grip is None:
            return False if self._met_nothing() else None
        return True if self._rises(grip) and not data.warning.number.any() else None

    def _met_nothing(self) -> bool:
        gripper, data = self._gripper, self._gripper.data
        touched = touching(data, gripper.left | gripper.right, gripper.body >= 0).size > 0
        return not touched and bool((gripper.gripper.positions(data.qpos[gripper.fingers]) < MET).all())

    def _rises(self, grip: int) -> bool:
        """Begin the lift; return whether object ``grip`` comes to sit firm."""
        start = float(self._gripper.data.ctrl[self._gripper.carrier_u[2]])
        return any(self._rises_firmly(grip, start + i * RISE * QUICK.lift_speed) for i in range(RISES))

    def _rises_firmly(self, grip: int, height: float) -> bool:
        gripper = self._gripper
        model, data = gripper.model, gripper.data
        q, v, carrier = gripper.object_q[grip], gripper.object_v[grip], gripper.carrier_q[:3]
        before = data.qpos[q : q + 7].copy()
        offset = before[:3] - data.qpos[carrier]
        for t in np.arange(0, RISE - 1e-9, CHUNK * model.opt.timestep):
            data.ctrl[gripper.carrier_u[2]] = height + QUICK.lift_speed * t
            mujoco.mj_step(model, data, CHUNK)
        turned = np.zeros(3)
        mujoco.mju_subQuat(turned, data.qpos[q + 3 : q + 7], before[3:])
        return bool(
            gripper.held() == grip
            and np.linalg.norm(data.qpos[q : q + 3] - data.qpos[carrier] - offset) < SHIFT
            and np.linalg.norm(turned) < TURN
            and np.linalg.norm(data.qvel[v : v + 3] - data.qvel[gripper.carrier_v[:3]]) < SPEED
            and np.linalg.norm(data.qvel[v + 3 : v + 6]) < SPIN
        )
