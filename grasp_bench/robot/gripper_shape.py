"""What the compiled model of a gripper tells: its measures, its travel, and the force of its actuator."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from grasp_bench.errors import AssetError
from grasp_bench.robot.gripper_file import GripperFile
from grasp_bench.robot.linkage import Linkage, sweep
from grasp_bench.robot.parts import compiled, find, metres, tcp_place
from grasp_bench.robot.solids import extent, solids, subtree
from grasp_bench.system.arrays import Floats

GAP = 0.002
"""Pads that are further apart when closed do not close [m]."""
TIPS = 0.005
"""How far the TCP may be from the ends of the finger tips along the approach [m]."""


@dataclass(frozen=True)
class GripperShape:
    """Measures of a gripper in its flange's frame: z is the approach, x the direction in which the jaws open.

    All lengths are rounded to a micrometre.

    Attributes:
        stroke: travel of one finger from closed to open [m].
        finger_thickness: thickness of a finger and its pad near the tip, along the jaw direction [m].
        finger_width: width of a finger across the jaw direction, below the hand [m].
        finger_length: distance from the tips up to the hand's underside [m].
        pad: thickness along the jaw direction, width across it and height of a pad [m].
        palm: extent of the hand's underside along and across the jaw direction [m].
        flange_to_tcp: distance from the flange to the TCP, along the approach [m].
        force_ratio: force of the actuator for a force of 1 N of each pad.
        mass: of the whole gripper [kg].
        joints: names of the joints of the left and the right finger; of all joints of a linkage.
        closed: their positions when closed [m].
        slopes: their travel for each metre of a finger's; 1 for a linkage, which has ``linkage`` instead.
        strongest: force of each pad that the actuator presses with at the full squeeze when closed [N].
        linkage: where the joints of fingers on hinges are.
    """

    stroke: float
    finger_thickness: float
    finger_width: float
    finger_length: float
    pad: tuple[float, float, float]
    palm: tuple[float, float]
    flange_to_tcp: float
    force_ratio: float
    mass: float
    joints: tuple[str, ...]
    closed: tuple[float, ...]
    slopes: tuple[float, ...]
    strongest: float
    linkage: Linkage | None = None


def measure(path: Path, facts: GripperFile) -> GripperShape:
    """Measure the gripper whose MJCF is ``path``.

    Raises:
        AssetError: in one line, for a part that is not found or does not work as a parallel gripper.
    """
    model = compiled(path)
    data = mujoco.MjData(model)
    objects = mujoco.mjtObj
    bodies = [find(model, path, "body", objects.mjOBJ_BODY, n) for n in (*facts.fingers, facts.palm)]
    pads = [find(model, path, "geom (pad)", objects.mjOBJ_GEOM, n) for n in facts.pads]
    actuator = find(model, path, "actuator", objects.mjOBJ_ACTUATOR, facts.actuator)
    tcp = find(model, path, "site (TCP)", objects.mjOBJ_SITE, facts.tcp)
    for pad, body in zip(pads, bodies[:2], strict=True):
        if int(model.geom_bodyid[pad]) not in subtree(model, body):
            raise AssetError(
                f"{path}: pad {model.geom(pad).name!r} is not of finger {model.body(body).name!r}."
            )
        if pad not in solids(model, subtree(model, body)):
            raise AssetError(
                f"{path}: pad {model.geom(pad).name!r} touches nothing (contype, conaffinity 0)."
            )
    moving = [_slide_of(model, path, body) for body in bodies[:2]]
    if moving[0] is None or moving[1] is None:
        moved = _linkage(model, data, path, facts, pads, actuator)
    else:
        moved = _slides(model, data, path, [moving[0], moving[1]], pads, actuator)

    depth = tcp_place(model, data, path, tcp)
    fingers = [solids(model, subtree(model, body)) for body in bodies[:2]]
    both = [g for finger in fingers for g in finger]
    tips = float(_boxes(extent(model, data, both))[1, 2])
    if abs(tips - depth) > TIPS:
        raise AssetError(
            f"{path}: the TCP {facts.tcp!r} must lie at the ends of the finger tips, {1000 * tips:.1f} mm "
            f"from the flange; it is at {1000 * depth:.1f} mm."
        )
    hand = solids(model, [bodies[2]])
    if not hand:
        raise AssetError(f"{path}: the palm {facts.palm!r} has no geom that collides.")
    underside = float(_boxes(extent(model, data, hand))[1, 2])
    palm = np.ptp(_boxes(extent(model, data, hand, underside - 1e-3)), axis=0)
    pad = [_boxes(extent(model, data, [p])) for p in pads]
    left = _boxes(extent(model, data, fingers[0], float(pad[0][0, 2])))
    width = max(float(np.ptp(_boxes(extent(model, data, f, underside)), axis=0)[1]) for f in fingers)
    commands = facts.commands
    pressing = (
        abs(commands.open - commands.closed)
        / moved.travel
        * facts.squeeze
        * model.actuator_gainprm[actuator, 0]
    )
    return GripperShape(
        stroke=metres(moved.travel),
        finger_thickness=metres(np.ptp(left, axis=0)[0]),
        finger_width=metres(width),
        finger_length=metres(tips - underside),
        pad=tuple(metres(v) for v in np.ptp(pad[0], axis=0)),  # type: ignore[arg-type]
        palm=(metres(palm[0]), metres(palm[1])),
        flange_to_tcp=metres(depth),
        force_ratio=round(moved.ratio, 6),
        mass=round(float(model.body_mass.sum()), 6),
        joints=tuple(model.joint(j).name for j in moved.joints),
        closed=tuple(metres(v) for v in moved.closed),
        slopes=tuple(float(v) for v in moved.slopes),
        strongest=float(pressing / moved.ratio),
        linkage=moved.linkage,
    )


@dataclass(frozen=True)
class _Moved:
    """How the fingers travel; see :class:`GripperShape`."""

    travel: float
    ratio: float
    joints: list[int]
    closed: Floats
    slopes: Floats
    linkage: Linkage | None


def _slides(
    model: mujoco.MjModel, data: mujoco.MjData, path: Path, joints: list[int], pads: list[int], actuator: int
) -> _Moved:
    """Measure fingers on slides, and leave them closed."""
    addresses = model.jnt_qposadr[joints]

    def gap(q: Floats) -> float:
        data.qpos[addresses] = q
        mujoco.mj_forward(model, data)
        return _gap(model, data, pads)

    ends = model.jnt_range[joints]
    widest = max(((a, b) for a in ends[0] for b in ends[1]), key=lambda q: gap(np.array(q)))
    opened = np.array(widest)
    closed = np.where(opened == ends[:, 0], ends[:, 1], ends[:, 0])
    wide, narrow = gap(opened), gap(closed)
    if wide - narrow < 2 * GAP:
        raise AssetError(f"{path}: the pads do not move apart along x, the direction in which jaws open.")
    if narrow > GAP:
        raise AssetError(
            f"{path}: this gripper cannot close: its pads stay {1000 * narrow:.1f} mm apart where the joints "
            f"{' and '.join(model.joint(j).name for j in joints)} end."
        )
    if narrow < -GAP:  # the joints would go on; the pads meet first
        closed = opened + (closed - opened) * wide / (wide - narrow)
        gap(closed)
    travel = wide / 2
    slopes = (opened - closed) / travel
    slopes = np.where(np.abs(slopes - 1) < 1e-6, 1.0, slopes)
    gap(closed)
    moment = np.zeros(model.nv)
    mujoco.mju_sparse2dense(
        row := np.zeros((1, model.nv)),
        data.actuator_moment,
        data.moment_rownnz[actuator : actuator + 1],
        data.moment_rowadr[actuator : actuator + 1],
        data.moment_colind,
    )
    moment[:] = row[0]
    share = float(np.abs(moment[model.jnt_dofadr[joints]] @ slopes))
    if share < 1e-9:
        raise AssetError(f"{path}: actuator {model.actuator(actuator).name!r} does not move the fingers.")
    return _Moved(travel, 2 / share, joints, closed, slopes, None)


def _linkage(
    model: mujoco.MjModel, data: mujoco.MjData, path: Path, facts: GripperFile, pads: list[int], actuator: int
) -> _Moved:
    """Measure fingers on hinges, and leave them where their tips reach furthest."""
    swept = sweep(model, data, path, actuator, facts.commands, pads, lambda: _gap(model, data, pads))
    narrow = 2 * swept.linkage.positions[0]
    if abs(narrow) > GAP:
        raise AssetError(
            f"{path}: this gripper cannot close: its pads stay {1000 * narrow:.1f} mm apart where actuator "
            f"{facts.actuator!r} is commanded closed."
        )
    data.qpos[:] = swept.linkage.joints_at(swept.deepest)
    mujoco.mj_forward(model, data)
    every = list(range(model.njnt))
    closed = np.array(swept.linkage.angles[0])
    return _Moved(swept.travel, swept.ratio, every, closed, np.ones(model.njnt), swept.linkage)


def _gap(model: mujoco.MjModel, data: mujoco.MjData, pads: list[int]) -> float:
    left, right = (_boxes(extent(model, data, [pad])) for pad in pads)
    return float(left[0, 0] - right[1, 0])


def _slide_of(model: mujoco.MjModel, path: Path, body: int) -> int | None:
    """Return the slide of a finger, None where it hangs on hinges."""
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    kinds = mujoco.mjtJoint
    if count == 1 and model.jnt_type[first] == kinds.mjJNT_SLIDE and model.jnt_limited[first]:
        return first
    if count == 1 and model.jnt_type[first] == kinds.mjJNT_HINGE:
        return None
    raise AssetError(
        f"{path}: finger {model.body(body).name!r} must have one slide joint with a range, or one hinge of a "
        "linkage; other mechanisms are not supported."
    )


def _boxes(box: Floats | None) -> Floats:
    assert box is not None
    return box
