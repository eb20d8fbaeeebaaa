"""What imports of fingers on slides and of linkages share."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import mujoco
import numpy as np

from grasp_bench.errors import AssetError
from grasp_bench.robot.solids import extent, solids, subtree
from grasp_bench.system.arrays import Floats

SQUEEZE = 0.03
"""How far inside the closed position a finger may be commanded [m]."""
SOLREF, SOLIMP = (0.004, 1.0), (0.995, 0.999, 0.0005, 0.5, 2.0)
"""Contacts of the shipped grippers' pads; docs/physics.md says what they are measured by."""
CENTRED = 1e-3
"""How far the middle between the pads may be from the flange's axis [m]."""


def box_of(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Floats:
    """Return lower and upper corner (2, 3) of the box around a geom [m]."""
    box = extent(model, data, [geom])
    assert box is not None
    return box


def turn_about_z(spec: mujoco.MjSpec, model: mujoco.MjModel, yaw: float) -> None:
    """Turn a whole model about z."""
    turn = np.array([np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)])
    for body in [b for b in spec.bodies[1:] if b.parent.name == "world"]:
        place, quaternion = np.zeros(3), np.zeros(4)
        mujoco.mju_rotVecQuat(place, model.body(body.name).pos, turn)
        mujoco.mju_mulQuat(quaternion, turn, model.body(body.name).quat)
        body.pos, body.quat = place, quaternion
        body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def palm_of(model: mujoco.MjModel, data: mujoco.MjData, source: Path, moving: Collection[int]) -> str:
    """Return the name of the lowest body that collides and is not one of ``moving``."""
    rest = [b for b in range(1, model.nbody) if b not in moving and solids(model, [b])]
    if not rest:
        raise AssetError(f"{source} has no body between flange and fingers that collides (the palm).")

    def underside(body: int) -> float:
        box = extent(model, data, solids(model, [body]))
        return -np.inf if box is None else float(box[1, 2])

    return model.body(max(rest, key=underside)).name


def pad_of(model: mujoco.MjModel, data: mujoco.MjData, source: Path, body: int) -> int:
    """Return the geom of a finger that touches what is held: the lowest that has ``pad`` in its name, or the
    lowest of all."""
    candidates = solids(model, subtree(model, body))
    if not candidates:
        raise AssetError(f"{source}: finger {model.body(body).name!r} has no geom that collides.")

    def low(geom: int) -> float:
        box = extent(model, data, [geom])
        return -np.inf if box is None else float(box[1, 2])

    named = [g for g in candidates if "pad" in model.geom(g).name.lower()]
    return max(named or candidates, key=low)


def set_contacts(spec: mujoco.MjSpec, pads: Collection[str]) -> None:
    """Give the pads the contacts of the shipped grippers, and let no part meet another."""
    for geom in [g for g in spec.geoms if g.contype or g.conaffinity]:
        geom.contype = geom.conaffinity = 1
        geom.priority = 0
        if geom.name in pads:
            geom.priority, geom.condim = 1, 4
            geom.solref, geom.solimp, geom.friction = list(SOLREF), list(SOLIMP), [0.9, 0.005, 1e-4]
    solid = [b.name for b in spec.bodies[1:]]
    for i, first in enumerate(solid):
        for second in solid[i + 1 :]:
            spec.add_exclude(bodyname1=first, bodyname2=second)


def add_servo(spec: mujoco.MjSpec, kp: float, kv: float, commands: Collection[float], force: float) -> None:
    """Add the position servo ``grip`` on the tendon of that name, which opens or closes both fingers.

    Args:
        kp, kv: its gains [N/m, N s/m].
        commands: least and greatest length of the tendon that it may be told [m].
        force: greatest force, either way [N].
    """
    spec.add_actuator(
        name="grip",
        target="grip",
        trntype=mujoco.mjtTrn.mjTRN_TENDON,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        gainprm=[kp, *[0.0] * 9],
        biasprm=[0.0, -kp, -kv, *[0.0] * 7],
        ctrllimited=mujoco.mjtLimited.mjLIMITED_TRUE,
        ctrlrange=list(commands),
        forcelimited=mujoco.mjtLimited.mjLIMITED_TRUE,
        forcerange=[-force, force],
    )
