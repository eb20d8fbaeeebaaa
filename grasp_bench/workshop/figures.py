"""Plane figures and curves that solids are extruded, revolved and swept from.

Figures are shapely polygons, curves are arrays of points; millimetres and degrees.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from shapely import affinity
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from grasp_bench.system.arrays import Floats

Figure = BaseGeometry | ArrayLike
"""A plane figure: shapely's polygons, or the corners (N, 2) of one."""
G = TypeVar("G", bound=BaseGeometry)


def polygon(points: ArrayLike) -> Polygon:
    """Make the polygon through ``points`` (N, 2)."""
    return Polygon(np.asarray(points, dtype=float))


def circle(radius: float, x: float = 0.0, y: float = 0.0, segments: int = 48) -> Polygon:
    """Make a disc of ``radius`` about (x, y)."""
    return ellipse(radius, radius, x, y, segments)


def ellipse(rx: float, ry: float, x: float = 0.0, y: float = 0.0, segments: int = 48) -> Polygon:
    """Make an ellipse with half-axes ``rx``, ``ry`` about (x, y)."""
    t = np.linspace(0, 2 * np.pi, segments, endpoint=False)
    return Polygon(np.column_stack([x + rx * np.cos(t), y + ry * np.sin(t)]))


def rect(width: float, height: float, radius: float = 0.0, x: float = 0.0, y: float = 0.0) -> Polygon:
    """Make a rectangle centred on (x, y), corners rounded by ``radius``."""
    w, h = width / 2, height / 2
    shape = Polygon([(x - w, y - h), (x + w, y - h), (x + w, y + h), (x - w, y + h)])
    return rounded(shape, radius) if radius > 0 else shape


def regular(sides: int, radius: float, turn: float = 0.0) -> Polygon:
    """Make a regular polygon with circumradius ``radius``, first corner at angle ``turn``."""
    t = np.radians(turn) + np.linspace(0, 2 * np.pi, sides, endpoint=False)
    return Polygon(radius * np.column_stack([np.cos(t), np.sin(t)]))


def star(tips: int, outer: float, inner: float, turn: float = 90.0) -> Polygon:
    """Make a star (or gear blank) with ``tips`` corners at ``outer`` and valleys at ``inner``."""
    t = np.radians(turn) + np.linspace(0, 2 * np.pi, 2 * tips, endpoint=False)
    r = np.where(np.arange(2 * tips) % 2 == 0, outer, inner)
    return Polygon(np.column_stack([r * np.cos(t), r * np.sin(t)]))


def rounded(shape: Polygon, radius: float, segments: int = 4) -> Polygon:
    """Round the convex corners of a plane figure by ``radius``."""
    return shape.buffer(-radius, quad_segs=segments).buffer(radius, quad_segs=segments)


def stroke(points: ArrayLike, width: float, cap: Literal["round", "flat", "square"] = "round") -> Polygon:
    """Make a band of ``width`` along an open polyline (N, 2); ``cap`` is round, flat or square."""
    line = LineString(np.asarray(points, dtype=float))
    return line.buffer(width / 2, cap_style=cap, quad_segs=6)


def arc(
    radius: float, start: float, stop: float, x: float = 0.0, y: float = 0.0, segments: int = 16
) -> Floats:
    """Return points (segments + 1, 2) on a circle from angle ``start`` to ``stop`` in degrees."""
    t = np.radians(np.linspace(start, stop, segments + 1))
    return np.column_stack([x + radius * np.cos(t), y + radius * np.sin(t)])


def bezier(*control: ArrayLike, segments: int = 16) -> Floats:
    """Return the Bézier curve (segments + 1, D) through the given control points (de Casteljau)."""
    t = np.linspace(0, 1, segments + 1)[:, None]
    points = [np.asarray(c, dtype=float)[None] for c in control]
    while len(points) > 1:
        points = [(1 - t) * a + t * b for a, b in pairwise(points)]
    return points[0]


def spline(points: ArrayLike, segments: int = 32, closed: bool = False) -> Floats:
    """Return the smooth cubic curve (segments + 1, D) through ``points`` (N, D), by chord length."""
    p = np.asarray(points, dtype=float)
    if closed:
        p = np.vstack([p, p[:1]])
    t = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    curve = CubicSpline(t, p, bc_type="periodic" if closed else "natural")
    samples = curve(np.linspace(0, t[-1], segments + 1))
    return samples[:-1] if closed else samples


def figures(shapes: Iterable[BaseGeometry]) -> BaseGeometry:
    """Unite plane figures."""
    return unary_union(list(shapes))


def place(shape: G, x: float = 0.0, y: float = 0.0, turn: float = 0.0) -> G:
    """Turn a plane figure about the origin by ``turn`` degrees, then move it."""
    return affinity.translate(affinity.rotate(shape, turn, origin=(0, 0)), x, y)
