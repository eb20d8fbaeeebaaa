"""Toy cars, a train, a plane and a boat."""

from __future__ import annotations

import numpy as np

from grasp_bench.workshop.household.forms import above, along_x, along_y, axle, bar, between, lean, skin
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Mesh,
    box,
    cylinder,
    difference,
    ellipse,
    ellipsoid,
    extrude,
    hull,
    intersection,
    mirror,
    move,
    polygon,
    prism,
    rect,
    revolve,
    rotate,
    rounded,
    rounded_box,
    scale,
    sphere,
    union,
)


def _both(mesh: Mesh) -> tuple[Mesh, Mesh]:
    """A part and its mirror image on the other side."""
    return mesh, mirror(mesh, "y")


@household(
    category="toy_car",
    family="toys",
    mass=0.115,
    material="aluminium",
    source="die-cast VW Beetle at about 1:36 (real 4079 x 1540 x 1500 mm): 111 x 45 x 42 mm, ~115 g",
)
def beetle_car() -> list[Part]:
    hood = skin(
        [
            (55, 5, 10, 14),
            (50, 12, 8, 22),
            (36, 15, 6, 28),
            (15, 17, 6, 29),
            (-10, 18, 6, 30),
            (-36, 16, 6, 29),
            (-50, 12, 8, 20),
            (-55, 5, 10, 13),
        ],
        12,
        24,
        2.6,
    )
    dome = skin(
        [
            (21, 12, 20, 25),
            (14, 15, 18, 33),
            (4, 16.5, 18, 40.5),
            (-8, 17, 18, 42),
            (-22, 16, 18, 39),
            (-34, 13, 18, 32),
            (-42, 8, 18, 24),
        ],
        12,
        24,
        2.8,
    )
    fender = union(
        *(move(ellipsoid(15, 9, 14, 20), x=x, y=14, z=9) for x in (33, -33)),
        move(rounded_box(40, 8, 4, 1.5), y=18, z=6),
    )
    arches = [rotate(cylinder(10.5, 60, 24), x=90) for _ in range(2)]
    gaps = [
        difference(move(a, x=x, y=30, z=9), box(200, 26, 60)) for a, x in zip(arches, (33, -33), strict=True)
    ]
    shell = above(difference(union(hood, dome, *_both(fender)), *gaps), 5)
    side = rounded(polygon([(13, 30), (5, 38.5), (-4, 39.5), (-4, 30)]), 1.5)
    rear = rounded(polygon([(-7, 30), (-7, 39.5), (-18, 38), (-25, 33), (-25, 30)]), 1.5)
    pane = move(along_x(extrude(rect(25, 8, 2), 80)), x=-40, z=35)
    panes = union(along_y(side, 60), along_y(rear, 60), pane)
    grown = move(scale(move(dome, x=8, z=-18), 1.03, 1.03, 1.01), x=-8, z=18)
    glass = intersection(grown, panes)
    lamps = union(*_both(move(sphere(4.6, 12), x=44, y=15.5, z=17)), bar(1, 31, x=44, z=17, segments=8))
    chrome = [Part(bar(2, 28, x=x, z=10, segments=8), "#c9ccd1", "steel", "convex") for x in (53.5, -53.5)]
    return [
        Part(lean(difference(shell, glass, lamps), 0.1), "#58a9d6", "aluminium", 0.1),
        Part(lean(glass), "#20262e", "plastic", "convex"),
        Part(lamps, "#f4f1dc", "plastic", "convex"),
        *chrome,
        *axle(9, 8, 44, 33),
        *axle(9, 8, 44, -33),
    ]


@household(
    category="toy_car",
    family="toys",
    mass=0.21,
    material="plastic",
    source="common plastic sandbox tipper, small: 155 x 67 x 79 mm, ~210 g (retail data)",
)
def dump_truck() -> list[Part]:
    chassis = move(rounded_box(142, 34, 20, 2), x=-2, z=11)
    cab = along_y(rounded(polygon([(27, 21), (72, 21), (72, 44), (62, 48), (56, 74), (27, 74)]), 3), 60)
    arch = move(rotate(cylinder(17.5, 70, 28), x=90), x=44, y=35, z=16)
    side = rounded(polygon([(30, 48), (57, 48), (52, 68), (30, 68)]), 2)
    front = extrude(rect(48, 19, 2), 60)
    glass = union(
        along_y(side, 61),
        intersection(
            move(along_x(front), x=30, z=59),
            along_y(polygon([(27, 21), (73, 21), (73, 44), (62.6, 48), (56.6, 74.6), (24, 74)]), 70),
        ),
    )
    lamps = union(
        *_both(move(along_x(cylinder(5, 6, 20)), x=66.6, y=20, z=32)),
        move(bar(1.5, 40, z=32, segments=8), x=68),
    )
    grille = move(box(2, 22, 9), x=71.6, z=27)
    bed = along_y(
        polygon([(20, 30), (-72, 30), (-82, 70), (22, 70), (22, 79), (46, 79), (46, 76), (27, 76)]), 64
    )
    load = union(along_y(polygon([(16.5, 34), (-68, 34), (-80, 81), (24.3, 81)]), 57))
    return [
        Part(chassis, "#3a3d42", "plastic", "convex"),
        Part(difference(cab, glass, lamps, grille, arch, chassis), "#d3302c", "plastic", "convex"),
        Part(glass, "#bfe0f2", "plastic", "convex"),
        Part(lamps, "#fff4c2", "plastic", "convex"),
        Part(grille, "#2b2d31", "plastic", "convex"),
        Part(difference(bed, load), "#f4b61a", "plastic"),
        *axle(16, 15, 66, 44, hub="#f4b61a"),
        *axle(16, 15, 66, -40, hub="#f4b61a"),
    ]


def _roof_arch() -> np.ndarray:
    """Cross-section (y, z) of an arched cab roof."""
    top = np.column_stack([np.linspace(-27, 27, 15), 11 - 8 * np.linspace(-1, 1, 15) ** 2])
    return np.vstack([[(-27, 0)], top, [(27, 0)]])[::-1]


@household(
    category="toy_train",
    family="toys",
    mass=0.19,
    material="wood",
    source="common wooden pull-along steam engine: 139 x 57 x 81 mm, beech, ~190 g (retail data)",
)
def steam_locomotive() -> list[Part]:
    frame = move(rounded_box(128, 36, 11, 2), z=11)
    boiler = move(along_x(cylinder(18, 68, 36)), x=-12, z=38)
    smokebox = move(
        along_x(prism(polygon(np.asarray(rect(37, 37, 18.4).exterior.coords)[:-1]), 16, 1.5)), x=48, z=38
    )
    door = move(along_x(prism(ellipse(11, 11), 3, 1)), x=62.5, z=38)
    stack = move(revolve([(0, 0), (6, 0), (6, 14), (10, 22), (10, 27), (0, 27)], 28), x=52, z=54)
    steam = move(revolve([(0, 0), (8, 0), (8, 5), (6, 10), (0, 13)], 28), x=14, z=53)
    cab = move(rounded_box(42, 46, 48, 2), x=-37, z=21)
    window = move(rotate(extrude(rect(24, 17, 3), 60), x=90), x=-37, y=30, z=53)
    window = union(window, move(along_x(extrude(rect(32, 17, 3), 60)), x=-70, z=53))
    roof = move(along_x(extrude(_roof_arch(), 54)), x=-64, z=64)
    catcher = hull(
        move(box(2, 40, 3), x=62, z=15), move(box(2, 40, 3), x=62, z=4), move(box(2, 8, 3), x=74, z=4)
    )
    rod = move(rounded_box(72, 3, 5, 1, 2), x=-2, y=27.3, z=11)
    return [
        Part(frame, "#33363b", "wood", "convex"),
        Part(difference(boiler, cab), "#2e8b57", "wood", "convex"),
        Part(smokebox, "#26282c", "wood", "convex"),
        Part(door, "#d8a531", "wood", "convex"),
        Part(stack, "#26282c", "wood"),
        Part(steam, "#d8a531", "wood", "convex"),
        Part(difference(cab, window), "#c8352b", "wood"),
        Part(roof, "#26282c", "wood", "convex"),
        Part(catcher, "#c8352b", "wood", "convex"),
        *(Part(r, "#d8a531", "wood", "convex") for r in _both(rod)),
        *axle(13, 8, 52, 32, hub="#c8352b", tyre="#26282c"),
        *axle(13, 8, 52, 0, hub="#c8352b", tyre="#26282c"),
        *axle(16, 8, 52, -37, hub="#c8352b", tyre="#26282c"),
    ]


@household(
    category="toy_plane",
    family="toys",
    mass=0.16,
    material="wood",
    source="common wooden toy propeller plane: 162 x 164 x 72 mm, ~160 g (retail data)",
)
def toy_plane() -> list[Part]:
    hull_ = skin(
        [
            (62, 13, 17, 43),
            (50, 19, 12, 48),
            (25, 20, 10, 50),
            (-10, 17, 13, 49),
            (-50, 10, 24, 46),
            (-78, 6, 33, 44),
            (-80, 2, 37, 41),
        ],
        18,
        28,
        2.5,
    )
    cowl = move(along_x(prism(ellipse(18, 18, segments=36), 14, 3)), x=55, z=30)
    wing = move(prism(rect(42, 164, 14), 6, 1.5), x=18, z=15)
    tail = move(prism(rect(24, 64, 9), 5, 1.5), x=-66, z=36)
    fin = move(along_y(rounded(polygon([(-82, 40), (-50, 40), (-68, 72), (-82, 72)]), 4), 7), z=0)
    seat = move(ellipsoid(16, 11, 13, 28), x=12, z=48)
    blade = hull(move(ellipsoid(2, 3.5, 3, 12), z=6), move(ellipsoid(2, 6, 5, 16), z=30))
    blades = [move(rotate(blade, x=angle), x=71, z=30) for angle in (35, 215)]
    spinner = move(along_x(revolve([(0, 0), (6, 0), (6, 4), (4, 9), (0, 12)], 24)), x=68, z=30)
    legs = [move(rotate(box(7, 5, 22), x=s * -12), x=30, y=s * 19, z=6) for s in (1, -1)]
    body = difference(hull_, wing, cowl, tail, fin)
    return [
        Part(body, "#d6362e", "wood", "convex"),
        Part(cowl, "#f2f0ea", "wood", "convex"),
        Part(wing, "#f2b632", "wood", "convex"),
        Part(tail, "#f2b632", "wood", "convex"),
        Part(difference(fin, tail), "#f2b632", "wood", "convex"),
        Part(difference(seat, hull_), "#8cc9ea", "plastic", "convex"),
        *(Part(difference(b, spinner), "#4a3728", "wood", "convex") for b in blades),
        Part(spinner, "#4a3728", "wood", "convex"),
        *(Part(between(leg, 0, 15.5), "#5b5e64", "plastic", "convex") for leg in legs),
        *axle(9, 7, 56, 30),
    ]


@household(
    category="toy_boat",
    family="toys",
    mass=0.14,
    material="plastic",
    source="common bath tugboat: 148 x 58 x 78 mm, polypropylene, ~140 g (retail data)",
)
def toy_boat() -> list[Part]:
    hull_ = skin(
        [
            (-70, 20, 2, 30),
            (-66, 26, 0, 31),
            (-30, 29, -4, 29),
            (15, 29, -4, 29),
            (50, 18, 0, 35),
            (72, 5, 12, 41),
            (78, 1.5, 30, 43),
        ],
        18,
        28,
        3.2,
    )
    deck = np.asarray(
        [
            (-63, 22),
            (-30, 25),
            (15, 25),
            (46, 15),
            (62, 5),
            (62, -5),
            (46, -15),
            (15, -25),
            (-30, -25),
            (-63, -22),
        ]
    )
    well = move(extrude(deck, 40), z=21)
    body = difference(hull_, well)
    plank = move(extrude(deck, 3), z=19.5)
    lower = between(above(body), 0, 10)
    cabin = move(rounded_box(58, 36, 22, 3), x=-8, z=21)
    bridge = move(rounded_box(32, 30, 24, 3), x=4, z=41)
    holes = [rotate(cylinder(5, 37, 20), x=90) for _ in range(2)]
    ports = [move(h, x=x, y=18.5, z=32) for h, x in zip(holes, (-22, -4), strict=True)]
    panes = union(
        move(rotate(extrude(rect(22, 10, 2), 30.8), x=90), x=4, y=15.4, z=55),
        move(along_x(extrude(rect(22, 10, 2), 16.4)), x=4, z=55),
    )
    roof = move(prism(rect(40, 36, 5), 5, 1.5), x=4, z=63)
    funnel = move(rotate(cylinder(8.5, 36, 28), y=-6), x=-24, z=41)
    return [
        Part(difference(above(body), lower, plank), "#d5342d", "plastic"),
        Part(lower, "#1f3f73", "plastic", "convex"),
        Part(plank, "#d9b57a", "plastic", "convex"),
        Part(difference(cabin, *ports, plank), "#f5f4ef", "plastic", "convex"),
        Part(difference(bridge, panes), "#f5f4ef", "plastic", "convex"),
        *(Part(p, "#2a6fb0", "plastic", "convex") for p in ports),
        Part(panes, "#2a4a66", "plastic", "convex"),
        Part(roof, "#f2b632", "plastic", "convex"),
        Part(above(funnel, 69), "#22252a", "plastic", "convex"),
        Part(difference(between(funnel, 40, 69), bridge), "#f2b632", "plastic", "convex"),
    ]
