"""Things one drinks from, and the helpers for thrown and blown shapes that crockery shares."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from shapely.geometry import Polygon
from shapely.geometry import box as shapely_box

from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Figure,
    Floats,
    Mesh,
    box,
    capsule,
    circle,
    cylinder,
    deform,
    difference,
    ellipse,
    extrude,
    intersection,
    move,
    rect,
    regular,
    revolve,
    ring,
    rotate,
    spin,
    spline,
    star,
    sweep,
    torus,
    vessel,
)

GLASS, CLEAR = "#a9cbd6", "#cfe3e8"


def solid(profile: ArrayLike, inset: float = 0.0, segments: int = 48) -> Mesh:
    """Filled body of revolution under an outer profile of (r, z), shrunk by ``inset``."""
    p = np.asarray(profile, dtype=float)
    # Shrunk as the whole cross-section, both sides of the axis, so that no hole opens along it.
    section = Polygon(np.vstack([p, p[::-1] * [-1, 1]])).buffer(0).buffer(-inset, join_style="mitre")
    return revolve(section.intersection(shapely_box(0, -1e3, 1e3, 1e3)), segments)


def ear(points: ArrayLike, width: float, thick: float, core: Mesh, steps: int = 20, sides: int = 12) -> Mesh:
    """Handle of oval section along (x, z) points, cut off where it enters ``core``."""
    path = np.insert(spline(points, steps), 1, 0.0, axis=1)
    return difference(sweep(ellipse(thick / 2, width / 2, segments=sides), path, up=(0, 1, 0)), core)


def split(mesh: Mesh, height: float) -> tuple[Mesh, Mesh]:
    """The parts of a mesh below and above a height."""
    slab = move(box(1000, 1000, 1000), z=height - 1000)
    return intersection(mesh, slab), difference(mesh, slab)


def staves(mesh: Mesh, material: str, *bands: tuple[float, int, str], turn: float = 0.0) -> list[Part]:
    """A hollow body as nearly convex pieces, which keep a thin wall truer than cutting by planes does.

    Args:
        mesh: body about the z axis.
        material: of all pieces.
        bands: (top, count, colour) of each slice from below, cut into ``count`` like sectors.
        turn: direction of the first sector's middle.
    """
    parts = []
    for top, count, color in bands:
        band, mesh = split(mesh, top)
        half = np.pi / count
        corner = 1000 * np.array([np.cos(half), np.sin(half)])
        wedge = move(extrude(np.stack([np.zeros(2), corner * [1, -1], corner]), 2000), z=-1000)
        pieces = [band] if count == 1 else [
            intersection(band, rotate(wedge, z=turn + i * 360 / count)) for i in range(count)]
        parts += [Part(piece, color, material, "convex") for piece in pieces]
    return parts


def patch(figure: Figure, profile: ArrayLike, angle: float, z: float, proud: float = 0.5) -> Mesh:
    """Sticker of a plane figure on a body of revolution, seen upright from direction ``angle``."""
    stick = move(rotate(rotate(extrude(figure, 300), x=90), z=angle + 90), z=z)
    return intersection(stick, difference(solid(profile, -proud), solid(profile, 1.0)))


def pour_lip(mesh: Mesh, reach: float, low: float, high: float, half_angle: float = 35.0) -> Mesh:
    """Draw the rim out to a pouring lip towards -x, growing from height ``low`` to ``high``."""

    def pull(v: Floats) -> Floats:
        off = np.abs(np.arctan2(v[:, 1], -v[:, 0])) / np.radians(half_angle)
        rise = np.clip((v[:, 2] - low) / (high - low), 0, 1)
        v[:, 0] -= reach * np.cos(np.clip(off, 0, 1) * np.pi / 2) ** 2 * rise**1.5
        return v

    return deform(mesh, pull)


@household(category="mug", family="kitchen", mass=0.33, material="ceramic",
           source="common 11 oz stoneware mug: Ø82 x 95 mm, 330 g (retail data sheets)")
def coffee_mug() -> list[Part]:
    body = vessel([(36, 0), (40, 3), (41, 10), (41, 95)], wall=4, floor=6)
    path = spline([(38, 0, 78), (60, 0, 76), (72, 0, 52), (62, 0, 26), (38, 0, 20)], 20)
    handle = difference(sweep(5, path, segments=12), move(cylinder(37.5, 120), z=-5))
    return [Part(body, "#2f5d8a", "ceramic"), Part(handle, "#2f5d8a", "ceramic")]


@household(category="mug", family="kitchen", mass=0.36, material="ceramic",
           source="typical retail 350 ml conical stoneware latte mug: rim Ø96, foot Ø60, height 90 mm, 360 g")
def latte_mug() -> list[Part]:
    profile = [(28, 0), (30, 2), (36, 30), (48, 90)]
    body = vessel(profile, wall=4.5, floor=9, segments=42)
    handle = ear([(40, 80), (66, 84), (86, 70), (80, 48), (58, 34), (30, 29)], 14, 8, solid(profile, 1.5))
    glaze = "#3b8a86"
    return [*staves(body, "ceramic", (9, 1, "#c49a6c"), (90, 14, glaze)), Part(handle, glaze, "ceramic")]


@household(category="mug", family="kitchen", mass=0.15, material="steel",
           source="typical retail 8 cm enamel camping mug: Ø88 x 80 mm, 150 g, sheet thickened to 2.4 mm")
def enamel_camping_mug() -> list[Part]:
    profile = [(41, 0), (43, 2.5), (44, 80)]
    body = vessel(profile, wall=2.4, segments=36)
    rim = difference(move(torus(42.8, 2.6, segments=36, sides=10), z=80), body)
    path = spline([(40, 70), (54, 71), (70, 66), (73, 52), (66, 34), (54, 23), (40, 18)], 24)
    strap = sweep(rect(4, 13, 1.5), np.insert(path, 1, 0, axis=1), up=(0, 1, 0))
    handle = difference(strap, solid(profile, 1.2))
    white, blue = "#f3f1e8", "#1d3a7a"
    return [*staves(body, "steel", (2.4, 1, white), (80, 12, white)), *staves(rim, "steel", (90, 12, blue)),
            Part(handle, blue, "steel", 0.08)]


@household(category="glass", family="kitchen", mass=0.2, material="glass",
           source="typical retail 22 cl nine-sided bistro tumbler: rim Ø72, height 90 mm, 200 g")
def faceted_tumbler() -> list[Part]:
    body = vessel([(25, 0), (26, 1.5), (36, 90)], wall=4.5, floor=11, segments=54)
    # The facets lean out more than the wall does, so that they end in arches below the rim.
    facets = extrude(regular(9, 24 / np.cos(np.pi / 9)), 90, taper=36.6 / 24)
    return staves(intersection(body, facets), "glass", (11, 1, GLASS), (90, 18, GLASS))


@household(category="glass", family="kitchen", mass=0.13, material="glass",
           source="ISO 3591 tasting glass: 155 high, bowl Ø65 x 100, rim Ø46, stem Ø9, base Ø65 mm; 130 g")
def wine_glass() -> list[Part]:
    foot = [(32.5, 0), (32.5, 2.2), (14, 4.5), (7, 9), (4.8, 18), (4.5, 40), (6, 50), (9, 56)]
    outline = spline([(8, 55), (24, 64), (32, 80), (31.5, 100), (27.5, 125), (23, 155)], 12)
    bowl = vessel(outline, wall=2, floor=4, segments=36)
    return [Part(solid(foot, segments=36), CLEAR, "glass"),
            *staves(bowl, "glass", (59, 1, CLEAR), (84, 12, CLEAR), (155, 12, CLEAR))]


@household(category="glass", family="kitchen", mass=0.48, material="glass",
           source="typical retail 0.3 l fluted glass beer mug: Ø78 x 125 mm, handle to 112 mm, 480 g")
def beer_mug() -> list[Part]:
    profile = [(36, 0), (39, 3), (39, 10), (37, 15), (36.5, 60), (36.5, 104), (37.5, 112), (38, 125)]
    flute = move(capsule(14, 54, segments=16), x=47.6, z=34)
    body = difference(vessel(profile, wall=5, floor=16, segments=60), *spin(flute, 12))
    handle = ear([(30, 112), (56, 114), (71, 96), (72, 60), (60, 32), (30, 25)], 15, 13, solid(profile, 2.5))
    return [*staves(body, "glass", (16, 1, GLASS), (125, 24, GLASS), turn=7.5),
            Part(handle, GLASS, "glass", 0.06)]


@household(category="cup", family="kitchen", mass=0.19, material="ceramic",
           source="typical retail 70 ml espresso cup: Ø64 x 58 mm, 160 g, with 30 ml espresso")
def espresso_cup() -> list[Part]:
    profile = spline([(17, 0), (23, 5), (29, 20), (31, 36), (32, 58)], 8)
    body = vessel(profile, wall=4.5, floor=8, segments=42)
    espresso = intersection(solid(profile, 4.2, segments=42), move(box(90, 90, 34), z=7))
    handle = ear([(24, 47), (42, 50), (51, 40), (45, 27), (24, 22)], 9, 7, solid(profile, 2))
    cream = "#e9e4d8"
    # Below the surface of the coffee the cup is as good as solid.
    return [*staves(body, "ceramic", (41, 1, cream), (58, 14, cream)), Part(handle, cream, "ceramic"),
            Part(espresso, "#6f3e1c", "liquid", "convex")]


@household(category="cup", family="kitchen", mass=0.17, material="cardboard",
           source="typical retail 6 oz paper cup: rim Ø72, foot Ø50, height 80 mm; with 155 ml of coffee")
def paper_coffee_cup() -> list[Part]:
    cone = [(25, 0), (35, 80)]
    foot, upper = split(solid(cone), 20)
    upper = split(upper, 58)[1]
    sleeve = split(split(solid(cone, -0.9), 20)[1], 58)[0]
    lid = revolve([(0, 79), (36, 79), (36, 83), (33.5, 84), (31.5, 93), (28, 93), (27, 89), (0, 89)])
    sip = move(extrude(ellipse(2.2, 5), 2), x=21, z=87.5)
    logo = patch(circle(12), [(25.9, 0), (35.9, 80)], -5, 40)
    return [Part(foot, "#f4f4f0", "liquid", "convex"), Part(sleeve, "#b07a45", "liquid", "convex"),
            Part(upper, "#f4f4f0", "liquid", "convex"), Part(lid, "#26221f", "plastic", "convex"),
            Part(sip, "#e8e4dc", "plastic", "convex"), Part(logo, "#1f6b3f", "paper", "convex")]


@household(category="thermos", family="kitchen", mass=0.48, material="steel",
           source="typical retail 0.5 l stainless vacuum flask with handle: Ø70 x 245 mm, 480 g")
def thermos_flask() -> list[Part]:
    body = [(35, 8), (35, 160), (33, 172), (27, 186)]
    grip = [(30, 150), (52, 150), (60, 138), (60, 80), (52, 68), (30, 68)]
    handle = ear(grip, 16, 8, solid(body, 1), steps=28)
    cup = [(28, 194), (31, 196), (30, 236), (27, 243), (22, 245)]
    return [Part(cylinder(35.4, 9), "#b9bcc0", "steel", "convex"),
            Part(solid(body), "#22543d", "steel", "convex"),
            Part(move(cylinder(27.4, 9), z=185.5), "#23262a", "plastic", "convex"),
            Part(solid(cup), "#b9bcc0", "steel", "convex"), Part(handle, "#23262a", "plastic"),
            Part(move(ring(35.5, 34, 7), z=30), "#b9bcc0", "steel", "convex"),
            Part(move(ring(31.3, 29, 4), z=203), "#8d9196", "steel", "convex")]


@household(category="baby_bottle", family="kitchen", mass=0.18, material="plastic",
           source="typical retail 150 ml baby bottle: Ø56 x 165 mm, 60 g, with 120 ml of milk")
def baby_bottle() -> list[Part]:
    outline = [(25, 0), (28, 4), (28, 96), (25, 108), (20, 112)]
    milk, empty = split(solid(outline), 74)
    collar = move(extrude(star(28, 26, 24.8), 17), z=110)
    nipple = [(20, 126), (18, 132), (11, 140), (7, 147), (6.5, 156), (4, 163), (0, 165)]
    teat = solid(spline(nipple, 16), segments=32)
    marks = [patch(rect(16 if i % 2 else 10, 2), outline, -5, 20 + 14 * i) for i in range(6)]
    return [Part(milk, "#f7f2e6", "liquid", "convex"), Part(empty, "#bfe0ea", "plastic", "convex"),
            Part(collar, "#3d8fd1", "plastic", "convex"), Part(teat, "#e3b873", "silicone"),
            *(Part(m, "#2b5fa0", "plastic", "convex") for m in marks)]
