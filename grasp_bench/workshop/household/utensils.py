"""Hand-held cooking utensils: spoons, spatulas, whisk, tongs, brushes and the like.

Lying utensils are modelled along x, handle towards +x.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Figure,
    Mesh,
    arc,
    box,
    circle,
    cylinder,
    difference,
    ellipsoid,
    extrude,
    hull,
    intersection,
    loft,
    mirror,
    move,
    polygon,
    prism,
    rect,
    revolve,
    rotate,
    rounded,
    scale,
    sphere,
    spline,
    star,
    sweep,
)

STEEL = "#a6adb4"
BLACK = "#2b2b2e"
BEECH = "#d3a76c"


# ---------------------------------------------------------------- shapes utensils share

def grip(stations: ArrayLike, sides: int = 16, power: float = 2.6, steps: int = 4) -> Mesh:
    """Handle along x through stations (x, width, height, z), of superelliptic section."""
    s = np.asarray(stations, dtype=float)
    index = np.arange(len(s))
    fine = PchipInterpolator(index, s)(np.linspace(0, index[-1], steps * index[-1] + 1))
    t = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    c, d = (np.sign(a) * np.abs(a) ** (2 / power) / 2 for a in (np.cos(t), np.sin(t)))
    return loft([np.column_stack([np.full(sides, x), w * c, z + h * d]) for x, w, h, z in fine])


def straight_grip(start: float, stop: float, width: float, height: float, power: float = 2.6) -> Mesh:
    """Convex handle with rounded ends."""
    e, n = min(width, height) / 2, stop - start
    return grip([(start, width - e, height - e, 0), (start + e / 2, width, height, 0),
                 (start + n / 2, width, height, 0), (stop - e, width, height, 0),
                 (stop - e / 4, width - e / 1.5, height - e / 1.5, 0), (stop, width / 3, height / 3, 0)],
                power=power, steps=2)


def turned(profile: Figure, segments: int = 20) -> Mesh:
    """Body turned about the x axis from a closed profile of (radius, x)."""
    return rotate(revolve(profile, segments), y=90)


def rod(radius: float, start: float, stop: float, segments: int = 12) -> Mesh:
    """Round bar along x."""
    return move(rotate(cylinder(radius, stop - start, segments), y=90), x=start)


def bowl(rx: float, ry: float, depth: float, wall: float, segments: int = 32) -> Mesh:
    """Lower half of a hollow ellipsoid, its rim at z = 0."""
    inner = ellipsoid(rx - wall, ry - wall, depth - wall, segments)
    return difference(ellipsoid(rx, ry, depth, segments), inner, box(4 * rx, 4 * ry, 2 * depth))


# ---------------------------------------------------------------- spoons

@household(category="spoon", family="utensils", mass=0.045, material="wood",
           source="beech cooking spoon: 280 mm long, bowl 74 x 53 mm, handle Ø12 mm, 45 g (retail)")
def wooden_spoon() -> list[Part]:
    head = intersection(ellipsoid(38, 27, 13, 40), move(box(80, 60, 20), z=-17))
    head = difference(head, move(ellipsoid(33, 22.5, 11, 40), z=3))
    handle = turned([(0, 30), (5, 31), (6, 60), (5.5, 140), (6.5, 230), (5.5, 238), (3, 242), (0, 243)])
    handle = difference(move(handle, z=-1), move(ellipsoid(37, 26, 12, 40), z=-0.5))
    return [Part(head, BEECH, "wood", 0.1), Part(handle, BEECH, "wood", "convex")]


@household(category="spoon", family="utensils", mass=0.16, material="steel",
           source="common stainless steel ladle with plastic grip: 290 mm, bowl Ø84 mm, 160 g (retail data)")
def soup_ladle() -> list[Part]:
    head = rotate(bowl(42, 42, 34, 2.2), y=40)
    neck = rod(4, 31, 130)
    handle = straight_grip(118, 245, 24, 17)
    return [Part(head, STEEL, "steel", 0.15), Part(move(neck, z=-28), STEEL, "steel", "convex"),
            Part(move(handle, z=-28), BLACK, "plastic", "convex")]


@household(category="spoon", family="utensils", mass=0.11, material="plastic",
           source="common nylon slotted serving spoon: 285 mm, bowl 96 x 68 mm, 110 g (retail data)")
def slotted_spoon() -> list[Part]:
    head = bowl(48, 34, 15, 2.6, 40)
    slots = [move(extrude(rect(length, 5, 2.4), 40), y=y, z=-30)
             for y, length in ((-20, 36), (-10, 54), (0, 60), (10, 54), (20, 36))]
    neck = sweep(4, spline([(45, 0, -2.5), (60, 0, 1), (90, 0, 4), (140, 0, 5)], 8), segments=12)
    handle = move(straight_grip(130, 237, 24, 16), z=5)
    return [Part(difference(head, *slots), BLACK, "plastic", 0.1), Part(neck, BLACK, "plastic", "convex"),
            Part(handle, "#1fa3a3", "silicone", "convex")]


@household(category="spoon", family="utensils", mass=0.022, material="plastic",
           source="15 ml measuring tablespoon: inner bowl Ø38.6 mm, 125 mm long, 22 g (retail data)")
def measuring_spoon() -> list[Part]:
    cup = bowl(21.5, 21.5, 21.5, 2.2)
    outline = polygon([(20, -6), (45, -7), (90, -9.5), (103, -7), (103, 7), (90, 9.5), (45, 7), (20, 6)])
    flat = rounded(outline, 3).difference(circle(4, x=94, segments=16))
    handle = difference(move(extrude(flat, 8), z=-8), sphere(20.9, 32))
    label = move(prism(rect(34, 8, 3), 1.3, 0.2), x=62, z=-0.9)
    return [Part(cup, "#e2574c", "plastic", 0.15), Part(handle, "#e2574c", "plastic", "convex"),
            Part(label, "#f7f3ea", "plastic", "convex")]


# ---------------------------------------------------------------- spatulas

@household(category="spatula", family="utensils", mass=0.12, material="plastic",
           source="common nylon slotted turner: 290 mm, blade 85 x 95 mm, 120 g (retail data)")
def slotted_turner() -> list[Part]:
    outline = rounded(polygon([(-100, -44), (-100, 40), (-30, 36), (0, 14), (0, -14), (-30, -36)]), 5)
    for y, start in ((-24, -35), (-8, -25), (8, -25), (24, -35)):
        outline = outline.difference(rect(-start + 50, 6, 2.9, x=start - 22, y=y))
    blade = extrude(outline, 2.6)
    neck = sweep(rect(15, 7, 3), spline([(-14, 0, 3), (6, 0, 7), (22, 0, 23), (50, 0, 34), (90, 0, 42)], 14))
    handle = move(rotate(straight_grip(0, 112, 26, 17), y=-11), x=80, z=40)
    return [Part(blade, BLACK, "plastic", "convex"), Part(neck, BLACK, "plastic", 0.1),
            Part(handle, "#d9772b", "silicone", "convex")]


@household(category="spatula", family="utensils", mass=0.085, material="wood",
           source="common silicone scraper with beech handle: 270 mm, blade 58 x 90 mm, 85 g (retail data)")
def silicone_scraper() -> list[Part]:
    outline = rounded(polygon([(-90, -27), (-80, 29), (-10, 29), (0, 20), (0, -20), (-10, -29), (-76, -29)]),
                      9)
    blade = prism(outline, 9, 3)
    socket = grip([(-42, 5, 9, 4.5), (-36, 15, 12, 5), (-8, 24, 17, 6), (6, 24, 18, 7), (9, 19, 14, 7)])
    handle = move(turned([(0, 4), (7, 4), (7.5, 60), (8.5, 150), (7, 172), (4, 178), (0, 180)]), z=7)
    return [Part(blade, "#c8322f", "silicone", "convex"), Part(socket, "#c8322f", "silicone", "convex"),
            Part(handle, BEECH, "wood", "convex")]


# ---------------------------------------------------------------- stirring, turning, mashing

@household(category="whisk", family="utensils", mass=0.14, material="steel",
           source="common stainless steel balloon whisk: 280 mm, balloon Ø66 mm, 140 g (retail data)")
def balloon_whisk() -> list[Part]:
    half = [(0, 4), (-25, 8), (-70, 22), (-115, 32), (-148, 25), (-162, 10)]
    loop = spline([*half, (-164, 0), *[(x, -y) for x, y in half[::-1]]], 26)
    wire = sweep(1.3, np.insert(loop, 2, 0, axis=1), segments=6)
    wires = [Part(rotate(wire, x=a), STEEL, "steel") for a in (0, 60, 120)]
    collar = rod(10, -4, 22, 20)
    handle = turned([(0, 18), (12, 18), (12, 24), (10.5, 45), (13, 80), (12, 108), (8, 115), (0, 116)])
    return [*wires, Part(collar, STEEL, "steel", "convex"), Part(handle, "#33475b", "plastic", "convex")]


@household(category="tongs", family="utensils", mass=0.15, material="steel",
           source="common 9 inch scallop tongs with silicone tips: 235 mm, 150 g (retail data)")
def kitchen_tongs() -> list[Part]:
    path = spline([(0, 9, 0), (50, 21, 0), (120, 30, 0), (172, 31, 0)], 10)
    arm = sweep(rect(3, 20, 1.2), path)
    pad = prism(rect(86, 26, 8), 9, 2.5)
    pad = move(rotate(rotate(pad, x=90), z=6.5), x=98, y=32)
    scallop = star(10, 17, 14.6).buffer(1.2, quad_segs=2)
    shell = difference(scale(extrude(scallop, 8, taper=0.75), 1.5, 0.95, 1), ellipsoid(20, 12, 5, 20))
    tip = move(rotate(rotate(shell, x=-90), z=-6), x=186, y=24)
    back = sweep(rect(3, 20, 1.2), np.insert(arc(9, 90, 270, segments=8), 2, 0, axis=1))
    ring_ = sweep(1.8, np.insert(arc(9, 30, 330, x=-20, segments=14), 2, 0, axis=1), segments=8)
    parts = [Part(back, STEEL, "steel", 0.1), Part(ring_, STEEL, "steel", 0.2)]
    for side in (lambda m: m, lambda m: mirror(m, "y")):
        parts += [Part(side(arm), STEEL, "steel"), Part(side(pad), BLACK, "plastic", "convex"),
                  Part(side(tip), "#c8322f", "silicone", "convex")]
    return parts


@household(category="rolling_pin", family="utensils", mass=0.26, material="wood",
           source="small beech pastry rolling pin: Ø46 x 180 mm barrel, 300 mm with handles, 260 g (retail)")
def rolling_pin() -> list[Part]:
    barrel = turned([(0, -90), (21, -90), (23, -88), (23, 88), (21, 90), (0, 90)], 40)
    knob = turned([(0, 87), (7, 87), (7, 97), (12, 103), (14, 118), (13, 136), (9, 146), (0, 149)], 24)
    return [Part(barrel, "#e0bb85", "wood", "convex"), Part(knob, "#a9472f", "wood"),
            Part(rotate(knob, z=180), "#a9472f", "wood")]


@household(category="potato_masher", family="utensils", mass=0.2, material="plastic",
           source="common wire potato masher: 250 mm, head 90 x 74 mm, wire Ø6 mm, 200 g (retail data)")
def potato_masher() -> list[Part]:
    x = np.linspace(-37, 37, 49)
    y = 36 * np.clip(1.25 * np.sin(2 * np.pi * x / 37), -1, 1)
    head = sweep(3, np.column_stack([x, y, 0 * x + 3]), segments=8)
    stem = sweep(3, spline([(37, 0, 3), (38, 0, 30), (32, 0, 75), (12, 0, 125), (8, 0, 150)], 14), segments=8)
    top = rotate(turned([(0, 0), (13, 0), (15, 6), (12, 35), (16, 85), (14, 102), (8, 108), (0, 109)]), y=-90)
    return [Part(head, STEEL, "steel"), Part(stem, STEEL, "steel"), Part(mirror(stem), STEEL, "steel"),
            Part(move(top, z=142), BLACK, "plastic", "convex")]


@household(category="honey_dipper", family="utensils", mass=0.03, material="wood",
           source="common beech honey dipper: 160 mm, head Ø36 x 48 mm, 30 g (retail data)")
def honey_dipper() -> list[Part]:
    outline = [(0, -24), (8, -23), (14, -18), (17.5, -8), (18, 0), (17.5, 8), (14, 18), (8, 23), (0, 24)]
    profile = polygon(outline)
    for x in (-16.5, -8.3, 0, 8.3, 16.5):
        profile = profile.difference(rect(20, 3.4, x=18, y=x))
    stick = turned([(0, 22), (4.5, 22), (4, 70), (5, 118), (7, 126), (7, 131), (4, 135), (0, 136)])
    return [Part(turned(profile, 28), BEECH, "wood", "convex"), Part(stick, BEECH, "wood", "convex")]


# ---------------------------------------------------------------- brushes

@household(category="pastry_brush", family="utensils", mass=0.04, material="wood",
           source="common pastry brush with natural bristle: 210 x 38 x 14 mm, 40 g (retail data)")
def pastry_brush() -> list[Part]:
    comb = rect(54, 37, x=-27)
    for i in range(6):
        comb = comb.difference(rect(12 + 8 * (i % 2), 1.2, x=-54, y=-15 + 6 * i))
    hair = hull(move(box(4, 36, 11), x=-3, z=-5.5), move(box(1, 38, 5), x=-54, z=-2.5))
    hair = intersection(hair, move(extrude(comb, 30), z=-15))
    # The thin ferrule is filled with glue and hair: weighed as plastic.
    ferrule = move(prism(rect(26, 41, 2), 14, 1.5), x=10, z=-7)
    handle = grip([(20, 37, 12, 0), (30, 36, 13, 0), (52, 22, 13, 0), (80, 17, 13, 0), (120, 22, 14, 0),
                   (148, 23, 13, 0), (156, 16, 9, 0), (158, 8, 5, 0)], power=3)
    handle = difference(handle, move(cylinder(3.5, 40, 16), x=144, z=-20))
    return [Part(hair, "#e9dcbd", "bristle", "convex"), Part(ferrule, STEEL, "plastic", "convex"),
            Part(handle, "#b5763d", "wood")]


@household(category="dish_brush", family="utensils", mass=0.075, material="plastic",
           source="common dish washing brush: 260 mm, head Ø72 mm, 75 g (retail data)")
def dish_brush() -> list[Part]:
    tuft = star(26, 30, 26.5)
    hair = move(rotate(extrude(tuft, 26, taper=1.18), x=180), z=1)
    back = hull(move(cylinder(29, 3, 32), z=0), move(cylinder(22, 2, 32), z=9))
    handle = grip([(12, 20, 9, 8), (30, 18, 13, 9), (60, 15, 14, 14), (110, 18, 15, 20), (170, 25, 16, 20),
                   (212, 22, 15, 17), (224, 13, 9, 16), (226, 6, 5, 16)])
    handle = difference(handle, move(extrude(rect(16, 9, 4), 60), x=207, z=-10), move(cylinder(22, 10.9, 32)))
    return [Part(hair, "#f3f1e6", "bristle", "convex"), Part(back, "#2b7fc0", "plastic", "convex"),
            Part(handle, "#2b7fc0", "plastic")]
