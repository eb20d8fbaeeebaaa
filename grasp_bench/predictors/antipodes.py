"""Antipodal grasps on a known shape, in any direction: geometry alone, before physics has its word.

The shape is the union of convex pieces that collide. A line through it along the jaws meets it where a finger
would, on both sides; where both surfaces face the fingers within the friction cone, the jaws hold there
(Nguyen, 1988).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from grasp_bench.system.arrays import Floats

SAMPLES = 900
"""Points on the surface that are looked at."""
CONE = math.radians(18)
"""Greatest angle between the jaws and the normal of either surface [rad]."""
LEVEL = math.radians(8)
"""Jaws that are nearly level, or nearly upright, are made so [rad]."""


@dataclass(frozen=True)
class Pair:
    """Two places that face each other.

    Attributes:
        middle: (3,) between both [m].
        axis: (3,) unit vector from one to the other.
        width: their distance [m].
        alignment: cosine of the greater angle between the axis and a surface's normal.
    """

    middle: Floats
    axis: Floats
    width: float
    alignment: float


class Union:
    """Convex pieces together.

    Args:
        hulls: vertices (V, 3) of each piece [m].
    """

    def __init__(self, hulls: Sequence[Floats]) -> None:
        self._shapes = [ConvexHull(h) for h in hulls]
        # n · x + d ≤ 0 inside
        self._planes = [np.unique(np.round(s.equations, 9), axis=0) for s in self._shapes]

    def surface(self, count: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
        """Return points (N, 3) spread over the outer surface, ``count`` at most, and their normals (N, 3)."""
        corners = np.concatenate([s.points[s.simplices] for s in self._shapes])
        normals = np.concatenate([s.equations[:, :3] for s in self._shapes])
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        chosen = rng.choice(len(areas), count, p=areas / areas.sum())
        u, v = np.sqrt(rng.random(count))[:, None], rng.random(count)[:, None]
        a, b, c = corners[chosen].transpose(1, 0, 2)
        points = (1 - u) * a + u * (1 - v) * b + u * v * c
        outside = points + 1e-5 * normals[chosen]
        hidden = np.zeros(count, bool)
        for planes in self._planes:
            hidden |= (outside @ planes[:, :3].T + planes[:, 3] < 0).all(1)
        return points[~hidden], normals[chosen][~hidden]

    def through(self, point: Floats, direction: Floats) -> list[tuple[float, Floats]]:
        """Return where a line leaves the union beyond ``point``: distances [m] and outward normals, nearest
        first."""
        spans: list[tuple[float, float, Floats]] = []
        for planes in self._planes:
            rate, gap = planes[:, :3] @ direction, -(planes[:, :3] @ point + planes[:, 3])
            if (gap[np.abs(rate) < 1e-12] < 0).any():
                continue
            with np.errstate(divide="ignore", invalid="ignore"):
                at = gap / rate
            enters = float(at[rate < -1e-12].max(initial=-np.inf))
            leaving = np.where(rate > 1e-12, at, np.inf)
            last = int(leaving.argmin())
            if enters < leaving[last]:
                spans.append((enters, float(leaving[last]), planes[last, :3]))
        ends: list[tuple[float, Floats]] = []
        reach = -np.inf
        for enters, leaves, normal in sorted(spans, key=lambda s: s[0]):
            if enters > reach + 1e-4 or not ends:
                ends.append((leaves, normal))
            elif leaves > ends[-1][0]:
                ends[-1] = (leaves, normal)
            reach = max(reach, leaves)
        return [e for e in ends if e[0] > 1e-4]


def pairs(shape: Union, widest: float, up: Floats, rng: np.random.Generator) -> list[Pair]:
    """Return places that jaws opening up to ``widest`` [m] can close on.

    Args:
        shape: the object.
        widest: greatest distance between both places.
        up: (3,) unit vector against gravity, to which jaws that are nearly level or upright are brought.
        rng: draws where is looked.
    """
    points, normals = shape.surface(SAMPLES, rng)
    least, found = math.cos(CONE), []
    for point, normal in zip(points, normals, strict=True):
        axis = _squared(-normal, up)
        if -normal @ axis < least:
            continue
        for width, other in shape.through(point, axis):
            if width > widest:
                break
            alignment = min(float(-normal @ axis), float(other @ axis))
            if alignment >= least:
                found.append(Pair(point + width / 2 * axis, axis, width, alignment))
    return found


def _squared(axis: Floats, up: Floats) -> Floats:
    """Return a unit vector, made level or upright where it nearly is."""
    rise = float(axis @ up)
    if abs(rise) > math.cos(LEVEL):
        return math.copysign(1.0, rise) * up
    if abs(rise) < math.sin(LEVEL):
        level = axis - rise * up
        return level / np.linalg.norm(level)
    return axis


def approaches(axis: Floats, up: Floats, count: int) -> list[Floats]:
    """Return ``count`` directions (3,) at right angles to ``axis``, the most downward first."""
    down = -up - (-up @ axis) * axis
    if np.linalg.norm(down) < 1e-6:  # upright jaws: all ways are level
        down = np.cross(up, [1.0, 0.0, 0.0] if abs(up[0]) < 0.9 else [0.0, 1.0, 0.0])
    first = down / np.linalg.norm(down)
    second = np.cross(axis, first)
    angles = 2 * math.pi * np.arange(count) / count
    return [math.cos(a) * first + math.sin(a) * second for a in angles]
