"""Balls, blocks, dice, chess pieces and other things to play with."""

from __future__ import annotations

import numpy as np

from grasp_bench.workshop.household.forms import along_x, along_y
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Mesh,
    box,
    cylinder,
    difference,
    extrude,
    intersection,
    mirror,
    move,
    polygon,
    prism,
    rect,
    regular,
    revolve,
    ring,
    rotate,
    rounded,
    rounded_box,
    sphere,
    spline,
    sweep,
    union,
)

FACES = [(0, 0, 0), (180, 0, 0), (0, 90, 0), (0, -90, 0), (90, 0, 0), (-90, 0, 0)]
"""Turns about x, y, z that bring the +z side of a cube to +z, -z, +x, -x, -y, +y."""


@household(
    category="toy_brick",
    family="toys",
    mass=0.012,
    material="plastic",
    source="Lego Duplo 2 x 4 brick: 63.8 x 31.8 x 19.2 mm + studs of 9.4 x 4.4 mm, ~12 g",
)
def toy_brick() -> list[Part]:
    stud = difference(cylinder(4.7, 5.4, 24), move(cylinder(3.2, 3, 20), z=2.9))
    studs = [
        Part(move(stud, x=x, y=y, z=18.2), "#d3202a", "plastic", "convex")
        for x in (-24, -8, 8, 24)
        for y in (-8, 8)
    ]
    shell = [  # a hollow underside between 2.5 mm walls, with a rib across
        move(prism(rect(63.8, 31.8, 0.6), 4.2, 0.5), z=15),
        *(move(box(63.8, 2.5, 15.2), y=y) for y in (-14.65, 14.65)),
        *(move(box(2.5, 26.8, 15.2), x=x) for x in (-30.65, 0, 30.65)),
    ]
    return [*(Part(wall, "#d3202a", "plastic", "convex") for wall in shell), *studs]


@household(
    category="dice",
    family="toys",
    mass=0.018,
    material="foam",
    source="common foam playing die: 50 mm edge, EVA, ~18 g (retail data)",
)
def foam_die() -> list[Part]:
    d = 12.5
    spots = {
        1: [(0, 0)],
        2: [(-d, d), (d, -d)],
        3: [(-d, d), (0, 0), (d, -d)],
        4: [(-d, -d), (-d, d), (d, -d), (d, d)],
        5: [(-d, -d), (-d, d), (0, 0), (d, -d), (d, d)],
        6: [(-d, s * d) for s in (-1, 0, 1)] + [(d, s * d) for s in (-1, 0, 1)],
    }
    pins = [
        rotate(move(cylinder(4.6, 5.2, 20), x=x, y=y, z=20), *turn)
        for turn, count in zip(FACES, (1, 6, 5, 2, 3, 4), strict=True)
        for x, y in spots[count]
    ]
    # The pips are one body: pins that stand on a core inside the die.
    pips = union(move(box(41, 41, 41), z=-20.5), *pins)
    shell = difference(move(rounded_box(50, 50, 50, 5), z=-25), pips)
    return [
        Part(move(shell, z=25), "#f4f2ec", "foam", "convex"),
        Part(move(pips, z=25), "#18181b", "foam", "convex"),
    ]


@household(
    category="puzzle_cube",
    family="toys",
    mass=0.095,
    material="plastic",
    source="common 3x3 puzzle cube: 57 mm edge, ~95 g (retail data)",
)
def puzzle_cube() -> list[Part]:
    tile = rounded(rect(17, 17), 1.8, 1)
    tiles = [move(extrude(tile, 1.4), x=19 * i, y=19 * j, z=27.5) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    side = union(move(box(40, 40, 1.5), z=26.2), *tiles)
    sides = [rotate(side, *turn) for turn in FACES]
    colors = ("#f5f5f2", "#f7d716", "#c41e3a", "#f2711c", "#0a9b4b", "#1257b5")
    core = difference(move(rounded_box(57, 57, 57, 2, 2), z=-28.5), *sides)
    return [
        Part(move(core, z=28.5), "#141416", "plastic", "convex"),
        *(Part(move(s, z=28.5), c, "plastic", "convex") for s, c in zip(sides, colors, strict=True)),
    ]


def _chess_foot(height: float) -> list[tuple[float, float]]:
    return [(0, 0), (19, 0), (19.5, 4), (18, 8), (19, 11), (17, 15), (14.5, 18), (14, height), (0, height)]


@household(
    category="chess_piece",
    family="toys",
    mass=0.052,
    material="wood",
    source="large Staunton knight, king size 3.75 in: diameter 39 x 79 mm, weighted, ~50 g",
)
def chess_knight() -> list[Part]:
    foot = revolve(_chess_foot(20), 36)
    outline = spline(
        [
            (-13, 19),
            (-16, 36),
            (-13, 55),
            (-5, 70),
            (1, 77),
            (4, 71),
            (12, 66),
            (19, 55),
            (24, 48),
            (20, 42),
            (13, 44),
            (5, 46),
            (8, 38),
            (13, 30),
            (13, 19),
        ],
        60,
    )
    head = along_y(polygon(outline), 22)
    cheeks = intersection(
        head, rotate(move(revolve([(0, 0), (14, 0), (13, 25), (11, 40), (9, 60), (0, 60)], 28), z=19), z=0)
    )
    nose = along_y(polygon(outline), 15)
    mane = [
        move(along_y(rounded(regular(4, 4.5), 0.6), 10), x=x, z=z)
        for x, z in ((-15.5, 32), (-15.3, 39), (-14.5, 46), (-12.6, 53), (-9.6, 60), (-5.5, 66))
    ]
    ears = [move(rotate(prism(rect(6, 4, 1), 10, 1), y=15), x=0, y=s * 4.5, z=67) for s in (1, -1)]
    mouth = along_y(polygon([(30, 46.5), (15, 49.5), (30, 48)]), 30)
    eyes = rotate(cylinder(2.2, 20, 14), x=90)
    eyes = move(eyes, x=7, y=10, z=60)
    nostril = move(rotate(cylinder(1.3, 15.8, 10), x=90), x=20.5, y=7.9, z=49.5)
    body = difference(union(foot, cheeks, nose, *mane, *ears), mouth, eyes, nostril)
    felt = move(cylinder(18, 2, 36), z=-1.5)
    return [
        Part(difference(body, felt), "#e2c08a", "wood"),
        Part(eyes, "#3b2615", "wood", "convex"),
        Part(nostril, "#3b2615", "wood", "convex"),
        Part(felt, "#2e6b45", "fabric", "convex"),
    ]


@household(
    category="chess_piece",
    family="toys",
    mass=0.048,
    material="wood",
    source="large Staunton rook, king size 3.75 in: diameter 39 x 66 mm, weighted, ~48 g",
)
def chess_rook() -> list[Part]:
    foot = [
        (0, 0),
        (19, 0),
        (19.5, 4),
        (18, 8),
        (19, 11),
        (17, 15),
        (14.5, 19),
        (12, 30),
        (11.5, 40),
        (14.5, 43),
        (14.5, 45),
        (12.5, 46),
        (16, 49),
        (16, 64),
        (0, 64),
    ]
    crown = move(cylinder(10, 20, 36), z=56)
    slots = [rotate(move(box(40, 5.5, 20), z=56.5), z=60 * i) for i in range(3)]
    felt = move(cylinder(18, 2, 36), z=-1.5)
    body = difference(revolve(foot, 42), crown, *slots, felt)
    return [Part(body, "#3a2418", "wood"), Part(felt, "#2e6b45", "fabric", "convex")]


def _seam(radius: float, points: int = 96) -> np.ndarray:
    """The closed curve along which the two covers of a tennis ball meet."""
    t = np.linspace(0, 2 * np.pi, points, endpoint=False)
    a, b = 0.75, 0.25
    curve = np.column_stack(
        [
            a * np.cos(t) + b * np.cos(3 * t),
            a * np.sin(t) - b * np.sin(3 * t),
            2 * np.sqrt(a * b) * np.sin(2 * t),
        ]
    )
    return radius * curve / np.linalg.norm(curve, axis=1, keepdims=True)


@household(
    category="ball",
    family="toys",
    mass=0.058,
    material="fabric",
    source="ITF tennis ball: diameter 65.4-68.6 mm, 56.0-59.4 g (YCB 056_tennis_ball)",
)
def tennis_ball() -> list[Part]:
    seam = sweep(1.6, _seam(32.4), closed=True, segments=8)
    ball = difference(sphere(33.2, 52), seam)
    return [
        Part(rotate(ball, x=25, z=20), "#cfe23a", "fabric", "convex"),
        Part(rotate(seam, x=25, z=20), "#f4f4ee", "rubber", "convex"),
    ]


@household(
    category="ball",
    family="toys",
    mass=0.065,
    material="foam",
    source="common mini foam American football: 114 x 66 mm, ~65 g (retail data)",
)
def mini_football() -> list[Part]:
    x = np.linspace(-57, 57, 29)
    r = 33 * np.clip(1 - np.abs(x / 57.5) ** 2, 0, 1) ** 0.8
    ball = along_x(revolve(np.vstack([[(0, -57)], np.column_stack([r, x])[1:-1], [(0, 57)]])[:, :2], 40))

    def band(low: float, high: float, grow: float) -> Mesh:
        inside = np.linspace(low, high, 6)
        edge = np.interp(inside, x, r) + grow
        return along_x(revolve(np.vstack([[(0, low)], np.column_stack([edge, inside]), [(0, high)]]), 40))

    stripes = [band(*b, 0.3) for b in ((-37, -30), (30, 37))]
    ridge = intersection(band(-24, 24, 1.6), move(box(50, 5, 60), z=0))
    ties = [
        intersection(band(c - 1.8, c + 1.8, 2.0), move(box(60, 17, 60), z=0)) for c in (-18, -9, 0, 9, 18)
    ]
    lace = difference(union(ridge, *ties), along_x(move(cylinder(29, 60, 24), z=-30)))
    skin_ = difference(ball, *stripes, lace)
    return [
        *(Part(move(m, z=33), "#8a4523", "foam", "convex") for m in skin_.split()),
        *(Part(move(s, z=33), "#f3f1ea", "foam", "convex") for s in stripes),
        Part(move(lace, z=33), "#f3f1ea", "foam", "convex"),
    ]


@household(
    category="dumbbell",
    family="toys",
    mass=1.0,
    material="rubber",
    source="common 1 kg neoprene dumbbell, cast iron core: 168 x 58 x 50 mm (retail data)",
)
def dumbbell() -> list[Part]:
    def head(side: float) -> Mesh:
        return move(along_x(prism(regular(6, 29, 0), 30, 4)), x=side * 68 - 15, z=25.1)

    grip = spline([(13, -55), (12, -40), (14, 0), (12, 40), (13, 55)], 24)
    handle = move(along_x(revolve(np.vstack([[(0, -55)], grip, [(0, 55)]]), 28)), z=25.1)
    plate = move(along_x(ring(17, 13, 1.6, 28)), x=82.3, z=25.1)
    heads = [difference(head(s), p) for s, p in ((1, plate), (-1, mirror(plate, "x")))]
    handle = difference(handle, *heads)
    return [
        Part(handle, "#34363c", "iron", 0.1),
        *(Part(h, "#d8327c", "iron", "convex") for h in heads),
        *(Part(p, "#f3f1ea", "rubber", "convex") for p in (plate, mirror(plate, "x"))),
    ]
