"""A suction cup without the arm: tries in physics where it holds."""

from __future__ import annotations

import mujoco
import numpy as np

from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.gripper import Gripper
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.floating import PREFIX, FloatingGripper, Routine
from grasp_bench.scene.sealing import Sealing
from grasp_bench.system.arrays import Floats

ABOVE = 0.03
"""How far above the place of a grasp the cup appears [m]."""
HELD_UP = 3e-4
"""A hand that stops this far from where it should be has met something [m]: with 9 N and more."""
DOWN = 0.15
"""Speed at which it comes down [m/s]."""


class FloatingCup(FloatingGripper):
    """Tries places for a suction cup on the objects of one scene.

    Args:
        model, scenario, count: as of :class:`FloatingGripper`.
        gripper: the cup that the model was compiled with.
    """

    def __init__(self, model: mujoco.MjModel, scenario: Scenario, count: int, gripper: SuctionCup) -> None:
        super().__init__(model, scenario, count, gripper)
        self._sealing = Sealing(model, gripper, PREFIX)

    def take(self, carrier: Floats, opening: float, routine: Routine) -> str:
        """Appear above ``carrier`` (4,) [m, rad], come down, and switch the vacuum on where the cup seals."""
        model, data, chunk = self.model, self.data, 5
        self.put(carrier + [0, 0, ABOVE, 0], opening)
        mujoco.mj_forward(model, data)
        if self.penetrates():
            return "collision"
        for above in np.arange(ABOVE, 0, -DOWN * model.opt.timestep * chunk):
            data.ctrl[self.carrier_u[2]] = carrier[2] + above
            mujoco.mj_step(model, data, chunk)
        data.ctrl[self.carrier_u[2]] = carrier[2]
        mujoco.mj_step(model, data, int(0.1 / model.opt.timestep))
        if np.abs(data.qpos[self.carrier_q[:3]] - carrier[:3]).max() > HELD_UP:
            return "collision"
        objects = [int(model.dof_bodyid[v]) for v in self.object_v]
        if self._sealing.fault(data, objects):
            return "no seal"
        data.ctrl[self.jaw] = self.gripper.command(-self.scenario.gripper.squeeze)
        return ""


def floating(model: mujoco.MjModel, scenario: Scenario, count: int, gripper: Gripper) -> FloatingGripper:
    """Return what tries grasps of ``gripper``, with which ``model`` was compiled."""
    kind = FloatingCup if isinstance(gripper, SuctionCup) else FloatingGripper
    return kind(model, scenario, count, gripper)  # type: ignore[arg-type]
