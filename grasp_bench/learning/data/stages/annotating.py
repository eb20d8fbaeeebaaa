"""Grasps that held, as people draw them: a rectangle across what is seen of the object.

Physics says where the jaws stood when a grasp held, which may be off the middle of what they closed on, and
as little open as was free. Somebody who annotates a picture sees the object's outline: the rectangle is
centred across it, reaches a little beyond on either side, and is as high as the part that is alike, a jaw's
height at least. Angles are those that held.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grasp_bench.system.arrays import Floats

BEYOND = 0.006
"""Room between outline and rectangle on either side [m]; never less than :data:`BEYOND_SHARE`."""
BEYOND_SHARE = 0.15
"""The same as a share of the width across the object."""
HEIGHT = (0.012, 0.045)
"""Least and greatest height of a rectangle [m]."""
ALIKE = 0.25
"""Sections whose ends move by less than this share of the width belong to the same part."""
SIDES = 1.4
"""An outline may be wider than the jaws opened by this factor: a tilted camera sees sides, too."""
STEP = 0.5
"""Pixels between two looks along a line."""


def annotated(grasps: NDArray[np.floating], mask: NDArray[np.bool_], scale: float) -> NDArray[np.float32]:
    """Return (N, 6) x, y [px], angle [rad], width, height [px] and quality of what people would draw.

    Grasps whose centre is not on the object, and those wider than the jaws open, are left out.

    Args:
        grasps: (M, 5) x, y [px], angle [rad], width [px], quality.
        mask: (S, S) pixels that show objects.
        scale: pixels a metre where the objects are.
    """
    found = []
    for x, y, angle, width, quality in np.asarray(grasps, float):
        along = np.array([np.cos(angle), -np.sin(angle)])
        across = np.array([along[1], -along[0]])
        section = _section(mask, np.array([x, y]), along, width)
        if section is None:
            continue
        low, high = section
        span = high - low
        middle = np.array([x, y]) + (low + high) / 2 * along
        up, down = (_alike(mask, middle, along, sign * across, span, scale) for sign in (1, -1))
        middle = middle + (up - down) / 2 * across
        height = float(np.clip(up + down, HEIGHT[0] * scale, HEIGHT[1] * scale))
        drawn = span + 2 * max(BEYOND * scale, BEYOND_SHARE * span)
        found.append([*middle, angle, drawn, height, quality])
    return np.array(found, np.float32).reshape(-1, 6)


def _section(
    mask: NDArray[np.bool_], centre: Floats, along: Floats, width: float
) -> tuple[float, float] | None:
    """Return from where to where a line through ``centre`` is on the mask [px along it]; None where not,
    or further than the opened jaws could reach."""
    reach = SIDES * width / 2 + 2
    steps = np.arange(-reach, reach + STEP, STEP)
    on = _looked_up(mask, centre + steps[:, None] * along)
    near = np.flatnonzero(on & (np.abs(steps) <= 3))
    if not len(near):
        return None
    first = last = near[np.abs(steps[near]).argmin()]
    while first > 0 and on[first - 1]:
        first -= 1
    while last < len(on) - 1 and on[last + 1]:
        last += 1
    if first == 0 or last == len(on) - 1:
        return None
    return float(steps[first]), float(steps[last])


def _alike(
    mask: NDArray[np.bool_], middle: Floats, along: Floats, across: Floats, span: float, scale: float
) -> float:
    """Return how far from ``middle`` the sections across stay alike [px]."""
    limit, step = HEIGHT[1] * scale / 2, max(scale * 0.002, 1.0)
    tolerance = max(ALIKE * span, 1.5)
    reached = 0.0
    while reached + step <= limit:
        section = _section(mask, middle + (reached + step) * across, along, span + 2 * tolerance + 2)
        if section is None or max(abs(section[0] + span / 2), abs(section[1] - span / 2)) > tolerance:
            break
        reached += step
    return reached


def _looked_up(mask: NDArray[np.bool_], points: Floats) -> NDArray[np.bool_]:
    """Return (N,) the mask at pixels (N, 2), False beside it."""
    column, row = np.floor(points).astype(int).T
    size = len(mask)
    inside = (column >= 0) & (row >= 0) & (column < size) & (row < size)
    return inside & mask[np.clip(row, 0, size - 1), np.clip(column, 0, size - 1)]
