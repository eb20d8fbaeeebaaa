"""Grasps that analysis finds on the heights that a perfect camera shows; for controls that know the truth."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from grasp_bench.grasps import GraspPose, KnownGrasp, wrap_angle
from grasp_bench.planning import suction
from grasp_bench.planning.heightfield import CELL, HeightField, analyse, maxima
from grasp_bench.planning.seen import SeenScene
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.gripper import Gripper
from grasp_bench.system.arrays import Floats

AROUND = 0.06
"""Table analysed around what is grasped [m]."""
LEAST_QUALITY = 0.02
"""Grasps of less quality are not proposed."""
NEAR = 3
"""A grasp's centre is at most so many cells from what is to be grasped."""


def analysed(scene: SeenScene, shows: NDArray[np.bool_], gripper: Gripper, count: int) -> list[KnownGrasp]:
    """Return up to ``count`` grasps of what the pixels ``shows`` (H, W) show, best first."""
    from scipy.ndimage import maximum_filter

    rows, columns = np.nonzero(shows & np.isfinite(scene.heights))
    if not len(rows):
        return []
    points = scene.places(rows, columns)
    low, high = points.min(0) - AROUND, points.max(0) + AROUND
    field, there = _field(scene, low, high, points)
    cup = isinstance(gripper, SuctionCup)
    found = suction.analyse(field, gripper) if cup else analyse(field, gripper=gripper)
    near = maximum_filter(there, size=2 * NEAR + 1)
    grasps = []
    for row, column in maxima(found, len(rows), threshold=LEAST_QUALITY):
        if len(grasps) == count:
            break
        if near[row, column]:
            place = np.array([field.origin[0] + column * CELL, field.origin[1] + row * CELL])
            values = (
                float(getattr(found, n)[row, column]) for n in ("yaw", "opening", "tip", "top", "quality")
            )
            grasps.append(_known(scene, place, *values))
    return grasps


def _field(
    scene: SeenScene, low: Floats, high: Floats, points: Floats
) -> tuple[HeightField, NDArray[np.bool_]]:
    """Return the heights seen from one corner (2,) on, and the cells (N, N) in which points (M, 2) lie."""
    from scipy.ndimage import grey_closing

    size = math.ceil(float((high - low).max()) / CELL)
    heights, there = np.zeros((size, size), np.float32), np.zeros((size, size), bool)
    rows, columns = np.nonzero(np.isfinite(scene.heights))
    cells = np.rint((scene.places(rows, columns) - low) / CELL).astype(int)
    inside = ((cells >= 0) & (cells < size)).all(1)
    x, y = cells[inside].T
    np.maximum.at(heights, (y, x), scene.heights[rows[inside], columns[inside]].astype(np.float32))
    x, y = np.rint((points - low) / CELL).astype(int).T
    there[y, x] = True
    middle = points.mean(0)
    closed = grey_closing(heights, size=3)  # cells that fall between pixels
    return HeightField(closed, (float(low[0]), float(low[1])), (float(middle[0]), float(middle[1]))), there


def _known(
    scene: SeenScene, place: Floats, yaw: float, opening: float, tip: float, top: float, quality: float
) -> KnownGrasp:
    axis = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    centre = np.array([*place, top])
    ends = np.stack([centre - opening / 2 * axis, centre + opening / 2 * axis])
    first, second = scene.image.intrinsics.project(scene.camera.to_camera(ends))
    (x, y), (dx, dy) = (first + second) / 2, second - first
    return KnownGrasp(
        float(x),
        float(y),
        wrap_angle(math.atan2(-dy, dx)),
        float(math.hypot(dx, dy)),
        quality,
        pose=GraspPose.top_down([*place, tip], yaw, opening),
        top=top,
    )
