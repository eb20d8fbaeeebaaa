"""Things one cooks, mixes and seasons with."""

from __future__ import annotations

import numpy as np

from grasp_bench.workshop.household.drinkware import GLASS, ear, pour_lip, solid, split, staves
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Mesh,
    box,
    circle,
    cylinder,
    difference,
    ellipse,
    extrude,
    figures,
    hull,
    intersection,
    move,
    rect,
    regular,
    revolve,
    ring,
    rotate,
    rounded_box,
    spin,
    spline,
    star,
    sweep,
    vessel,
)

STEEL, BLACK, ALUMINIUM = "#b4b8bc", "#232326", "#c3c6c9"


def _bar(start: tuple[float, float], end: tuple[float, float], width: float, thick: float) -> Mesh:
    """Long pan handle, waisted and round-ended, along (x, z) points, with a hole to hang it by."""
    t = np.linspace(0, 1, 14)
    path = np.column_stack([start[0] + t * (end[0] - start[0]), 0 * t, start[1] + t * (end[1] - start[1])])
    grip = np.interp(t, [0, 0.1, 0.35, 0.85, 0.95, 1], [0.7, 0.8, 0.8, 1.1, 1.0, 0.6])
    bar = sweep(rect(width, thick, thick / 3), path, scales=np.column_stack([grip, grip**0.5]))
    hole = move(cylinder(width / 5, 80, segments=16), x=end[0] - width * 0.65, z=end[1] - 40)
    return difference(bar, hole)


@household(category="saucepan", family="kitchen", mass=0.58, material="aluminium",
           source="typical retail cast aluminium 1 l saucepan: Ø142 x 75 mm, wall 4 mm, 288 mm long, 580 g")
def saucepan() -> list[Part]:
    profile = [(66, 0), (69, 2), (70, 6), (70, 70), (71, 75)]
    pot = vessel(profile, wall=4, floor=5, segments=48)
    neck = hull(move(box(4, 26, 12), x=68, z=50), move(box(4, 14, 9), x=92, z=56))
    neck = difference(neck, solid(profile, 1.5))
    return [*staves(pot, "aluminium", (5, 1, ALUMINIUM), (75, 16, ALUMINIUM)),
            Part(neck, "#8d9196", "aluminium", "convex"),
            Part(_bar((89, 60), (216, 74), 19, 15), BLACK, "plastic", 0.1)]


@household(category="frying_pan", family="kitchen", mass=0.29, material="aluminium",
           source="typical retail 14 cm egg pan: Ø142 x 32 mm, 284 mm long, wooden handle, 290 g")
def egg_pan() -> list[Part]:
    profile, black = [(52, 0), (55, 1.5), (63, 9), (68, 20), (71, 32)], "#2d2e33"
    pan = vessel(profile, wall=3, floor=4, segments=36)
    neck = hull(move(box(4, 26, 9), x=66, z=16), move(box(4, 15, 9), x=92, z=26))
    neck = difference(neck, solid(profile, 1.5))
    return [*staves(pan, "aluminium", (4, 1, black), (14, 12, black), (32, 12, black)),
            Part(neck, STEEL, "steel", "convex"),
            Part(_bar((89, 30), (212, 52), 20, 15), "#b9793c", "wood", 0.1)]


@household(category="kettle", family="kitchen", mass=0.62, material="steel",
           source="typical retail 1 l enamel kettle: Ø142, height 163, 182 mm over the spout, 620 g")
def stove_kettle() -> list[Part]:
    profile = [(58, 0), (66, 3), (71, 14), (71, 30), (66, 48), (55, 66), (42, 78), (38, 80)]
    lid = [(37, 79), (37, 83), (30, 88), (8, 92)]
    knob = [(5, 91), (5, 95), (11, 99), (12, 104), (8, 109)]
    path = np.array([(-52, 0, 36), (-70, 0, 46), (-84, 0, 62), (-93, 0, 80), (-104, 0, 92)], float)
    spout = sweep(circle(1, segments=20), path, scales=[19, 15, 11, 8.5, 8], up=(0, 1, 0))
    bore = rotate(cylinder(5, 22, segments=16), y=-43)
    body, core = solid(profile), solid(profile, 1.5)
    spout = difference(spout, move(bore, x=-94, z=81), core)
    hoop = spline([(56, 60), (68, 96), (62, 130), (42, 148), (0, 154), (-42, 148), (-62, 130), (-68, 96),
                   (-56, 60)], 36)
    wire = sweep(4, np.insert(hoop, 1, 0, axis=1), up=(0, 1, 0), segments=10)
    right = difference(intersection(wire, move(box(100, 50, 300), x=88)), core)
    grip = sweep(ellipse(9, 11, segments=16), np.insert(hoop[11:26], 1, 0, axis=1), up=(0, 1, 0))
    return [Part(body, "#b5242b", "steel", "convex"), Part(solid(lid), "#b5242b", "steel", "convex"),
            Part(solid(knob, segments=24), BLACK, "plastic", "convex"), Part(spout, "#b5242b", "steel", 0.15),
            Part(right, STEEL, "steel"), Part(rotate(right, z=180), STEEL, "steel"),
            Part(grip, BLACK, "plastic")]


@household(category="moka_pot", family="kitchen", mass=0.42, material="aluminium",
           source="typical retail 3-cup moka pot (Bialetti Moka Express): height 160 mm, base Ø86 mm, 420 g")
def moka_pot() -> list[Part]:
    boiler = solid([(41, 0), (43, 3), (36, 60)], segments=8)
    waist = extrude(star(40, 36, 35), 10)
    jug = solid([(30, 68), (41, 130)], segments=8)
    lid = solid([(41.5, 129.5), (41.5, 133), (12, 144), (9, 146)], segments=8)
    core = solid([(29, 68), (40, 130)], segments=8)
    spout = difference(hull(move(box(1, 30, 1), x=-38, z=129), move(box(1, 8, 1), x=-53, z=129),
                            move(box(1, 4, 1), x=-32, z=90)), core)
    knob = solid([(5, 145), (5, 148), (10, 153), (10, 158), (6, 161)], segments=8)
    arm = np.array([(30, 0, 121), (52, 0, 122), (70, 0, 120), (76, 0, 112), (75, 0, 96), (70, 0, 66)], float)
    handle = sweep(rect(11, 14, 3), arm, up=(0, 1, 0), scales=[0.9, 0.9, 1, 1.1, 1, 0.8])
    handle = difference(handle, core)
    valve = move(rotate(cylinder(5, 8, segments=6), x=90), y=-34, z=38)
    return [Part(boiler, ALUMINIUM, "aluminium", "convex"),
            Part(move(waist, z=59), "#8f9398", "aluminium", "convex"),
            Part(jug, ALUMINIUM, "aluminium", "convex"), Part(lid, ALUMINIUM, "aluminium", "convex"),
            Part(spout, ALUMINIUM, "aluminium", "convex"), Part(knob, BLACK, "plastic", "convex"),
            Part(handle, BLACK, "plastic"), Part(rotate(valve, z=22.5), "#c08a35", "brass", "convex")]


@household(category="coffee_press", family="kitchen", mass=0.62, material="glass",
           source="typical retail 350 ml French press: beaker Ø70 x 195 mm, 340 g, with 280 ml of coffee")
def french_press() -> list[Part]:
    beaker = cylinder(35, 136)
    coffee, glass = split(move(beaker, z=6), 96)
    beak = difference(hull(move(box(1, 22, 1), x=-34, z=140), move(box(1, 6, 1), x=-44, z=140),
                           move(box(1, 4, 1), x=-33, z=124)), cylinder(34.5, 200))
    lid = solid([(37, 141), (37, 147), (30, 153), (8, 158)])
    knob = solid([(6, 176), (11, 180), (13, 186), (11, 192), (6, 195)], segments=24)
    strap = move(rounded_box(2.4, 10, 128, 1, 1), x=35.8, z=2)
    core = cylinder(36, 200)
    handle = ear([(30, 124), (58, 126), (68, 112), (68, 62), (58, 46), (30, 48)], 15, 11, core)
    return [Part(coffee, "#4a2614", "liquid", "convex"), Part(glass, GLASS, "glass", "convex"),
            Part(beak, GLASS, "glass", "convex"), Part(lid, STEEL, "steel", "convex"),
            Part(move(cylinder(2.5, 20, segments=12), z=157), STEEL, "steel", "convex"),
            Part(knob, BLACK, "plastic", "convex"), Part(cylinder(37, 9), STEEL, "steel", "convex"),
            Part(move(ring(36.8, 34.5, 9), z=118), STEEL, "steel", "convex"), Part(handle, BLACK, "plastic"),
            *(Part(rotate(strap, z=a), STEEL, "steel", "convex") for a in (60, 180, 300))]


@household(category="funnel", family="kitchen", mass=0.045, material="polyethylene",
           source="typical retail 10 cm kitchen funnel: mouth Ø100, height 115, spout Ø18 mm, 45 g")
def funnel() -> list[Part]:
    # Modelled as it is put down: standing on its mouth.
    outside = [(51.5, 0), (51.5, 4), (49.5, 5), (49, 14), (10, 58), (7, 115)]
    body = revolve([*outside, (4.5, 115), (7, 57), (46, 13), (47, 0)], 36)
    eye = figures([circle(13, x=58), rect(14, 26, x=51)]).difference(circle(6.5, x=60))
    tab = difference(extrude(eye, 4), cylinder(48.5, 20))
    red = "#e0692a"
    return [*staves(body, "polyethylene", (13, 12, red), (57, 12, red), (115, 1, red)),
            Part(tab, red, "polyethylene", 0.1)]


@household(category="mortar", family="kitchen", mass=0.68, material="ceramic",
           source="typical retail mortar Ø106 x 66 mm, 560 g, with pestle 125 mm, 120 g")
def mortar_and_pestle() -> list[Part]:
    profile = [(33, 0), (35, 3), (33, 9), (37, 15), (46, 30), (51, 46), (53, 66)]
    bowl = vessel(profile, wall=8, floor=12, segments=36)
    head = solid([(6, 0), (11, 2), (14, 8), (14, 16), (10, 30), (9, 36)], segments=24)
    shaft = solid([(8, 35), (8, 70), (10, 100), (11, 116), (8, 123), (4, 125)], segments=24)
    head, shaft = (move(rotate(m, y=43), x=-15, z=22) for m in (head, shaft))
    white = "#eceae4"
    return [*staves(bowl, "ceramic", (12, 1, white), (32, 12, white), (66, 12, white)),
            Part(difference(head, bowl), "#dedbd2", "ceramic"),
            Part(difference(shaft, bowl), "#a8672f", "wood", "convex")]


@household(category="pepper_mill", family="kitchen", mass=0.21, material="wood",
           source="typical retail 20 cm turned beech pepper mill: Ø56 x 202 mm, 210 g")
def pepper_mill() -> list[Part]:
    waist = spline([(27.5, 0), (28, 12), (26, 20), (19, 45), (16.5, 66), (18, 90), (22, 112)], 16)
    crown = spline([(20, 116), (23, 124), (17, 132), (22, 146), (25, 160), (21, 176), (10, 187)], 16)
    base, head = solid(waist, segments=36), solid(crown, segments=36)
    knob = solid([(4, 186), (4, 190), (7.5, 193), (7.5, 198), (4, 202)], segments=20)
    return [Part(base, "#6b3a1e", "wood"), Part(move(cylinder(20.5, 6), z=111), STEEL, "steel", "convex"),
            Part(head, "#6b3a1e", "wood"), Part(knob, STEEL, "steel", "convex")]


@household(category="salt_shaker", family="kitchen", mass=0.16, material="glass",
           source="typical retail diner salt shaker: octagonal glass Ø44, steel cap, 92 mm, 160 g filled")
def salt_shaker() -> list[Part]:
    facets = extrude(regular(8, 24, 22.5), 68, taper=0.86)
    jar = intersection(facets, solid([(22, 0), (23.5, 2), (23.5, 68)]))
    salt, glass = split(jar, 46)
    cap = solid([(19, 66), (20.5, 67), (20.5, 78), (18.5, 85), (13, 90), (5, 92)], segments=36)
    hole = move(cylinder(1.6, 6, segments=10), z=87.5)
    holes = [hole, *spin(move(hole, x=8.5, z=-1.8), 6)]
    return [Part(salt, "#f6f6f4", "liquid", "convex"), Part(glass, GLASS, "glass", "convex"),
            Part(difference(cap, *(move(h, z=2) for h in holes)), STEEL, "steel", "convex"),
            *(Part(move(h, z=-3), BLACK, "plastic", "convex") for h in holes)]


@household(category="bowl", family="kitchen", mass=0.29, material="plastic",
           source="typical retail 1 l melamine mixing bowl: rim Ø146, height 92 mm, 290 g")
def mixing_bowl() -> list[Part]:
    wall = [(40, 4), (47, 7), (58, 24), (66, 46), (69, 60), (70, 68), (71, 74)]
    profile = [*wall, (71.5, 80), (73, 81), (73, 92)]
    bowl = pour_lip(vessel(profile, wall=4, floor=4, segments=60), 17, 45, 92, 30)
    tab = extrude(figures([rect(40, 54, 12, x=76)]).difference(rect(9, 28, 4, x=86)), 7)
    tab = difference(move(tab, z=84), move(cylinder(71, 200), z=-10))
    green = "#8cc5b4"
    return [*staves(bowl, "plastic", (8, 1, green), (44, 11, green), (92, 12, green)),
            Part(tab, green, "plastic", 0.1),
            Part(cylinder(45, 6.5), "#4a4d50", "rubber", "convex")]
