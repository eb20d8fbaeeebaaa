"""Dense and sparse algebra give the same accelerations.

MuJoCo 4.0.0 had a sparse factorisation that gave its Newton solver wrong Hessians; trials use the dense
one, and this tells whether it would matter.
"""

from __future__ import annotations

import mujoco
import numpy as np

from grasp_bench.doctor.physics.check import Check, below
from grasp_bench.doctor.physics.rig import Rig, block
from grasp_bench.scenario.sections import Scenario


def jacobian(scenario: Scenario) -> list[Check]:
    """Check the greatest difference of accelerations over a grip, relative to the greatest acceleration."""
    rig = Rig(scenario, block((0.04, 0.04, 0.04), 0.2, 0.7))
    rig.grip(scenario.gripper.force)
    worst = 0.0
    count = len(scenario.robot.loaded.arm.joints)
    joints, sides = rig.data.ctrl[:count].copy(), np.resize([1, 1, -1, 1, -1, 1], count)
    for step in range(200):
        # Shaken while held, so that contacts and limits are all at work.
        rig.data.ctrl[:count] = joints + 0.02 * np.sin(0.1 * step) * sides
        rig.world.step(1)
        dense, sparse = (
            acceleration(rig, mode)
            for mode in (mujoco.mjtJacobian.mjJAC_DENSE, mujoco.mjtJacobian.mjJAC_SPARSE)
        )
        worst = max(worst, float(np.abs(dense - sparse).max() / np.abs(dense).max()))
    return [
        below(
            "accelerations with a sparse instead of a dense Jacobian, of the greatest",
            worst,
            1e-6,
            "",
            "the same equations",
        )
    ]


def acceleration(rig: Rig, mode: mujoco.mjtJacobian) -> np.ndarray:
    """Return (nv,) accelerations in the rig's present state, with a Jacobian of ``mode``."""
    data = mujoco.MjData(rig.model)
    before, rig.model.opt.jacobian = rig.model.opt.jacobian, mode
    try:
        mujoco.mj_copyData(data, rig.model, rig.data)
        mujoco.mj_forward(rig.model, data)
    finally:
        rig.model.opt.jacobian = before
    return data.qacc.copy()
