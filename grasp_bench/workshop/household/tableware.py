"""Things that stand on a laid table."""

from __future__ import annotations

import numpy as np

from grasp_bench.workshop.household.drinkware import ear, patch, pour_lip, solid, split, staves
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Floats,
    Mesh,
    bezier,
    box,
    circle,
    cylinder,
    deform,
    difference,
    ellipsoid,
    extrude,
    figures,
    loft,
    move,
    rect,
    revolve,
    ring,
    rotate,
    rounded_box,
    spline,
    sweep,
    vessel,
)

PORCELAIN, COBALT, BRASS = "#f1efe8", "#27509b", "#c9a24a"


def _band(profile: Floats, low: float, high: float) -> Mesh:
    """Painted band around a body of revolution, barely proud of it."""
    shell = difference(solid(profile, -0.5), solid(profile, 1.0))
    return split(split(shell, low)[1], high)[0]


@household(category="bowl", family="kitchen", mass=0.36, material="ceramic",
           source="typical retail stoneware cereal bowl: Ø142 x 66 mm, 360 g")
def cereal_bowl() -> list[Part]:
    foot = [(32, 0), (33, 4)]
    side = spline([(36, 5), (52, 14), (64, 32), (69, 50), (71, 66)], 9)
    body, blue = vessel(np.vstack([foot, side]), wall=4.5, floor=8, segments=42), "#2b6f8f"
    return staves(body, "ceramic", (8, 1, blue), (20, 6, blue), (50, 12, blue), (66, 12, PORCELAIN))


@household(category="bowl", family="kitchen", mass=0.62, material="ceramic",
           source="typical retail non-tip stoneware pet bowl: base Ø146, rim Ø122, height 55 mm, 620 g")
def pet_bowl() -> list[Part]:
    outside = [(71, 0), (73, 3), (73, 7), (61.5, 53), (60, 55)]
    body = revolve([(0, 0), *outside, (55, 55), (53, 52), (51, 26), (46, 16), (38, 12), (0, 12)], 36)
    bone = figures([rect(26, 8), *(circle(6, x, y, 20) for x in (-13, 13) for y in (-4.5, 4.5))])
    bones = [patch(bone, outside, angle, 28, 0.6) for angle in (-50, 40, 130, 220)]
    red = "#c8443a"
    return [*staves(body, "ceramic", (12, 1, red), (55, 12, red)),
            *(Part(b, "#f7f3e8", "ceramic", "convex") for b in bones)]


@household(category="teapot", family="kitchen", mass=0.62, material="ceramic",
           source="typical retail 0.7 l porcelain teapot: Ø117, height 121, 206 mm over the spout, 620 g")
def teapot() -> list[Part]:
    profile = np.vstack([[(36, 0), (37, 4)], spline([(40, 5), (54, 24), (58, 46), (52, 70), (36, 88)], 16)])
    core = solid(profile, 2)
    path = bezier((-44, 0, 26), (-86, 0, 22), (-68, 0, 72), (-106, 0, 90), segments=14)
    spout = sweep(circle(1, segments=20), path, scales=np.linspace(17, 7.5, 15), up=(0, 1, 0))
    bore = move(rotate(cylinder(4.5, 16, segments=16), y=-64), x=-96, z=85)
    handle = ear([(36, 82), (62, 88), (88, 74), (92, 54), (78, 34), (44, 26)], 13, 9, core)
    lid = solid([(36, 87), (35, 90), (26, 97), (12, 102), (6, 103)])
    knob = solid([(6, 102), (6, 106), (11, 111), (11, 116), (6, 121)], segments=24)
    band = _band(profile, 44, 52)
    spout, cream = difference(spout, bore, core), "#e9e2cf"
    return [Part(solid(profile), cream, "ceramic", "convex"), Part(spout, cream, "ceramic", 0.15),
            Part(handle, cream, "ceramic"), Part(lid, cream, "ceramic", "convex"),
            Part(knob, COBALT, "ceramic", "convex"), Part(band, COBALT, "ceramic", "convex")]


@household(category="pitcher", family="kitchen", mass=0.22, material="ceramic",
           source="typical retail 0.25 l porcelain milk jug: belly Ø76, height 96 mm, 220 g")
def creamer() -> list[Part]:
    profile = np.vstack([[(26, 0), (27, 3)],
                         spline([(29, 4), (37, 20), (38, 34), (32, 54), (28, 70), (29.5, 84), (32, 96)], 9)])
    body = pour_lip(vessel(profile, wall=4, floor=6, segments=42), 17, 62, 96, 42)
    handle = ear([(24, 86), (44, 92), (60, 80), (61, 58), (52, 38), (30, 26)], 11, 8, solid(profile, 2))
    bands = (6, 1, COBALT), (34, 7, COBALT), (68, 8, PORCELAIN), (96, 10, PORCELAIN)
    return [*staves(body, "ceramic", *bands), Part(handle, PORCELAIN, "ceramic", 0.08)]


@household(category="pitcher", family="kitchen", mass=0.178, material="plastic",
           source="YCB 019_pitcher_base: Ø108 x 235 mm, 178 g without its lid")
def water_pitcher() -> list[Part]:
    profile = [(44, 0), (47, 3), (48, 20), (50, 90), (52, 150),
               (52.5, 175), (53, 190), (53.5, 205), (54, 222), (54, 235)]
    body = pour_lip(vessel(profile, wall=4, floor=4, segments=60), 24, 180, 235, 30)
    handle = ear([(46, 212), (76, 216), (96, 200), (98, 130), (92, 70), (74, 50), (44, 52)], 20, 12,
                 solid(profile, 2), steps=30)
    blue, white = "#3f7fc4", "#f2f2ee"
    return [*staves(body, "plastic", (4, 1, blue), (198, 12, blue), (235, 12, white)),
            Part(handle, white, "plastic")]


@household(category="egg_cup", family="kitchen", mass=0.115, material="ceramic",
           source="typical retail porcelain egg cup: Ø48 x 60 mm, 55 g, with a size M egg Ø44 x 57 mm, 60 g")
def egg_cup() -> list[Part]:
    egg = deform(ellipsoid(22, 22, 28.5, segments=28),
                 lambda v: v * np.column_stack([1 - v[:, 2] / 250, 1 - v[:, 2] / 250, np.ones(len(v))]))
    egg = move(egg, z=60)
    cup = solid(spline([(13, 14), (19, 24), (23, 38), (24, 60)], 10), segments=40)
    foot = solid([(21, 0), (22, 3), (12, 7), (8.5, 11), (13, 15)], segments=40)
    return [Part(foot, "#3a86a8", "ceramic"), Part(difference(cup, egg), "#3a86a8", "ceramic", "convex"),
            Part(egg, "#d99f6c", "fruit", "convex")]


@household(category="sugar_bowl", family="kitchen", mass=0.34, material="ceramic",
           source="typical retail porcelain sugar bowl: Ø93, height 108, 146 mm over the handles, 340 g")
def sugar_bowl() -> list[Part]:
    profile = np.vstack([[(30, 0), (31, 4)], spline([(33, 5), (43, 22), (46, 42), (44, 60), (42, 68)], 12)])
    handle = ear([(36, 60), (56, 66), (69, 52), (64, 34), (38, 26)], 10, 7, solid(profile, 2))
    lid = solid([(45, 68), (45, 71), (40, 79), (28, 87), (10, 92), (5, 92)])
    knob = solid([(5, 91), (5, 95), (10, 100), (10, 104), (5, 108)], segments=24)
    return [Part(solid(profile), "#f0d9d2", "ceramic", "convex"), Part(handle, "#b4546a", "ceramic"),
            Part(rotate(handle, z=180), "#b4546a", "ceramic"), Part(lid, "#f0d9d2", "ceramic", "convex"),
            Part(knob, "#b4546a", "ceramic", "convex"),
            Part(_band(profile, 38, 46), "#b4546a", "ceramic", "convex")]


@household(category="candlestick", family="kitchen", mass=0.46, material="brass",
           source="typical retail brass candlestick Ø90 x 112 mm, 400 g, with a Ø22 candle, 60 g")
def candlestick() -> list[Part]:
    foot = solid([(43, 0), (45, 2), (45, 5), (40, 9), (22, 14), (12, 20)], segments=40)
    stem = solid([(10, 19), (8, 27), (14, 33), (15, 38), (9, 45), (6.5, 54), (8, 72), (11, 80)], segments=32)
    pan = vessel([(10, 79), (22, 84), (27, 92)], wall=2.5, segments=40)
    socket = solid([(13.5, 82), (13.5, 106), (16, 108), (16, 112)], segments=32)
    candle = solid([(11, 108), (11, 196), (9, 200), (3, 203)], segments=32)
    wick = move(cylinder(1.2, 12, segments=8), z=202)
    return [Part(foot, BRASS, "brass"), Part(stem, BRASS, "brass"),
            *staves(difference(pan, socket), "brass", (81.5, 1, BRASS), (92, 8, BRASS)),
            Part(socket, BRASS, "brass", "convex"), Part(candle, "#c73a3a", "wax", "convex"),
            Part(wick, "#2a2522", "fabric", "convex")]


def _napkin_wing() -> Mesh:
    """One half of a napkin, gathered at x = 0 and fanned out in pleats towards +x."""
    t = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    rings = []
    for x, wide, high in ((0, 15, 15), (10, 15, 15), (26, 19, 15), (48, 29, 13), (72, 40, 11), (86, 44, 10)):
        pleat = 1 + min(max(x, 0) / 70, 1) * 0.2 * np.cos(10 * t) * np.abs(np.sin(t))
        droop = 5 * min(x / 70, 1)
        y, z = wide * np.cos(t), high * np.sin(t) * pleat
        rings.append(np.column_stack([x + 10 * np.sin(t) ** 2 * (x > 80), y, z - z.min() - droop]))
    return loft(rings)


@household(category="napkin_ring", family="kitchen", mass=0.085, material="fabric",
           source="typical retail brass napkin ring Ø40 x 28 mm, 45 g, with a 40 cm napkin, 40 g")
def napkin_ring() -> list[Part]:
    wing = move(_napkin_wing(), z=-15)
    hoop = revolve([(14.5, 0), (18, 0), (20, 3), (18.5, 7), (18.5, 21), (20, 25), (18, 28), (14.5, 28)], 40)
    hoop = move(rotate(hoop, y=90), x=-14)
    half = difference(wing, rotate(move(ring(30, 14.6, 28), z=-14), y=90))
    return [Part(hoop, BRASS, "brass", "convex"), Part(half, "#a63d4f", "fabric", "convex"),
            Part(rotate(half, z=180), "#a63d4f", "fabric", "convex")]


@household(category="butter_dish", family="kitchen", mass=0.52, material="ceramic",
           source="typical retail butter dish tray 170 x 93, lid 128 x 70, height 84 mm, 520 g")
def butter_dish() -> list[Part]:
    dish = extrude(rect(158, 86, 12), 14, taper=1.08)
    tray = difference(dish, move(dish, z=7))
    cover = difference(rounded_box(128, 70, 100, 9), move(box(300, 300, 60), z=-17))
    stripe, lid = split(move(cover, z=-36), 18)
    knob = solid([(5, 63), (5, 68), (11, 73), (11, 79), (6, 84)], segments=24)
    return [Part(tray, COBALT, "ceramic"), Part(stripe, COBALT, "ceramic", "convex"),
            Part(lid, PORCELAIN, "ceramic", "convex"), Part(knob, COBALT, "ceramic", "convex")]
