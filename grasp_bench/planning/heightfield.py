"""Where a top-down parallel-jaw grasp should hold: analysis of a height field.

Fingers that come from above meet only what can be seen from above, so the height field of
the true shape tells which places they can reach and what they close on. For every cell and
jaw direction the analysis opens the jaws as little as is free, puts the tips where the
planner would (:func:`grasp_bench.planning.planner.grasp_pose`), and scores what lies between
them. It is geometry, not physics: reference grasps and labels are tried in physics besides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, binary_dilation, maximum_filter

from grasp_bench.robot.ec66 import FINGER_STROKE
from grasp_bench.scenario.sections import Motion

Floats = NDArray[np.float32]

CELL = 0.002
"""Edge of a cell [m]."""
ALONG = np.arange(-0.052, 0.0521, CELL, dtype=np.float32)
"""Sample positions along the jaw direction [m]."""
ACROSS = np.arange(-0.009, 0.0091, 0.003, dtype=np.float32)
"""Sample positions across it: the width of a pad [m]."""
HALF_OPENINGS = np.arange(0.006, FINGER_STROKE + 1e-6, CELL, dtype=np.float32)
FINGER = 0.009
"""Thickness of a finger along the jaw direction, with 1 mm to spare [m]."""
INSERTION, CLEARANCE = Motion().insertion, Motion().table_clearance
TABLE_NOISE = 0.004
"""Heights below this count as table [m]."""
LEAST_INSERTION = 0.003
"""A grasp whose fingers reach less far below the top of what they hold is not tried [m]."""
YAWS = np.linspace(0, np.pi, 18, endpoint=False)
"""Jaw directions tried [rad]."""


@dataclass(frozen=True)
class HeightField:
    """Heights over a square table patch.

    Attributes:
        heights: (N, N) float32 [m]; row i lies at y = origin[1] + i·CELL, column j at x likewise.
        origin: x, y of cell (0, 0) [m].
        centre_of_mass: x, y of what stands there [m].
    """

    heights: Floats
    origin: tuple[float, float]
    centre_of_mass: tuple[float, float]


@dataclass(frozen=True)
class GraspField:
    """The best grasp centred on each cell; arrays (N, N).

    Attributes:
        quality: 0 to 1.
        yaw: jaw direction from world x towards y, [0, π).
        opening: of the jaws before closing [m].
        tip: height of the finger tips [m].
        top: height of what is grasped [m].
    """

    quality: Floats
    yaw: Floats
    opening: Floats
    tip: Floats
    top: Floats


def analyse(field: HeightField, yaws: NDArray[np.float64] = YAWS, chunk: int = 2000) -> GraspField:
    """Best grasp on every cell of ``field`` over all ``yaws``."""
    h = field.heights
    solid = h > TABLE_NOISE
    # Also between walls (across a cup's mouth), where the centre lies on no material.
    candidates = binary_closing(np.pad(solid, 20), iterations=14)[20:-20, 20:-20] | solid
    rows, columns = np.nonzero(candidates & binary_dilation(solid, iterations=14))
    best = {name: np.zeros(h.shape, np.float32) for name in ("quality", "yaw", "opening", "tip", "top")}
    padded = np.pad(h, 30)
    for yaw in yaws:
        for start in range(0, len(rows), chunk):
            r, c = rows[start : start + chunk], columns[start : start + chunk]
            found = _score(padded, r + 30, c + 30, float(yaw), field)
            better = found["quality"] > best["quality"][r, c]
            for name, values in found.items():
                best[name][r[better], c[better]] = values[better]
            best["yaw"][r[better], c[better]] = yaw
    return GraspField(**best)


def grasps_at(
    field: HeightField, rows: NDArray[np.intp], columns: NDArray[np.intp], yaw: float
) -> dict[str, Floats]:
    """The fields of :class:`GraspField` (N,) for given cells with jaws along ``yaw``, feasible or not."""
    return _score(np.pad(field.heights, 30), rows + 30, columns + 30, yaw, field)


def _score(
    h: Floats, rows: NDArray[np.intp], columns: NDArray[np.intp], yaw: float, field: HeightField
) -> dict[str, Floats]:
    """Quality, opening, tip and top of grasps at cells of the padded height field ``h``.

    Grasps (N) are the last axis of all arrays: what is reduced are short axes, over long contiguous rows.
    """
    cos, sin = np.cos(yaw), np.sin(yaw)
    a, b = np.meshgrid(ALONG, ACROSS)  # (B, A)
    dc = np.rint((a * cos - b * sin) / CELL).astype(np.intp)
    dr = np.rint((a * sin + b * cos) / CELL).astype(np.intp)
    patch = h.ravel().take((dr * h.shape[1] + dc)[..., None] + (rows * h.shape[1] + columns))  # (B, A, N)

    # Ground under both fingers for each symmetric opening.
    profile = patch.max(axis=0)
    width = round(FINGER / CELL)
    ground = np.stack(
        [
            np.maximum(
                profile[_near(e) : _near(e) + width].max(0),
                profile[_near(-e) - width + 1 : _near(-e) + 1].max(0),
            )
            for e in HALF_OPENINGS.tolist()
        ]
    )  # (E, N)
    ground = np.where(ground > TABLE_NOISE, ground + CLEARANCE, 0)
    inner = np.stack([profile[_near(-e) + 1 : _near(e)].max(0) for e in HALF_OPENINGS.tolist()])
    tip = np.maximum(np.maximum(inner - INSERTION, CLEARANCE), ground)
    free = inner - tip >= LEAST_INSERTION
    depth = np.where(free, inner - tip, 0)
    # The smallest opening that reaches nearly as deep as any, then a little wider if that is free.
    enough = depth >= np.maximum(0.9 * depth.max(0), LEAST_INSERTION)
    feasible = enough.any(0)
    first = np.where(feasible, _first(enough, 0), 0).astype(np.intp)
    index, n = first, np.arange(len(rows))
    for extra in (1, 2, 3):
        wider = np.minimum(first + extra, len(HALF_OPENINGS) - 1)
        same = enough[wider, n] & (index == np.maximum(wider - 1, first))
        index = np.where(same, wider, index)
    e, tips, tops = HALF_OPENINGS[index], tip[index, n], inner[index, n]

    inside = np.abs(ALONG)[:, None] < e  # (A, N)
    low = (patch > tips + 0.002) & inside
    high = (patch > np.minimum(tips + 0.007, tops - 0.001)) & inside
    left, left_at, left_spread = _edge(low, +1)
    right, right_at, right_spread = _edge(low, -1)
    high_left, *_ = _edge(high, +1)
    high_right, *_ = _edge(high, -1)
    rise = np.maximum(np.minimum(0.005, tops - 0.001 - tips - 0.002), 0.001)
    # Half a cell is within the grid's own error: on low things it would look like a steep slope.
    slope = np.maximum(np.maximum(high_left - left, right - high_right) - CELL / 2, 0) / rise

    twist = np.exp(-(((left_at - right_at) / 0.008) ** 2))
    torsion = np.exp(-(((0.5 * (left_at + right_at)) / 0.008) ** 2))
    lean = np.clip((0.75 - slope) / 0.45, 0, 1)
    centred = np.exp(-(((0.5 * (left + right)) / 0.012) ** 2))
    area = np.clip(0.4 + 0.3 * (left_spread + right_spread), 0, 1)
    bite = np.clip((tops - tips) / 0.012, 0.4, 1)
    x = field.origin[0] + (columns - 30) * CELL - field.centre_of_mass[0]
    y = field.origin[1] + (rows - 30) * CELL - field.centre_of_mass[1]
    room = np.clip((e + left) / 0.003, 0.5, 1) * np.clip((e - right) / 0.003, 0.5, 1)
    quality = twist * torsion * lean * centred * area * bite * balance(np.stack([x, y], axis=-1)) * room
    quality = np.where(feasible & low.any(axis=(0, 1)) & (right > left), quality, 0)
    return {
        "quality": quality.astype(np.float32),
        "opening": (2 * e).astype(np.float32),
        "tip": tips.astype(np.float32),
        "top": tops.astype(np.float32),
        "yaw": np.full(len(rows), yaw, np.float32),
    }


def ground_of_fingers(
    field: HeightField, centre: NDArray[np.floating], axis: NDArray[np.floating], opening: float, half: float
) -> float:
    """Greatest height [m] under two open fingers.

    Args:
        field: what stands on the table.
        centre: x, y between the fingers [m].
        axis: x, y of the unit jaw direction.
        opening: between the pads [m].
        half: half width of the corridor of each finger, across the jaw direction [m].
    """
    a, b = np.meshgrid(
        opening / 2 + np.arange(-CELL / 2, FINGER, CELL / 4), np.arange(-half, half + CELL / 8, CELL / 4)
    )
    a, b = np.concatenate([a, -a]), np.concatenate([b, b])
    columns = np.rint((centre[0] + a * axis[0] - b * axis[1] - field.origin[0]) / CELL).astype(np.intp)
    rows = np.rint((centre[1] + a * axis[1] + b * axis[0] - field.origin[1]) / CELL).astype(np.intp)
    size = len(field.heights)
    inside = (rows >= 0) & (rows < size) & (columns >= 0) & (columns < size)
    return float(field.heights[rows[inside], columns[inside]].max(initial=0.0))


def balance(offset: NDArray[np.floating]) -> NDArray[np.floating]:
    """The factor of quality for a grasp's distance (…, 2) [m] from the centre of mass."""
    return 0.25 + 0.75 * np.exp(-(offset**2).sum(-1) / 0.07**2)


def _near(position: float) -> int:
    """Index of the sample nearest to ``position`` along the jaws."""
    return round((position - float(ALONG[0])) / CELL)


def _edge(mask: NDArray[np.bool_], side: int) -> tuple[Floats, Floats, Floats]:
    """Outermost material of each grasp, seen by one finger.

    Args:
        mask: (B, A, N) material between the jaws.
        side: +1 for the finger coming from negative positions, −1 for the other.

    Returns:
        Position of the contact along the jaws (N,), its mean place across (N,), and the share
        of the pad's width that it covers (N,).
    """
    nowhere = np.float32(side) * 1.0
    reach = np.append(ALONG[::side], nowhere)[_first(mask[:, ::side], 1)]  # (B, N)
    contact = reach.min(0) if side > 0 else reach.max(0)
    touching = (reach != nowhere) & (np.abs(reach - contact) < 0.0015)
    count = np.maximum(touching.sum(0), 1)
    return contact, (touching * ACROSS[:, None]).sum(0) / count, touching.sum(0) / len(ACROSS)


def _first(mask: NDArray[np.bool_], axis: int) -> NDArray[np.uint8]:
    """Index along a short ``axis`` of the first that is true, its length where none is.

    Made of byte operations that processors vectorise, which :func:`numpy.argmax` is not.
    """
    length = mask.shape[axis]
    index = np.arange(length, dtype=np.uint8).reshape([-1 if i == axis else 1 for i in range(mask.ndim)])
    missing = mask.view(np.uint8) - np.uint8(1)  # 0 where true, 255 where not
    return np.minimum((index | missing).min(axis), np.uint8(length))


def maxima(field: GraspField, count: int, threshold: float = 0.1, distance: int = 4) -> list[tuple[int, int]]:
    """Cells (row, column) of the best local maxima of quality, best first."""
    q = field.quality
    rows, columns = np.nonzero((q == maximum_filter(q, size=2 * distance + 1)) & (q >= threshold))
    order = np.argsort(-q[rows, columns], kind="stable")[:count]
    return [(int(rows[i]), int(columns[i])) for i in order]
