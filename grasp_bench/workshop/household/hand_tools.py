"""Striking, turning and gripping tools."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator
from shapely.geometry import Polygon

from grasp_bench.workshop.household.forms import sectors
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Figure,
    Mesh,
    arc,
    bezier,
    box,
    circle,
    cone,
    cylinder,
    difference,
    ellipse,
    extrude,
    figures,
    hull,
    intersection,
    loft,
    mirror,
    move,
    place,
    polygon,
    rect,
    regular,
    revolve,
    rotate,
    rounded,
    rounded_box,
    star,
    stroke,
    sweep,
    union,
)

STEEL, DARK, WOOD, BLACK = "#979da4", "#5d646b", "#c58f4c", "#26282b"


def along_x(profile: ArrayLike, x: float = 0.0, segments: int = 24) -> Mesh:
    """Profile of (r, x) points turned about the x axis."""
    return move(rotate(revolve(profile, segments), y=90), x=x)


def along_y(profile: ArrayLike, y: float = 0.0, segments: int = 24) -> Mesh:
    """Profile of (r, y) points turned about the y axis."""
    return move(rotate(revolve(profile, segments), x=-90), y=y)


def slab(shape: Figure, thickness: float) -> Mesh:
    """Plane figure extruded evenly to both sides of z = 0."""
    return move(extrude(shape, thickness), z=-thickness / 2)


def upright(shape: Figure, thickness: float) -> Mesh:
    """Plane figure of (x, z) points extruded evenly to both sides of y = 0."""
    return rotate(slab(shape, thickness), x=90)


def limb(stations: Sequence[Sequence[float]], steps: int = 18, power: float = 2.5, sides: int = 16,
         ends: tuple[float, float] = (4, 4)) -> Mesh:
    """Handle along x through (x, y, half width, half thickness), its ends rounded over ``ends``."""
    s = np.asarray(stations, dtype=float)
    x = s[0, 0] + (s[-1, 0] - s[0, 0]) * (0.5 - 0.5 * np.cos(np.pi * np.linspace(0, 1, steps)))
    y, w, h = PchipInterpolator(s[:, 0], s[:, 1:])(x).T
    for end, reach in zip((x[0], x[-1]), ends, strict=True):
        if reach:
            w_h = np.sqrt(np.clip(1 - (1 - np.clip(np.abs(x - end) / reach, 0, 1)) ** 2, 0.2, 1))
            w, h = w * w_h, h * w_h
    t = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    c, d = (np.sign(f) * np.abs(f) ** (2 / power) for f in (np.cos(t), np.sin(t)))
    return loft([np.column_stack([np.full(sides, a), b + p * c, q * d])
                 for a, b, p, q in zip(x, y, w, h, strict=True)])


def thread(radius: float, length: float, pitch: float, segments: int = 20) -> Mesh:
    """Screw thread along z: V grooves tilted by half a pitch, which looks like a helix."""
    z = np.arange(0, length + 0.1, pitch / 2)
    r = np.where(np.arange(len(z)) % 2 == 0, radius, radius - 0.6 * pitch)
    body = revolve(np.vstack([[0, 0], np.column_stack([r, z]), [0, z[-1]]]), segments)
    vertices = np.asarray(body.vertices).copy()
    inner = (vertices[:, 2] > 0.1) & (vertices[:, 2] < z[-1] - 0.1)
    vertices[inner, 2] += vertices[inner, 0] / radius * pitch / 4
    return Mesh(vertices, body.faces, process=False)


def fluted(profile: Sequence[tuple[float, float]], flutes: int, radius: float, reach: float) -> Mesh:
    """Turned handle along x with ``flutes`` grooves of ``radius`` centred ``reach`` off its axis."""
    turn = np.arange(flutes) * 360 / flutes
    grooves = figures(place(circle(radius, reach, segments=16), turn=a) for a in turn)
    section = circle(reach, segments=48).difference(grooves)
    top = max(p[1] for p in profile)
    return rotate(intersection(revolve(profile, 36), extrude(section, top)), y=90)


@household(category="hammer", family="tools", mass=0.58, material="wood",
           source="estimate, typical: 16 oz claw hammer, head 450 g and 133 mm long, total 290 mm")
def claw_hammer() -> list[Part]:
    cheek = move(rounded_box(32, 32, 27, 3), 122, 0, -13.5)
    back, front = bezier((137, -8), (138, -48), (122, -68), (96, -80)), \
        bezier((94, -76), (108, -58), (112, -40), (107, -8))
    claw = slab(polygon(np.vstack([back, front])), 26)
    slot = move(rotate(extrude(polygon([(0, -36), (7, -90), (-7, -90)]), 80), y=90), x=70)
    poll = along_y([(0, 12), (11, 12), (9.5, 24), (9.5, 34), (13.5, 38), (13.5, 51), (12, 53), (0, 53)])
    poll = move(poll, x=122)
    handle = limb([(-150, 0, 15, 11), (-115, 0, 17, 13), (-60, 0, 14, 11), (20, 0, 11, 9), (107, 0, 13, 9)],
                  ends=(8, 0))
    plug = slab(rect(3, 20, x=139), 12)
    return [Part(difference(union(cheek, claw), slot), DARK, "steel"), Part(poll, STEEL, "steel"),
            Part(handle, WOOD, "wood"), Part(plug, WOOD, "wood", threshold="convex")]


@household(category="hammer", family="tools", mass=0.55, material="rubber",
           source="estimate, typical: 16 oz rubber mallet, head Ø60 x 95 mm, total 300 mm, 0.55 kg")
def rubber_mallet() -> list[Part]:
    head = along_y([(0, 0), (26, 0), (30, 4), (30, 14), (28, 16), (28, 79), (30, 81), (30, 91), (26, 95),
                    (0, 95)], y=-47.5, segments=32)
    head = move(head, x=115)
    handle = limb([(-155, 0, 14, 12), (-110, 0, 16, 14), (-40, 0, 13, 11), (87, 0, 13, 12)], ends=(8, 0))
    plug = move(along_x([(0, 0), (11, 0), (11, 3), (0, 3)]), x=142)
    return [Part(head, BLACK, "rubber"), Part(handle, WOOD, "wood"), Part(plug, WOOD, "wood", "convex")]


@household(category="screwdriver", family="tools", mass=0.12, material="plastic",
           source="estimate, typical: 8 mm flat blade 125 mm long, fluted handle Ø31 x 105 mm, 120 g")
def flat_screwdriver() -> list[Part]:
    grip = fluted([(0, 10), (14.5, 10), (16, 14), (16, 70), (14, 84), (0, 84)], 8, 5, 19)
    butt = along_x([(0, 0), (9, 0), (13, 3), (14.5, 10), (0, 10)])
    collar = along_x([(0, 84), (13.5, 84), (10.5, 92), (10.5, 97), (13.5, 101), (12, 105), (0, 105)])
    shank = along_x([(0, 105), (3.7, 105), (3.7, 205), (0, 205)], segments=16)
    tip = hull(along_x([(0, 205), (3.7, 205), (3.7, 206), (0, 206)], segments=16),
               move(box(1, 9, 4), 217, 0, -2), move(box(1, 8, 2), 230, 0, -1))
    return [Part(grip, "#c8201f", "plastic"), Part(butt, BLACK, "plastic", "convex"),
            Part(collar, BLACK, "plastic"), Part(union(shank, tip), STEEL, "steel")]


@household(category="screwdriver", family="tools", mass=0.085, material="plastic",
           source="estimate, typical: stubby Phillips PH3 x 38 mm, handle Ø36 x 58 mm, 85 g")
def stubby_phillips_screwdriver() -> list[Part]:
    grip = fluted([(0, 14), (17, 14), (18.5, 20), (18, 38), (14, 46), (0, 46)], 6, 8, 24)
    butt = along_x([(0, 0), (8, 0), (14, 4), (17, 14), (0, 14)])
    collar = along_x([(0, 46), (13.5, 46), (13.5, 50), (15.5, 54), (13, 58), (0, 58)])
    blade = union(cylinder(4, 34, 20), move(cone(4, 9, 20), z=34))
    quarter = move(box(5, 5, 20), 3.4, 3.4, 26)
    blade = difference(blade, *(rotate(quarter, z=a) for a in (0, 90, 180, 270)), move(box(9, 9, 9), z=41))
    return [Part(grip, "#f08a1d", "plastic"), Part(butt, BLACK, "plastic", "convex"),
            Part(collar, BLACK, "plastic"), Part(move(rotate(blade, y=90), x=58), STEEL, "steel")]


@household(category="wrench", family="tools", mass=0.31, material="steel",
           source="estimate, typical: 22 mm spanner, 273 mm, shank 8 mm, heads 11-13 mm thick, 310 g")
def combination_spanner() -> list[Part]:
    shank = polygon([(-105, -12), (105, -9), (105, 9), (-105, 12)])
    head = place(ellipse(25, 24).difference(figures([stroke([(-3, 0), (-60, 0)], 22), rect(20, 60, x=-29)])),
                 -114, 0, 15)
    ring = slab(circle(18.5, 0, segments=40), 13)
    body = difference(union(slab(shank, 8), slab(head, 11)), move(ring, x=118))
    recess = stroke([(-80, 0), (88, 0)], 9)
    bore = slab(star(12, 13, 11.6), 20)
    body = difference(body, move(extrude(recess, 5), z=2.8), move(extrude(recess, 5), z=-7.8))
    return [Part(body, STEEL, "steel"),
            *(Part(move(s, x=118), STEEL, "steel", "convex") for s in sectors(difference(ring, bore), 12))]


@household(category="wrench", family="tools", mass=0.30, material="steel",
           source="estimate, typical: 8 in adjustable wrench, 210 mm, head 14 mm thick, 300 g")
def adjustable_wrench() -> list[Part]:
    fixed = polygon([(-26, -13), (-25, 13), (-9, 27), (18, 30), (42, 23), (45, 14), (8, 13), (8, -24),
                     (-8, -25)])
    window = rect(13, 20, x=-4, y=-9)
    neck = polygon([(-15, -11), (30, -14), (45, 0), (30, 16), (-15, 11)])
    jaw = rounded(polygon([(8.3, -2), (44, -1), (45, -7), (24, -22), (8.3, -26)]), 1)

    def turned(shape: Polygon) -> Polygon:
        return place(shape, 50, 0, 18)

    steel = union(slab(neck.difference(turned(rect(60, 60, x=37))), 10),
                  difference(slab(turned(fixed), 14), slab(turned(window), 20)))
    worm = rotate(move(thread(6.9, 20, 3.4), z=-10.2), x=90)
    worm = move(rotate(move(worm, -4, -9), z=18), x=50)
    grip = limb([(-115, 0, 15, 7), (-90, 0, 14, 7), (-30, 0, 12, 7), (-14, 0, 12.5, 7)],
                power=3.5, ends=(12, 3))
    grip = difference(grip, move(cylinder(5, 30, 20), -102, 0, -15))
    return [Part(difference(steel, slab(turned(jaw), 20)), STEEL, "steel"),
            Part(slab(turned(jaw), 14), "#8d949b", "steel", "convex"),
            Part(worm, "#c9a13b", "steel", "convex"),
            Part(grip, "#c8201f", "rubber")]


def _pliers(jaw: Mesh, joint: float, thickness: float, handle: Sequence[Sequence[float]], opening: float,
            color: str, tip: str) -> list[Part]:
    """Pliers lying along x about their pivot; ``jaw`` and ``handle`` are the halves at y > 0."""
    grip = limb(handle, steps=20)
    x, y, w, h = handle[-1]
    tang = hull(move(box(8, 2 * w, 1.8 * h), x - 1, y, -0.9 * h),
                move(box(4, 8, thickness), -5, 5, -thickness / 2))
    grip = difference(grip, move(box(16, 40, 40), x + 5, y, -20))  # the tang shows here
    halves = [rotate(m, z=opening) for m in (union(jaw, tang), grip)]
    steel, up = halves[0], halves[1]
    rivet = slab(circle(0.42 * joint, segments=24), thickness + 1.6)
    steel = difference(union(steel, mirror(steel, "y"), slab(circle(joint, segments=32), thickness)), rivet)
    cut = move(box(200, 400, 100), 0.6 * handle[0][0] - 100, 0, -50)
    parts = [Part(steel, STEEL, "steel"), Part(rivet, DARK, "steel", "convex")]
    for half in (up, mirror(up, "y")):
        parts += [Part(difference(half, cut), color, "rubber"), Part(intersection(half, cut), tip, "rubber")]
    return parts


@household(category="pliers", family="tools", mass=0.15, material="rubber",
           source="estimate, typical: 165 mm needle nose pliers, 10 mm joint, 150 g")
def needle_nose_pliers() -> list[Part]:
    jaw = hull(move(box(4, 10, 10), 8, 5.2, -5), move(box(1, 2.6, 5), 63, 1.5, -2.5))
    return _pliers(jaw, 11, 10, [(-100, 19, 5, 6), (-75, 20, 6, 7), (-40, 15, 6, 6.5), (-14, 8, 4.5, 5.5)], 4,
                   "#d42a22", "#d42a22")


@household(category="pliers", family="tools", mass=0.25, material="rubber",
           source="estimate, typical: 174 mm combination pliers, head 11 mm thick, 250 g")
def combination_pliers() -> list[Part]:
    outline = polygon([(0, 0.3), (13, 0.3), (17, 4), (25, 4), (29, 0.3), (47, 0.3), (48, 6), (42, 10),
                       (15, 14),
                       (0, 13)])
    return _pliers(slab(outline, 11), 15, 12,
                   [(-125, 22, 6, 7), (-95, 23, 7.5, 9), (-50, 20, 7, 8), (-18, 11, 6, 7)], 3, "#1f4fa0",
                   "#e0b020")


@household(category="pliers", family="tools", mass=0.34, material="rubber",
           source="estimate, typical: 227 mm slip joint pliers, head 11 mm thick, 340 g")
def tongue_and_groove_pliers() -> list[Part]:
    teeth = np.column_stack([np.linspace(34, 6, 11), np.where(np.arange(11) % 2, 3.5, 2.0)])
    upper = polygon(np.vstack([teeth, [(-2, 6), (-20, 8), (-16, 20), (8, 22), (30, 11)]]))
    lower = polygon(np.vstack([teeth * [1, -1], [(-2, -6), (-20, -6), (-14, -24), (10, -21), (30, -11)]]))
    head = [place(f, 62, 12, 38) for f in (upper, lower)]
    arms = figures([stroke([(56, 6), (30, 2), (12, -12)], 20), stroke([(52, 16), (28, 14), (12, 15)], 17)])
    steel = slab(figures([*head, arms, place(rect(16, 26, x=-12), 62, 12, 38)]), 11)
    rivet = move(slab(circle(6.5, segments=24), 13), 43, 6)
    low = limb([(-135, -22, 6.5, 7), (-100, -24, 7.5, 8), (-40, -22, 7.5, 7.5), (14, -11, 9, 7)], steps=20)
    high = limb([(-135, 24, 6.5, 7), (-100, 25, 7.5, 8), (-40, 20, 7.5, 7.5), (14, 14, 8, 7)], steps=20)
    blue = "#1d56b0"
    grips = [Part(difference(g, move(box(20, 90, 40), 21, 0, -20)), blue, "rubber") for g in (low, high)]
    return [Part(difference(steel, rivet), STEEL, "steel"), Part(rivet, DARK, "steel", "convex"), *grips]


@household(category="hex_key", family="tools", mass=0.135, material="steel",
           source="ISO 2936 hexagon key 10 mm, long series: arms 170 x 40 mm; mass from volume")
def hex_key() -> list[Part]:
    bend = arc(16, -90, 0, 149, 16, 10)
    path = np.vstack([[(0, 0), (1.5, 0), (70, 0), (140, 0)], bend, [(165, 30), (165, 39), (165, 40.5)]])
    scales = np.ones(len(path))
    scales[[0, -1]] = 0.85
    bar = sweep(regular(6, 10 / np.sqrt(3)), np.column_stack([path, np.zeros(len(path))]), scales=scales)
    return [Part(bar, "#4a4f55", "steel")]


@household(category="chisel", family="tools", mass=0.24, material="wood",
           source="estimate, typical: 26 mm firmer chisel, 255 mm, handle Ø33 mm, 240 g")
def wood_chisel() -> list[Part]:
    handle = along_x([(0, 12), (13, 12), (15, 22), (16.5, 50), (14, 85), (13, 100), (11, 115), (0, 115)])
    hoop = along_x([(0, 3), (12, 3), (14, 5), (14, 14), (0, 14)])
    ferrule = along_x([(0, 113), (11.5, 113), (9, 132), (0, 132)])
    neck = union(along_x([(0, 131), (6.5, 131), (4.5, 150), (0, 150)]),
                 hull(along_x([(0, 148), (4.6, 148), (4.6, 149), (0, 149)], segments=16),
                      move(box(1, 26, 5), 168, 0, -2.5)))
    blade = hull(move(box(72, 26, 5), 204, 0, -2.5), move(box(1, 26, 1), 255, 0, -2.5))
    wood = difference(handle, along_x([(0, 0), (30, 0), (30, 14), (0, 14)]))
    return [Part(wood, WOOD, "wood"), Part(hoop, DARK, "steel", "convex"),
            Part(ferrule, "#c9a13b", "brass", "convex"), Part(union(neck, blade), STEEL, "steel")]
