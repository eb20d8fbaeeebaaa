"""How deep a grasp goes, and how wide the jaws open for it: part of the benchmark's definition.

Nothing here knows the simulator: what the camera saw and the shape of the gripper decide.
"""

from __future__ import annotations

import math

import numpy as np

from grasp_bench.grasps import Grasp, GraspPose
from grasp_bench.planning.heightfield import LEAST_INSERTION, TABLE_NOISE, finger_room
from grasp_bench.planning.refusals import Blocked
from grasp_bench.planning.seen import STRAYS_UNDER_HAND, SeenScene, highest
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.sections import Execution, Motion
from grasp_bench.system.arrays import Floats

SIDE_CLEARANCE = 0.004
"""Room that a finger or the hand on its way down wants beside it [m]."""
ASSISTED = Execution()
WIDENING_STEP = 0.004
WIDENING_GAIN = 0.004
"""The jaws are opened wider than predicted until the tips come this near to the wanted depth [m]."""


def grasp_pose(
    scene: SeenScene,
    grasp: Grasp,
    motion: Motion,
    gripper: Gripper = PARALLEL_85,
    execution: Execution = ASSISTED,
) -> tuple[GraspPose, float]:
    """Return the world pose of an image-plane grasp, and the height of what it holds [m].

    The height of the object under the grasp is the 95th percentile of the heights seen
    inside the grasp's rectangle, the plane on which its centre and ends are deprojected. The
    tips go ``motion.insertion`` below it, never nearer to the table than
    ``motion.table_clearance``, and never so deep that the hand would meet what is seen under it, or the open
    fingers what is under them; where the latter would keep them up, the jaws are opened wider than predicted,
    unless ``execution`` wants the grasp as it was predicted.

    Raises:
        Blocked: where nothing was measured, or the fingers cannot get below the top of it.
    """
    heights = scene.heights_in(grasp, 0.8 * gripper.finger_width)
    if len(heights) < 4:
        raise Blocked("no depth was measured inside the grasp")
    top = float(np.percentile(heights, 95))
    empty = top < TABLE_NOISE  # nothing but table: carried out all the same, to close on nothing
    top = 0.0 if empty else top
    centre = scene.on_plane(np.array([grasp.x, grasp.y]), top)
    span = _span(scene, grasp, top)
    axis = span / max(float(np.linalg.norm(span)), 1e-9)
    wanted = wanted_tip(top, motion)
    offset, height = scene.local(centre, axis, _reach(gripper))
    under_hand = (np.abs(offset) < np.array(gripper.palm) / 2 + SIDE_CLEARANCE).all(1)
    obstacle = highest(height[under_hand], STRAYS_UNDER_HAND)
    floor = max(wanted, obstacle - gripper.finger_length + motion.table_clearance)
    under_jaws = np.abs(offset[:, 1]) < gripper.finger_width / 2 + SIDE_CLEARANCE
    along, height = offset[under_jaws, 0], height[under_jaws]
    tip, opening, room = np.inf, 0.0, finger_room(gripper)
    for trial in openings(float(np.linalg.norm(span[:2])), gripper.opening, execution):
        grounds = (ground_under(side * along - trial / 2, height, room) for side in (-1, 1))
        lowest = max(floor, *(ground + motion.table_clearance for ground in grounds))
        if lowest < tip - 1e-6:
            tip, opening = lowest, trial
        if tip <= floor + WIDENING_GAIN:
            break
    if top - tip < LEAST_INSERTION and not empty:
        what = "the table" if tip <= wanted else "the hand" if tip <= floor else "a finger"
        raise Blocked(_too_high(top, tip, what))
    yaw = math.atan2(axis[1], axis[0])
    return GraspPose.top_down([centre[0], centre[1], tip], yaw, opening), top


def wanted_tip(top: float, motion: Motion) -> float:
    """Return the height at which the tips hold best what is ``top`` high [m]."""
    return max(top - motion.insertion, motion.table_clearance)


def widening(
    scene: SeenScene, grasp: Grasp, pose: GraspPose, top: float, gripper: Gripper = PARALLEL_85
) -> float:
    """Return how much wider than predicted the jaws open [m]; predictions are cut to what they can."""
    predicted = float(np.linalg.norm(_span(scene, grasp, top)[:2]))
    return pose.opening - min(predicted, gripper.opening)


def _span(scene: SeenScene, grasp: Grasp, top: float) -> Floats:
    """Return the (3,) vector between a grasp's ends on the plane at height ``top`` [m]."""
    first, second = (scene.on_plane(end, top) for end in grasp.ends())
    return second - first


def _too_high(top: float, tip: float, what: str) -> str:
    """Say why the fingers cannot hold something ``top`` high, whose tips stop at ``tip`` [m]."""
    if what == "the table":
        why = f"is only {round(1000 * top)} mm high, too flat for fingers that stay clear of the table"
    else:
        above = round(1000 * (tip - top))
        where = f"{abs(above)} mm {'above' if above > 0 else 'below'}" if above else "no deeper than"
        why = f"cannot be got round: the tips would stop {where} its top, as something is under {what}"
    return f"what the grasp is on {why}; the arm did not move"


def openings(predicted: float, most: float, execution: Execution = ASSISTED) -> list[float]:
    """Return the openings to try [m]: the predicted one, then wider ones up to ``most``; without help one,
    the predicted with the scenario's clearance."""
    if not execution.assisted:
        return [min(predicted + execution.clearance, most)]
    first = min(predicted, most)
    return [first, *np.arange(first + WIDENING_STEP, most, WIDENING_STEP).tolist(), most]


def ground_under(beyond: Floats, height: Floats, room: float) -> float:
    """Return the height [m] of what is seen under one open finger, −inf where that is table or nothing.

    Args:
        beyond: (N,) distance of the seen points outwards from the finger's pad [m].
        height: (N,) their heights [m].
        room: width that the finger takes outwards [m].
    """
    ground = highest(height[(beyond > -SIDE_CLEARANCE) & (beyond < room)])
    return ground if ground > TABLE_NOISE else -np.inf


def _reach(gripper: Gripper) -> float:
    """Return how far from a grasp's centre hand and open fingers come down, in whole centimetres [m]."""
    hand = math.hypot(*(side / 2 + SIDE_CLEARANCE for side in gripper.palm))
    fingers = math.hypot(gripper.stroke + finger_room(gripper), gripper.finger_width / 2 + SIDE_CLEARANCE)
    return math.ceil(100 * max(hand, fingers)) / 100
