"""Toy animals and dolls."""

from __future__ import annotations

import numpy as np

from grasp_bench.workshop.household.forms import above, along_x, bar, between, skin
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Mesh,
    difference,
    ellipse,
    ellipsoid,
    extrude,
    hull,
    intersection,
    mirror,
    move,
    revolve,
    rotate,
    sphere,
    spline,
    union,
)


def _both(mesh: Mesh) -> tuple[Mesh, Mesh]:
    """A part and its mirror image on the other side."""
    return mesh, mirror(mesh, "y")


@household(
    category="rubber_duck",
    family="toys",
    mass=0.055,
    material="rubber",
    source="common bath duck: 95 x 71 x 80 mm, vinyl, 50-60 g (retail data)",
)
def rubber_duck() -> list[Part]:
    body = above(
        skin(
            [
                (-45, 2, 44, 48),
                (-40, 12, 30, 49),
                (-27, 26, 6, 43),
                (-4, 32, -3, 39),
                (18, 31, -3, 42),
                (32, 20, 4, 40),
                (39, 3, 18, 26),
            ]
        )
    )
    head = difference(move(sphere(22, 32), x=15, z=58), body)
    bill = hull(move(ellipsoid(13, 11, 2.5, 20), x=37, z=56), move(ellipsoid(6, 9, 5, 16), x=33, z=57))
    bill = difference(union(bill, move(ellipsoid(10, 8, 2.5, 20), x=35, z=51.5)), head)
    wing = rotate(ellipsoid(19, 5, 11, 24), y=18)
    wings = [difference(w, body) for w in _both(move(wing, x=-8, y=30.5, z=25))]
    return [
        Part(body, "#f7cf1d", "rubber"),
        Part(head, "#f7cf1d", "rubber", "convex"),
        Part(bill, "#ef7d1a", "rubber", "convex"),
        Part(bar(3.6, 25, x=30, z=64), "#15151a", "rubber", "convex"),
        *(Part(w, "#e9b90f", "rubber", "convex") for w in wings),
    ]


@household(
    category="teddy_bear",
    family="toys",
    mass=0.065,
    material="fabric",
    source="common 12 cm sitting plush bear: 86 x 82 x 118 mm, ~65 g (retail data)",
)
def teddy_bear() -> list[Part]:
    trunk = above(move(ellipsoid(27, 29, 37, 28), z=31))
    head = difference(move(ellipsoid(27, 30, 26, 28), x=3, z=85), trunk)
    muzzle = difference(move(ellipsoid(12, 13, 10, 20), x=27, z=80), head)
    nose = move(ellipsoid(4, 5.5, 3.8, 14), x=37, z=84)
    belly = difference(move(ellipsoid(6, 18, 22, 20), x=23.5, z=34), trunk)
    ear = move(ellipsoid(6, 11, 11, 20), x=2, y=25, z=107)
    inner = move(ellipsoid(3, 7, 7, 14), x=6.5, y=25, z=107)
    arm = difference(move(rotate(ellipsoid(10, 10, 22, 20), x=18, y=-35), x=9, y=29, z=47), trunk)
    leg = difference(above(move(ellipsoid(28, 14, 15, 24), x=30, y=22, z=13)), trunk, belly)
    pad = move(ellipsoid(3, 9, 9.5, 18), x=56.3, y=22, z=14)
    fur = [head, *_both(difference(ear, head, inner)), *_both(arm), *_both(difference(leg, pad))]
    cream = [muzzle, belly, *_both(difference(inner, head)), *_both(pad)]
    dark = [nose, *_both(move(sphere(3.6, 14), x=26, y=11, z=93))]
    return [
        Part(trunk, "#a9713f", "fabric", "convex"),
        *(Part(m, "#a9713f", "fabric", "convex") for m in fur),
        *(Part(m, "#ecd3a8", "fabric", "convex") for m in cream),
        *(Part(m, "#1d1a18", "plastic", "convex") for m in dark),
    ]


@household(
    category="doll",
    family="toys",
    mass=0.095,
    material="wood",
    source="common matryoshka outer doll: diameter 58 x 110 mm, lime wood, ~95 g (retail data)",
)
def nesting_doll() -> list[Part]:
    outline = spline(
        [(22, 0), (27, 12), (29, 32), (25, 56), (19.5, 68), (20.5, 84), (17, 99), (8, 108.5), (0, 110)], 40
    )
    outline = np.vstack([[(0, 0)], outline[:-1], [(0, outline[-1, 1])]])

    def layer(grow: float = 0.0) -> Mesh:
        return revolve(np.column_stack([outline[:, 0] + grow * (outline[:, 0] > 0), outline[:, 1]]), 36)

    body = layer()

    def patch(ry: float, rz: float, z: float, y: float = 0.0, deep: float = 0.0, grow: float = 0.5) -> Mesh:
        mark = move(along_x(extrude(ellipse(ry, rz, segments=24), 60)), x=deep, y=y, z=z)
        return intersection(layer(grow), mark)

    hair, face = patch(15, 15.5, 86, deep=6, grow=0.4), patch(12, 13, 84, deep=5, grow=0.8)
    apron = patch(17, 20, 33, deep=12)
    flower = [patch(5.5, 5.5, 34, deep=14, grow=0.9), patch(2.2, 2.2, 34, deep=15, grow=1.3)]
    leaves = [patch(2.5, 5, 23, y=s * 4, deep=14, grow=0.8) for s in (1, -1)]
    eyes = [patch(1.7, 1.9, 87, y=s * 4.6, deep=10, grow=1.2) for s in (1, -1)]
    cheeks = [patch(2.6, 2.3, 80, y=s * 7.2, deep=8, grow=1.1) for s in (1, -1)]
    mouth = patch(2.6, 1.3, 76.5, deep=10, grow=1.2)
    shawl, dress = above(body, 62), between(body, 0, 62)
    return [
        Part(difference(dress, apron), "#c42a30", "wood", "convex"),
        Part(difference(shawl, hair, face), "#f0b323", "wood", 0.1),
        Part(difference(hair, face), "#5a3320", "wood", "convex"),
        Part(face, "#f6d7b5", "wood", "convex"),
        Part(apron, "#f6efdc", "wood", "convex"),
        Part(flower[0], "#d63b63", "wood", "convex"),
        Part(flower[1], "#f0b323", "wood", "convex"),
        *(Part(m, "#3b8a4a", "wood", "convex") for m in leaves),
        *(Part(m, "#1b1b22", "wood", "convex") for m in eyes),
        *(Part(m, "#eb9a8e", "wood", "convex") for m in cheeks),
        Part(mouth, "#c2242c", "wood", "convex"),
    ]
