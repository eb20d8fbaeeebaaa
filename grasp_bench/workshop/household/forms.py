"""Shapes that several toys, bathroom things and wearables are made of."""

from __future__ import annotations

import manifold3d as m3
import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from grasp_bench.workshop.model import Part
from grasp_bench.workshop.shapes import (
    Figure,
    Mesh,
    box,
    capsule,
    circle,
    cylinder,
    difference,
    extrude,
    intersection,
    loft,
    move,
    prism,
    rotate,
    union,
)

BIG = 1000.0


def skin(stations: ArrayLike, steps: int = 24, sides: int = 32, power: float = 2.0) -> Mesh:
    """Smooth hull along x over superelliptic stations (x, half width, lowest z, highest z)."""
    given = np.asarray(stations, dtype=float)
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(given, axis=0), axis=1))])
    samples = PchipInterpolator(way, given)(np.linspace(0, way[-1], steps + 1))
    t = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    c, s = (np.sign(f(t)) * np.abs(f(t)) ** (2 / power) for f in (np.cos, np.sin))
    return loft(
        [
            np.column_stack([np.full(sides, x), w * c, (low + high) / 2 + (high - low) / 2 * s])
            for x, w, low, high in samples
        ]
    )


def lean(mesh: Mesh, tolerance: float = 0.05) -> Mesh:
    """The same solid with fewer faces, vertices moved by ``tolerance`` at most."""
    solid = m3.Manifold(m3.Mesh(np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.uint32)))
    raw = solid.simplify(tolerance).to_mesh()
    return Mesh(np.asarray(raw.vert_properties)[:, :3], np.asarray(raw.tri_verts), process=False)


def above(mesh: Mesh, z: float = 0.0) -> Mesh:
    """What of ``mesh`` lies above the height ``z``."""
    return intersection(mesh, move(box(BIG, BIG, BIG), z=z))


def between(mesh: Mesh, low: float, high: float) -> Mesh:
    """What of ``mesh`` lies between two heights."""
    return intersection(mesh, move(box(BIG, BIG, high - low), z=low))


def slab(mesh: Mesh, back: float, front: float) -> Mesh:
    """What of ``mesh`` lies between two places along x."""
    return intersection(mesh, move(box(front - back, BIG, BIG), x=(front + back) / 2, z=-BIG / 2))


def sectors(mesh: Mesh, count: int) -> list[Mesh]:
    """A ring about z cut into equal sectors, whose own hulls leave the hole open."""
    half = np.pi / count
    wedge = extrude([(0, 0), (BIG, -BIG * np.tan(half)), (BIG, BIG * np.tan(half))], 2 * BIG)
    return [intersection(mesh, rotate(move(wedge, z=-BIG), z=360 * i / count)) for i in range(count)]


def along_x(mesh: Mesh) -> Mesh:
    """Turn what was modelled along z (plane figure in x, y) to point along x (figure in y, z)."""
    return rotate(rotate(mesh, x=90), z=90)


def along_y(shape: Figure, width: float) -> Mesh:
    """Extrude a side view, drawn in (x, z), over ``width`` centred on y = 0."""
    return move(rotate(extrude(shape, width), x=90), y=width / 2)


def bar(radius: float, span: float, x: float = 0.0, z: float = 0.0, segments: int = 16) -> Mesh:
    """Capsule across y whose end centres lie ``span`` apart: a pair of eyes, lamps, bumpers."""
    return move(rotate(capsule(radius, span, segments), x=90), x=x, y=span / 2, z=z)


def axle(
    radius: float,
    width: float,
    track: float,
    x: float,
    z: float | None = None,
    tyre: str = "#1f1f22",
    hub: str = "#d9d9dc",
) -> list[Part]:
    """A pair of wheels on an axle; ``track`` is the distance over the outer faces."""
    z = radius if z is None else z

    def pair(r: float, w: float, span: float, bevel: float, rod: float) -> Mesh:
        disc = circle(r, segments=20)
        wheel = rotate(prism(disc, w, bevel) if bevel else extrude(disc, w), x=90)
        pin = rotate(cylinder(rod, span - 2, 8), x=90)
        return move(
            union(move(wheel, y=span / 2), move(wheel, y=w - span / 2), move(pin, y=span / 2 - 1)), x=x, z=z
        )

    hubs = pair(0.55 * radius, 2.0, track + 0.8, 0.0, 1.0)
    return [
        Part(difference(pair(radius, width, track, 0.12 * radius, 3.0), hubs), tyre, "plastic", "convex"),
        Part(hubs, hub, "plastic", "convex"),
    ]
