"""An arm alone, held stretched out with its gripper and a payload: whether its motors are strong enough.

In trials the weight of arm and gripper is compensated by a force of its own, as a controller does that knows
them, which no limit of torque touches. Here it goes through the motors, whose limits count.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from grasp_bench.errors import AssetError
from grasp_bench.robot.arm import Arm
from grasp_bench.robot.facts import model_file
from grasp_bench.robot.gripper import Gripper
from grasp_bench.system.arrays import Floats

SECONDS = 1.0
TIMESTEP = 0.002
SAG = 0.01
"""Share of the reach by which the flange may sink in that time. Of the shipped arms, which sink by two fifths
of that, it is the payload, which servos do not know."""
STARTS = 8
"""Postures from which the one with the greatest reach is looked for, besides the ready one."""
ANGLES = 25
"""Angles of a joint that are tried at a time."""


@dataclass(frozen=True)
class Held:
    """What became of an arm held stretched out.

    Attributes:
        posture: (N,) joint angles [rad].
        reach: horizontal distance of the flange from the base's axis [m].
        sag: how far the flange sank within :data:`SECONDS` [m].
        torques: (N,) what arm, gripper and payload ask of each joint there [N m].
    """

    posture: Floats
    reach: float
    sag: float
    torques: Floats


def hold_out(arm: Arm, gripper: Gripper, payload: float) -> Held:
    """Hold an arm out as far as it reaches, with a gripper and what that holds.

    Args:
        payload: mass of what is held at the TCP [kg].

    Raises:
        AssetError: where it sinks by more than :data:`SAG` of that; in one line, with what is too weak.
    """
    model, data = _loaded(arm, gripper, payload)
    flange = model.site(arm.flange).id
    posture = _stretched(model, data, flange, np.array(arm.ready))
    data.ctrl[:] = data.qpos[:] = posture
    mujoco.mj_forward(model, data)
    torques, before = np.abs(data.qfrc_bias), data.site_xpos[flange].copy()
    mujoco.mj_step(model, data, round(SECONDS / TIMESTEP))
    mujoco.mj_kinematics(model, data)
    sag = float(before[2] - data.site_xpos[flange][2])
    held = Held(posture, float(np.hypot(*before[:2])), sag, torques)
    if data.warning.number.any() or not sag <= SAG * held.reach:
        raise AssetError(_too_weak(arm, gripper, payload, held))
    return held


def _too_weak(arm: Arm, gripper: Gripper, payload: float, held: Held) -> str:
    limits = np.array(arm.torque_limits)
    worst = int(np.argmax(held.torques / limits))
    joint, asked, given = arm.joints[worst], held.torques[worst], limits[worst]
    why = f"of joint {joint!r} {asked:.1f} N m are asked and its motor gives {given:g}; raise its forcerange"
    if asked <= given:
        why = "its motors would do, but its servos give way; raise their kp, or give all bodies gravcomp=1"
    sank = f"sinks by {1000 * held.sag:.0f} mm" if np.isfinite(held.sag) else "is unstable"
    return (
        f"{arm.path}: stretched out to {held.reach:.2f} m with gripper {gripper.name} and {payload:g} kg, "
        f"the arm {sank} in {SECONDS:g} s ({1000 * SAG * held.reach:.0f} mm are allowed): {why}."
    )


def _loaded(arm: Arm, gripper: Gripper, payload: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return an arm whose motors bear all that is at its flange, too."""
    path = str(model_file(arm.folder, arm.facts.model))
    spec, alone = mujoco.MjSpec.from_file(path), mujoco.MjModel.from_xml_path(path)
    hand = mujoco.MjModel.from_xml_path(str(model_file(gripper.folder, gripper.facts.model)))
    at_rest = mujoco.MjData(hand)
    mujoco.mj_forward(hand, at_rest)
    site = alone.site(arm.flange)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, site.quat)
    owner = spec.body(alone.body(int(site.bodyid[0])).name)
    for name, mass, place, compensated in (
        ("gripper", float(hand.body_subtreemass[0]), at_rest.subtree_com[0], 1.0),
        ("payload", payload, np.array([0.0, 0.0, gripper.flange_to_tcp]), 0.0),
    ):
        owner.add_body(
            name=f"grasp_bench_{name}",
            pos=site.pos + turn.reshape(3, 3) @ place,
            gravcomp=compensated,
            mass=mass,
            inertia=[1e-3 * mass] * 3,
            ipos=[0.0, 0.0, 0.0],
            explicitinertial=True,
        )
    for joint, limit in zip(arm.joints, arm.torque_limits, strict=True):
        own = spec.joint(joint)
        own.actgravcomp = True
        own.actfrclimited, own.actfrcrange = mujoco.mjtLimited.mjLIMITED_TRUE, [-limit, limit]
    model = spec.compile()
    model.opt.timestep = TIMESTEP
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # What stops a joint or touches a link would carry instead of the motors.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    return model, mujoco.MjData(model)


def _stretched(model: mujoco.MjModel, data: mujoco.MjData, flange: int, ready: Floats) -> Floats:
    """Return the joint angles within their ranges with which the flange is furthest from the base's axis.

    One joint after the other goes to the best of :data:`ANGLES` angles, which come closer together.
    """
    low, high = model.jnt_range.T

    def reach(q: Floats) -> float:
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        return float(np.hypot(*data.site_xpos[flange][:2]))

    best = ready
    for q in (ready, *np.random.default_rng(0).uniform(low, high, (STARTS, len(low)))):
        span = high - low
        while span.max() > 1e-3:
            for j in range(1, len(q)):  # the first turns about the base's axis
                tried = np.clip(q[j] + span[j] * np.linspace(-0.5, 0.5, ANGLES), low[j], high[j])
                q = max((np.r_[q[:j], v, q[j + 1 :]] for v in tried), key=reach)
            span = span / 4
        best = max(best, q, key=reach)
    return best
