"""Where a top-down parallel-jaw grasp should hold: analysis of a height field.

Fingers that come from above meet only what can be seen from above, so the height field of
the true shape tells which places they can reach and what they close on. For every cell and
jaw direction the analysis opens the jaws as little as is free, puts the tips where the
planner would (:func:`grasp_bench.planning.depth.grasp_pose`), and scores what lies between
them. It is geometry, not physics: reference grasps and labels are tried in physics besides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.sections import Motion

Floats = NDArray[np.float32]
Cells = NDArray[np.intp]

CELL = 0.002
"""Edge of a cell [m]."""
ACROSS_STEP = 0.003
"""Spacing of samples across the jaw direction [m]."""
SPARE = 0.001
"""Room behind an open finger [m]."""
LEAST_HALF_OPENING = 0.006
INSERTION, CLEARANCE = Motion().insertion, Motion().table_clearance
TABLE_NOISE = 0.004
"""Heights below this count as table [m]."""
LEAST_INSERTION = 0.003
"""A grasp whose fingers reach less far below the top of what they hold is not tried [m]."""
YAWS = np.linspace(0, np.pi, 18, endpoint=False)
"""Jaw directions tried [rad]."""


def finger_room(gripper: Gripper) -> float:
    """Return what an open finger takes along the jaw direction, with :data:`SPARE` [m]."""
    return round(gripper.finger_thickness + SPARE, 6)  # 8 mm and 1 mm are 9 mm to the bit


@dataclass(frozen=True)
class Samples:
    """Where the analysis looks for a gripper.

    Attributes:
        along: (A,) float32 sample positions along the jaw direction, :data:`CELL` apart [m].
        across: (B,) float32 sample positions across it, over the width of a pad [m].
        half_openings: (E,) float32 half openings that are tried [m].
        finger: cells that an open finger takes.
    """

    along: Floats
    across: Floats
    half_openings: Floats
    finger: int

    @property
    def margin(self) -> int:
        """Cells around a field that keep all samples of all jaw directions inside."""
        return len(self.along) // 2 + 4

    def near(self, position: float) -> int:
        """Return the index of the sample nearest to ``position`` along the jaws [m]."""
        return round((position - float(self.along[0])) / CELL)


@lru_cache
def samples_of(gripper: Gripper) -> Samples:
    """Return the samples for ``gripper``."""
    room = finger_room(gripper)
    reach = CELL * math.ceil((gripper.stroke + room) / CELL)
    pad = ACROSS_STEP * math.floor(gripper.pad[1] / 2 / ACROSS_STEP)
    return Samples(
        np.arange(-reach, reach + 1e-4, CELL, dtype=np.float32),
        np.arange(-pad, pad + 1e-4, ACROSS_STEP, dtype=np.float32),
        np.arange(LEAST_HALF_OPENING, gripper.stroke + 1e-6, CELL, dtype=np.float32),
        round(room / CELL),
    )


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
        quality: how good the grasp is, 0 to 1.
        yaw: jaw direction from world x towards y, [0, π).
        opening: distance between the pads before closing [m].
        tip: height of the finger tips [m].
        top: height of what is grasped [m].
    """

    quality: Floats
    yaw: Floats
    opening: Floats
    tip: Floats
    top: Floats


def analyse(
    field: HeightField, yaws: NDArray[np.float64] = YAWS, chunk: int = 2000, gripper: Gripper = PARALLEL_85
) -> GraspField:
    """Find the best grasp of ``gripper`` on every cell of ``field`` over all ``yaws``."""
    from scipy.ndimage import binary_closing, binary_dilation

    samples = samples_of(gripper)
    h = field.heights
    solid = h > TABLE_NOISE
    # Also between walls (across a cup's mouth), where the centre is on no material.
    candidates = binary_closing(np.pad(solid, 20), iterations=14)[20:-20, 20:-20] | solid
    rows, columns = np.nonzero(candidates & binary_dilation(solid, iterations=14))
    best = {name: np.zeros(h.shape, np.float32) for name in ("quality", "yaw", "opening", "tip", "top")}
    padded = np.pad(h, samples.margin)
    for yaw in yaws:
        for start in range(0, len(rows), chunk):
            r, c = rows[start : start + chunk], columns[start : start + chunk]
            found = _score(padded, r, c, float(yaw), field, samples)
            better = found["quality"] > best["quality"][r, c]
            for name, values in found.items():
                best[name][r[better], c[better]] = values[better]
            best["yaw"][r[better], c[better]] = yaw
    return GraspField(**best)


def grasps_at(
    field: HeightField, rows: Cells, columns: Cells, yaw: float, gripper: Gripper = PARALLEL_85
) -> dict[str, Floats]:
    """Return the fields of :class:`GraspField` (N,) for given cells with jaws along ``yaw``, feasible or
    not."""
    samples = samples_of(gripper)
    return _score(np.pad(field.heights, samples.margin), rows, columns, yaw, field, samples)


def _score(
    h: Floats, rows: Cells, columns: Cells, yaw: float, field: HeightField, samples: Samples
) -> dict[str, Floats]:
    """Return quality, opening, tip and top of grasps at cells of ``field``, of which ``h`` are the padded
    heights.

    Grasps (N) are the last axis of all arrays: what is reduced are short axes, over long contiguous rows.
    """
    along, half_openings, near, width = samples.along, samples.half_openings, samples.near, samples.finger
    cos, sin = np.cos(yaw), np.sin(yaw)
    a, b = np.meshgrid(along, samples.across)  # (B, A)
    dc = np.rint((a * cos - b * sin) / CELL).astype(np.intp) + samples.margin
    dr = np.rint((a * sin + b * cos) / CELL).astype(np.intp) + samples.margin
    patch = h.ravel().take((dr * h.shape[1] + dc)[..., None] + (rows * h.shape[1] + columns))  # (B, A, N)

    # Ground under both fingers for each symmetric opening.
    profile = patch.max(axis=0)
    ground = np.stack(
        [
            np.maximum(
                profile[near(e) : near(e) + width].max(0), profile[near(-e) - width + 1 : near(-e) + 1].max(0)
            )
            for e in half_openings.tolist()
        ]
    )  # (E, N)
    ground = np.where(ground > TABLE_NOISE, ground + CLEARANCE, 0)
    inner = np.stack([profile[near(-e) + 1 : near(e)].max(0) for e in half_openings.tolist()])
    tip = np.maximum(np.maximum(inner - INSERTION, CLEARANCE), ground)
    free = inner - tip >= LEAST_INSERTION
    depth = np.where(free, inner - tip, 0)
    # The smallest opening that reaches nearly as deep as any, then a little wider if that is free.
    enough = depth >= np.maximum(0.9 * depth.max(0), LEAST_INSERTION)
    feasible = enough.any(0)
    first = np.where(feasible, _first(enough, 0), 0).astype(np.intp)
    index, n = first, np.arange(len(rows))
    for extra in (1, 2, 3):
        wider = np.minimum(first + extra, len(half_openings) - 1)
        same = enough[wider, n] & (index == np.maximum(wider - 1, first))
        index = np.where(same, wider, index)
    e, tips, tops = half_openings[index], tip[index, n], inner[index, n]

    inside = np.abs(along)[:, None] < e  # (A, N)
    low = (patch > tips + 0.002) & inside
    high = (patch > np.minimum(tips + 0.007, tops - 0.001)) & inside
    left, left_at, left_spread = _edge(low, +1, samples)
    right, right_at, right_spread = _edge(low, -1, samples)
    high_left, *_ = _edge(high, +1, samples)
    high_right, *_ = _edge(high, -1, samples)
    rise = np.maximum(np.minimum(0.005, tops - 0.001 - tips - 0.002), 0.001)
    # Half a cell is within the grid's own error: on low things it would look like a steep slope.
    slope = np.maximum(np.maximum(high_left - left, right - high_right) - CELL / 2, 0) / rise

    twist = np.exp(-(((left_at - right_at) / 0.008) ** 2))
    torsion = np.exp(-(((0.5 * (left_at + right_at)) / 0.008) ** 2))
    lean = np.clip((0.75 - slope) / 0.45, 0, 1)
    centred = np.exp(-(((0.5 * (left + right)) / 0.012) ** 2))
    area = np.clip(0.4 + 0.3 * (left_spread + right_spread), 0, 1)
    bite = np.clip((tops - tips) / 0.012, 0.4, 1)
    x = field.origin[0] + columns * CELL - field.centre_of_mass[0]
    y = field.origin[1] + rows * CELL - field.centre_of_mass[1]
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
    field: HeightField,
    centre: NDArray[np.floating],
    axis: NDArray[np.floating],
    opening: float,
    half: float,
    gripper: Gripper = PARALLEL_85,
) -> float:
    """Return the greatest height [m] under two open fingers.

    Args:
        centre: x, y between the fingers [m].
        axis: x, y of the unit jaw direction.
        opening: distance between the pads [m].
        half: half width of the corridor of each finger, across the jaw direction [m].
    """
    a, b = np.meshgrid(
        opening / 2 + np.arange(-CELL / 2, finger_room(gripper), CELL / 4),
        np.arange(-half, half + CELL / 8, CELL / 4),
    )
    a, b = np.concatenate([a, -a]), np.concatenate([b, b])
    columns = np.rint((centre[0] + a * axis[0] - b * axis[1] - field.origin[0]) / CELL).astype(np.intp)
    rows = np.rint((centre[1] + a * axis[1] + b * axis[0] - field.origin[1]) / CELL).astype(np.intp)
    size = len(field.heights)
    inside = (rows >= 0) & (rows < size) & (columns >= 0) & (columns < size)
    return float(field.heights[rows[inside], columns[inside]].max(initial=0.0))


def balance(offset: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return the factor of quality for a grasp's distance (…, 2) [m] from the centre of mass."""
    return 0.25 + 0.75 * np.exp(-(offset**2).sum(-1) / 0.07**2)


def _edge(mask: NDArray[np.bool_], side: int, samples: Samples) -> tuple[Floats, Floats, Floats]:
    """Find the outermost material of each grasp, seen by one finger.

    Args:
        mask: (B, A, N) material between the jaws.
        side: +1 for the finger coming from negative positions, −1 for the other.
        samples: where ``mask`` was sampled.

    Returns:
        Position of the contact along the jaws (N,), its mean place across (N,), and the share
        of the pad's width that it covers (N,).
    """
    nowhere = np.float32(side) * 1.0
    reach = np.append(samples.along[::side], nowhere)[_first(mask[:, ::side], 1)]  # (B, N)
    contact = reach.min(0) if side > 0 else reach.max(0)
    touching = (reach != nowhere) & (np.abs(reach - contact) < 0.0015)
    count = np.maximum(touching.sum(0), 1)
    return contact, (touching * samples.across[:, None]).sum(0) / count, touching.sum(0) / len(samples.across)


def _first(mask: NDArray[np.bool_], axis: int) -> NDArray[np.uint8]:
    """Return the index along a short ``axis`` of the first that is true, its length where none is.

    Made of byte operations that processors vectorise, which :func:`numpy.argmax` is not.
    """
    length = mask.shape[axis]
    index = np.arange(length, dtype=np.uint8).reshape([-1 if i == axis else 1 for i in range(mask.ndim)])
    missing = mask.view(np.uint8) - np.uint8(1)  # 0 where true, 255 where not
    return np.minimum((index | missing).min(axis), np.uint8(length))


def maxima(field: GraspField, count: int, threshold: float = 0.1, distance: int = 4) -> list[tuple[int, int]]:
    """Return the cells (row, column) of the best local maxima of quality, best first."""
    from scipy.ndimage import maximum_filter

    q = field.quality
    rows, columns = np.nonzero((q == maximum_filter(q, size=2 * distance + 1)) & (q >= threshold))
    order = np.argsort(-q[rows, columns], kind="stable")[:count]
    return [(int(rows[i]), int(columns[i])) for i in order]
