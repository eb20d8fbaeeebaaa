"""What the compiled model of a suction cup tells."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np

from grasp_bench.errors import AssetError
from grasp_bench.robot.gripper_file import SuctionFile
from grasp_bench.robot.gripper_shape import GripperShape
from grasp_bench.robot.parts import compiled, find, metres, tcp_place
from grasp_bench.robot.solids import extent, solids, subtree


def measure(path: Path, facts: SuctionFile) -> GripperShape:
    """Measure the cup whose MJCF is ``path``, in the terms of a gripper whose jaws do not move.

    Raises:
        AssetError: in one line, for a part that is not found or does not work as a suction cup.
    """
    model = compiled(path)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    objects = mujoco.mjtObj
    plunger, palm = (find(model, path, "body", objects.mjOBJ_BODY, n) for n in (facts.plunger, facts.palm))
    rim, touch = (find(model, path, "geom", objects.mjOBJ_GEOM, n) for n in (facts.rim, facts.contact))
    vacuum = find(model, path, "actuator", objects.mjOBJ_ACTUATOR, facts.actuator)
    tcp = find(model, path, "site (TCP)", objects.mjOBJ_SITE, facts.tcp)
    first, count = int(model.body_jntadr[plunger]), int(model.body_jntnum[plunger])
    if count != 1 or model.jnt_type[first] != mujoco.mjtJoint.mjJNT_SLIDE or not model.jnt_limited[first]:
        raise AssetError(f"{path}: the plunger {facts.plunger!r} must have one slide joint with a range.")
    if abs(data.xaxis[first][2]) < 1 - 1e-6 or model.jnt_range[first][1] != 0:
        raise AssetError(
            f"{path}: the plunger's joint must slide along z, 0 where it is out and negative where pushed in."
        )
    if -model.jnt_range[first][0] < facts.press:
        raise AssetError(f"{path}: the plunger travels less than the {1000 * facts.press:g} mm of press.")
    if model.geom_type[rim] != mujoco.mjtGeom.mjGEOM_CYLINDER:
        raise AssetError(f"{path}: the rim {facts.rim!r} must be a cylinder.")
    owner = int(model.geom_bodyid[touch])
    if solids(model, [owner]) != [touch] or owner not in subtree(model, plunger):
        raise AssetError(
            f"{path}: {facts.contact!r} must be the only geom that collides in a body of its own below the "
            "plunger."
        )
    if model.geom_condim[touch] != 6 or model.geom_priority[touch] < 1:
        raise AssetError(f"{path}: {facts.contact!r} must have condim 6 and a priority of 1.")
    if (
        model.actuator_trntype[vacuum] != mujoco.mjtTrn.mjTRN_BODY
        or int(model.actuator_trnid[vacuum, 0]) != owner
    ):
        raise AssetError(
            f"{path}: actuator {facts.actuator!r} must be an <adhesion> of the body of {facts.contact!r}."
        )
    depth = tcp_place(model, data, path, tcp)
    box = extent(model, data, [touch])
    assert box is not None
    if abs(box[1, 2] - depth) > 1e-4 or np.abs(box.mean(0)[:2]).max() > 1e-4:
        raise AssetError(f"{path}: {facts.contact!r} must touch at the TCP.")
    radius = float(model.geom_size[rim][0])
    hand = extent(model, data, solids(model, [palm]))
    if hand is None:
        raise AssetError(f"{path}: the palm {facts.palm!r} has no geom that collides.")
    size = np.ptp(hand, axis=0)
    area = math.pi * radius**2
    strongest = float(model.actuator_gainprm[vacuum, 0])
    if strongest < facts.vacuum[1] * area:
        raise AssetError(
            f"{path}: the gain of {facts.actuator!r} must be {facts.vacuum[1] * area:.1f} N at least, the "
            "greatest vacuum times the area."
        )
    joint = model.joint(first).name
    return GripperShape(
        stroke=0.0,
        finger_thickness=metres(radius),
        finger_width=metres(2 * radius),
        finger_length=metres(depth - hand[1, 2]),
        pad=(metres(radius), metres(2 * radius), metres(2 * radius)),
        palm=(metres(size[0]), metres(size[1])),
        flange_to_tcp=metres(depth),
        force_ratio=1.0,
        mass=round(float(model.body_mass.sum()), 6),
        joints=(joint, joint),
        closed=(0.0, 0.0),
        slopes=(1.0, 1.0),
        strongest=strongest,
    )
