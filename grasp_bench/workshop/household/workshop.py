"""Cutting, measuring, clamping and painting tools."""

import numpy as np
from shapely.geometry.base import BaseGeometry

from grasp_bench.workshop.household.hand_tools import (
    BLACK,
    DARK,
    STEEL,
    WOOD,
    along_x,
    along_y,
    limb,
    slab,
    thread,
    upright,
)
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Mesh,
    arc,
    bezier,
    box,
    circle,
    cylinder,
    difference,
    ellipse,
    extrude,
    figures,
    hull,
    loft,
    move,
    polygon,
    rect,
    rotate,
    rounded,
    rounded_box,
    spline,
    stroke,
    sweep,
    union,
)

YELLOW = "#f2bd1d"


def _plate(shape: BaseGeometry, thickness: float, bevel: float) -> Mesh:
    """Slab whose outline steps in by ``bevel`` towards both faces."""
    return union(slab(shape.buffer(-bevel, quad_segs=3), thickness), slab(shape, thickness - 2 * bevel))


@household(category="saw", family="tools", mass=0.28, material="wood",
           source="estimate, typical: toolbox saw, blade 200 mm, wooden handle 22 mm thick, 280 g")
def hand_saw() -> list[Part]:
    x = np.linspace(0, 196, 50)
    teeth = np.column_stack([x, np.where(np.arange(50) % 2, 0, 5)])
    blade = slab(polygon(np.vstack([teeth, [(198, 6), (198, 34), (0, 70)]])), 2)
    outer = rounded(polygon([(22, 0), (20, 66), (-18, 78), (-72, 92), (-92, 84), (-82, 60), (-94, 10),
                             (-90, -16),
                             (-66, -22), (-30, -6)]), 7)
    hole = rounded(polygon([(-10, 14), (-8, 54), (-30, 62), (-54, 66), (-64, 12), (-52, 4), (-30, 6)]), 9)
    studs = [slab(circle(5, *at, segments=16), 23) for at in ((8, 20), (6, 48))]
    handle = difference(_plate(outer.difference(hole), 22, 3), blade, *studs)
    return [Part(handle, "#a8672e", "wood", 0.1), Part(difference(blade, *studs), "#aeb4ba", "steel",
                                                       "convex"),
            *(Part(s, "#d4ae4a", "brass", "convex") for s in studs)]


@household(category="drill", family="tools", mass=1.0, material="plastic",
           source="estimate, typical: compact 12 V drill driver, 172 x 58 x 180 mm, 1.0 kg with battery")
def cordless_drill() -> list[Part]:
    axle = 152.0
    housing = move(along_x([(0, -52), (27, -52), (28.5, -46), (28.5, 24), (25, 34), (0, 34)], segments=36),
                   z=axle)
    cap = move(along_x([(0, -64), (20, -64), (25, -60), (26, -51), (0, -51)], segments=36), z=axle)
    clutch = move(along_x([(0, 33), (24, 33), (24, 37), (22.5, 38), (22.5, 48), (20, 52), (0, 52)]), z=axle)
    chuck = move(along_x([(0, 51), (18, 51), (20, 55), (20, 80), (19, 83), (11, 97), (0, 97)]), z=axle)
    bit = move(along_x([(0, 97), (6, 97), (4, 106), (0, 106)], segments=12), z=axle)
    path = bezier((-14, 0, 140), (-18, 0, 95), (-30, 0, 75), (-28, 0, 34), segments=8)
    grip = difference(sweep(ellipse(16, 20, segments=24), path, up=(1, 0, 0)),
                      move(along_x([(0, -60), (28, -60), (28, 40), (0, 40)]), z=axle))
    shoe = difference(move(rounded_box(84, 56, 16, 6), -24, 0, 29), grip)
    battery = move(rounded_box(90, 58, 31, 6), -22)
    trigger = difference(move(rotate(rounded_box(16, 13, 26, 4), y=-8), 9, 0, 97), grip)
    badge = move(upright(rounded(rect(44, 13, x=-12), 4), 58.2), z=axle)
    badge = difference(badge, move(along_x([(0, -60), (28, -60), (28, 40), (0, 40)], segments=36), z=axle))
    badges = badge.split()
    teal = "#0f8f8a"
    return [Part(difference(housing, *badges), teal, "plastic", "convex"),
            Part(cap, BLACK, "plastic", "convex"),
            Part(clutch, "#3b3f44", "plastic", "convex"), Part(chuck, BLACK, "aluminium", "convex"),
            Part(bit, STEEL, "steel", "convex"), Part(grip, BLACK, "rubber"),
            Part(shoe, teal, "plastic", 0.1),
            Part(battery, "#303338", "plastic", "convex"), Part(trigger, "#d42a22", "plastic"),
            *(Part(b, "#f4f4f0", "plastic", "convex") for b in badges)]


@household(category="tape_measure", family="tools", mass=0.33, material="plastic",
           source="estimate, typical: 5 m x 25 mm pocket tape measure, case 74 x 68 x 38 mm, 330 g")
def tape_measure() -> list[Part]:
    case = polygon(np.vstack([[(-37, 3), (-34, 0), (36, 0), (37, 4), (37, 16)], arc(37, 0, 180, 0, 31, 18)]))
    low = case.intersection(rect(100, 15, y=7.5))
    low = figures([low, case.difference(case.buffer(-9)).intersection(rect(60, 100, x=-30, y=49))])
    discs = [move(rotate(cylinder(23, 2.5, 32), x=90), 0, y, 33) for y in (20.3, -17.8)]
    shell = upright(case.difference(low), 36)
    lock = move(rounded_box(20, 18, 9, 3), 24, 0, 56)
    lock = rotate(lock, y=40, about=(24, 0, 60))
    tape = move(box(45, 25, 2), 58, 0, 8)
    hook = union(move(box(2, 25, 12), 81), move(box(9, 16, 2), 77, 0, 9.5))
    marks = [Part(move(box(1.6, 25 * k, 0.6), 44 + 6 * i, 12.5 * (1 - k), 9.8), BLACK, "plastic", "convex")
             for i, k in enumerate((0.4, 0.4, 1.0, 0.4, 0.4))]
    return [Part(difference(shell, *discs), YELLOW, "plastic"), Part(upright(low, 38), BLACK, "rubber"),
            *(Part(d, "#d8dadc", "plastic", "convex") for d in discs),
            Part(difference(lock, shell), BLACK, "plastic"), Part(tape, "#f7e04a", "steel", "convex"),
            Part(hook, STEEL, "steel"), *marks]


@household(category="clamp", family="tools", mass=0.6, material="iron",
           source="estimate, typical: 3 in (75 mm) malleable iron G-clamp, throat 50 mm, 0.6 kg")
def c_clamp() -> list[Part]:
    spine = [(-8, 0), (-8, 52), (4, 62), (88, 62), (100, 52), (100, 0)]
    frame = slab(figures([stroke(spine, 17), rect(12, 24, x=-3), rect(24, 24, x=100)]), 17)
    web = stroke(spine[1:-1], 7)
    frame = difference(frame, move(extrude(web, 9), z=5), move(extrude(web, 9), z=-14))
    screw = union(move(rotate(thread(6.5, 112, 5), y=90), 42),
                  along_x([(0, 150), (9, 150), (9, 166), (0, 166)]))
    pad = along_x([(0, 32), (12, 32), (12, 36), (7, 43), (0, 43)])
    bar = along_y([(0, -38), (4.5, -38), (5, -36), (5, -32), (3.5, -30), (3.5, 30), (5, 32), (5, 36),
                   (4.5, 38),
                   (0, 38)], segments=12)
    bar = move(bar, x=158)
    return [Part(difference(frame, screw), "#2456a6", "iron"), Part(difference(screw, bar), STEEL, "steel"),
            Part(pad, "#7f868d", "steel", "convex"), Part(bar, STEEL, "steel")]


@household(category="spirit_level", family="tools", mass=0.24, material="aluminium",
           source="estimate, typical: 9 in torpedo level, 230 x 44 x 24 mm, three vials, 240 g")
def spirit_level() -> list[Part]:
    side = polygon([(-115, 4), (115, 4), (115, 20), (70, 44), (-70, 44), (-115, 20)])
    windows = figures([circle(13, -72, 23, 24), circle(13, 72, 23, 24), rounded(rect(46, 26, y=38), 4)])
    body = upright(side.difference(windows), 24)
    base = box(230, 24, 4)
    parts = [Part(body, YELLOW, "plastic"), Part(base, "#8f959b", "aluminium", "convex")]
    green, bubble, line = "#b9e33b", "#eef8c8", "#222222"
    for x, z, turn, half in ((0, 35, 0, 23.5), (-72, 23, 90, 13.3), (72, 23, 45, 13.3)):
        cuts = [(green, -half, -6), (line, -6, -5), (bubble, -5, 5), (line, 5, 6), (green, 6, half)]
        for color, a, b in cuts:
            rod = along_x([(0, a), (6, a), (6, b), (0, b)], segments=16)
            parts.append(Part(move(rotate(rod, y=-turn), x, 0, z), color, "plastic", "convex"))
    return parts


@household(category="utility_knife", family="tools", mass=0.16, material="plastic",
           source="estimate, typical: knife with trapezoid blade, 155 x 37 x 20 mm, 160 g, blade out 25 mm")
def utility_knife() -> list[Part]:
    top = spline([(-78, 4), (-70, 13), (-30, 15), (20, 12), (60, 9)], 16)
    low = spline([(60, -8), (35, -13), (5, -12), (-30, -19), (-65, -21), (-78, -12)], 18)
    outline = rounded(polygon(np.vstack([top, low])), 3)
    body = _plate(outline, 19, 3)
    nose = hull(move(box(2, 16, 13), 58, 0.5, -6.5), move(box(2, 11, 8), 74, 1.5, -4))
    inlay = slab(rounded(polygon([(-64, -3), (-64, -16), (-30, -14), (0, -7.5), (24, -8), (24, -2),
                                  (-20, 0)]), 3), 20)
    slider = slab(rounded(polygon([(10, 8), (14, 17), (36, 15.5), (40, 6)]), 1.5), 10)
    screw = slab(circle(5, -40, 5, 20), 20)
    blade = slab(polygon([(72, -3.8), (100, -3.8), (85, 6.5), (72, 6.5)]), 2)
    return [Part(difference(body, inlay, slider, screw), YELLOW, "plastic", 0.1),
            Part(inlay, BLACK, "rubber"),
            Part(slider, BLACK, "plastic", "convex"), Part(screw, DARK, "steel", "convex"),
            Part(difference(nose, body), "#3b3f44", "steel"), Part(blade, "#b8bec4", "steel", "convex")]


@household(category="axe", family="tools", mass=0.65, material="wood",
           source="estimate, typical: small hatchet, head 500 g, 110 mm deep, total 300 mm, 650 g")
def hatchet() -> list[Part]:
    cheek = hull(slab(rect(38, 44, 2, x=102, y=-10), 22), slab(rect(42, 2, x=102, y=32), 12))
    edge = hull(slab(rect(42, 2, x=102, y=33), 12),
                slab(polygon(bezier((60, 68), (85, 82), (115, 82), (142, 66), segments=10)), 2))
    handle = limb([(-160, -16, 14, 9), (-145, -14, 18, 11), (-110, -2, 14, 11), (-40, 3, 13, 10),
                   (40, -2, 14, 10),
                   (84, -8, 17, 9)], steps=22, ends=(8, 0))
    plug = slab(ellipse(6, 15, 120, -8), 12)
    return [Part(cheek, "#b3201f", "steel", "convex"), Part(difference(edge, cheek), STEEL, "steel",
                                                            "convex"),
            Part(difference(handle, cheek), WOOD, "wood"),
            Part(difference(plug, cheek), WOOD, "wood", "convex")]


@household(category="trowel", family="tools", mass=0.22, material="wood",
           source="estimate, typical: garden hand trowel, blade 143 x 80 mm, total 290 mm, 220 g")
def garden_trowel() -> list[Part]:
    u = np.linspace(-1, 1, 11)
    stations = [(0, 7, 4), (8, 14, 6), (22, 34, 11), (45, 40, 12), (90, 38, 11), (115, 31, 8), (133, 19, 4.5),
                (143, 6, 1)]
    rings = [np.vstack([np.column_stack([np.full(11, x), w * v, d * v**2 + h])
                        for v, h in ((u, 0.0), (u[::-1], 2.4))]) for x, w, d in stations]
    blade = loft(rings)
    neck = sweep(5, bezier((-44, 0, 26), (-15, 0, 27), (-20, 0, 4), (32, 0, 4), segments=12), segments=12)
    handle = along_x([(0, -148), (10, -147), (14, -140), (15, -125), (12.5, -100), (14, -75), (11, -46),
                      (0, -46)])
    ferrule = along_x([(0, -47), (11, -47), (7.5, -34), (0, -34)])
    return [Part(union(blade, difference(neck, move(ferrule, z=26))), "#2f7d4f", "steel"),
            Part(move(ferrule, z=26), STEEL, "steel", "convex"), Part(move(handle, z=26), WOOD, "wood")]


@household(category="paint_brush", family="tools", mass=0.085, material="wood",
           source="estimate, typical: 50 mm flat brush, 17 mm thick, bristles 54 mm, total 235 mm, 85 g")
def paint_brush() -> list[Part]:
    handle = limb([(-148, 0, 8, 6), (-130, 0, 11, 8), (-90, 0, 8, 7), (-50, 0, 11, 8), (-18, 0, 22, 8),
                   (1, 0, 24, 8)], ends=(5, 0), power=3)
    handle = difference(handle, move(cylinder(3.2, 30, 16), -136, 0, -15))
    ferrule = union(slab(rect(34, 51, x=17), 17), slab(rect(3, 52.4, x=7), 18.4),
                    slab(rect(3, 52.4, x=27), 18.4))
    y = np.linspace(-24, 24, 33)
    edge = np.column_stack([y, np.where(np.arange(33) % 2, 7.6, 6.4)])
    tuft = extrude(polygon(np.vstack([edge, edge[::-1] * [1, -1]])), 54)
    vertices = np.asarray(tuft.vertices).copy()
    vertices[:, 1] *= 1 - 0.45 * vertices[:, 2] / 54
    tuft = Mesh(np.column_stack([vertices[:, 2] + 33.5, vertices[:, 0], vertices[:, 1]]), tuft.faces,
                process=False)
    return [Part(handle, "#c8302a", "wood"), Part(ferrule, "#b4b9be", "aluminium", "convex"),
            Part(tuft, "#3a2a1e", "bristle", "convex")]


@household(category="paint_roller", family="tools", mass=0.16, material="plastic",
           source="estimate, typical: 4 in mini roller, sleeve Ø46 x 106 mm, wire 7 mm, 275 mm long, 160 g")
def paint_roller() -> list[Part]:
    sleeve = along_y([(0, -53), (20, -53), (23, -50), (23, 50), (20, 53), (0, 53)], segments=28)
    caps = [along_y([(0, -56), (9, -56), (11, -52), (0, -52)]),
            along_y([(0, 52), (11, 52), (9, 56), (0, 56)])]
    corners = [(0, 54), (0, 70), (-42, 70), (-72, 0), (-132, 0)]
    path = [corners[0]]
    for a, b, c in zip(corners, corners[1:], corners[2:], strict=False):
        a, b, c = (np.asarray(p, dtype=float) for p in (a, b, c))
        start, stop = (b + 10 * (q - b) / np.linalg.norm(q - b) for q in (a, c))
        path += list(bezier(start, b, stop, segments=5))
    path = np.vstack([path, corners[-1:]])
    wire = sweep(3.5, np.column_stack([path, np.zeros(len(path))]), segments=12)
    handle = along_x([(0, -252), (10, -252), (14, -246), (15, -225), (12.5, -195), (14, -165), (12, -140),
                      (8, -130),
                      (0, -130)])
    return [Part(sleeve, "#f3ead2", "fabric", "convex"), *(Part(c, "#2b6fc2", "plastic",
                                                                "convex") for c in caps),
            Part(difference(wire, handle, *caps), STEEL, "steel"), Part(handle, "#2b6fc2", "plastic")]
