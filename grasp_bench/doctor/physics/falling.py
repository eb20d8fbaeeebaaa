"""Falling and landing: s = ½ g t², p = m g t, and the table gives back all momentum."""

from __future__ import annotations

import mujoco
import numpy as np

from grasp_bench.doctor.physics.check import Check, below, equals
from grasp_bench.doctor.physics.rig import Rig, block
from grasp_bench.scenario.sections import Scenario

G = 9.81
HEIGHT = 0.6
MASS = 0.2


def falling(scenario: Scenario) -> list[Check]:
    """Check free fall [m], momentum before landing and impulse of the landing [N s], and spin in flight."""
    rig = Rig(scenario, block((0.06, 0.04, 0.03), MASS, 0.7))
    beside = np.array([scenario.table.center[0], 0.3, HEIGHT])
    rig.reset()
    rig.world.place_object(beside, np.array([1.0, 0, 0, 0]))
    time = 0.3
    rig.run(time)
    mujoco.mj_kinematics(rig.model, rig.data)  # poses are otherwise those before the last step
    fallen = HEIGHT - float(rig.world.object_pose[0][2])
    dof = int(rig.model.joint("object").dofadr[0])
    momentum = MASS * float(np.linalg.norm(rig.data.qvel[dof : dof + 3]))
    # On to rest: the table's impulse must be m g T, whatever happened in between.
    impulse, force = 0.0, np.zeros(6)
    steps = round((2.0 - time) / rig.dt)
    for _ in range(steps):
        rig.world.step(1)
        for i in range(rig.data.ncon):
            if rig.world.object_body in rig.model.geom_bodyid[rig.data.contact.geom[i]]:
                mujoco.mj_contactForce(rig.model, rig.data, i, force)
                impulse += float((rig.data.contact.frame[i].reshape(3, 3).T @ force[:3])[2]) * rig.dt
    left = MASS * float(np.linalg.norm(rig.data.qvel[dof : dof + 3]))
    return [
        equals(
            "free fall in 0.3 s",
            G * time**2 / 2,
            fallen,
            "m",
            0.01,
            "½ g t²; semi-implicit Euler falls g t dt / 2 further",
        ),
        equals("momentum after 0.3 s of falling", MASS * G * time, momentum, "N s", 1e-3, "m g t"),
        equals(
            "impulse of the table on what was dropped, in 2 s",
            MASS * G * 2.0,
            abs(impulse),
            "N s",
            0.01,
            "momentum: ∫ N dt = m g T",
        ),
        below("momentum left 2 s after it was let go", left, 1e-4, "N s", "at rest"),
        spin(rig),
    ]


def spin(rig: Rig) -> Check:
    """Check the angular momentum of a box tumbling in the air for half a second."""
    rig.reset()
    rig.model.opt.gravity[:] = 0
    rig.world.place_object(np.array([0.5, 0.3, 0.5]), np.array([1.0, 0, 0, 0]))
    dof = int(rig.model.joint("object").dofadr[0])
    rig.data.qvel[dof + 3 : dof + 6] = [8.0, 1.0, 3.0]

    def angular() -> np.ndarray:
        mujoco.mj_kinematics(rig.model, rig.data)
        rotation = rig.world.object_pose[1]
        return rotation @ (rig.body.inertia @ rig.data.qvel[dof + 3 : dof + 6])

    before = angular()
    rig.run(0.5)
    change = float(np.linalg.norm(angular() - before) / np.linalg.norm(before))
    return below(
        "change of angular momentum of a tumbling box in 0.5 s",
        100 * change,
        1.0,
        "%",
        "conservation; Euler's equations",
    )
