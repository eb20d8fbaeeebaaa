"""The drive of an imported linkage: a servo on the distance between the fingers, and where they end."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from grasp_bench.errors import AssetError
from grasp_bench.robot.solids import extent, solids, subtree
from grasp_bench.workshop.own_hand import CENTRED, SQUEEZE, add_servo, box_of

KP, KV = 6250.0, 60.0
"""Gains of the servo on the distance between the fingers [N/m, N s/m]: those of `adaptive-85`."""
BEHIND = 0.020
"""The tendon ends so far behind the pads' middles [m]: it must not shrink to nothing."""
SLACK = 0.02
"""The first links may turn further than was found by so much [rad]."""
STEP, WIDEST = 0.002, 0.2
"""Steps in which the fingers are moved to find where they end, and how far apart they are tried [m]."""


def add_end(spec: mujoco.MjSpec, model: mujoco.MjModel, data: mujoco.MjData, side: str, geom: int) -> None:
    """Add the tendon's end of one finger, behind the pad's middle."""
    owner = int(model.geom_bodyid[geom])
    outwards = np.array([BEHIND if side == "left" else -BEHIND, 0.0, 0.0])
    place = box_of(model, data, geom).mean(0) + outwards
    place[1] = 0.0
    local = data.xmat[owner].reshape(3, 3).T @ (place - data.xpos[owner])
    spec.body(model.body(owner).name).add_site(
        name=f"grasp_bench_{side}", pos=local, size=[0.001] * 3, group=4
    )


def add_grip(spec: mujoco.MjSpec) -> None:
    """Add the servo on the tendon."""
    add_servo(spec, KP, KV, (-2 * SQUEEZE, WIDEST + 4 * BEHIND), 60.0)


def find_ends(
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
