"""Which grasps of a training scene are tried in physics: good ones, poor ones, and wrong ones.

Networks learn from what holds and from what does not. A fifth of the candidates each is
sampled as Dex-Net does (antipodal points of the true surface: rims, handles, thin edges) and
with jaws turned at random; the others are the best grasps that analysis finds, and any it finds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grasp_bench.planning import heightfield
from grasp_bench.planning.heightfield import CELL, GraspField, HeightField, maxima
from grasp_bench.scene.floating import FloatingGripper
from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.antipodal import Jaws, antipodal

Rng = np.random.Generator

SOURCES = ("maximum", "anywhere", "antipodal", "turned")
"""Where a candidate is from, by the number stored with it."""
SHARES = (0.4, 0.2, 0.2, 0.2)
NEAR = 0.008
"""Maxima and others of the analysis are at least this far apart [m]."""
LEAST_QUALITY = 0.05
"""Grasps of less quality are not taken from the analysis."""


class Candidates(NamedTuple):
    """Grasps to try; arrays (M,), see :class:`grasp_bench.planning.heightfield.GraspField`."""

    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    yaw: Floats
    opening: Floats
    tip: Floats
    top: Floats
    quality: Floats
    source: NDArray[np.int8]


def propose(
    gripper: FloatingGripper, found: GraspField, field: HeightField, count: int, rng: Rng
) -> Candidates:
    """Draw about ``count`` candidates of all :data:`SOURCES`; fewer where there is little to grasp.

    Args:
        gripper: parked beside the scene at rest.
        found: what the analysis of ``field`` gave.
        field: true heights of the scene.
    """
    wanted = [round(count * share) for share in SHARES]
    best = _apart(maxima(found, 100, threshold=LEAST_QUALITY), [], wanted[0])
    some = np.argwhere(found.quality >= LEAST_QUALITY)
    both = _apart([(int(r), int(c)) for r, c in rng.permutation(some)[:200]], best, len(best) + wanted[1])
    own = [(r, c, float(found.yaw[r, c])) for r, c in both]
    free: list[Jaws] = antipodal(gripper, field, wanted[2], rng)
    pairs = len(free)
    if len(some):
        chosen = some[rng.integers(len(some), size=count - len(own) - pairs)]
        free += [(int(r), int(c), float(rng.uniform(0, np.pi))) for r, c in chosen]
    source = [0] * len(best) + [1] * (len(both) - len(best)) + [2] * pairs + [3] * (len(free) - pairs)
    if not source:
        none, nowhere = np.zeros(0), np.zeros(0, np.int64)
        return Candidates(nowhere, nowhere, none, none, none, none, none, none.astype(np.int8))
    rows, columns, yaw = map(np.array, zip(*own, *free, strict=True))
    graded = [
        heightfield.grasps_at(field, rows[i : i + 1], columns[i : i + 1], float(yaw[i]), gripper.gripper)
        for i in range(len(own), len(rows))
    ]
    own_cells = rows[: len(own)], columns[: len(own)]

    def column(name: str) -> Floats:
        return np.concatenate([getattr(found, name)[own_cells], *(g[name] for g in graded)]).astype(float)

    values = map(column, ("opening", "tip", "top", "quality"))
    return Candidates(rows, columns, yaw, *values, source=np.array(source, np.int8))


def _apart(cells: list[tuple[int, int]], chosen: list[tuple[int, int]], count: int) -> list[tuple[int, int]]:
    """Return ``chosen`` and those of ``cells`` that are apart from all before them, ``count`` at most."""
    chosen = list(chosen)
    for cell in cells:
        if len(chosen) < count and all(np.hypot(cell[0] - r, cell[1] - c) * CELL > NEAR for r, c in chosen):
            chosen.append(cell)
    return chosen
