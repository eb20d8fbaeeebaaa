"""Random solids that know their convex pieces.

Every solid is a closed mesh together with the convex pieces of which it was built, so that
no convex decomposition has to be searched for afterwards. Lengths are millimetres; a solid is
centred on the origin of its bounding box unless its function says otherwise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import cast

import numpy as np
import shapely
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation
from shapely.geometry import MultiPoint, Polygon
from shapely.geometry.base import BaseGeometry

from grasp_bench.system.arrays import Floats
from grasp_bench.workshop import shapes
from grasp_bench.workshop.shapes import Mesh

Rng = np.random.Generator

SEGMENTS = 24
"""Number of sides of round solids."""
SECTORS = 12
"""Convex pieces around the wall of a vessel."""
MERGE = 1.04
"""Neighbouring pieces are merged when their hull is at most so much larger than they are."""


@dataclass(frozen=True)
class Solid:
    """A closed mesh [mm] and the vertices (V, 3) of its convex pieces."""

    mesh: Mesh
    pieces: list[Floats]

    @property
    def size(self) -> Floats:
        """(3,) edges of the bounding box."""
        return np.asarray(self.mesh.extents)

    def placed(self, rotation: ArrayLike = (0, 0, 0), offset: ArrayLike = (0, 0, 0)) -> Solid:
        """Return a copy turned about the fixed axes by ``rotation`` [deg], then moved by ``offset``."""
        turn = Rotation.from_euler("xyz", rotation, degrees=True).as_matrix()
        shift = np.asarray(offset, float)
        return self.mapped(lambda v: v @ turn.T + shift)

    def scaled(self, factors: ArrayLike) -> Solid:
        """Return a copy scaled about the origin by one or three positive factors."""
        return self.mapped(lambda v: v * np.asarray(factors, float))

    def centred(self) -> Solid:
        """Return a copy with the middle of its bounding box at the origin."""
        middle = np.asarray(self.mesh.bounds).mean(0)
        return self.mapped(lambda v: v - middle)

    def fitted(self, size: ArrayLike) -> Solid:
        """Return a centred copy stretched to fill a box of ``size`` (3,)."""
        return self.centred().scaled(np.asarray(size, float) / self.size)

    def mapped(self, f: Callable[[Floats], Floats]) -> Solid:
        """Return a copy with an affine map applied to all vertices."""
        return Solid(
            Mesh(f(np.asarray(self.mesh.vertices)), self.mesh.faces, process=False),
            [f(p) for p in self.pieces],
        )


def log_uniform(rng: Rng, low: float, high: float) -> float:
    """Draw a random number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def convex(mesh: Mesh) -> Solid:
    """Take a convex mesh as its own single piece."""
    return Solid(mesh, [np.asarray(mesh.vertices)])


# ---------------------------------------------------------------- convex solids, filling a box


def block(rng: Rng, size: Floats) -> Solid:
    """Make a box with sharp or rounded edges."""
    if rng.random() < 0.5:
        return convex(shapes.box(*size)).centred()
    x, y, z = size
    return convex(shapes.rounded_box(x, y, z, rng.uniform(0.08, 0.4) * size.min())).centred()


def superquadric(rng: Rng, size: Floats) -> Solid:
    """Make a convex superellipsoid: anything between ball, box, cylinder and octahedron."""
    e1, e2 = rng.uniform(0.2, 1.7, 2)
    return convex(shapes.superellipsoid(1, 1, 1, e1, e2, SEGMENTS)).fitted(size)


def column(rng: Rng, size: Floats) -> Solid:
    """Make a cylinder, prism, frustum or cone along a random axis of the box."""
    sides = SEGMENTS if rng.random() < 0.6 else int(rng.integers(3, 9))
    top = float(rng.choice([1.0, 1.0, rng.uniform(0.3, 0.9), 0.0]))
    turn = float(rng.choice([0, 90])), float(rng.choice([0, 90])), 0.0
    return convex(shapes.cylinder(1, 1, sides, top=top)).placed(turn).fitted(size)


def wedge(rng: Rng, size: Floats) -> Solid:
    """Make a prism over a random triangle, quadrilateral or pentagon."""
    count = int(rng.integers(3, 6))
    angles = 2 * np.pi * (np.arange(count) + rng.uniform(-0.3, 0.3, count)) / count
    outline = Polygon(np.column_stack([np.cos(angles), np.sin(angles)]))
    turn = float(rng.choice([0, 90])), float(rng.choice([0, 90])), 0.0
    return convex(shapes.extrude(outline, 1.0, taper=rng.uniform(0.6, 1.0))).placed(turn).fitted(size)


CONVEX = (block, superquadric, column, wedge)


def lump(rng: Rng, size: ArrayLike) -> Solid:
    """Make some convex solid that fills a box of ``size``."""
    return CONVEX[int(rng.integers(len(CONVEX)))](rng, np.asarray(size, float))


# ---------------------------------------------------------------- solids of revolution


def _frustum(
    low: Floats, high: Floats, start: float = 0.0, stop: float = 2 * np.pi, points: int = SEGMENTS
) -> Floats:
    """Return points on the circles of (r, z) ``low`` and ``high`` between two angles."""
    t = np.linspace(start, stop, points, endpoint=stop - start < 2 * np.pi - 1e-9)
    return np.vstack(
        [np.column_stack([r * np.cos(t), r * np.sin(t), np.full(points, z)]) for r, z in (low, high)]
    )


def _profile(rng: Rng, count: int, least: float) -> Floats:
    """Draw (count, 2) random smooth-ish radii in [least, 1] at rising heights from 0 to 1."""
    heights = np.concatenate([[0], np.sort(rng.uniform(0.1, 0.9, count - 2)), [1]])
    heights = 0.5 * heights + 0.5 * np.linspace(0, 1, count)
    radii = np.clip(rng.uniform(least, 1) + np.cumsum(rng.normal(0, 0.22, count)), least, 1)
    return np.column_stack([radii / radii.max(), heights])


def turned(rng: Rng, diameter: float, height: float) -> Solid:
    """Make a solid of revolution about z with a random profile."""
    profile = _profile(rng, int(rng.integers(3, 8)), 0.3) * [diameter / 2, height]
    mesh = shapes.revolve(np.vstack([[0, 0], profile, [0, height]]), SEGMENTS)
    return Solid(mesh, [_frustum(a, b) for a, b in pairwise(profile)]).centred()


def vessel(rng: Rng, diameter: float, height: float) -> Solid:
    """Make an open vessel or tube about z, walls 2 to 5 mm: straight, flaring, bulging or with a waist."""
    bands = int(rng.integers(1, 4))
    wall = min(rng.uniform(2, 5), 0.2 * diameter, 0.5 * height)
    outer = _profile(rng, bands + 1, 0.55) * [diameter / 2, height]
    outer[:, 0] = np.maximum(outer[:, 0], 2.5 * wall)
    inner = outer - [wall, 0]
    is_tube = rng.random() < 0.15
    floor = 0.0 if is_tube else wall
    inner[0] = [np.interp(floor, outer[:, 1], inner[:, 0]), floor]
    middle = [] if is_tube else [[0, floor], [0, 0]]
    mesh = shapes.revolve(np.vstack([outer, inner[::-1], *([middle] if middle else [])]), SEGMENTS)
    # Chords of the sectors cut into the cavity: half of that is taken off the pieces' inside.
    slack = np.minimum(2 / (1 + np.cos(np.pi / SECTORS)) * inner[:, 0], outer[:, 0] - 0.6 * wall)
    hollow = np.column_stack([slack, inner[:, 1]])
    edges = np.linspace(0, 2 * np.pi, SECTORS + 1)
    points = SEGMENTS // SECTORS + 1
    pieces = [
        np.vstack([_frustum(ring[i], ring[i + 1], a, b, points) for ring in (outer, hollow)])
        for i in range(bands)
        for a, b in pairwise(edges)
    ]
    if not is_tube:
        pieces.append(_frustum(outer[0], np.array([np.interp(floor, outer[:, 1], outer[:, 0]) - 0.1, floor])))
    return Solid(mesh, pieces).centred()


# ---------------------------------------------------------------- extruded figures


def partition(figure: BaseGeometry) -> list[Floats]:
    """Cover ``figure`` with convex polygons (N, 2), which stand out a little at round hollows."""
    parts = []
    triangles = cast(list[Polygon], list(shapely.constrained_delaunay_triangles(figure).geoms))
    triangles.sort(key=lambda t: -t.area)
    whole = [True] * len(triangles)
    for i, seed in enumerate(triangles):
        if not whole[i]:
            continue
        part, area, whole[i] = seed, seed.area, False
        grown = True
        while grown:
            grown = False
            for j, other in enumerate(triangles):
                if whole[j] and part.intersection(other).length > 1e-6:
                    both = MultiPoint([*part.exterior.coords, *other.exterior.coords])
                    joint = cast(Polygon, both.convex_hull)
                    if joint.area <= MERGE * (area + other.area):
                        part, area, whole[j], grown = joint, area + other.area, False, True
        parts.append(part)
    return [np.asarray(p.exterior.coords)[:-1] for p in parts]


def extruded(figure: BaseGeometry, height: float) -> Solid:
    """Give a figure of the xy plane [mm] ``height``."""
    pieces = [
        np.vstack([np.column_stack([p, np.full(len(p), z)]) for z in (0.0, height)])
        for p in partition(figure)
    ]
    return Solid(shapes.extrude(figure, height), pieces).centred()


def _bars(*bars: tuple[float, float, float, float]) -> BaseGeometry:
    """Return the union of rectangles given by their corners x0, y0, x1, y1."""
    return shapely.union_all([shapely.box(*b) for b in bars])


def figure(rng: Rng, width: float, depth: float) -> BaseGeometry:
    """Draw a random plane figure, mostly not convex, that fills ``width`` × ``depth`` mm."""
    t = rng.uniform(0.18, 0.42)
    s = rng.uniform(0.2, 0.8)
    kind = int(rng.integers(9))
    if kind == 0:
        shape = _bars((0, 0, 1, t), (0, 0, t, 1))
    elif kind == 1:
        shape = _bars((0, 1 - t, 1, 1), (s - t / 2, 0, s + t / 2, 1))
    elif kind == 2:
        shape = _bars((0, 0, 1, t), (0, 0, t, 1), (1 - t, 0, 1, rng.uniform(0.5, 1)))
    elif kind == 3:
        shape = _bars((0, 0.5 - t / 2, 1, 0.5 + t / 2), (s - t / 2, 0, s + t / 2, 1))
    elif kind == 4:
        shape = shapes.star(int(rng.integers(3, 8)), 1.0, rng.uniform(0.4, 0.8))
    elif kind == 5:
        angles = np.linspace(0, 2 * np.pi, int(rng.integers(5, 11)), endpoint=False)
        radii = rng.uniform(0.45, 1, (len(angles), 1))
        shape = Polygon(radii * np.column_stack([np.cos(angles), np.sin(angles)]))
    elif kind == 6:
        shape = shapes.circle(1, segments=16).difference(shapes.circle(rng.uniform(0.4, 0.75), segments=12))
    elif kind == 7:
        outline = shapes.regular(int(rng.integers(4, 9)), 1.0, rng.uniform(0, 90))
        shape = outline.difference(shapes.circle(rng.uniform(0.2, 0.5), segments=10))
    else:
        holes = [shapes.circle(rng.uniform(0.08, 0.16), x, 0.5, segments=8) for x in (0.25, 0.75)]
        shape = shapely.box(0, 0, 1, 1).difference(shapely.union_all(holes))
    x0, y0, x1, y1 = shape.bounds
    return shapely.transform(shape, lambda p: (p - [x0, y0]) / [x1 - x0, y1 - y0] * [width, depth])


def cutout(rng: Rng, size: ArrayLike) -> Solid:
    """Draw a figure of the first two of ``size`` and extrude it by the third."""
    x, y, z = np.asarray(size, float)
    return extruded(figure(rng, x, y), z)


# ---------------------------------------------------------------- swept bars


def swept(path: ArrayLike, section: Polygon, scales: ArrayLike | None = None, closed: bool = False) -> Solid:
    """Make a bar along a ``path`` (N, 2) in the xy plane; the section's x lies in that plane."""
    points = np.asarray(path, float)
    path3 = np.column_stack([points, np.zeros(len(points))])
    mesh = shapes.sweep(section, path3, scales=scales, closed=closed)
    corners = len(section.exterior.coords) - 1
    rings = np.asarray(mesh.vertices)[: len(points) * corners].reshape(len(points), corners, 3)
    rings = np.concatenate([rings, rings[:1]]) if closed else rings
    return Solid(mesh, [np.concatenate([a, b]) for a, b in pairwise(rings)])


def section(rng: Rng, width: float, height: float) -> Polygon:
    """Draw the cross-section of a bar: round, angular or rectangular with bevelled edges."""
    kind = int(rng.integers(3))
    if kind == 0:
        return shapes.rect(width, height)
    rx, ry, sides = ((0.5, 0.5, 12), (0.54, 0.54, 8))[kind - 1]
    return shapes.ellipse(rx * width, ry * height, segments=sides)


def bar(rng: Rng, length: float, width: float, height: float) -> Solid:
    """Make a straight, curved, S-shaped or hooked bar along x, perhaps tapered."""
    kind = int(rng.integers(5))
    bend = rng.uniform(0.1, 0.45) * length * rng.choice([-1, 1])
    if kind <= 1:
        path = np.column_stack([np.linspace(0, length, 4), np.zeros(4)])
    elif kind == 2:
        path = shapes.bezier((0, 0), (length / 2, 2 * bend), (length, 0), segments=9)
    elif kind == 3:
        path = shapes.bezier((0, 0), (length / 3, bend), (2 * length / 3, -bend), (length, 0), segments=11)
    else:
        radius = max(rng.uniform(0.12, 0.3) * length, 0.9 * width)
        hook = shapes.arc(radius, -90, rng.uniform(30, 130), length - radius, radius, segments=8)
        path = np.vstack([[0, 0], [0.5 * (length - radius), 0], hook])
    scales = None
    if rng.random() < 0.5:
        scales = np.interp(np.linspace(0, 1, len(path)), [0, 0.5, 1], rng.uniform(0.45, 1.0, 3))
    return swept(path, section(rng, width, height), scales).centred()


def loop(rng: Rng, width: float, depth: float, thickness: float, height: float) -> Solid:
    """Make a closed bar around an ellipse, a rounded rectangle or something between, flat in xy."""
    t = np.linspace(0, 2 * np.pi, 14, endpoint=False)
    e = rng.uniform(0.5, 1.0)
    x, y = (np.sign(f(t)) * np.abs(f(t)) ** e for f in (np.cos, np.sin))
    y *= 1 + rng.uniform(-0.3, 0.3) * x
    path = np.column_stack([(width - thickness) / 2 * x, (depth - thickness) / 2 * y])
    return swept(path, section(rng, thickness, height), closed=True).centred()


def handle(rng: Rng, span: float, reach: float, thickness: float) -> Solid:
    """Make a D-shaped bar that starts at (0, −span/2), bulges to x = ``reach`` and ends at (0, span/2)."""
    power = rng.uniform(0.5, 1.0)
    t = np.linspace(-np.pi / 2, np.pi / 2, 9)
    path = np.column_stack([reach * np.abs(np.cos(t)) ** power, span / 2 * np.sin(t)])
    return swept(path, section(rng, thickness, thickness * rng.uniform(0.8, 1.8)))
