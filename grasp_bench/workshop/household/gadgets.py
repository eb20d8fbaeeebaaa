"""Small kitchen gadgets: openers, presses, cutters, grater, timer."""

from __future__ import annotations

import numpy as np
from shapely.geometry.base import BaseGeometry

from grasp_bench.workshop.household.utensils import BLACK, STEEL, grip, rod, turned
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Mesh,
    Polygon,
    bezier,
    box,
    circle,
    cylinder,
    difference,
    extrude,
    figures,
    helix,
    hull,
    mirror,
    move,
    place,
    polygon,
    prism,
    rect,
    regular,
    revolve,
    rotate,
    rounded,
    spline,
    star,
    stroke,
    sweep,
    union,
    vessel,
)


@household(category="can_opener", family="utensils", mass=0.21, material="plastic",
           source="common rotary can opener: 180 x 68 x 42 mm, 210 g (retail data)")
def can_opener() -> list[Part]:
    arm = grip([(14, 15, 12, 0), (24, 18, 14, 0), (70, 20, 15, 0), (120, 20, 15, 0), (133, 15, 11, 0),
                (136, 6, 5, 0)], power=3)
    arms = [move(rotate(arm, z=a), y=y) for a, y in ((5, 13), (-5, -13))]
    upper = polygon([(-44, 3), (-44, 16), (-20, 25), (30, 24), (30, 9), (0, 5), (-14, -6), (-34, -6)])
    lower = polygon([(-30, -14), (-4, -14), (30, -9), (30, -24), (-14, -27), (-36, -22)])
    plan = figures([rounded(upper, 3), rounded(lower, 3), circle(11, -12, -12, 24)])
    jaws = move(extrude(plan, 4), z=-5)
    pivot = move(cylinder(5, 9, 16), x=-12, y=-14, z=-5)
    cutter = move(prism(circle(11, segments=32), 3, 1.2), x=-27, y=5, z=-1)
    axle = move(cylinder(2.5, 3, 12), x=-27, y=5, z=2)
    gear = move(extrude(star(16, 8, 6.4), 4), x=-12, y=-14, z=4)
    stem = move(cylinder(4, 20, 16), x=-12, y=-14, z=8)
    wing = stroke([(-24, 0), (24, 0)], 14).union(circle(9))
    for x in (-22, 22):
        wing = wing.difference(circle(3, x, segments=12))
    key = move(rotate(extrude(wing, 7), z=35), x=-12, y=-14, z=27)
    return [*(Part(a, "#c8322f", "plastic", "convex") for a in arms), Part(jaws, STEEL, "steel"),
            Part(pivot, "#8b9198", "steel", "convex"), Part(cutter, "#dfe3e6", "steel", "convex"),
            Part(axle, "#8b9198", "steel", "convex"), Part(gear, "#8b9198", "steel", "convex"),
            Part(stem, STEEL, "steel", "convex"), Part(key, "#c8322f", "plastic", "convex")]


@household(category="corkscrew", family="utensils", mass=0.2, material="steel",
           source="common winged corkscrew: 197 x 89 x 34 mm, zinc alloy, 200 g (retail data)")
def winged_corkscrew() -> list[Part]:
    bell = turned([(13, 0), (17, 0), (17, 8), (14, 16), (14, 34), (11, 34), (11, 16), (13, 8)], 32)
    frame = move(prism(rect(40, 24, 4), 17, 2), x=53, z=-8.5)
    gear = star(14, 12, 9.6).difference(circle(2.5, segments=12))
    gears = [move(extrude(gear, 8), x=62, y=y, z=-4) for y in (14, -14)]
    path = bezier((62, 18), (58, 38), (30, 30), (-6, 34), segments=10)
    arm = move(extrude(stroke(path, 10), 8), z=-4)
    paddle = move(rotate(prism(rect(44, 17, 8), 11, 2), z=-7), x=-12, y=34.5, z=-5.5)
    teeth = [(r, x + 5 * i) for i in range(7) for r, x in ((6, 71), (6, 73.5), (4.5, 74.5), (4.5, 75.5))]
    rack = turned([(0, 70), *teeth, (0, 106)], 16)
    top = circle(22, 138).union(polygon([(104, -9), (116, -12), (126, -18), (126, 18), (116, 12), (104, 9)]))
    mouth = circle(14.5, 139).difference(rect(12, 11, x=126))
    handle = move(extrude(top.difference(mouth), 9), z=-4.5)
    worm = rotate(sweep(1.6, helix(4, 9, 6, 10), segments=6), y=90)
    shank = rod(4, 12, 36)
    return [Part(bell, BLACK, "plastic", "convex"), Part(frame, STEEL, "steel", "convex"),
            *(Part(g, "#8b9198", "steel", "convex") for g in gears),
            *(Part(m, STEEL, "steel") for m in (arm, mirror(arm, "y"))),
            *(Part(m, BLACK, "plastic", "convex") for m in (paddle, mirror(paddle, "y"))),
            Part(rack, "#8b9198", "steel", "convex"), Part(handle, STEEL, "steel"),
            Part(move(worm, x=-36), "#8b9198", "steel", "convex"), Part(shank, "#8b9198", "steel", "convex")]


def grater_wall(bottom: float, top: float, height: float, holes: list[Polygon], teeth: list[Mesh]) -> Mesh:
    """Upright wall (in the xz plane, facing -y) with holes and raised teeth."""
    sheet = polygon([(-bottom / 2, 0), (bottom / 2, 0), (top / 2, height), (-top / 2, height)])
    sheet = sheet.difference(figures(holes))
    return rotate(union(extrude(sheet, 2), *teeth), x=90)


@household(category="grater", family="utensils", mass=0.24, material="steel",
           source="common four-sided box grater: 100 x 75 x 231 mm, 240 g (retail data)")
def box_grater() -> list[Part]:
    height, w0, w1, d0, d1 = 172.0, 100.0, 78.0, 74.0, 54.0
    coarse = [(x, z) for row, z in enumerate(range(28, 160, 17)) for x in
              ((-26, -9, 8, 25) if row % 2 else (-17, 0, 17))]
    fine = [(x, z) for z in range(26, 165, 14) for x in (-14, 0, 14)]
    slots = [place(rect(30, 6, 2.5), 0, z) for z in (30, 60, 90, 120, 150)]
    slots += [place(rect(44, 6, 2.5), 0, z) for z in (45, 75, 105, 135)]
    tooth = difference(hull(cylinder(6, 1, 10), move(cylinder(2.5, 1, 8), y=1, z=2.6)),
                       move(box(20, 8, 20), y=-6.4, z=-1))
    front = grater_wall(w0, w1, height, [circle(4.5, x, z - 3, 8) for x, z in coarse],
                        [move(tooth, x=x, y=z, z=1) for x, z in coarse])
    back = grater_wall(w0, w1, height, slots, [])
    left = grater_wall(d0 - 4, d1 - 4, height, [circle(3, x, z, 6) for x, z in fine], [])
    right = grater_wall(d0 - 4, d1 - 4, height, [place(regular(4, 4.2), x, z) for x, z in fine[::2]], [])
    walls = []
    for wall, turn, foot, head in ((front, 0, d0, d1), (back, 180, d0, d1),
                                   (left, 90, w0, w1), (right, -90, w0, w1)):
        lean = np.degrees(np.arctan((foot - head) / 2 / height))
        walls.append(rotate(move(rotate(wall, x=-lean), y=2 - foot / 2), z=turn))
    mouth = move(extrude(rect(w1 - 3, d1 - 3, 4), 30), z=-9)
    rim = difference(prism(rect(w1 + 6, d1 + 6, 6), 12, 1.5), mouth)
    half = [(-34, 0, 178), (-37, 0, 196), (-28, 0, 215)]
    bow = sweep(rect(20, 9, 3), spline([*half, (0, 0, 221), *((-x, y, z) for x, y, z in half[::-1])], 22),
                up=(0, 1, 0))
    return [*(Part(w, STEEL, "steel", "convex") for w in walls),
            Part(move(rim, z=167), BLACK, "plastic"), Part(bow, BLACK, "plastic")]


def cutter(outline: BaseGeometry, height: float, flange: float) -> Mesh:
    """Cookie cutter: 2 mm wall with a wider rim at the top."""
    wall = extrude(outline.difference(outline.buffer(-2, join_style="mitre")), height)
    inner = outline.buffer(-2 - flange / 2, join_style="mitre")
    lip = outline.buffer(flange / 2, quad_segs=3).difference(inner)
    return union(wall, move(extrude(lip, 3), z=height - 3))


@household(category="cookie_cutter", family="utensils", mass=0.03, material="steel",
           source="common stainless steel star cookie cutter: 67 x 64 x 25 mm, 30 g (retail data)")
def star_cookie_cutter() -> list[Part]:
    return [Part(cutter(rounded(star(5, 37, 17.5), 2.2), 25, 2), "#a6adb4", "steel")]


@household(category="cookie_cutter", family="utensils", mass=0.018, material="plastic",
           source="common plastic heart cookie cutter: 64 x 62 x 28 mm, 18 g (retail data)")
def heart_cookie_cutter() -> list[Part]:
    half = spline([(0, 19), (6, 27), (17, 30), (28, 23), (30.5, 10), (24, -6), (11, -20), (0, -29)], 22)
    outline = polygon(np.vstack([half, half[-2:0:-1] * [-1, 1]]))
    return [Part(cutter(outline, 28, 3), "#d6336c", "plastic", 0.08)]


@household(category="lemon_squeezer", family="utensils", mass=0.11, material="plastic",
           source="plastic citrus juicer: Ø112 mm, 162 mm with handle, 57 mm high, 110 g (retail data)")
def lemon_squeezer() -> list[Part]:
    dish = vessel([(38, 0), (44, 2), (52, 18), (55, 34), (56, 36)], wall=2.5, floor=3)
    ribs = star(8, 22, 17.5).buffer(-1).buffer(1)
    cone = [extrude(ribs, 26, taper=0.82), move(extrude(place(ribs).buffer(0), 1), z=0)]
    cone = hull(move(cylinder(4, 2, 16), z=52), cylinder(17, 2, 24))
    fin = hull(box(6, 46, 2), move(box(3.4, 34, 2), z=24), move(box(2.4, 10, 2), z=51))
    reamer = union(cone, *(rotate(fin, z=45 * i) for i in range(4)))
    handle = grip([(48, 16, 9, 0), (58, 18, 11, 0), (74, 20, 12, 0), (90, 18, 11, 0), (95, 8, 5, 0)], power=3)
    handle = difference(handle, move(cylinder(54.6, 80, 48), z=-40))
    spout = hull(move(box(4, 26, 9), x=-54, z=27), move(box(2, 8, 2), x=-66, z=34))
    groove = hull(move(box(4, 17, 9), x=-50, z=31), move(box(4, 4, 3), x=-68, z=35.2))
    notch = move(box(12, 17, 12), x=-55, z=31)
    spout = difference(spout, groove, difference(cylinder(54.6, 80, 48), notch))
    yellow = "#f2c230"
    return [Part(difference(dish, notch), yellow, "plastic", 0.1),
            Part(move(reamer, z=3), yellow, "plastic", "convex"),
            Part(move(handle, z=29), yellow, "plastic", "convex"), Part(spout, yellow, "plastic", 0.3)]


@household(category="garlic_press", family="utensils", mass=0.21, material="aluminium",
           source="common cast aluminium garlic press: 182 x 32 mm, 210 g (retail data)")
def garlic_press() -> list[Part]:
    pivot = (-28, 0, 26)
    hopper = difference(prism(rect(42, 32, 7), 28, 1.2), move(extrude(rect(34, 24, 5), 40), z=2.4),
                        *(move(cylinder(2, 20, 8), x=x, y=y, z=-5) for x in (-10, 0, 10) for y in (-6, 6)))
    ears = [move(rotate(hull(cylinder(6, 4, 16), move(box(8, 10, 4), x=10, y=-12)), x=90), x=-28, y=y, z=26)
            for y in (14, -10)]
    pin = move(rotate(cylinder(3, 30, 12), x=90), x=-28, y=15, z=26)
    lower = grip([(18, 16, 13, 17), (30, 11, 12, 17), (62, 11, 11, 15)], power=3)
    handle = grip([(54, 12, 12, 0), (58, 16, 15, 0), (100, 19, 16, -1), (138, 18, 15, 1),
                   (146, 8, 7, 2)], power=3)
    bottom = difference(move(handle, z=15), lower)
    upper = grip([(-35, 10, 8, 26), (-28, 13, 13, 26), (-10, 14, 13, 32), (30, 12, 12, 34),
                  (62, 11, 11, 34)], power=3)
    plunger = union(move(prism(rect(32, 22, 4.5), 6, 1), z=7), move(box(11, 10, 20), z=11))
    top = difference(move(mirror(handle, "z"), z=34), upper)
    upper, top, plunger = (rotate(m, y=-30, about=pivot) for m in (upper, top, plunger))
    return [Part(hopper, "#a9b0b7", "aluminium", 0.1), Part(lower, "#a9b0b7", "aluminium", "convex"),
            *(Part(h, "#c8322f", "plastic", "convex") for h in (bottom, top)),
            *(Part(e, "#a9b0b7", "aluminium", "convex") for e in ears),
            Part(pin, "#6f757b", "steel", "convex"), Part(upper, "#a9b0b7", "aluminium", 0.1),
            Part(difference(plunger, upper), "#8b9198", "aluminium", 0.1)]


@household(category="bottle_opener", family="utensils", mass=0.085, material="rubber",
           source="common hand-held crown cap opener: 156 x 44 x 17 mm, 85 g (retail data)")
def bottle_opener() -> list[Part]:
    head = circle(22, -34).union(polygon([(8, -8), (-8, -9), (-24, -18), (-24, 18), (-8, 9), (8, 8)]))
    mouth = circle(15.5, -34).difference(rounded(rect(12, 14, x=-20), 3))
    plate = move(extrude(head.difference(mouth), 3.2), z=-1.6)
    handle = grip([(-2, 16, 11, 0), (3, 20, 15, 0), (35, 19, 15, 0), (70, 24, 17, 0), (92, 22, 16, 0),
                   (98, 14, 10, 0), (100, 6, 4, 0)], power=3)
    handle = difference(handle, move(cylinder(4, 40, 16), x=84, z=-20))
    return [Part(plate, STEEL, "steel"), Part(handle, "#1f6f78", "rubber", "convex")]


@household(category="kitchen_timer", family="utensils", mass=0.11, material="plastic",
           source="common mechanical 60 minute dial timer: Ø68 x 40 mm, 110 g (retail data)")
def kitchen_timer() -> list[Part]:
    case = revolve([(0, 0), (31, 0), (34, 3), (34, 21), (31, 25), (0, 25)], 48)
    face = move(cylinder(29.5, 1.2, 48), z=24.4)
    minor, major = rect(4.5, 1.4, x=24.5), rect(7, 2.4, x=23.4)
    ticks = [place(minor if i % 3 else major, turn=30 * i) for i in range(12)]
    ring_ = circle(28, segments=48).difference(circle(26.6, segments=48))
    marks = move(extrude(figures([ring_, *ticks]), 1), z=24.9)
    knob = move(cylinder(16, 6, 40, top=14), z=25)
    bar = move(prism(rect(31, 9, 4), 11, 1.5), z=29)
    pointer = move(prism(polygon([(12, -2), (12, 2), (19, 0)]), 4, 0.2), z=25)
    return [Part(case, "#d43d34", "plastic", "convex"), Part(face, "#f8f6f0", "plastic", "convex"),
            Part(marks, "#232323", "plastic", "convex"), Part(knob, "#d43d34", "plastic", "convex"),
            Part(bar, "#d43d34", "plastic", "convex"), Part(pointer, "#232323", "plastic", "convex")]
