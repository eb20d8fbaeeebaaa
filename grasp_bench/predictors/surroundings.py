"""What surrounds a table in its depth image: walls, floors, shelves, and not what stands on it.

A network that was trained on tables alone takes the foot of a wall for a thing to be grasped. What is far off
the table's plane and goes on to the picture's rim is none: a wall behind, a floor below the table's edge.
Things on the table end within the picture, or at a jump in depth where they stand in front of a wall.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

FAR = 0.03
"""Height above or below the table from which a pixel may be of the surroundings [m]."""
FOOT = 0.008
"""Height from which a pixel next to the surroundings is their foot [m]."""
FOOT_WIDTH = 12
"""Greatest width of such a foot [px]."""
JUMP = 0.015
"""Step in depth between neighbouring pixels across which nothing goes on [m]."""
LEAST = 0.01
"""Share of the picture below which what reaches the rim is a thing that the picture cuts off."""


def surroundings(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Mark what is not the table's and goes on to the rim, in a picture whose table is level.

    Args:
        depth: (H, W) metres, 0 for invalid; the table prevails in it, seen face on or made level
            (:func:`grasp_bench.predictors.tabletop.levelled`).

    Returns:
        (H, W), true for walls, floors and their feet.
    """
    valid = depth > 0
    if not valid.any():
        return np.zeros(depth.shape, bool)
    height = np.where(valid, np.median(depth[valid]) - depth, 0).astype(np.float32)
    near = cv2.morphologyEx(height, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) > 2 * JUMP
    off = (np.abs(height) > FAR) & ~near
    _, labels, stats, _ = cv2.connectedComponentsWithStats(off.astype(np.uint8), connectivity=4)
    rim = np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])
    large = stats[:, cv2.CC_STAT_AREA] > LEAST * depth.size
    found = [i for i in np.unique(rim) if i and large[i]]
    marked = np.isin(labels, found)
    if not found:
        return marked
    foot = np.ones((2 * FOOT_WIDTH + 1, 2 * FOOT_WIDTH + 1), np.uint8)
    about = cv2.dilate(marked.astype(np.uint8), foot) > 0
    slope = about & ((np.abs(height) > FOOT) | ~valid) & ~_things(height, labels, found)
    return marked | slope


def _things(height: NDArray[np.float32], labels: NDArray[np.int32], found: list[int]) -> NDArray[np.bool_]:
    """Mark what is as far off the table, and is not of the surroundings."""
    return (labels > 0) & ~np.isin(labels, found)
