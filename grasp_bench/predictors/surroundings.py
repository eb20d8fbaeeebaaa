"""What surrounds a table in its depth image: walls, floors, shelves, and not what stands on it.

A network that was trained on tables alone takes the foot of a wall for a thing to be grasped. What is far
off the table's plane and goes on to the picture's rim is none: a wall behind, a floor below the table's edge.
Things on the table end within the picture, or at a jump in depth where they stand in front of a wall; one
that touches a wall is taken for a part of it.
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
JUMP = 0.03
"""Step in depth within three pixels across which nothing goes on [m]."""
CONTACT = 0.3
"""Sides of the picture along which it meets the rim at least; what does less is a thing that is cut off."""


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
    near = cv2.morphologyEx(height, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) > JUMP
    off = (np.abs(height) > FAR) & ~near
    _, parts = cv2.connectedComponents(off.astype(np.uint8), connectivity=4)
    rim = np.concatenate([parts[0], parts[-1], parts[1:-1, 0], parts[1:-1, -1]])
    names, lengths = np.unique(rim[rim > 0], return_counts=True)
    marked = np.isin(parts, names[lengths > CONTACT * min(depth.shape)])
    if not marked.any():
        return marked
    things = (parts > 0) & ~marked
    reach = np.ones((2 * FOOT_WIDTH + 1, 2 * FOOT_WIDTH + 1), np.uint8)
    beside = cv2.dilate(marked.astype(np.uint8), reach) > 0
    foot = beside & ((np.abs(height) > FOOT) | ~valid) & ~things
    return marked | foot
