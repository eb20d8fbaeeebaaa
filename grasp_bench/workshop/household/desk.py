"""Things that stand on a desk, and what lights and powers it."""

import numpy as np

from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Mesh,
    arc,
    bezier,
    box,
    circle,
    cylinder,
    difference,
    ellipsoid,
    extrude,
    figures,
    helix,
    hull,
    intersection,
    move,
    place,
    polygon,
    prism,
    rect,
    regular,
    revolve,
    ring,
    rotate,
    sphere,
    spline,
    sweep,
    union,
    vessel,
)

STEEL, BLACK, BRASS = "#b9bec4", "#26282b", "#d8ac3c"


def _convex(mesh: Mesh, color: str, material: str = "plastic") -> Part:
    """A part that is its own convex hull."""
    return Part(mesh, color, material, "convex")


def _lying(mesh: Mesh, z: float) -> Mesh:
    """A solid modelled upright, laid down along x with its axis at height ``z``."""
    return move(rotate(mesh, y=90), z=z)


def _facing(mesh: Mesh, z: float, y: float = 0.0) -> Mesh:
    """A solid modelled upright, turned so that its top looks towards -y."""
    return move(rotate(mesh, x=90), y=y, z=z)


def _leaning(mesh: Mesh, turn: float, foot: float = 9.0, tilt: float = 10.8) -> Mesh:
    """A solid standing ``foot`` from the middle of the cup's floor and leaning on its rim."""
    return rotate(move(rotate(mesh, y=tilt), x=foot, z=6), z=turn)


@household(category="pencil_cup", family="office", mass=0.21, material="ceramic",
           source="common stoneware pencil pot Ø70 x 100 mm, 175 g, with four pencils (~5 g each) and a "
                  "ruler")
def pencil_cup() -> list[Part]:
    cup = vessel([(32, 0), (34, 1.5), (35, 100)], wall=3, floor=4, segments=40)
    parts = [Part(cup, "#2f6f8f", "ceramic", 0.07)]
    for turn, length, color in ((20, 128, "#f2b61c"), (95, 138, "#cc2b2b"), (170, 122, "#2f9a45"),
                                (245, 132, "#2255bb")):
        shaft = extrude(regular(6, 4.2), length)
        wood = move(cylinder(3.8, 11, 16, top=1), z=length)
        parts += [_convex(_leaning(shaft, turn), color, "wood"),
                  _convex(_leaning(wood, turn), "#e2bf8a", "wood")]
    ruler = box(3, 22, 146)
    lengths = [9 if i % 5 == 4 else 5 for i in range(12)]
    lines = [move(box(1, w, 0.9), x=1.3, y=10 - w / 2, z=98 + 4 * i) for i, w in enumerate(lengths)]
    marks = union(move(box(0.4, 4, 46), x=1, y=8, z=97), *lines)
    return [*parts, _convex(_leaning(ruler, 310, 14, 8), "#f0d27a", "wood"),
            _convex(_leaning(marks, 310, 14, 8), BLACK)]


@household(category="magnifying_glass", family="office", mass=0.13, material="plastic",
           source="common 75 mm reading glass: Ø88 lens ring, 195 mm long, 130 g (retail data sheets)")
def magnifying_glass() -> list[Part]:
    z = 9.0
    frame = move(ring(44, 38, 12, 40), z=z - 6)
    lens = move(ellipsoid(38.3, 38.3, 4.5, 40), z=z)
    ferrule = _lying(move(cylinder(6.5, 17, 24), z=43), z)
    grip = spline([(6.8, 58), (9, 72), (8, 100), (9.2, 135), (7, 150)], 14)
    handle = _lying(revolve([(0, 58), *grip, (0, 151)], 28), z)
    return [Part(frame, "#9aa0a6", "aluminium"), _convex(lens, "#c9e6f2", "glass"),
            _convex(ferrule, BRASS, "brass"), Part(handle, "#5a2f1c", "wood")]


@household(category="rubber_stamp", family="office", mass=0.075, material="wood",
           source="common wooden hand stamp, 64 x 30 mm plate, 82 mm high, 75 g (retail data sheets)")
def rubber_stamp() -> list[Part]:
    rubber = box(60, 26, 5)
    mount = move(prism(rect(64, 30, 2), 13, 1), z=5)
    label = move(box(40, 0.6, 8), y=-15, z=7)
    profile = spline([(13, 18), (10, 22), (8, 32), (9.5, 44), (15.5, 58), (16.5, 68), (12, 79), (3, 82)], 24)
    handle = revolve([(0, 18), *profile, (0, 82.3)], 32)
    return [_convex(rubber, "#c0392b", "rubber"), _convex(mount, "#d8b07a", "wood"),
            _convex(label, "#f7f5ef", "paper"), Part(handle, "#7a3f1d", "wood")]


@household(category="alarm_clock", family="office", mass=0.26, material="steel",
           source="common twin-bell alarm clock: 102 x 52 x 140 mm, 260 g (retail data sheets)")
def twin_bell_alarm_clock() -> list[Part]:
    z, red = 52.0, "#c8202f"
    drum = _facing(revolve([(0, 0), (38, 0), (43, 4), (43, 44), (0, 44)], 40), z, 24)
    bezel = _facing(ring(45, 38, 8, 40), z, -19.8)
    face = _facing(cylinder(38.2, 3, 36), z, -20)
    ticks = [place(rect(5 if i % 3 else 8, 2.4 if i % 3 else 3.2, x=32), turn=30 * i) for i in range(12)]
    marks = union(extrude(circle(35, segments=24), 1), *(extrude(t, 2.0) for t in ticks))
    hands = extrude(figures([place(rect(32, 3, x=12), turn=60), place(rect(24, 4.4, x=9), turn=150),
                             circle(4)]), 1.5)
    dome = hull(intersection(sphere(21, 24), box(60, 60, 30)), cylinder(21.5, 3, 24))
    post = move(cylinder(3.2, 37, 14), z=-12)
    foot = hull(*(move(sphere(4.5, 12), y=y, z=-56) for y in (-15, 15)),
                *(move(sphere(4.5, 12), y=y, z=-43) for y in (-12, 12)))
    hammer = union(move(rotate(cylinder(5.5, 15, 16), y=90), x=-7.5, z=z + 56),
                   move(cylinder(2, 16, 10), z=z + 42))
    loop = np.array([(x, 0, h) for x, h in bezier((-26, 108), (-28, 146), (28, 146), (26, 108), segments=16)])
    parts = [_convex(drum, red), _convex(bezel, STEEL, "aluminium"),
             _convex(face, "#fbfaf5"), Part(hammer, BLACK, "steel")]
    parts += [_convex(_facing(m, z, y), BLACK) for m, y in ((marks, -21.7), (hands, -22.8))]
    for sign in (-1, 1):
        for mesh, lift, turn, color in ((dome, 54, 34, BRASS), (post, 54, 34, BRASS), (foot, 0, 30, STEEL)):
            placed = rotate(move(mesh, z=z + lift), y=sign * turn, about=(0, 0, z))
            parts.append(_convex(placed, color, "aluminium"))
    return [*parts, Part(sweep(2.5, loop, up=(0, 1, 0), segments=10), STEEL, "steel")]


@household(category="light_bulb", family="office", mass=0.035, material="glass",
           source="A60 bulb, IEC 60630: Ø60 x 107 mm, E27 cap (IEC 60061-1), 35 g")
def light_bulb() -> list[Part]:
    glass = spline([(13, 27), (14.5, 34), (21, 50), (28.5, 66), (29.6, 82), (22, 98), (10, 105.5),
                    (0.1, 107)], 28)
    globe = revolve([(0, 27), *glass[:-1], (0, 107)], 40)
    thread = [(12 + 1.4 * (i % 2), 8 + 2 * i) for i in range(10)]
    cap = revolve([(0, 7), (9, 7), *thread, (13, 28), (0, 28)], 28)
    insulator = cylinder(4.5, 7.2, 24, top=9)
    tip = move(cylinder(3.2, 2, 16, top=4.5), z=-1)
    return [Part(_lying(globe, 30), "#fdf6dc", "glass"), Part(_lying(cap, 30), STEEL, "brass"),
            _convex(_lying(insulator, 30), BLACK, "glass"), _convex(_lying(tip, 30), STEEL, "brass")]


@household(category="battery", family="office", mass=0.138, material="plastic",
           source="IEC 60086-2 LR20 (D cell): Ø34.2 x 61.5 mm; alkaline 138 g (data sheet)")
def d_cell_battery() -> list[Part]:
    cell = [("#b9bec4", 11, 0.6, -0.6), ("#232427", 17.1, 40, 0), ("#c77a3a", 17.1, 17, 40),
            ("#b9bec4", 15, 1.5, 57),
            ("#d5d9dd", 4.6, 2.4, 58.5)]
    parts = [_convex(move(cylinder(r, h, 36), z=z + 0.6), c, "steel") for c, r, h, z in cell]
    cross = rotate(extrude(figures([rect(9, 2.8), rect(2.8, 9)]), 40), x=90, z=40)
    plus = intersection(move(cross, z=50), ring(17.5, 15, 61, 36))
    return [*parts, _convex(plus, "#f4f2ec")]


@household(category="battery", family="office", mass=0.046, material="plastic",
           source="IEC 60086-2 6LR61 (9 V block): 26.5 x 17.5 x 48.5 mm; alkaline 46 g (data sheet)")
def nine_volt_battery() -> list[Part]:
    outline = rect(26.5, 17.5, 2.5)
    lower = prism(outline, 33, 0.5)
    upper = move(extrude(outline, 11), z=33)
    deck = move(extrude(rect(25.5, 16.5, 2), 1.6), z=44)
    snap = move(cylinder(3, 3.2, 20), x=-6.35, z=45.4)
    socket = move(difference(extrude(regular(6, 5), 3.2), move(cylinder(2.8, 4, 16), z=1)), x=6.35, z=45.4)
    bolt = polygon([(-1, -11), (4, 2), (0.5, 2), (3, 11), (-4, -2), (-0.5, -2)])
    flash = move(rotate(extrude(bolt, 1), x=90), y=-8.1, z=18)
    return [_convex(lower, "#1c3f94", "steel"), _convex(upper, "#e4b422", "steel"),
            _convex(deck, BLACK), _convex(snap, "#d5d9dd", "steel"),
            _convex(socket, "#d5d9dd", "steel"), _convex(flash, "#f6d23a")]


@household(category="power_plug", family="office", mass=0.075, material="plastic",
           source="CEE 7/7 mains plug: Ø38 mm face, two Ø4.8 x 19 mm pins 19 mm apart; 75 g with 90 mm of "
                  "cable")
def power_plug() -> list[Part]:
    z = 19.0
    shell = [(0, 0), (12, 0), (15, 4), (17.5, 14), (17.5, 22), (19, 24), (19, 40), (0, 40)]
    side = [move(box(6.5, 10, 40), x=s * 18.4, z=22) for s in (-1, 1)]
    body = difference(revolve(shell, 36), *side)
    earth = [move(box(1.2, 6, 17), x=s * 15.4, z=23) for s in (-1, 1)]
    relief = revolve([(0, -22), (4.4, -22), (7, 1), (0, 1)], 20)
    pin = hull(move(cylinder(2.4, 15, 16), z=39), move(sphere(2.2, 12), z=57))
    path = spline([(-20, 0, z), (-38, 1, 15), (-60, 10, 5), (-86, 12, 4), (-104, 0, 4)], 20)
    cord = sweep(3.4, path, segments=10)
    parts = [Part(_lying(body, z), "#2b2d31", "plastic"), _convex(_lying(relief, z), "#3a3d42", "rubber"),
             Part(cord, "#3a3d42", "rubber")]
    parts += [_convex(_lying(move(pin, y=y), z), "#d5d9dd", "brass") for y in (-9.5, 9.5)]
    return parts + [_convex(_lying(e, z), "#d5d9dd", "brass") for e in earth]


@household(category="phone", family="office", mass=0.19, material="plastic",
           source="common desk telephone handset: 215 x 52 x 62 mm, 190 g with cord stub (retail data "
                  "sheets)")
def telephone_handset() -> list[Part]:
    red, half = "#c8202f", 26.0
    arch = spline([(-82, 0, 24), (-78, 0, 40), (-50, 0, 51), (0, 0, 54), (50, 0, 51), (78, 0, 40),
                   (82, 0, 24)], 26)
    bar = sweep(rect(20, 26, 7), arch, up=(0, 1, 0))
    parts = []
    for sign in (-1, 1):
        shell = revolve([(0, 8), (25.5, 8), (half, 11), (half, 20), (18, 32), (0, 32)], 32)
        mouth = revolve([(0, 0), (22, 0), (25, 3), (25, 8.2), (0, 8.2)], 32)
        holes = union(extrude(circle(17, segments=12), 1),
                      *(move(cylinder(2, 2, 10), x=x, y=y, z=-1) for x,
                        y in ((0, 0), *arc(11, 0, 300, segments=5))))
        tilted = [move(rotate(m, y=sign * -12), x=sign * 82, z=2) for m in (shell, mouth, move(holes, z=0.6))]
        parts += [_convex(tilted[0], red), _convex(tilted[1], "#8f1420"),
                  _convex(tilted[2], BLACK)]
    bar = difference(bar, *(parts[i].mesh for i in (0, 3)))
    coil = sweep(1.8, helix(5, 5, 8, 9), segments=6)
    cord = move(rotate(coil, y=90), x=104, z=18)
    parts = [Part(bar, red, "plastic"), *parts, _convex(cord, BLACK, "rubber")]
    return [Part(move(rotate(p.mesh, x=90), z=half), p.color, p.material, p.threshold) for p in parts]
