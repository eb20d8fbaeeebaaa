"""A user's arm, rewritten as a folder with ``arm.yaml``: hinges in a chain that stands at the origin."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import yaml

from grasp_bench.errors import AssetError
from grasp_bench.robot.arm import Arm, load_arm
from grasp_bench.robot.solids import subtree
from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.menagerie import model_of
from grasp_bench.workshop.own_model import fix_inertia, making, name_all, read_model, strip, write_model
from grasp_bench.workshop.postures import Postures

STRONG = 40.0
"""Joints of more torque than this get the gains and the armature of a large joint [N m]."""
GAINS = {True: (4000.0, 0.3), False: (1000.0, 0.1)}
"""Position gain [N m/rad] and armature [kg m²] of large and of small joints: those of the shipped arms."""
DAMPING = 1.5
ATTACHMENT = "attachment_site"
"""The flange's site in models of MuJoCo Menagerie."""
PAYLOAD = 1.0
"""What the servos' damping is laid out for, at the flange [kg]."""
READY = (0.48, 0.40)
"""Distance ahead of the base and height of the flange in the ready posture [m]."""
HOME = ((0.16, 0.58), (0.20, 0.58), (0.24, 0.60), (0.28, 0.62), (0.32, 0.65))
"""The same at home, tried in turn: above and behind what table4's camera sees."""
UPRIGHT, CENTRED = 0.9998, 1e-3
"""Cosine of the first axis' tilt, at least, and its distance from the origin [m], at most."""


@dataclass(frozen=True)
class Asked:
    """What a user says of an arm; None is found out.

    Attributes:
        flange: site or body whose z points out of the flange; the last body of the chain by default.
        velocity: greatest speeds [°/s], one for all joints or one for each.
        torque: greatest torques [N m], likewise; those of the file's motors by default.
        home, ready: postures [°]; looked for by default.
        title: what it is called in reports.
        endless: range to either side of joints that have none in the file [°].
    """

    flange: str | None = None
    velocity: tuple[float, ...] = (120.0,)
    torque: tuple[float, ...] | None = None
    home: tuple[float, ...] | None = None
    ready: tuple[float, ...] | None = None
    title: str | None = None
    endless: float | None = None


def import_arm(source: Path, out: Path, asked: Asked) -> Arm:
    """Rewrite the arm whose MJCF or URDF is ``source`` as the folder ``out``, and load it from there.

    Its motors become position servos with the gains of the shipped arms, which carry the arm's weight; links
    meet objects and table, not each other.

    Raises:
        AssetError: in one line, for what is not an arm, or one without limits.
    """
    source = model_of(source)
    with making(out, "arm.xml", source):
        return _import(source, out, asked)


def _import(source: Path, out: Path, asked: Asked) -> Arm:
    spec = read_model(source)
    name_all(spec)
    model = spec.compile()
    hinges = mujoco.mjtJoint.mjJNT_HINGE
    other = [model.joint(j).name for j in range(model.njnt) if model.jnt_type[j] != hinges]
    if other or model.njnt < 6:
        what = f"joint {other[0]!r} is no hinge" if other else f"it has {model.njnt} joints"
        raise AssetError(f"{source}: {what}; an arm has six or more hinges and no gripper on it.")
    names = [model.joint(j).name for j in range(model.njnt)]
    if asked.endless is not None:
        for j in np.flatnonzero(model.jnt_limited == 0):
            joint, half = spec.joint(names[j]), asked.endless
            joint.range = [-half, half] if spec.compiler.degree else np.radians([-half, half])
            joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        model = spec.compile()
    free = [n for n, limited in zip(names, model.jnt_limited, strict=True) if not limited]
    if free:
        raise AssetError(
            f"{source}: an arm without limits: joint {free[0]!r} has no range; write it into the file, or "
            "say --endless 360 for joints that turn without end."
        )
    _stands(model, source)
    count = len(names)
    torque = _each("torque", asked.torque, count) or _torques(model, source, names)
    velocity = _each("velocity", asked.velocity, count)
    strip_and_drive(spec, model, names, torque, asked.flange, source)
    path = write_model(spec, source, out, "arm.xml")
    made = mujoco.MjModel.from_xml_path(str(path))
    search = Postures(made, source)
    ready = _posture("ready", asked.ready, count)
    ready = search.find(*READY) if ready is None else ready
    home = _posture("home", asked.home, count)
    home = search.first(HOME, ready) if home is None else home
    facts = {
        "title": asked.title or source.stem,
        "source": f"rewritten from {source.name} by `grasp-bench arms import`",
        "model": path.name,
        "joints": names,
        "flange": "grasp_bench_flange",
        "velocity_deg": [float(v) for v in velocity or ()],
        "home_deg": np.round(np.degrees(home), 4).tolist(),
        "ready_deg": np.round(np.degrees(ready), 4).tolist(),
    }
    (out / "arm.yaml").write_text(yaml.safe_dump(facts, sort_keys=False))
    load_arm.cache_clear()
    arm = load_arm(str(out))
    _ = arm.shape
    return arm


def _stands(model: mujoco.MjModel, source: Path) -> None:
    """Look that an arm stands upright at the origin."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    axis, at = data.xaxis[0], data.xanchor[0]
    if abs(axis[2]) < UPRIGHT or np.hypot(*at[:2]) > CENTRED:
        direction = ", ".join(f"{v:.2f}" for v in axis)
        raise AssetError(
            f"{source}: joint {model.joint(0).name!r} must turn about the vertical through the origin; it "
            f"turns about ({direction}) through ({at[0]:.3f}, {at[1]:.3f}) m. Move or turn the base's body."
        )


def _posture(what: str, degrees: tuple[float, ...] | None, count: int) -> Floats | None:
    if degrees is not None and len(degrees) != count:
        raise AssetError(f"--{what} must be {count} angles in degrees, one for each joint.")
    return None if degrees is None else np.radians(degrees)


def _each(what: str, values: tuple[float, ...] | None, count: int) -> list[float] | None:
    if values is None:
        return None
    if len(values) not in (1, count) or not all(0 < v < np.inf for v in values):
        raise AssetError(f"--{what} must be one positive number for all joints or {count}, one for each.")
    return list(values) * (count if len(values) == 1 else 1)


def _torques(model: mujoco.MjModel, source: Path, names: list[str]) -> list[float]:
    """Return the torque limits (N,) [N m] that the file's joints or motors have."""
    found = {}
    for j, name in enumerate(names):
        if model.jnt_actfrclimited[j]:
            found[name] = float(np.abs(model.jnt_actfrcrange[j]).max())
    for i in range(model.nu):
        joint = int(model.actuator_trnid[i, 0])
        if model.actuator_trntype[i] != mujoco.mjtTrn.mjTRN_JOINT or names[joint] in found:
            continue
        gear = abs(float(model.actuator_gear[i, 0]))
        if model.actuator_forcelimited[i]:
            found[names[joint]] = gear * float(np.abs(model.actuator_forcerange[i]).max())
        elif model.actuator_ctrllimited[i] and model.actuator_biastype[i] == mujoco.mjtBias.mjBIAS_NONE:
            found[names[joint]] = gear * float(np.abs(model.actuator_ctrlrange[i]).max())  # a motor
    missing = [n for n in names if not found.get(n)]
    if missing:
        raise AssetError(
            f"{source}: an arm without limits: no greatest torque of joint {missing[0]!r} is in the file; "
            "say --torque, in N m, one number for all joints or one for each."
        )
    return [found[n] for n in names]


def strip_and_drive(
    spec: mujoco.MjSpec,
    model: mujoco.MjModel,
    names: list[str],
    torque: list[float],
    flange: str | None,
    source: Path,
) -> None:
    """Leave of a model what an arm is made of, with a flange's site and position servos."""
    place, turn, owner = _flange(model, source, names, flange)
    strip(spec, names)
    fix_inertia(spec, model)
    spec.body(owner).add_site(name="grasp_bench_flange", pos=place, quat=turn, size=[0.004] * 3, group=4)
    for geom in spec.geoms:
        if geom.contype or geom.conaffinity:
            geom.contype, geom.conaffinity = 1, 0
    data = mujoco.MjData(model)
    data.qpos[:] = np.clip(0.0, model.jnt_range[:, 0], model.jnt_range[:, 1])
    mujoco.mj_forward(model, data)
    tip = data.xpos[model.body(owner).id]
    for j, (name, limit) in enumerate(zip(names, torque, strict=True)):
        gain, armature = GAINS[limit > STRONG]
        joint = spec.joint(name)
        joint.damping, joint.stiffness = [DAMPING, 0.0, 0.0], [0.0, 0.0, 0.0]
        joint.armature, joint.frictionloss = armature, 0.0
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        joint.range, joint.limited = model.jnt_range[j].tolist(), mujoco.mjtLimited.mjLIMITED_TRUE
        lever = np.linalg.norm(np.cross(data.xaxis[j], tip - data.xanchor[j]))
        inertia = armature + PAYLOAD * float(lever**2) + _inertia_beyond(model, data, j)
        servo = 2 * np.sqrt(gain * inertia)
        spec.add_actuator(
            name=name,
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
            gainprm=[gain, *[0.0] * 9],
            biasprm=[0.0, -gain, -round(float(servo), 1), *[0.0] * 7],
            ctrllimited=mujoco.mjtLimited.mjLIMITED_TRUE,
            ctrlrange=model.jnt_range[j].tolist(),
            forcelimited=mujoco.mjtLimited.mjLIMITED_TRUE,
            forcerange=[-limit, limit],
        )


def _inertia_beyond(model: mujoco.MjModel, data: mujoco.MjData, joint: int) -> float:
    """Return the inertia of all links beyond a joint about its axis [kg m²], as points of mass."""
    total = 0.0
    for body in range(int(model.jnt_bodyid[joint]), model.nbody):
        lever = np.linalg.norm(np.cross(data.xaxis[joint], data.xipos[body] - data.xanchor[joint]))
        total += float(model.body_mass[body] * lever**2)
    return total


def _flange(
    model: mujoco.MjModel, source: Path, names: list[str], flange: str | None
) -> tuple[list[float], list[float], str]:
    """Return position and quaternion of the flange in the body that has it, and that body's name."""
    if flange is None and mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, ATTACHMENT) >= 0:
        flange = ATTACHMENT
    if flange is None:
        beyond = subtree(model, int(model.jnt_bodyid[model.njnt - 1]))
        return [0, 0, 0], [1, 0, 0, 0], model.body(beyond[-1]).name
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, flange)
    if site >= 0:
        owner = model.body(model.site_bodyid[site]).name
        return model.site_pos[site].tolist(), model.site_quat[site].tolist(), owner
    if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, flange) >= 0:
        return [0, 0, 0], [1, 0, 0, 0], flange
    sites = [model.site(i).name for i in range(model.nsite)]
    bodies = [model.body(i).name for i in range(1, model.nbody)]
    raise AssetError(
        f"{source} has no site or body (flange) {flange!r}; it has {', '.join([*sites, *bodies])}."
    )
