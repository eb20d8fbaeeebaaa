"""Where a suction cup goes: from a planar grasp and what the camera saw, and on a height field.

Of a planar grasp its centre counts: the cup comes straight down there. The angle turns the hand about the
approach; the width means nothing.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from grasp_bench.grasps import Grasp, GraspPose
from grasp_bench.planning.depth import SIDE_CLEARANCE
from grasp_bench.planning.heightfield import CELL, TABLE_NOISE, GraspField, HeightField, balance
from grasp_bench.planning.refusals import Blocked
from grasp_bench.planning.seen import STRAYS_UNDER_HAND, SeenScene, highest
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.scenario.sections import Motion

ASIDE = 0.001
"""A place must seal with a rim that is wider by this, as the arm may go as far beside it [m]."""
LEAST_PRESS = 0.001
"""A plunger that is pushed in by less does not touch what a noisy image shows [m]."""


def wanted_height(top: float, motion: Motion, cup: SuctionCup) -> float:
    """Return the TCP's height on a surface ``top`` high [m]: the plunger pressed in, clear of the table."""
    return max(top - cup.cup.press, motion.table_clearance)


def cup_pose(scene: SeenScene, grasp: Grasp, motion: Motion, cup: SuctionCup) -> tuple[GraspPose, float]:
    """Return the world pose of an image-plane grasp, and the height of the surface it goes to [m].

    That height is the median of those seen under the cup. The hand stays clear of what is seen under it.

    Raises:
        Blocked: where nothing was measured, or the hand would meet something before the cup does.
    """
    near = scene.heights_in(replace(grasp, width=4.0), 0.004)
    if not len(near):
        raise Blocked("no depth was measured where the cup would go")
    level = float(np.median(near))
    pixel = np.array([grasp.x, grasp.y])
    centre = scene.on_plane(pixel, max(level, 0.0))
    ends = [scene.on_plane(end, max(level, 0.0)) for end in grasp.ends()]
    yaw = math.atan2(ends[1][1] - ends[0][1], ends[1][0] - ends[0][0])
    size = np.array(cup.palm) / 2 + SIDE_CLEARANCE
    reach = math.ceil(100 * float(np.hypot(*size))) / 100
    offset, height = scene.local(centre, np.array([math.cos(yaw), math.sin(yaw), 0.0]), reach)
    under = height[np.hypot(*offset.T) < cup.radius]
    top = max(float(np.median(under)) if len(under) else level, 0.0)
    tip = wanted_height(top, motion, cup)
    under_hand = (np.abs(offset) < size).all(1)
    floor = highest(height[under_hand], STRAYS_UNDER_HAND) - cup.finger_length + motion.table_clearance
    if floor > max(top - LEAST_PRESS, tip):
        over = round(1000 * (floor + cup.finger_length - motion.table_clearance - top))
        raise Blocked(
            f"the hand would meet what is seen under it, {over} mm higher than where the cup goes; the arm "
            "did not move"
        )
    return GraspPose.top_down([centre[0], centre[1], max(tip, floor)], yaw, cup.finger_width), top


def analyse(field: HeightField, cup: SuctionCup) -> GraspField:
    """Find on every cell of ``field`` whether the cup seals there, and how well: near the centre of mass, on
    a flat and level surface."""
    from scipy.ndimage import map_coordinates

    h = field.heights
    seal = cup.seal
    rows, columns = np.nonzero(h > TABLE_NOISE)
    found = {name: np.zeros(h.shape, np.float32) for name in ("quality", "yaw", "opening", "tip", "top")}
    if not len(rows):
        return GraspField(**found)
    places = (1 + ASIDE / cup.radius) * seal.places / CELL  # cells along columns and rows
    at = np.stack([rows + places[:, 1:], columns + places[:, :1]])  # (2, P, N)
    heights = map_coordinates(h, at, order=1, mode="constant")
    solid = (heights > TABLE_NOISE).all(0)
    centre = h[rows, columns]
    tilt, departure, out = seal.faults(centre - heights)
    ok = solid & (tilt < 1) & (departure < 1) & (out < 1)
    x = field.origin[0] + columns * CELL - field.centre_of_mass[0]
    y = field.origin[1] + rows * CELL - field.centre_of_mass[1]
    quality = balance(np.stack([x, y], axis=-1)) * (1 - 0.5 * tilt) * (1 - 0.5 * departure)
    found["quality"][rows, columns] = np.where(ok, quality, 0)
    found["top"][rows, columns] = centre
    clearance = Motion().table_clearance
    found["tip"][rows, columns] = np.maximum(centre - cup.cup.press, clearance)
    found["opening"][rows, columns] = cup.finger_width
    return GraspField(**found)
