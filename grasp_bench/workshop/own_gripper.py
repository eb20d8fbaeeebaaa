"""A user's gripper, rewritten as a folder with ``gripper.yaml``: two fingers on slides."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import yaml

from grasp_bench.errors import AssetError
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.grippers import load_gripper
from grasp_bench.robot.solids import extent, solids, subtree
from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.menagerie import model_of
from grasp_bench.workshop.own_hand import (
    CENTRED,
    SQUEEZE,
    add_servo,
    box_of,
    pad_of,
    palm_of,
    set_contacts,
    turn_about_z,
)
from grasp_bench.workshop.own_linkage import rewrite_linkage
from grasp_bench.workshop.own_model import fix_inertia, making, name_all, read_model, strip, write_model

KP, KV = 25000.0, 240.0
"""Gains of the servo that moves both fingers [N/m, N s/m]: those of the shipped grippers."""
BEYOND = 0.0025


@dataclass(frozen=True)
class Asked:
    """What a user says of a gripper; None is found out.

    Attributes:
        fingers: bodies of the fingers, in any order.
        pads: geoms that touch what is held, in the order of ``fingers``.
        force: least and greatest force of each pad [N].
        speed: greatest speed of each finger [m/s].
        title: what it is called in reports.
        radian: whether the file's angles are radians, though it does not say so.
    """

    fingers: tuple[str, str] | None = None
    pads: tuple[str, str] | None = None
    force: tuple[float, float] = (5.0, 100.0)
    speed: float = 0.1
    title: str | None = None
    radian: bool = False


def import_gripper(source: Path, out: Path, asked: Asked) -> Gripper:
    """Rewrite the gripper whose MJCF or URDF is ``source`` as the folder ``out``, and load it from there.

    The frame of its file is taken for the flange's: z is the approach. It is turned about z so that the jaws
    open along x. Both fingers are coupled and moved by one position servo, and the pads get the contacts of
    the shipped grippers, so that its physics is that which `doctor --physics` measures.

    Raises:
        AssetError: in one line, for what is not a gripper of two fingers on slides.
    """
    source = model_of(source)
    with making(out, "gripper.xml", source):
        return _import(source, out, asked)


def _import(source: Path, out: Path, asked: Asked) -> Gripper:
    spec = read_model(source, asked.radian)
    name_all(spec)
    kinds = mujoco.mjtJoint
    joints = [j.type for j in spec.joints]
    if asked.fingers is None and kinds.mjJNT_HINGE in joints and kinds.mjJNT_SLIDE not in joints:
        parts, commands = rewrite_linkage(spec, source, asked.pads)
    else:
        parts, commands = _rewrite_slides(spec, source, asked)
    write_model(spec, source, out, "gripper.xml")
    facts = {
        "title": asked.title or source.stem,
        "source": f"rewritten from {source.name} by `grasp-bench grippers import`",
        "model": "gripper.xml",
        "actuator": "grip",
        "commands": commands,
        **parts,
        "tcp": "grasp_bench_tcp",
        "force": list(asked.force),
        "speed": asked.speed,
        "squeeze": SQUEEZE,
    }
    (out / "gripper.yaml").write_text(yaml.safe_dump(facts, sort_keys=False))
    load_gripper.cache_clear()
    made = load_gripper(str(out))
    _ = made.shape
    return made


def _rewrite_slides(
    spec: mujoco.MjSpec, source: Path, asked: Asked
) -> tuple[dict[str, Any], dict[str, float]]:
    """Rewrite a gripper of two fingers on slides; the names of its parts, and its commands."""
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    joints = _finger_joints(model, source, asked.fingers)
    axis = data.xaxis[joints[0]]
    if abs(axis[2]) > 0.05:
        raise AssetError(
            f"{source}: the jaws must open across z, which is taken for the direction of approach."
        )
    turn_about_z(spec, model, -float(np.arctan2(axis[1], axis[0])))
    model = spec.compile()
    data = mujoco.MjData(model)
    bodies = [int(model.jnt_bodyid[j]) for j in joints]
    pads = _pads(model, data, source, bodies, asked.pads)
    if _middle(model, data, joints, _ends(model, data, source, joints, pads)[0], pads[0])[0] < 0:
        joints, bodies, pads = joints[::-1], bodies[::-1], pads[::-1]  # the left one is where x is positive
    opened, closed = _ends(model, data, source, joints, pads)
    middles = [_middle(model, data, joints, closed, pad) for pad in pads]
    beside = float(np.hypot(*(middles[0] + middles[1])[:2] / 2))
    if beside > CENTRED:
        raise AssetError(
            f"{source}: the middle between the pads lies {1000 * beside:.1f} mm beside the z axis of the "
            "file, which is taken for the flange's; move the gripper's root body there."
        )
    fingers = [g for body in bodies for g in solids(model, subtree(model, body))]
    box = extent(model, data, fingers)
    assert box is not None
    tips = float(box[1, 2])
    if tips < 0.01:
        raise AssetError(f"{source}: the fingers must point along z, the direction of approach.")
    names = [model.joint(j).name for j in joints]
    parts: dict[str, Any] = {
        "fingers": [model.body(b).name for b in bodies],
        "pads": [model.geom(p).name for p in pads],
        "palm": palm_of(model, data, source, {b for body in bodies for b in subtree(model, body)}),
    }
    _rewrite(spec, model, names, parts, (opened, closed), tips)
    signs = np.sign(opened - closed)
    commands = {"open": _length(signs, opened), "closed": _length(signs, closed)}
    return parts, commands


def _length(signs: Floats, q: Floats) -> float:
    return round(float(0.5 * signs @ q), 7)


def _finger_joints(model: mujoco.MjModel, source: Path, fingers: tuple[str, str] | None) -> list[int]:
    slides = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_SLIDE]
    if fingers is not None:
        known = [model.body(i).name for i in range(1, model.nbody)]
        if fingers[0] == fingers[1]:
            raise AssetError(f"{source}: --fingers names {fingers[0]!r} twice; it needs two bodies.")
        for name in fingers:
            if name not in known:
                raise AssetError(f"{source} has no body (finger) {name!r}; it has {', '.join(known)}.")
        slides = [j for name in fingers for j in slides if model.body(model.jnt_bodyid[j]).name == name]
    if len(slides) != 2:
        hinges = model.njnt - len(slides)
        other = f" and {hinges} joints of other kinds" if hinges else ""
        raise AssetError(
            f"{source} has {len(slides)} fingers on slides{other}; read are two fingers on slides, and "
            "two on linkages that have hinges only. Of more slides name the two with --fingers."
        )
    if not model.jnt_limited[slides].all():
        raise AssetError(f"{source}: the finger joints need a range.")
    return slides


def _pads(
    model: mujoco.MjModel, data: mujoco.MjData, source: Path, bodies: list[int], asked: tuple[str, str] | None
) -> list[int]:
    if asked is not None:
        named = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, n) for n in asked]
        owners = [[b for b in bodies if g >= 0 and model.geom_bodyid[g] in subtree(model, b)] for g in named]
        if min(named) < 0 or [o[:1] for o in owners] not in (
            [[bodies[0]], [bodies[1]]],
            [[bodies[1]], [bodies[0]]],
        ):
            solid = ", ".join(model.geom(g).name for b in bodies for g in solids(model, subtree(model, b)))
            raise AssetError(f"{source}: --pads must be one geom of each finger; they have {solid}.")
        return named if owners[0][0] == bodies[0] else named[::-1]
    found = []
    for body in bodies:
        found.append(pad_of(model, data, source, body))
    return found


def _middle(model: mujoco.MjModel, data: mujoco.MjData, joints: list[int], q: Floats, pad: int) -> Floats:
    data.qpos[model.jnt_qposadr[joints]] = q
    mujoco.mj_forward(model, data)
    return box_of(model, data, pad).mean(0)


def _ends(
    model: mujoco.MjModel, data: mujoco.MjData, source: Path, joints: list[int], pads: list[int]
) -> tuple[Floats, Floats]:
    """Return positions (2,) of the finger joints when open, and where the pads meet."""
    ranges = model.jnt_range[joints]

    def apart(q: Floats) -> float:
        first, second = (_middle(model, data, joints, q, pad)[0] for pad in pads)
        thickness = sum(float(np.ptp(box_of(model, data, pad), axis=0)[0]) for pad in pads)
        return abs(float(first - second)) - thickness / 2

    opened = max((np.array([a, b]) for a in ranges[0] for b in ranges[1]), key=apart)
    closed = np.where(opened == ranges[:, 0], ranges[:, 1], ranges[:, 0])
    side = np.sign(np.subtract(*(_middle(model, data, joints, opened, pad)[0] for pad in pads)))
    wide = apart(opened)
    first, second = (_middle(model, data, joints, closed, pad)[0] for pad in pads)
    thickness = sum(float(np.ptp(box_of(model, data, pad), axis=0)[0]) for pad in pads)
    narrow = float(side * (first - second)) - thickness / 2  # negative where the pads would overlap
    if wide - narrow < 0.004:
        raise AssetError(f"{source}: the pads do not move apart where the finger joints do.")
    if narrow < 0:  # the joints would go on; the pads meet first
        closed = opened + (closed - opened) * wide / (wide - narrow)
    return opened, closed


def _rewrite(
    spec: mujoco.MjSpec,
    model: mujoco.MjModel,
    joints: list[str],
    parts: dict[str, list[str]],
    ends: tuple[Floats, Floats],
    tips: float,
) -> None:
    opened, closed = ends
    signs = np.sign(opened - closed)
    strip(spec, joints)
    fix_inertia(spec, model)
    spec.worldbody.add_site(name="grasp_bench_tcp", pos=[0, 0, tips], size=[0.003] * 3, group=4)
    for name, low, high in zip(joints, np.minimum(*ends), np.maximum(*ends), strict=True):
        joint = spec.joint(name)
        joint.range, joint.limited = [float(low), float(high)], mujoco.mjtLimited.mjLIMITED_TRUE
        joint.damping, joint.stiffness = [5.0, 0.0, 0.0], [0.0, 0.0, 0.0]
        joint.armature, joint.frictionloss = 0.2, 0.0
        joint.solref_limit, joint.solimp_limit = [0.004, 1.0], [0.95, 0.99, 0.001, 0.5, 2.0]
    set_contacts(spec, parts["pads"])
    tendon = spec.add_tendon(name="grip")
    for name, sign in zip(joints, signs, strict=True):
        tendon.wrap_joint(name, 0.5 * float(sign))
    same = float(signs[0] * signs[1])
    coupling = np.zeros(mujoco.mjNEQDATA)
    coupling[:2] = closed[1] - same * closed[0], same
    spec.add_equality(
        name="fingers",
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=joints[1],
        name2=joints[0],
        data=coupling,
        solref=[0.004, 1.0],
        solimp=[0.95, 0.99, 0.001, 0.5, 2.0],
    )
    lengths = sorted((_length(signs, closed) - SQUEEZE, _length(signs, opened) + BEYOND))
    add_servo(spec, KP, KV, lengths, 120.0)
