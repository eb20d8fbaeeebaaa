"""Antipodal grasps on a known shape, in any direction: geometry alone, before physics has its word.

The shape is the union of convex pieces that collide. A line through it along the jaws meets it where a finger
would, on both sides; where both surfaces face the fingers within the friction cone, the jaws hold there
(Nguyen, 1988). At an edge a surface has all the normals between those of the faces that meet there, for a pad
is flat.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.spatial import ConvexHull

from grasp_bench.system.arrays import Floats

SAMPLES = 900
"""Points on the surface that are looked at."""
EDGE = 1e-3
"""A pad that is so near to an edge lies against it, and feels any normal between those of its faces [m]."""
LEVEL = math.radians(8)
"""Jaws that are nearly level, or nearly upright, are made so [rad]."""
LEAST_LEVEL = 0.5
"""Least level share of a normal of whose surface level jaws are tried, too: at an edge, or in a wide cone."""


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

    def surface(self, count: int, rng: np.random.Generator) -> tuple[Floats, Floats, NDArray[np.intp]]:
        """Return points (N, 3) spread over the outer surface, ``count`` at most, their normals (N, 3), and of
        which piece each is (N,)."""
        corners = np.concatenate([s.points[s.simplices] for s in self._shapes])
        normals = np.concatenate([s.equations[:, :3] for s in self._shapes])
        piece = np.repeat(np.arange(len(self._shapes)), [len(s.simplices) for s in self._shapes])
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        chosen = rng.choice(len(areas), count, p=areas / areas.sum())
        u, v = np.sqrt(rng.random(count))[:, None], rng.random(count)[:, None]
        a, b, c = corners[chosen].transpose(1, 0, 2)
        points = (1 - u) * a + u * (1 - v) * b + u * v * c
        outside = points + 1e-5 * normals[chosen]
        hidden = np.zeros(count, bool)
        for planes in self._planes:
            hidden |= (outside @ planes[:, :3].T + planes[:, 3] < 0).all(1)
        return points[~hidden], normals[chosen][~hidden], piece[chosen][~hidden]

    def facing(self, point: Floats, piece: int, direction: Floats) -> float:
        """Return how well a piece's surface at ``point`` (3,) faces ``direction`` (3,): the cosine of the
        least angle to a normal there, 0 where that is a right one or more."""
        planes = self._planes[piece]
        near = planes[planes[:, :3] @ point + planes[:, 3] > -EDGE, :3]
        if len(near) < 2:
            return max(0.0, float((near @ direction).max(initial=0.0)))
        # The nearest point to a unit vector in a cone is as far from the origin as the angle's cosine.
        return float(np.linalg.norm(near.T @ nnls(near.T, direction)[0]))

    def through(self, point: Floats, direction: Floats) -> list[tuple[float, int]]:
        """Return where a line leaves the union beyond ``point``: distances [m] and which piece it leaves
        there, nearest first."""
        spans: list[tuple[float, float, int]] = []
        for piece, planes in enumerate(self._planes):
            rate, gap = planes[:, :3] @ direction, -(planes[:, :3] @ point + planes[:, 3])
            if (gap[np.abs(rate) < 1e-12] < 0).any():
                continue
            with np.errstate(divide="ignore", invalid="ignore"):
                at = gap / rate
            enters = float(at[rate < -1e-12].max(initial=-np.inf))
            leaving = np.where(rate > 1e-12, at, np.inf)
            last = float(leaving.min())
            if enters < last:
                spans.append((enters, last, piece))
        ends: list[tuple[float, int]] = []
        reach = -np.inf
        for enters, leaves, piece in sorted(spans):
            if enters > reach + 1e-4 or not ends:
                ends.append((leaves, piece))
            elif leaves > ends[-1][0]:
                ends[-1] = (leaves, piece)
            reach = max(reach, leaves)
        return [e for e in ends if e[0] > 1e-4]


def pairs(shape: Union, widest: float, cone: float, up: Floats, rng: np.random.Generator) -> list[Pair]:
    """Return places that jaws opening up to ``widest`` [m] can close on.

    Args:
        shape: the object.
        widest: greatest distance between both places.
        cone: greatest angle between the jaws and the normal of either surface, that of friction [rad].
        up: (3,) unit vector against gravity, to which jaws that are nearly level or upright are brought.
        rng: draws where is looked.
    """
    least, found = math.cos(cone), []
    for point, normal, piece in zip(*shape.surface(SAMPLES, rng), strict=True):
        for axis in _axes(-normal, up):
            here = shape.facing(point, piece, -axis)
            if here < least:
                continue
            for width, other in shape.through(point, axis):
                if width > widest:
                    break
                alignment = min(here, shape.facing(point + width * axis, other, axis))
                if alignment >= least:
                    found.append(Pair(point + width / 2 * axis, axis, width, alignment))
    return found


def _axes(inward: Floats, up: Floats) -> list[Floats]:
    """Return how jaws may lie at a surface: along its inward normal, and level."""
    axis = _squared(inward, up)
    level = axis - axis @ up * up
    length = float(np.linalg.norm(level))
    return [axis] if length < LEAST_LEVEL or length > 1 - 1e-9 else [axis, level / length]


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
