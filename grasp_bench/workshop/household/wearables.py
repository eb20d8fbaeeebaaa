"""Things that are worn, and small things from a dressing table or hall."""

from __future__ import annotations

import numpy as np

from grasp_bench.workshop.household.forms import above, along_x, between, lean, skin, slab
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Mesh,
    Polygon,
    box,
    circle,
    cylinder,
    difference,
    ellipse,
    extrude,
    figures,
    intersection,
    mirror,
    move,
    place,
    polygon,
    prism,
    rect,
    revolve,
    rotate,
    rounded,
    rounded_box,
    sphere,
    spline,
    sweep,
    union,
)


@household(
    category="lipstick",
    family="toys",
    mass=0.024,
    material="plastic",
    source="common lipstick, cap off: diameter 20 x 77 mm, ~24 g (retail data)",
)
def lipstick() -> list[Part]:
    case = prism(circle(10, segments=36), 34, 0.8)
    collar = move(cylinder(8.6, 15, 36), z=33.5)
    inner = move(cylinder(7.4, 8, 36), z=48)
    bullet = move(revolve([(0, 0), (6.3, 0), (6.3, 14), (5, 19), (2.5, 21), (0, 21.5)], 32), z=55.5)
    slant = move(rotate(box(40, 40, 30), y=48), x=1.5, z=73)
    return [
        Part(between(case, 0, 30), "#1b1a1e", "plastic", "convex"),
        Part(above(case, 30), "#d9b25a", "aluminium", "convex"),
        Part(collar, "#d9b25a", "aluminium", "convex"),
        Part(inner, "#1b1a1e", "plastic", "convex"),
        Part(difference(bullet, slant), "#c2143c", "wax", "convex"),
    ]


@household(
    category="eyeglasses",
    family="toys",
    mass=0.028,
    material="plastic",
    source="common acetate frame, size 50-18-145: 149 x 144 x 50 mm, ~28 g (retail data)",
)
def eyeglasses() -> list[Part]:
    def eye(grow: float) -> Polygon:
        return rounded(
            polygon(
                [
                    (-25 - grow, -12),
                    (-21, -20 - grow),
                    (17, -20 - grow),
                    (23 + grow, -10),
                    (25 + grow, 21 + grow),
                    (-25 - grow, 21 + grow),
                ]
            ),
            11 + grow,
        )

    lens = move(along_x(extrude(place(eye(0.3), 34), 2.2)), x=1.4, z=24.5)
    rim = move(along_x(extrude(place(eye(4.5).difference(eye(0)), 34), 5)), z=24.5)
    corner = move(rounded_box(7, 11, 9, 1.5, 2), x=1.5, y=66, z=35)
    bow = sweep(
        5.5 / 2, spline([(2.5, -10, 32), (2.5, -4, 36), (2.5, 4, 36), (2.5, 10, 32)], 10), segments=12
    )
    bow = difference(bow, rim, mirror(rim, "y"))
    path = spline([(-1, 69, 39.5), (-50, 69.5, 39.5), (-95, 68, 39), (-118, 66, 30), (-140, 64, 6)], 22)
    temple = sweep(
        rounded(rect(4.4, 8), 1.5, 2),
        path,
        scales=np.column_stack([np.ones(23), np.interp(np.arange(23), [0, 8, 16, 22], [1, 0.75, 0.8, 1.15])]),
        up=(0, 0, 1),
    )
    corner = difference(corner, rim)
    temple = difference(temple, corner)
    return [
        Part(bow, "#26221f", "plastic", "convex"),
        *(
            Part(m if side else mirror(m, "y"), color, "plastic", threshold)
            for side in (0, 1)
            for m, color, threshold in (
                (rim, "#26221f", 0.1),
                (lens, "#bfe3ee", "convex"),
                (corner, "#26221f", "convex"),
                (temple, "#26221f", None),
            )
        ),
    ]


@household(
    category="wristwatch",
    family="toys",
    mass=0.068,
    material="leather",
    source="common men's watch: case 40 x 10 mm, strap 22 mm, closed 65 x 44 x 63 mm, ~68 g (retail data)",
)
def wristwatch() -> list[Part]:
    t = np.linspace(0, 2 * np.pi, 56, endpoint=False)
    oval = np.column_stack(
        [
            31 * np.sign(np.cos(t)) * np.abs(np.cos(t)) ** 0.85,
            np.zeros(56),
            26 * np.sign(np.sin(t)) * np.abs(np.sin(t)) ** 0.7 + 27.6,
        ]
    )
    case = move(prism(circle(20, segments=44), 10, 1.5), z=51)
    lugs = [move(rounded_box(9, 22, 6, 1.5, 2), x=s * 20, z=50) for s in (1, -1)]
    dial = move(cylinder(16.5, 1.5, 36), z=60)
    marks = [
        move(rotate(move(box(4 if i % 3 else 6, 2 if i % 3 else 2.6, 2), x=13.2), z=30 * i), z=60)
        for i in range(12)
    ]
    marks = union(move(cylinder(15, 1, 24), z=59.2), *marks)
    # Twelve o'clock points along +x, where the strap leaves the case.
    hands = union(
        *(
            rotate(move(box(length, 2, 1), x=length / 2 - 1.5), z=turn)
            for length, turn in ((10, 35), (13, 155))
        ),
        cylinder(1.8, 1.4, 14),
    )
    hands = move(hands, z=61.3)
    crown = move(rotate(cylinder(2.8, 4.5, 16), x=90), y=-19.3, z=56)
    strap = sweep(rounded(rect(3, 22), 0.9, 2), oval, closed=True, up=(0, 1, 0))
    strap = difference(strap, case, *lugs)
    buckle = move(rounded_box(14, 27, 5, 1.2, 2), x=8)
    keeper = move(rounded_box(5, 24.5, 4.6, 1.2, 2), x=-10, z=0.1)
    return [
        *(Part(m, "#7a4a2b", "leather") for m in difference(strap, buckle, keeper).split() if m.volume > 50),
        Part(difference(case, dial, marks), "#c9ccd1", "steel", "convex"),
        *(Part(difference(lug, case), "#c9ccd1", "steel", "convex") for lug in lugs),
        Part(difference(dial, marks), "#16294d", "steel", "convex"),
        Part(marks, "#f4f4f0", "steel", "convex"),
        Part(hands, "#f4f4f0", "steel", "convex"),
        Part(crown, "#c9ccd1", "steel", "convex"),
        Part(buckle, "#c9ccd1", "steel", "convex"),
        Part(keeper, "#5c3620", "leather", "convex"),
    ]


@household(
    category="bell",
    family="toys",
    mass=0.26,
    material="wood",
    source="common brass hand bell: diameter 76 x 152 mm, wooden handle, ~260 g (retail data)",
)
def hand_bell() -> list[Part]:
    curve = spline([(38, 0), (34, 6), (28, 20), (25, 38), (22, 52), (12, 60)], 16)
    section = np.vstack([curve, [(0, 61), (0, 58)], (curve - [2.6, 2.6])[::-1][:-1], [(35.4, 0)]])
    shell = revolve(section, 36)
    crown = move(revolve([(0, 0), (9, 0), (9, 3), (5.5, 6), (5.5, 12), (0, 12)], 28), z=60.2)
    grip = spline(
        [(5.5, 70), (7, 76), (9.5, 92), (9, 112), (6.5, 124), (8, 132), (11, 141), (8, 150), (0, 152)], 28
    )
    handle = revolve(np.vstack([[(0, 70)], grip]), 28)
    clapper = union(move(cylinder(1.5, 50, 10), z=9.5), move(sphere(7.5, 16), z=9))
    return [
        Part(difference(shell, crown), "#d4a032", "brass", 0.2),
        Part(crown, "#d4a032", "brass", "convex"),
        Part(difference(handle, crown), "#6b3f20", "wood"),
        Part(clapper, "#8d8f94", "steel"),
    ]


@household(
    category="clothespin",
    family="toys",
    mass=0.014,
    material="wood",
    source="common jumbo wooden clothes peg with steel spring: 84 x 27 x 15 mm, ~14 g (retail data)",
)
def clothespin() -> list[Part]:
    side = polygon(
        [
            (40, 0.15),
            (40, 3.5),
            (33, 7),
            (15, 7.6),
            (13, 6.6),
            (11, 7.7),
            (0, 8.2),
            (-44, 13.5),
            (-44, 8),
            (-7, 0.6),
            (0, 0.15),
        ]
    )
    side = side.difference(
        figures(
            [circle(3.9, x=0, segments=24), circle(3.6, x=25, segments=24), circle(1.6, x=34, segments=12)]
        )
    )
    leg = extrude(side, 11)
    turns = np.array([(r, 2.1 * i + s) for i in range(7) for r, s in ((2.9, 0), (3.8, 1.05))])
    coil = revolve(np.vstack([[(0, 0)], turns, [(0, 14.7)]]), 24)
    wire = sweep(
        1.0,
        np.vstack(
            [
                np.linspace((-2, 2.6, 13), (12, 8.2, 12.4), 4),
                [(13, 8.6, 11.8)],
                np.linspace((13, 8.6, 10.5), (13, 8.6, 1), 4),
            ]
        ),
        up=(1, 0, 0),
        segments=8,
    )
    wires = [wire, move(rotate(wire, x=180), z=14)]
    return [
        Part(move(leg, z=1.5), "#d8b27c", "wood"),
        Part(move(mirror(leg, "y"), z=1.5), "#d8b27c", "wood"),
        Part(move(coil, z=-0.35), "#9a9da3", "steel", "convex"),
        *(Part(w, "#9a9da3", "steel") for w in wires),
    ]


@household(
    category="shoe",
    family="toys",
    mass=0.075,
    material="fabric",
    source="common baby canvas sneaker, EU 19: 120 x 52 x 59 mm, ~75 g (retail data)",
)
def baby_sneaker() -> list[Part]:
    footprint = spline(
        [
            (-58, 0),
            (-52, -17),
            (-25, -21),
            (10, -23),
            (35, -26),
            (55, -17),
            (62, 2),
            (54, 21),
            (30, 26),
            (0, 21),
            (-28, 20),
            (-52, 17),
        ],
        48,
        closed=True,
    )
    sole = extrude(footprint, 11)

    def last(inset: float) -> Mesh:
        return skin(
            [
                (-56 + inset, 3, 8, 14),
                (-56 + inset, 15 - inset, 2, 58),
                (-50 + inset, 18 - inset, 2, 60),
                (-20, 20 - inset, 2, 59 - inset),
                (0, 21 - inset, 2, 50 - inset),
                (22, 23.5 - inset, 2, 38 - inset),
                (42, 22.5 - inset, 2, 29 - inset),
                (55 - inset, 14 - inset, 3, 23 - inset),
                (59 - inset, 3, 8, 16),
            ],
            24,
            32,
            2.5,
        )

    outer = above(last(0), 10)
    mouth = move(extrude(ellipse(28, 16.5, segments=32), 60), x=-24.5, z=40)
    slit = move(extrude(rect(40, 11, 4), 60), x=4, z=30)
    inside = slab(above(last(3.2), 12.5), -60, 38)  # the toe cap stays solid
    cap = slab(outer, 38, 70)
    body = slab(outer, -60, 38)
    tongue = intersection(above(last(0.8), 30), move(box(45, 14, 60), x=4, z=20))
    laces = [
        difference(intersection(last(-1.6), move(rotate(box(4, 27, 40), z=turn), x=x, z=24)), last(1.5))
        for x, turn in ((4, 12), (14, -12), (24, 12))
    ]
    canvas = difference(body, inside, mouth, slit, *laces)
    tongue = difference(tongue, last(3.2), canvas, *laces)
    return [
        Part(sole, "#f6f5f0", "rubber"),
        Part(canvas, "#2458b8", "fabric", 0.1),
        Part(cap, "#f6f5f0", "rubber", "convex"),
        Part(lean(tongue), "#dfe6f2", "fabric", "convex"),
        *(Part(m, "#ffffff", "fabric", "convex") for m in laces),
    ]
