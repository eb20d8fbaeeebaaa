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
from grasp_bench.robot.solids import extent, solids, subtree
from grasp_bench.workshop.own_hand import (
    CENTRED,
    SQUEEZE,
    box_of,
    pad_of,
    palm_of,
    set_contacts,
    turn_about_z,
)
from grasp_bench.workshop.own_model import fix_inertia, strip

KP, KV = 6250.0, 60.0
"""Gains of the servo on the distance between the fingers [N/m, N s/m]: those of `adaptive-85`."""
BEHIND = 0.020
"""The tendon ends so far behind the pads' middles [m]: it must not shrink to nothing."""
LEAST_TRAVEL = 0.1
"""Hinges that turn by less are those of a file whose angles were taken for degrees [rad]."""
SLACK = 0.02
"""The first links may turn further than was found by so much [rad]."""
STEP, WIDEST = 0.002, 0.2
"""Steps in which the fingers are moved to find where they end, and how far apart they are tried [m]."""
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
        _add_end(spec, model, data, side, geom)
    tendon = spec.add_tendon(name="grip", width=1e-4, rgba=[0, 0, 0, 0])
    tendon.wrap_site("grasp_bench_left")
    tendon.wrap_site("grasp_bench_right")
    _add_servo(spec)
    commands, tips = _ends(spec, source, fingers, chosen, [chain[0] for chain in chains])
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


def _add_end(spec: mujoco.MjSpec, model: mujoco.MjModel, data: mujoco.MjData, side: str, geom: int) -> None:
    """Add the tendon's end of one finger, behind the pad's middle."""
    owner = int(model.geom_bodyid[geom])
    outwards = np.array([BEHIND if side == "left" else -BEHIND, 0.0, 0.0])
    place = box_of(model, data, geom).mean(0) + outwards
    place[1] = 0.0
    local = data.xmat[owner].reshape(3, 3).T @ (place - data.xpos[owner])
    spec.body(model.body(owner).name).add_site(
        name=f"grasp_bench_{side}", pos=local, size=[0.001] * 3, group=4
    )


def _add_servo(spec: mujoco.MjSpec) -> None:
    spec.add_actuator(
        name="grip",
        target="grip",
        trntype=mujoco.mjtTrn.mjTRN_TENDON,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        gainprm=[KP, *[0.0] * 9],
        biasprm=[0.0, -KP, -KV, *[0.0] * 7],
        ctrllimited=mujoco.mjtLimited.mjLIMITED_TRUE,
        ctrlrange=[-2 * SQUEEZE, WIDEST + 4 * BEHIND],
        forcelimited=mujoco.mjtLimited.mjLIMITED_TRUE,
        forcerange=[-60.0, 60.0],
    )


def _ends(
    spec: mujoco.MjSpec, source: Path, fingers: list[int], pads: list[int], drivers: list[int]
) -> tuple[dict[str, float], float]:
    """Move the fingers, and return the commands for open and closed, and how far the tips reach [m].

    The pads may go through each other meanwhile: closed is where they meet. Of links without a range, the
    file's own posture is taken for open. The first links get the range that was found.
    """
    model = spec.compile()
    model.opt.gravity[:] = 0
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start = float(data.ten_length[0])
    seen: list[tuple[float, ...]] = []
    at = model.jnt_qposadr[drivers]
    limited = bool(model.jnt_limited[drivers].all())

    def look() -> tuple[float, ...]:
        left, right = (box_of(model, data, p) for p in pads)
        tips = extent(model, data, [g for body in fingers for g in solids(model, subtree(model, body))])
        assert tips is not None
        if np.hypot(*((left + right).mean(0)[:2] / 2)) > CENTRED:
            raise AssetError(
                f"{source}: the middle between the pads is not on the z axis of the file, which is taken for "
                "the flange's; move the gripper's root body there."
            )
        return float(data.ten_length[0]), float(left[0, 0] - right[1, 0]), float(tips[1, 2]), *data.qpos[at]

    seen.append(look())
    for way in (STEP, -STEP) if limited else (-STEP,):
        mujoco.mj_resetData(model, data)
        wanted = start
        while True:
            wanted += way
            data.ctrl[0] = wanted
            mujoco.mj_step(model, data, 40)
            if data.warning.number.any():
                raise AssetError(f"{source}: the linkage is unstable when its fingers are moved.")
            length, gap, *_ = found = look()
            if abs(length - wanted) > STEP / 2 or gap > WIDEST:
                break  # the joints end
            seen.append(found)
            if gap < 0:
                break
    seen.sort()
    lengths, gaps, tips, *angles = np.array(seen).T
    for driver, turned in zip(drivers, angles, strict=True):
        joint = spec.joint(model.joint(driver).name)
        joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.range = (
            np.degrees([turned.min() - SLACK, turned.max() + SLACK])
            if spec.compiler.degree
            else [turned.min() - SLACK, turned.max() + SLACK]
        )
    if gaps[0] > STEP:
        raise AssetError(
            f"{source}: this gripper cannot close: its pads stay {1000 * gaps[0]:.1f} mm apart where its "
            "joints end."
        )
    shut = float(np.interp(0.0, gaps, lengths)) if gaps[0] < 0 else float(lengths[0])
    inside = lengths >= shut - STEP
    return {"open": round(float(lengths[-1]), 6), "closed": round(shut, 6)}, float(tips[inside].max())
