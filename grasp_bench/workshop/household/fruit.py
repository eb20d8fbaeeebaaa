"""Fruit and vegetables, in the sizes a grocer sorts them by."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from shapely.geometry import Polygon

from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Floats,
    Mesh,
    bezier,
    box,
    deform,
    difference,
    ellipsoid,
    extrude,
    intersection,
    loft,
    move,
    polygon,
    revolve,
    rotate,
    spline,
    star,
    sweep,
    union,
    vessel,
)

STEM = "#6b4a2b"
LEAF = "#4f8f35"


def _profile(points: ArrayLike, samples: int = 36) -> Floats:
    """Smooth (r, z) curve through ``points``, kept on the right of the axis."""
    curve = spline(points, samples)
    curve[:, 0] = np.maximum(curve[:, 0], 0)
    return curve


def _turned(points: ArrayLike, segments: int = 40, samples: int = 36) -> Mesh:
    """Solid of revolution with a smooth profile that begins and ends on the axis."""
    return revolve(_profile(points, samples), segments)


def _leaf(length: float, width: float, lift: float, sag: float) -> Mesh:
    """Pointed leaf along +x from the origin, creased along its rib, 2 mm thick."""
    edge = bezier((0, 0), (0.3 * length, width), (0.7 * length, 0.6 * width), (length, 0), segments=10)
    outline = polygon(np.vstack([edge, edge[-2:0:-1] * [1, -1]]))

    def bend(v: Floats) -> Floats:
        t = v[:, 0] / length
        v[:, 2] += lift * t - sag * t**2 + 0.3 * np.abs(v[:, 1])
        return v

    return deform(extrude(outline, 2), bend, max_edge=5)


def _drape(shape: Polygon, low: float, high: float, curve: ArrayLike, edge: float = 4) -> Mesh:
    """Plane figure laid over a turned surface like a cloth, from ``low`` to ``high`` off the surface.

    ``curve`` is the (r, z) profile from the pole outwards; radii in the plane become lengths along it.
    """
    c = np.asarray(curve, dtype=float)
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(c, axis=0), axis=1))])
    tangent = np.gradient(c, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)

    def wrap(v: Floats) -> Floats:
        rho, angle, off = np.hypot(v[:, 0], v[:, 1]), np.arctan2(v[:, 1], v[:, 0]), v[:, 2] + low
        r = np.interp(rho, s, c[:, 0]) - off * np.interp(rho, s, tangent[:, 1])
        z = np.interp(rho, s, c[:, 1]) + off * np.interp(rho, s, tangent[:, 0])
        r = np.where(rho < 1e-6, 0, r)
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])

    return deform(extrude(shape, high - low), wrap, max_edge=edge)


@household(category="apple", family="food", mass=0.15, material="fruit",
           source="UNECE standard FFV-50, size class 65/70 mm: Ø68 mm, about 150 g")
def apple() -> list[Part]:
    body = _turned([(0, 5), (9, 0.5), (20, 4), (31, 22), (34, 39), (29, 55), (18, 62), (8, 59), (0, 51)])

    def lobes(v: Floats) -> Floats:
        angle = np.arctan2(v[:, 1], v[:, 0])
        v[:, :2] *= (1 + 0.02 * np.cos(5 * angle) * (1 - v[:, 2] / 62))[:, None]
        return v

    stem = sweep(1.6, spline([(0, 0, 48), (1, 0, 60), (4, 0, 74)], 8), segments=8)
    leaf = rotate(_leaf(34, 15, 12, 14), z=-30)
    return [Part(deform(body, lobes), "#c8242b", "fruit"), Part(stem, STEM, "wood", "convex"),
            Part(move(leaf, 1, 0, 63), LEAF, "fruit", "convex")]


@household(category="pear", family="food", mass=0.18, material="fruit",
           source="YCB 016_pear: Ø66 x 100 mm; UNECE FFV-51, size class 65 mm, about 180 g")
def pear() -> list[Part]:
    body = _turned([(0, 4), (8, 0.5), (18, 3), (31, 20), (33, 36), (26, 56), (18, 72), (15, 86), (10, 95),
                    (4, 97), (0, 95)])
    stem = sweep(1.8, spline([(0, 0, 92), (0.5, 0, 104), (5, 0, 116)], 8), segments=8)
    leaf = rotate(_leaf(36, 15, 10, 16), z=-40)
    return [Part(body, "#b9c13f", "fruit"), Part(stem, STEM, "wood", "convex"),
            Part(move(leaf, 0, 0, 100), LEAF, "fruit", "convex")]


@household(category="lemon", family="food", mass=0.11, material="fruit",
           source="YCB 014_lemon: 54 x 54 x 68 mm; UNECE FFV-14, size code 4 (53-62 mm), about 110 g")
def lemon() -> list[Part]:
    body = _turned([(0, 0), (4, 1), (8, 5), (20, 14), (27, 34), (20, 55), (11, 64), (6.5, 71), (3, 75),
                    (0, 75.5)])
    calyx = extrude(star(5, 5, 3), 3)
    leaf = rotate(_leaf(42, 18, -4, 8), z=90)
    lying = [Part(body, "#f2cf2b", "fruit"), Part(move(calyx, z=-2), "#5d7d33", "fruit", "convex"),
             Part(rotate(move(leaf, 0, 2, -2), x=-50), LEAF, "fruit", "convex")]
    return [Part(rotate(p.mesh, y=90), p.color, p.material, p.threshold) for p in lying]


@household(category="banana", family="food", mass=0.13, material="fruit",
           source="YCB 011_banana: 36 x 190 mm; EU 1333/2011 minimum 140 x 27 mm, about 130 g")
def banana() -> list[Part]:
    t = np.linspace(-1, 1, 33)
    angle = np.radians(-90 + 50 * t)
    path = np.column_stack([108 * np.cos(angle), 108 * np.sin(angle) + 108, np.zeros_like(t)])
    width = np.interp(t, [-1, -0.96, -0.9, -0.75, -0.4, 0.3, 0.6, 0.78, 0.86, 1],
                      [0.25, 0.3, 0.5, 0.85, 1, 1, 0.85, 0.45, 0.32, 0.34])
    corners = np.radians(90 + 72 * np.arange(5))
    ribs = spline(17 * np.column_stack([np.cos(corners), np.sin(corners)]), 20, closed=True) * 0.97

    def piece(a: int, b: int) -> Mesh:
        return sweep(ribs, path[a:b], scales=width[a:b])

    return [Part(piece(1, 28), "#f0cb35", "fruit"), Part(piece(26, 33), "#a8a63c", "fruit", "convex"),
            Part(piece(0, 3), "#3d2c1c", "fruit", "convex")]


@household(category="strawberry", family="food", mass=0.022, material="fruit",
           source="UNECE FFV-35 class Extra (at least 25 mm); large berry Ø36 x 42 mm, about 22 g")
def strawberry() -> list[Part]:
    points = [(0, 0), (4, 1), (9, 7), (14, 17), (17.5, 29), (15, 37), (8, 40.5), (0, 40)]
    curve = _profile(points, 28)
    seeds = [ellipsoid(3, 3, 3, 8)]
    heights = [6, 12, 18, 24, 30, 35]
    below = curve[:np.argmax(curve[:, 1])]
    # The seeds are the ends of thin needles that meet inside, so that they are one body.
    for row, z in enumerate(heights):
        r = float(np.interp(z, below[:, 1], below[:, 0]))
        count = 5 + min(row, 4)
        for k in range(count):
            a = 2 * np.pi * (k + row % 2 / 2) / count
            tip = np.array([(r + 0.5) * np.cos(a), (r + 0.5) * np.sin(a), z - 18.0])
            seeds.append(sweep(0.8, [tip * 0.05, tip * 0.5, tip], segments=4))
    calyx = _drape(star(7, 17, 6), -0.6, 1.5, np.vstack([[0, 40.5], [6, 41], [12, 40.5], [17, 41]]), 5)
    stem = sweep(1.5, spline([(0, 0, 38), (1, 0, 46), (4, 0, 52)], 6), segments=8)
    lying = [Part(_turned(points, 32, 28), "#d3202c", "fruit", "convex"),
             Part(move(union(*seeds), z=18), "#f0d36b", "fruit", "convex"),
             Part(calyx, LEAF, "fruit", "convex"), Part(stem, "#6fa34a", "fruit", "convex")]
    return [Part(rotate(p.mesh, y=-65), p.color, p.material, p.threshold) for p in lying]


@household(category="carrot", family="food", mass=0.11, material="fruit",
           source="UNECE FFV-10, 30-40 mm class: Ø34 x 160 mm root, about 110 g with a trimmed top")
def carrot() -> list[Part]:
    z = np.array([0, 4, 14, 40, 80, 120, 145, 155, 159, 157])
    r = np.array([0, 2, 4.2, 8, 12, 15.5, 17, 14, 7, 0])
    curve = _profile(np.column_stack([r, z]), 64)
    grooves = np.where(np.arange(len(curve)) % 7 == 3, 0.93, 1.0)
    root = revolve(curve * np.column_stack([grooves, np.ones_like(grooves)]), 28)
    edge = np.array([(-2, 0), (-2, 24), (-7, 26), (-5, 32), (-10, 36), (-6, 42), (-9, 49), (-4, 51), (0, 57)])
    frond = move(rotate(extrude(np.vstack([edge, edge[-2::-1] * [-1, 1]]), 3), x=90), y=1.5)
    tuft = [rotate(frond, y=15 * i, x=10 * (-1) ** i) for i in range(-2, 3)]
    top = union(ellipsoid(6, 6, 6, 16), *tuft)
    return [Part(rotate(root, y=90), "#ee7d22", "fruit"),
            Part(rotate(rotate(move(top, z=157), z=90), y=90), "#4c9433", "fruit", 0.2)]


@household(category="bell_pepper", family="food", mass=0.15, material="fruit",
           source="UNECE FFV-28, sweet pepper 60/70 mm: Ø70 x 85 mm, about 150 g")
def bell_pepper() -> list[Part]:
    body = _turned([(0, 8), (8, 3), (17, 0), (27, 10), (31, 30), (35, 55), (34, 68), (24, 77), (12, 73),
                    (0, 66)], 48, 40)

    def lobes(v: Floats) -> Floats:
        valley = 1 - np.abs(np.sin(2 * np.arctan2(v[:, 1], v[:, 0])))
        v[:, :2] *= (1 - 0.17 * valley**2)[:, None]
        v[:, 2] -= 4 * valley * np.cos(np.pi * v[:, 2] / 77)
        return v

    calyx = _drape(star(8, 14, 10), -2, 3, [(0, 69), (5, 70), (14, 73)], 6)
    stem = sweep(4.5, spline([(0, 0, 68), (0, 0, 80), (5, 0, 93)], 8), segments=12,
                 scales=np.linspace(1, 1.15, 9))
    return [Part(deform(body, lobes), "#c9261e", "fruit"), Part(calyx, "#4d8a34", "fruit", "convex"),
            Part(stem, "#5c9a3e", "fruit")]


@household(category="mushroom", family="food", mass=0.03, material="fruit",
           source="UNECE FFV-24, closed cup, large (45-65 mm): cap Ø54 mm, about 30 g")
def mushroom() -> list[Part]:
    cap = _turned([(0, 28), (14, 28), (20, 25), (25, 24), (27, 28), (23, 38), (14, 45), (0, 47)], 32)
    gills = revolve([(0, 22), (11, 23), (20.5, 24.3), (20.5, 28.5), (0, 28.5)], 32)
    stem = revolve(np.vstack([[0, 0], _profile([(9, 0), (11, 3), (9, 14), (10, 24)], 10), [0, 24]]), 24)
    parts = [(cap, "#c39a6b"), (gills, "#5b3a29"), (stem, "#efe6d3")]
    return [Part(rotate(mesh, y=-58), color, "fruit", "convex") for mesh, color in parts]


@household(category="corn_cob", family="food", mass=0.22, material="fruit",
           source="UNECE FFV-58, sweet corn: cob Ø47 x 175 mm, about 220 g with some husk")
def corn_cob() -> list[Part]:
    rows, kernels = 14, 15
    z = np.linspace(0, 165, 3 * kernels)
    radius = np.interp(z, *spline([(0, 20), (30, 23), (90, 22.5), (140, 17), (158, 11), (165, 5)], 40).T)
    angle = 2 * np.pi * np.arange(3 * rows) / (3 * rows)
    rings = []
    for i, (height, r) in enumerate(zip(z, radius, strict=True)):
        column = np.arange(3 * rows)
        groove = (column % 3 == 0) | ((i + column // 3 % 2) % 3 == 0)
        bumpy = r * np.where(groove, 0.91, 1.0)
        rings.append(np.column_stack([bumpy * np.cos(angle), bumpy * np.sin(angle),
                                      np.full_like(angle, height)]))
    husk = vessel(spline([(7, -26), (9, -14), (20, -4), (25.5, 14), (26.5, 40), (27, 90)], 12), 2, 22, 30)

    def leaves(v: Floats) -> Floats:
        theta, high = np.arctan2(v[:, 1], v[:, 0]), np.maximum(v[:, 2] - 5, 0)
        tip = np.abs(np.cos(1.5 * theta)) ** 1.5
        v[:, :2] *= (1 + 0.16 * (high * tip / 85) ** 2)[:, None]
        v[:, 2] = np.where(v[:, 2] > 5, 5 + high * (0.2 + 0.9 * tip), v[:, 2])
        return v

    lying = [Part(loft(rings), "#f3c93a", "fruit", "convex"),
             Part(deform(husk, leaves), "#86b04a", "fruit", "convex")]
    return [Part(rotate(p.mesh, y=90), p.color, p.material, p.threshold) for p in lying]


@household(category="avocado", family="food", mass=0.10, material="fruit",
           source="UNECE FFV-42, size code 18 (196-236 g whole): half of Ø64 x 100 mm with the stone")
def avocado_half() -> list[Part]:
    points = np.array([(0, 0), (12, 2), (27, 15), (32, 36), (27, 60), (18, 80), (12, 93), (5, 99), (0, 100)])
    outer, inner = _profile(points), _profile(points * [0.9, 0.955] + [0, 2.2])
    below = move(box(200, 200, 200), z=-200)
    stone = move(ellipsoid(15, 15, 15, 24), 36, 0, -4)

    def half(curve: Floats) -> Mesh:
        return intersection(rotate(revolve(curve, 36), y=90), below)

    return [Part(difference(half(outer), half(inner)), "#2f4a25", "fruit", "convex"),
            Part(difference(half(inner), stone), "#d5dc7c", "fruit", "convex"),
            Part(stone, "#7c4a26", "wood", "convex")]


@household(category="eggplant", family="food", mass=0.28, material="fruit",
           source="UNECE FFV-05, elongated 55-70 mm class: Ø64 x 175 mm, about 280 g")
def eggplant() -> list[Part]:
    points = [(0, 0), (14, 3), (27, 18), (32, 45), (29, 80), (23, 115), (18, 145), (13, 158), (0, 161)]
    curve = _profile(points)
    calyx = _drape(star(5, 46, 15), -0.8, 1.8, curve[::-1], 4)
    stem = sweep(5.5, spline([(0, 0, 158), (0, 0, 172), (0, 6, 190)], 10), segments=12,
                 scales=np.linspace(1, 0.9, 11))

    def bend(v: Floats) -> Floats:
        v[:, 1] += 0.0016 * np.maximum(v[:, 2] - 60, 0) ** 2
        return v

    parts = [(_turned(points), "#4a2350"), (calyx, "#5f8f3c"), (stem, "#7ba452")]
    return [Part(rotate(deform(mesh, bend), y=90), color, "fruit", "convex" if mesh is calyx else None)
            for mesh, color in parts]
