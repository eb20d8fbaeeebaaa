"""Bottles, tubes and rolls from the bathroom shelf."""

from __future__ import annotations

import numpy as np

from grasp_bench.workshop.household.forms import along_x, along_y, between, slab
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Mesh,
    bezier,
    box,
    circle,
    cylinder,
    difference,
    extrude,
    intersection,
    loft,
    move,
    polygon,
    prism,
    rect,
    revolve,
    ring,
    rotate,
    rounded,
    spline,
    star,
    sweep,
)


@household(
    category="toothpaste",
    family="toys",
    mass=0.1,
    material="plastic",
    source="common 75 ml toothpaste tube: 156 x 53 x 34 mm, ~100 g full (retail data)",
)
def toothpaste_tube() -> list[Part]:
    def section(x: float, ry: float, rz: float, dip: float) -> np.ndarray:
        t = np.linspace(0, 2 * np.pi, 36, endpoint=False)
        return np.column_stack([np.full(36, x), ry * np.cos(t), dip + rz * np.sin(t)])

    # Half-axes keep the girth of a round tube that is pressed flat at one end.
    stages = [
        (0, 17, 17, 17),
        (30, 18.2, 15.6, 15.6),
        (65, 21, 12, 12),
        (95, 24, 7.5, 7.8),
        (112, 26, 3.2, 4.4),
        (119, 26.4, 1.7, 3.4),
    ]
    tube = loft([section(-x, ry, rz, dip) for x, ry, rz, dip in stages])
    crimp = move(box(9, 53, 2.6), x=-122, z=2.1)
    shoulder = move(along_x(cylinder(17, 5, 36, top=13)), z=17)
    cap = move(along_x(extrude(star(20, 14.5, 13.3), 24, taper=0.9)), x=5, z=17)
    label, stripe = slab(tube, -84, -22), move(rotate(box(15, 120, 90), z=38), x=-52, z=-5)
    white = [slab(tube, -22, 0), slab(tube, -103, -84), intersection(label, stripe)]
    return [
        *(Part(m, "#f5f6f7", "plastic", "convex") for m in white),
        Part(shoulder, "#f5f6f7", "plastic", "convex"),
        *(Part(m, "#d6202c", "plastic", "convex") for m in difference(label, stripe).split()),
        Part(slab(tube, -119, -103), "#1b58b8", "plastic", "convex"),
        Part(crimp, "#1b58b8", "plastic", "convex"),
        Part(cap, "#1b58b8", "plastic", "convex"),
    ]


@household(
    category="soap_dispenser",
    family="toys",
    mass=0.28,
    material="plastic",
    source="common 250 ml pump soap, nearly full: 74 x 63 x 159 mm, ~280 g (retail data)",
)
def pump_soap() -> list[Part]:
    body = revolve(
        [(0, 0), (28, 0), (31, 3), (31, 84), (29, 93), (23, 100), (14, 104), (14, 110), (0, 110)], 40
    )
    label = revolve([(0, 22), (31.4, 22), (31.4, 78), (0, 78)], 40)
    leaf = intersection(
        revolve([(0, 20), (31.9, 20), (31.9, 80), (0, 80)], 40),
        move(
            along_x(
                extrude(
                    polygon(
                        np.vstack(
                            [
                                bezier((0, -17), (17, -4), (0, 19), segments=10),
                                bezier((0, 19), (-17, -4), (0, -17), segments=10)[1:-1],
                            ]
                        )
                    ),
                    40,
                )
            ),
            x=22,
            z=50,
        ),
    )
    collar = move(extrude(star(22, 17, 16.2), 15), z=107)
    stem = move(cylinder(4.5, 26, 20), z=121)
    spout = sweep(
        rounded(rect(11, 9), 2.5, 2),
        spline([(-9, 0, 153), (10, 0, 154), (32, 0, 152), (41, 0, 145)], 14),
        scales=np.linspace(1, 0.6, 15),
    )
    knob = move(prism(circle(13, segments=32), 13, 2), z=146)
    return [
        *(Part(between(body, a, b), "#8fd0b4", "plastic", "convex") for a, b in ((0, 22), (78, 107.2))),
        Part(difference(label, leaf), "#f6f6f0", "plastic", "convex"),
        Part(leaf, "#2f8f5b", "plastic", "convex"),
        Part(collar, "#f6f6f4", "plastic", "convex"),
        Part(stem, "#d8dada", "plastic", "convex"),
        Part(difference(knob, stem), "#f6f6f4", "plastic", "convex"),
        Part(difference(spout, knob), "#f6f6f4", "plastic"),
    ]


@household(
    category="toilet_roll",
    family="toys",
    mass=0.06,
    material="paper",
    source="half-used toilet roll: diameter 72 x 98 mm, core 42 mm, ~60 g (retail data)",
)
def toilet_roll() -> list[Part]:
    core = ring(21.5, 19.5, 98, 40)
    paper = ring(36, 21.5, 98, 44)
    turn = np.radians(np.linspace(-60, 25, 14))
    outer = np.column_stack([37.2 * np.cos(turn), 37.2 * np.sin(turn)])
    tail = np.vstack([outer, outer[-1] + [(2, 8), (5, 16), (6, 24)]])
    inner = np.vstack(
        [
            tail[-1] + [(-2, 0)],
            tail[-2] + [(-2.2, 0.4)],
            tail[-3] + [(-2.3, 0.8)],
            np.column_stack([35.2 * np.cos(turn), 35.2 * np.sin(turn)])[::-1],
        ]
    )
    sheet = difference(extrude(polygon(np.vstack([tail, inner])), 98), cylinder(35.9, 98, 44))
    return [
        Part(paper, "#f4f2ee", "paper"),
        Part(core, "#b58a5c", "cardboard"),
        Part(sheet, "#fbfaf7", "paper"),
    ]


@household(
    category="spray_bottle",
    family="toys",
    mass=0.24,
    material="plastic",
    source="common 600 ml trigger sprayer, a quarter full: 94 x 64 x 238 mm, ~240 g (retail data)",
)
def spray_bottle() -> list[Part]:
    def body(grow: float) -> Mesh:
        rings = [
            (0, 35, 28),
            (3, 38, 31),
            (60, 38, 31),
            (120, 36, 30),
            (140, 30, 27),
            (152, 18, 18),
            (158, 13, 13),
            (166, 13, 13),
        ]
        t = np.linspace(0, 2 * np.pi, 40, endpoint=False)
        power = [2.8] * 5 + [2.2, 2, 2]
        return loft(
            [
                np.column_stack(
                    [
                        (rx + grow) * np.sign(np.cos(t)) * np.abs(np.cos(t)) ** (2 / p),
                        (ry + grow) * np.sign(np.sin(t)) * np.abs(np.sin(t)) ** (2 / p),
                        np.full(40, z),
                    ]
                )
                for (z, rx, ry), p in zip(rings, power, strict=True)
            ]
        )

    collar = move(extrude(star(24, 17, 16.2), 18), z=163)
    head = along_y(
        rounded(
            polygon(
                [
                    (-20, 196),
                    (-38, 214),
                    (-36, 228),
                    (-20, 238),
                    (30, 236),
                    (44, 230),
                    (44, 212),
                    (14, 208),
                    (13, 181),
                    (-13, 181),
                ]
            ),
            5,
        ),
        25,
    )
    nozzle = move(along_x(prism(rect(20, 20, 4), 12, 1.5)), x=43, z=221)
    trigger = along_y(
        polygon(
            np.vstack(
                [
                    spline([(36, 214), (34, 200), (37, 186), (48, 172)], 10),
                    spline([(42, 169), (29, 184), (25, 199), (24, 214)], 10),
                ]
            )
        ),
        12,
    )
    mark = intersection(body(0.9), move(along_x(cylinder(19, 100, 28)), x=-50, z=80))
    band, whole = body(0.5), body(0)
    return [
        *(Part(between(whole, a, b), "#3f8fe0", "plastic", "convex") for a, b in ((0, 28), (112, 163))),
        *(
            Part(difference(between(band, a, b), mark), "#f5f6f7", "plastic", "convex")
            for a, b in ((28, 36), (46, 112))
        ),
        Part(between(band, 36, 46), "#e4572e", "plastic", "convex"),
        Part(mark, "#e4572e", "plastic", "convex"),
        Part(collar, "#e4572e", "plastic", "convex"),
        Part(difference(head, collar, trigger), "#f5f6f7", "plastic"),
        Part(difference(nozzle, head), "#e4572e", "plastic", "convex"),
        Part(trigger, "#e4572e", "plastic"),
    ]
