"""Tools for hair, beard and teeth."""

from __future__ import annotations

import numpy as np

from grasp_bench.workshop.household.forms import along_x, skin, slab
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    box,
    circle,
    cylinder,
    difference,
    ellipse,
    extrude,
    hull,
    intersection,
    move,
    prism,
    rect,
    revolve,
    rotate,
    rounded,
    rounded_box,
    spline,
    sweep,
    union,
)


@household(
    category="toothbrush",
    family="toys",
    mass=0.022,
    material="plastic",
    source="common children's chunky-grip toothbrush: 160 x 17 x 23 mm, ~22 g (retail data)",
)
def kids_toothbrush() -> list[Part]:
    handle = skin(
        [
            (-80, 2, 5, 9),
            (-77, 6, 2, 12),
            (-60, 8.5, 0, 14),
            (-30, 7.5, 1, 14),
            (-8, 8, 0.5, 14),
            (8, 5, 3, 11),
            (35, 3.5, 5, 10),
            (45, 4.5, 4.5, 9.5),
        ],
        22,
        24,
        2.3,
    )
    head = move(prism(ellipse(20, 7, segments=32), 6, 1.2), x=60, z=4)
    grips = [
        intersection(
            skin([(-66, 8.8, -0.3, 14.4), (-30, 8, 0.5, 14.5), (-8, 8.4, 0, 14.5)], 12, 24, 2.3),
            move(box(9, 40, 30), x=x),
        )
        for x in (-56, -40, -24)
    ]
    tufts = [(x, w) for x, w in zip((46, 52.5, 59, 65.5, 72), (6, 10, 11, 10, 7), strict=True)]
    rows = [move(rotate(rounded_box(4.6, w, 13, 0.8, 2), x=0), x=x, z=9.5) for x, w in tufts]
    colors = ("#3d8fd6", "#f7f7f4", "#f7f7f4", "#f7f7f4", "#3d8fd6")
    stem = difference(handle, head, *grips)
    return [
        *(Part(m, "#37b24d", "plastic") for m in stem.split()),
        Part(head, "#37b24d", "plastic", "convex"),
        *(Part(g, "#f7d716", "rubber", "convex") for g in grips),
        *(Part(m, c, "bristle", "convex") for m, c in zip(rows, colors, strict=True)),
    ]


@household(
    category="hairbrush",
    family="toys",
    mass=0.085,
    material="plastic",
    source="common cushion hairbrush, travel size: 200 x 56 x 38 mm, ~85 g (retail data)",
)
def hairbrush() -> list[Part]:
    back = skin(
        [
            (-12, 9, 1, 17),
            (0, 18, 0, 17),
            (20, 26, 0, 17),
            (45, 28, 0, 17),
            (75, 23, 0, 17),
            (92, 11, 3, 16),
            (96, 2, 7, 12),
        ],
        16,
        32,
        2.6,
    )
    handle = skin(
        [
            (-104, 2, 7, 11),
            (-100, 8, 3, 16),
            (-80, 11.5, 0, 18),
            (-55, 10.5, 0, 18),
            (-25, 8, 1, 16.5),
            (-10, 10, 1, 17),
        ],
        16,
        28,
        2.4,
    )
    pad = move(prism(ellipse(40, 21, segments=32), 6, 2), x=44, z=14)
    wood = difference(union(back, handle), pad)
    pins = [
        move(cylinder(1.2, 20, 6, top=1.0), x=44 + x, y=y, z=18)
        for y, count in ((-15, 5), (-7.5, 7), (0, 7), (7.5, 7), (15, 5))
        for x in np.linspace(-5.2 * (count - 1), 5.2 * (count - 1), count)
    ]
    base = move(prism(ellipse(37, 18, segments=24), 2, 0.5), x=44, z=18.4)
    return [
        Part(wood, "#7a2f6b", "plastic"),
        Part(pad, "#f0c7d8", "rubber", "convex"),
        Part(union(base, *pins), "#2a2430", "plastic", "convex"),
    ]


@household(
    category="razor",
    family="toys",
    mass=0.045,
    material="plastic",
    source="common cartridge razor: 147 x 42 x 32 mm, ~45 g (retail data)",
)
def cartridge_razor() -> list[Part]:
    path = spline([(-70, 0, 8), (-40, 0, 10), (0, 0, 9), (40, 0, 12), (62, 0, 20)], 26)
    size = np.interp(np.linspace(0, 1, 27), [0, 0.08, 0.3, 0.55, 0.85, 1], [0.7, 1, 1.05, 0.9, 0.75, 0.55])
    handle = sweep(ellipse(8, 7.2, segments=24), path, scales=size)
    tilt = {"y": 52, "about": (66, 0, 22)}
    head = rotate(move(hull(box(24, 42, 4), move(box(19, 39, 7.5), z=0)), x=66, z=20), **tilt)
    blades = [rotate(move(box(1.6, 35, 1.4), x=66 + dx, z=26.7), **tilt) for dx in (-4.5, -0.5, 3.5)]
    strip = rotate(move(box(3.2, 35, 1.4), x=58, z=26.6), **tilt)
    guard = rotate(move(box(2.4, 35, 1.6), x=73.5, z=26.2), **tilt)
    neck = rotate(move(hull(box(6, 16, 1), move(box(10, 26, 1), z=6)), x=65, z=15), **tilt)
    handle = difference(handle, neck, head)
    sleeve = sweep(ellipse(8.5, 7.7, segments=24), path, scales=size)
    bands = [slab(sleeve, x, x + 4) for x in (-48, -39, -30, -21)]
    return [
        *(Part(m, "#2563c9", "plastic") for m in difference(handle, *bands).split()),
        *(Part(b, "#1c2026", "rubber", "convex") for b in bands),
        Part(difference(neck, head), "#c3c8cf", "plastic", "convex"),
        Part(head, "#23262b", "plastic", "convex"),
        *(Part(b, "#d5dade", "steel", "convex") for b in blades),
        Part(strip, "#49c7b4", "rubber", "convex"),
        Part(guard, "#2563c9", "rubber", "convex"),
    ]


@household(
    category="hair_dryer",
    family="toys",
    mass=0.42,
    material="plastic",
    source="common 1200 W travel hair dryer: 167 x 62 x 179 mm, ~420 g without cord (retail data)",
)
def hair_dryer() -> list[Part]:
    barrel = revolve([(0, -60), (25, -60), (29, -52), (31, -30), (31, 0), (29, 40), (26, 66), (0, 66)], 36)
    bore = move(cylinder(21, 100, 32), z=30)
    ribs = union(*(move(box(60, 3, 4), y=y, z=-61) for y in (-14, -7, 0, 7, 14)))
    grill = intersection(ribs, move(cylinder(20, 10, 28), z=-64))
    intake = union(move(cylinder(23, 3, 32), z=-61.5), grill)
    nozzle = hull(move(extrude(circle(25.8, segments=36), 1), z=64), move(extrude(rect(62, 16, 6), 1), z=104))
    slot = hull(move(extrude(circle(21, segments=32), 1), z=63.5), move(extrude(rect(57, 11, 4), 1), z=104.5))
    barrel, intake, nozzle, bore = (
        move(along_x(m), z=132) for m in (barrel, intake, difference(nozzle, slot), bore)
    )
    handle = sweep(
        rounded(rect(40, 33), 13, 3),
        spline([(-16, 0, 0), (-10, 0, 50), (-14, 0, 112)], 12),
        scales=np.linspace(0.92, 1.05, 13),
        up=(0, 1, 0),
    )
    handle = difference(handle, barrel)
    keys = [move(rotate(rounded_box(7, 13, 16, 2, 2), y=-5), x=x, z=z) for x, z in ((8, 78), (8, 55))]
    cord = hull(move(cylinder(7, 4, 16), x=-15.5, z=-2), move(cylinder(4, 4, 16), x=-15.5, z=-16))
    body = difference(barrel, bore, intake)
    return [
        Part(body, "#8e2f6e", "plastic"),
        Part(intake, "#2b2b30", "plastic", "convex"),
        Part(nozzle, "#2b2b30", "plastic"),
        Part(difference(handle, *keys), "#8e2f6e", "plastic"),
        *(Part(k, "#e8e8ea", "plastic", "convex") for k in keys),
        Part(cord, "#2b2b30", "rubber", "convex"),
    ]
