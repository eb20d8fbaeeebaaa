"""Baked goods, sweets and other food without a package."""

from __future__ import annotations

import numpy as np
from shapely.geometry.base import BaseGeometry

from grasp_bench.workshop.household.forms import sectors
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Floats,
    Mesh,
    arc,
    box,
    cylinder,
    deform,
    difference,
    ellipsoid,
    extrude,
    hull,
    intersection,
    loft,
    move,
    polygon,
    rect,
    revolve,
    rotate,
    rounded,
    rounded_box,
    sphere,
    spline,
    star,
    superellipsoid,
    sweep,
    torus,
)


@household(category="egg", family="food", mass=0.058, material="ceramic",
           source="EU 589/2008 egg, weight class M (53-63 g): Ø44 x 57 mm, 58 g")
def egg() -> list[Part]:
    t = np.linspace(0, np.pi, 29)
    z = -28.5 * np.cos(t)
    r = 22 * np.sin(t) * (1 + 0.10 * np.cos(t))
    body = revolve(np.column_stack([np.maximum(r, 0), z]), 44)
    return [Part(rotate(body, y=90), "#d9a878", "fruit", "convex")]


@household(category="bread", family="food", mass=0.06, material="bread",
           source="common butter croissant (bakery data): about 130 x 82 x 45 mm, 60 g")
def croissant() -> list[Part]:
    segments = 7
    angle = np.radians(np.linspace(-172, -8, 8 * segments + 1))
    path = np.column_stack([58 * np.cos(angle), 62 * np.sin(angle), np.zeros_like(angle)])
    middle = np.abs(np.linspace(-1, 1, len(angle)))
    pieces = []
    for i in range(segments):
        # Every turn of the dough is a step that overlaps the next one outwards.
        inside = slice(8 * i, 8 * i + 9)
        if i == segments // 2:
            step = 0.5 * np.abs(np.linspace(-1, 1, 9))
        else:
            step = np.linspace(1, 0, 9) if i < segments // 2 else np.linspace(0, 1, 9)
        radius = 27 * (1 - 0.72 * middle[inside] ** 1.5) * (1 - 0.22 * step)
        pieces.append(sweep(1.0, path[inside], scales=np.column_stack([radius, 0.92 * radius]), segments=20))
    floor = move(box(300, 300, 40), z=-40 - 18)
    colors = ("#d9983f", "#c47f2e")
    return [Part(difference(piece, floor), colors[i % 2], "bread", "convex")
            for i, piece in enumerate(pieces)]


@household(category="bread", family="food", mass=0.09, material="bread",
           source="common demi-baguette roll (bakery data): 175 x 62 x 48 mm, 90 g")
def baguette_roll() -> list[Part]:
    body = superellipsoid(87, 31, 26, 0.9, 0.75, 36)
    loaf = difference(body, move(box(300, 300, 40), z=-40 - 18))
    parts = [Part(loaf, "#c98236", "bread", "convex")]
    for x in (-48, -16, 16, 48):
        slash = move(rotate(ellipsoid(23, 6.5, 30, 20), z=35), x)
        crust = intersection(slash, superellipsoid(87.8, 31.8, 26.8, 0.9, 0.75, 36))
        parts.append(Part(intersection(crust, move(box(300, 300, 40), z=14)), "#f0d9a6", "bread", "convex"))
    return parts


@household(category="cake", family="food", mass=0.085, material="bread",
           source="standard cupcake case (Ø50 mm base, 38 mm high): Ø69 x 78 mm, 85 g iced")
def cupcake() -> list[Part]:
    liner = extrude(star(28, 25, 23.5), 40, taper=1.32)
    crumb = move(cylinder(32, 5, 36, top=33), z=39)
    swirl = move(extrude(rounded(star(6, 34, 25), 4, 2), 34, twist=170, taper=0.22, steps=22), z=43)
    cherry = move(sphere(8.5, 24), z=80)
    stem = sweep(1.2, spline([(0, 0, 85), (1, 0, 93), (6, 0, 101)], 6), segments=8)
    return [Part(liner, "#4a9ac4", "paper", "convex"), Part(crumb, "#b9793a", "bread", "convex"),
            Part(swirl, "#f6c6d3", "bread", "convex"), Part(cherry, "#b3122a", "fruit", "convex"),
            Part(stem, "#4f7d35", "fruit", "convex")]


@household(category="cheese", family="food", mass=0.12, material="wax",
           source="common prepacked Emmental wedge (retail data): 110 x 53 x 40 mm, about 120 g")
def cheese_wedge() -> list[Part]:
    half = 14.0
    sector = polygon(np.vstack([[(0, 0)], arc(107, -half, half, segments=10)]))
    crust = polygon(np.vstack([arc(106, -half, half, segments=10), arc(110, half, -half, segments=10)]))
    holes = [(90, -6, 40, 9), (66, 8, 41, 8), (42, -2, 39, 5), (95, 17, 38, 5), (80, -23, 20, 9),
             (54, -14, 26, 6), (100, -26, 32, 5), (60, -18, 8, 5), (86, 24, 22, 10), (58, 15, 16, 7),
             (38, -8, 14, 4), (70, 18, 32, 5)]
    body = difference(extrude(sector, 40), *(move(sphere(r, 16), x, y, z) for x, y, z, r in holes))
    return [Part(body, "#f2c84b", "wax", "convex"), Part(extrude(crust, 40), "#c8892b", "wax", "convex")]


@household(category="ice_cream", family="food", mass=0.075, material="wax",
           source="common 73 ml ice pop (retail data): 47 x 22 x 90 mm on a 114 x 10 x 2 mm stick, 75 g")
def popsicle() -> list[Part]:
    outline = polygon(np.vstack([[(0, -23), (68, -23)], arc(23, -90, 90, x=68, segments=14), [(0, 23)]]))
    grooves = [move(ellipsoid(34, 4.2, 3.5, 12), 40, y, z) for y in (-9, 9) for z in (0, 22)]
    bar = difference(_soft(outline, 22, 3), *grooves)

    def layer(start: float, stop: float) -> Mesh:
        return intersection(bar, move(box(stop - start, 100, 100), x=(start + stop) / 2, z=-20))

    stick = difference(move(extrude(rect(114, 10, 4.9), 3), x=10, z=9.5), hull(bar))
    return [Part(layer(-1, 30), "#f5c530", "wax", "convex"), Part(layer(30, 60), "#f07c28", "wax", "convex"),
            Part(layer(60, 100), "#d92b3a", "wax", "convex"), Part(stick, "#d9b98a", "wood", "convex")]


def _soft(outline: BaseGeometry, height: float, radius: float) -> Mesh:
    """Convex plane figure extruded, with its edges rounded in two steps."""
    layers = [(radius, 0), (0.35 * radius, 0.3 * radius), (0, radius)]
    slabs = [move(extrude(outline.buffer(-inset), height - 2 * z), z=z) for inset, z in layers]
    return hull(*slabs)


@household(category="donut", family="food", mass=0.06, material="bread",
           source="common ring doughnut (bakery data): Ø71 x 30 mm, about 60 g")
def iced_donut() -> list[Part]:
    def flatten(v: Floats) -> Floats:
        v[:, 2] *= 0.85
        return v

    dough = deform(torus(22, 13.2, 40, 18), flatten)
    icing = revolve(arc(13.9, 6, 174, x=22, segments=14) * [1, 0.85], 60)

    def drip(v: Floats) -> Floats:
        theta, radius = np.arctan2(v[:, 1], v[:, 0]), np.hypot(v[:, 0], v[:, 1])
        low = v[:, 2] < 4
        v[:, 2] += np.where(low, 1.6 * np.cos(9 * theta) * np.sign(radius - 22), 0)
        return v

    icing = deform(icing, drip)
    colors = ("#f7e04a", "#49a7e0", "#ffffff", "#7ac74f", "#9a5fd0")
    sprinkles = []
    for i in range(10):
        bearing, tilt = 2.4 * i, (-28, 8, 34)[i % 3]
        grain = rotate(hull(move(sphere(1.4, 8), y=-3), move(sphere(1.4, 8), y=3)), z=53 * i)
        grain = rotate(move(grain, z=14.3), y=tilt)
        grain = move(deform(grain, flatten), x=22)
        sprinkles.append(Part(rotate(grain, z=np.degrees(bearing)), colors[i % 5], "chocolate", "convex"))
    dough = difference(dough, icing)
    return [*(Part(s, "#c98c4a", "bread", "convex") for s in sectors(dough, 11)),
            *(Part(s, "#ee7fa8", "bread", "convex") for s in sectors(icing, 11)), *sprinkles]


@household(category="chocolate_bar", family="food", mass=0.15, material="chocolate",
           source="common 150 g thick block bar (retail data): 150 x 52 x 17 mm, half unwrapped")
def chocolate_bar() -> list[Part]:
    base = move(box(76, 48, 8), x=37)
    pieces = [move(_frustum(21, 21, 8), 8.5 + 23.5 * i + 4, 23.5 * (j - 0.5), 7) for i in range(3)
              for j in range(2)]
    teeth = [(-3, -25.4), *((13 + 4 * (i % 2), -25.4 + 5.08 * i) for i in range(11)), (-3, 25.4)]
    foil = extrude(polygon(teeth), 16.2)
    sleeve = move(rounded_box(74, 52, 17, 1.5, 1), x=-37, z=-0.5)
    band = move(box(40, 52.6, 17.6), x=-37, z=-0.8)
    tail = move(rounded_box(4, 50, 6, 1, 1), x=-75, z=5)
    blocks = [Part(difference(piece, foil), "#66381d", "chocolate", "convex") for piece in pieces]
    return [Part(difference(base, foil), "#5a3018", "chocolate", "convex"), *blocks,
            Part(foil, "#c9ccd1", "aluminium", "convex"), Part(sleeve, "#7a2fa0", "chocolate", "convex"),
            Part(band, "#f0c23a", "chocolate", "convex"), Part(tail, "#c9ccd1", "aluminium", "convex")]


def _frustum(x: float, y: float, height: float) -> Mesh:
    """Square block with sloping sides."""
    return extrude(rect(x, y), height, taper=0.72)


@household(category="candy", family="food", mass=0.011, material="plastic",
           source="common twist-wrapped fruit bonbon (retail data): Ø20 x 70 mm, 11 g")
def wrapped_candy() -> list[Part]:
    t = np.linspace(-1, 1, 21)
    profile = np.column_stack([10 * np.sqrt(np.maximum(1 - np.abs(t) ** 2.6, 0)), 17 * t])
    core = revolve(profile, 32)
    parts = []
    for i, color in enumerate(("#d8232f", "#f7f3ea", "#d8232f", "#f7f3ea", "#d8232f")):
        cut = intersection(core, move(box(50, 50, 6.8), z=-17 + 6.8 * i))
        parts.append(Part(cut, color, "plastic", "convex"))
    pleats = star(9, 1.0, 0.72)
    flat = np.asarray(pleats.exterior.coords)[:-1]
    levels = [(15, 3.4), (18, 3.0), (21, 4.2), (27, 8.5), (35, 12.5)]
    fan = loft([np.column_stack([flat * r, np.full(len(flat), z)]) for z, r in levels])
    for mesh in (fan, rotate(fan, x=180)):
        parts.append(Part(mesh, "#d8232f", "plastic", "convex"))
    return [Part(rotate(p.mesh, y=90), p.color, p.material, p.threshold) for p in parts]
