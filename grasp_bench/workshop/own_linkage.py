"""A user's gripper whose fingers hang on hinges, rewritten: linkages that keep the pads parallel.

Links stay as they are, and so do the loops that the file closes with ``<connect>``. Files often leave the
rest to springs, to tendons or to the program that reads them; here it is what such grippers are built for:
the pads stay parallel, side links turn with the first link, and both fingers move alike.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from grasp_bench.errors import AssetError
from grasp_bench.robot.solids import solids, subtree
from grasp_bench.workshop.linkage_drive import add_end, add_grip, find_ends
from grasp_bench.workshop.own_hand import box_of, pad_of, palm_of, set_contacts, turn_about_z
from grasp_bench.workshop.own_model import fix_inertia, strip

LEAST_TRAVEL = 0.1
"""Hinges that turn by less are those of a file whose angles were taken for degrees [rad]."""
SOLREF, SOLIMP = [0.004, 1.0], [0.95, 0.99, 0.001, 0.5, 2.0]
"""Of the constraints that couple joints."""


def rewrite_linkage(
    spec: mujoco.MjSpec, source: Path, pads: tuple[str, str] | None
) -> tuple[dict[str, Any], dict[str, float]]:
    """Rewrite a model of a gripper with hinges; the names of its parts, and its commands.

    Args:
        spec: its parts have names.
        source: named in errors.
        pads: geoms that touch what is held; looked for by default.

    Raises:
        AssetError: in one line, for what is no gripper of two fingers on parallel linkages.
    """
    model = spec.compile()
    travels = np.ptp(model.jnt_range, axis=1)[model.jnt_limited.astype(bool)]
    if len(travels) and travels.max() < LEAST_TRAVEL:
        raise AssetError(
            f"{source}: its hinges turn by no more than {np.degrees(travels.max()):.1f}°; where the file "
            "means radians without saying so, say --radian."
        )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    fingers, chosen = _fingers(model, data, source, pads)
    across = box_of(model, data, chosen[0]).mean(0) - box_of(model, data, chosen[1]).mean(0)
    turn_about_z(spec, model, -float(np.arctan2(across[1], across[0])))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    chains = [_chain(model, body) for body in fingers]
    parts = {
        "fingers": [model.body(b).name for b in fingers],
        "pads": [model.geom(g).name for g in chosen],
        "palm": palm_of(model, data, source, {b for j in range(model.njnt) for b in _below(model, j)}),
    }
    loops = [
        (e.name1, e.name2, np.array(e.data[:3]))
        for e in spec.equalities
        if e.type == mujoco.mjtEq.mjEQ_CONNECT and e.objtype == mujoco.mjtObj.mjOBJ_BODY
    ]
    joints = [model.joint(j).name for j in range(model.njnt)]
    strip(spec, joints)
    fix_inertia(spec, model)
    set_contacts(spec, parts["pads"])
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST  # as in a trial
    spec.option.timestep = 0.002
    for j, name in enumerate(joints):
        _loosen(spec.joint(name), driver=j in (chains[0][0], chains[1][0]))
    for first, second, anchor in loops:
        row = np.zeros(mujoco.mjNEQDATA)
        row[:3] = anchor
        spec.add_equality(
            type=mujoco.mjtEq.mjEQ_CONNECT,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=first,
            name2=second,
            data=row,
            solref=SOLREF,
            solimp=SOLIMP,
        )
    _couple(spec, model, data, source, chains, bool(loops))
    for side, geom in zip(("left", "right"), chosen, strict=True):
        add_end(spec, model, data, side, geom)
    tendon = spec.add_tendon(name="grip", width=1e-4, rgba=[0, 0, 0, 0])
    tendon.wrap_site("grasp_bench_left")
    tendon.wrap_site("grasp_bench_right")
    add_grip(spec)
    commands, tips = find_ends(spec, source, fingers, chosen, [chain[0] for chain in chains])
    spec.worldbody.add_site(name="grasp_bench_tcp", pos=[0, 0, tips], size=[0.003] * 3, group=4)
    return parts, commands


def _below(model: mujoco.MjModel, joint: int) -> list[int]:
    return subtree(model, int(model.jnt_bodyid[joint]))


def _chain(model: mujoco.MjModel, body: int) -> list[int]:
    """Return the joints between base and ``body``, from the base on."""
    return [j for j in range(model.njnt) if body in _below(model, j)]


def _fingers(
    model: mujoco.MjModel, data: mujoco.MjData, source: Path, asked: tuple[str, str] | None
) -> tuple[list[int], list[int]]:
    """Return the bodies of the fingers and the geoms of the pads, the one that becomes the left first."""
    moving = sorted({b for j in range(model.njnt) for b in _below(model, j)})
    solid = solids(model, moving)
    if asked is not None:
        chosen = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, n) for n in asked]
        if any(g not in solid for g in chosen):
            names = ", ".join(model.geom(g).name for g in solid)
            raise AssetError(f"{source}: --pads must be one geom of each finger; they have {names}.")
    else:
        ends = [b for b in moving if model.body_jntnum[b] and not _moves_more(model, b)]
        named = [b for b in ends if any("pad" in model.geom(g).name.lower() for g in solids(model, [b]))]
        lowest = sorted(named or [b for b in ends if solids(model, [b])], key=lambda b: -data.xipos[b][2])
        if len(named) not in (0, 2) or len(lowest) < 2:
            raise AssetError(
                f"{source} has {len(named)} bodies on hinges with a geom named pad; a gripper has two "
                "fingers. Name one geom of each with --pads."
            )
        chosen = [pad_of(model, data, source, b) for b in lowest[:2]]
    owners = [_carrier(model, int(model.geom_bodyid[g])) for g in chosen]
    if owners[0] == owners[1]:
        raise AssetError(f"{source}: both pads are of body {model.body(owners[0]).name!r}.")
    return owners, chosen


def _moves_more(model: mujoco.MjModel, body: int) -> bool:
    return any(model.body_jntnum[b] for b in subtree(model, body)[1:])


def _carrier(model: mujoco.MjModel, body: int) -> int:
    """Return the nearest body at or above ``body`` that has a joint."""
    while body and not model.body_jntnum[body]:
        body = int(model.body_parentid[body])
    return body


def _loosen(joint: mujoco.MjsJoint, driver: bool) -> None:
    joint.stiffness, joint.frictionloss = [0.0, 0.0, 0.0], 0.0
    joint.damping = [0.018 if driver else 5e-4, 0.0, 0.0]
    joint.armature = 7e-4 if driver else 5e-5
    joint.solref_limit, joint.solimp_limit = SOLREF, SOLIMP


def _couple(
    spec: mujoco.MjSpec,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    source: Path,
    chains: list[list[int]],
    closed: bool,
) -> None:
    """Couple joints until one is left that moves: see the module's first lines."""

    def follow(joint: int, first: int, slope: float) -> None:
        row = np.zeros(mujoco.mjNEQDATA)
        row[1] = slope
        row[0] = float(model.qpos0[model.jnt_qposadr[joint]] - slope * model.qpos0[model.jnt_qposadr[first]])
        spec.add_equality(
            type=mujoco.mjtEq.mjEQ_JOINT,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            name1=model.joint(joint).name,
            name2=model.joint(first).name,
            data=row,
            solref=SOLREF,
            solimp=SOLIMP,
        )

    drivers = [chain[0] for chain in chains]
    same = float(np.sign(data.xaxis[drivers[0]] @ data.xaxis[drivers[1]]))
    follow(drivers[1], drivers[0], -same)
    if _freedoms(spec) == 1:
        return
    for chain in chains:
        if len(chain) != 2:
            raise AssetError(
                f"{source}: finger {model.body(model.jnt_bodyid[chain[-1]]).name!r} hangs on {len(chain)} "
                "hinges in a row; linkages of two are read, and fingers on slides. Model its pads on slides."
            )
        follow(chain[1], chain[0], -float(np.sign(data.xaxis[chain[0]] @ data.xaxis[chain[1]])))
    if _freedoms(spec) == 1:
        return
    if not closed:
        for side in (j for j in range(model.njnt) if not any(j in chain for chain in chains)):
            at = data.xanchor[side]
            first = min(drivers, key=lambda d: float(np.linalg.norm(data.xanchor[d] - at)))
            follow(side, first, float(np.sign(data.xaxis[first] @ data.xaxis[side])))
    if (left := _freedoms(spec)) != 1:
        raise AssetError(
            f"{source}: {left} joints of the linkage still move independently when the pads are kept "
            "parallel; close its loops with <connect>, or model its pads on slides."
        )


def _freedoms(spec: mujoco.MjSpec) -> int:
    """Return in how many ways a model can move."""
    model = spec.compile()
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    rows = data.ne
    if not rows:
        return int(model.nv)
    matrix = np.asarray(data.efc_J).reshape(-1, model.nv)[:rows]
    return int(model.nv - np.linalg.matrix_rank(matrix, tol=1e-6))
