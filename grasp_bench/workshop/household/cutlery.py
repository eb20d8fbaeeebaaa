"""Things that cut, carve, scoop and pound, with proper handles."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from grasp_bench.workshop.household.utensils import BEECH, BLACK, STEEL, bowl, grip, rod, turned
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Mesh,
    arc,
    bezier,
    box,
    circle,
    cylinder,
    difference,
    extrude,
    hull,
    mirror,
    move,
    polygon,
    prism,
    rect,
    rotate,
    sphere,
    spline,
    star,
    stroke,
    sweep,
    union,
)

WALNUT = "#6b4226"


def rivets(*places: float, proud: float) -> list[Part]:
    """Steel rivets through a lying handle at ``places`` along x, ``proud`` half as long."""
    return [Part(move(cylinder(3, 2 * proud, 14), x=x, z=-proud), STEEL, "steel", "convex") for x in places]


def riveted(handle: Mesh, *places: float) -> Mesh:
    """The handle with the holes for its rivets."""
    return difference(handle, *(move(cylinder(3, 60, 14), x=x, z=-30) for x in places))


def flat_handle(stop: float, width: float, height: float) -> Mesh:
    """Knife handle from x = 0 to ``stop`` with a hooked butt."""
    return grip([(0, width - 3, height - 3, 0), (4, width, height, 0), (stop * 0.45, width - 2, height, 0),
                 (stop * 0.8, width + 1, height, 0), (stop - 4, width + 1, height - 1, 0),
                 (stop, width - 8, height - 8, 0)], power=3.2, steps=3)


@household(category="knife", family="utensils", mass=0.17, material="plastic",
           source="common 6 inch chef's knife: 160 mm blade 46 mm high, 282 mm overall, 170 g (retail data)")
def chef_knife() -> list[Part]:
    edge = bezier((-160, 10), (-110, -26), (-60, -31), (-12, -32), segments=14)
    outline = polygon([(4, 12), (-60, 12.5), (-125, 13), *edge, (-9, -30), (-9, -10), (4, -10)])
    blade = move(extrude(outline, 2.2), z=-1.1)
    bolster = grip([(-9, 18, 7, 0), (-4, 22, 13, 0), (3, 24, 16, 0)], power=3.2)
    holes = (24, 60, 96)
    handle = riveted(flat_handle(122, 27, 19), *holes)
    return [Part(blade, "#aeb5bc", "steel", "convex"), Part(bolster, STEEL, "steel", "convex"),
            Part(handle, BLACK, "plastic", "convex"), *rivets(*holes, proud=9.8)]


@household(category="knife", family="utensils", mass=0.14, material="wood",
           source="common serrated bread knife: 175 mm blade 28 mm high, 290 mm overall, 140 g (retail data)")
def bread_knife() -> list[Part]:
    x = np.linspace(-172, -14, 18)
    waves = [p for a, b in pairwise(x)
             for p in ((a, -17), (a * 0.75 + b * 0.25, -13.2), (a * 0.25 + b * 0.75, -13.2))]
    outline = polygon([(6, 11), (-160, 11), *arc(14, 90, 180, -160, -3, 6), *waves[1:], (-14, -16), (-6, -11),
                       (6, -11)])
    blade = move(extrude(outline, 2), z=-1)
    holes = (22, 86)
    handle = riveted(flat_handle(115, 25, 18), *holes)
    return [Part(blade, "#aeb5bc", "steel", "convex"), Part(handle, "#b5763d", "wood", "convex"),
            *rivets(*holes, proud=9.3)]


@household(category="cleaver", family="utensils", mass=0.29, material="wood",
           source="small kitchen cleaver: blade 150 x 76 x 2.5 mm, 260 mm overall, 290 g (retail data)")
def meat_cleaver() -> list[Part]:
    outline = polygon([(6, 14), (-8, 22), (-150, 26), (-150, -44), (-144, -50), (-14, -50), (-8, -42),
                       (-4, -12), (6, -10)])
    outline = outline.difference(circle(7, -134, 11, 20))
    blade = move(extrude(outline, 2.5), z=-1.25)
    edge = polygon([(-149.5, -41), (-149.5, -44.5), (-144, -50.5), (-14, -50.5), (-8.6, -43), (-9, -41)])
    blade = difference(blade, move(extrude(edge, 9), z=-4))
    bevel = move(extrude(edge, 1.9), z=-0.95)
    holes = (24, 62, 92)
    handle = move(riveted(flat_handle(112, 28, 21), *holes), y=2)
    pins = [Part(move(p.mesh, y=2), p.color, p.material, p.threshold) for p in rivets(*holes, proud=10.8)]
    return [Part(blade, "#a4abb2", "steel", "convex"), Part(bevel, "#e3e7ea", "steel", "convex"),
            Part(handle, WALNUT, "wood", "convex"), *pins]


@household(category="fork", family="utensils", mass=0.14, material="wood",
           source="common carving fork: 285 mm overall, tines 100 mm, 140 g (retail data)")
def carving_fork() -> list[Part]:
    side = np.array([(-46, 3, 2), (-58, 9, 2), (-72, 13, 1), (-110, 14, -4), (-145, 13, -3), (-160, 12.5, 1)])
    taper = np.append(np.ones(13), [0.85, 0.65, 0.45, 0.3])
    tine = sweep(rect(5, 6, 1.6), spline(side, 16), scales=taper)
    shaft = grip([(-54, 14, 5.5, 2), (-47, 11, 7, 2), (-38, 7.5, 7.5, 1.5), (-20, 8, 8, 0.5),
                  (-6, 11, 10, 0), (-2, 19, 15, 0), (4, 20, 16, 0)])
    holes = (28, 92)
    handle = riveted(flat_handle(124, 25, 19), *holes)
    return [Part(tine, "#aeb5bc", "steel"), Part(mirror(tine, "y"), "#aeb5bc", "steel"),
            Part(shaft, STEEL, "steel"), Part(handle, WALNUT, "wood", "convex"), *rivets(*holes, proud=9.8)]


@household(category="peeler", family="utensils", mass=0.045, material="plastic",
           source="common Y peeler: 120 x 78 x 14 mm, blade 50 mm, 45 g (retail data)")
def y_peeler() -> list[Part]:
    fork = stroke(np.vstack([[(-44, 30)], bezier((-24, 30), (2, 29), (8, 0), segments=8),
                             bezier((8, 0), (2, -29), (-24, -30), segments=8)[1:], [(-44, -30)]]), 8)
    yoke = move(extrude(fork, 11), z=-5.5)
    handle = difference(grip([(2, 14, 11, 0), (12, 18, 13, 0), (30, 17, 14, 0), (55, 22, 14, 0),
                              (66, 20, 13, 0), (72, 10, 6, 0)]), yoke, move(cylinder(4, 40, 16), x=60, z=-20))
    blade = rotate(extrude(rect(13, 54, 1).difference(rect(3, 44, 1)), 2), y=-28)
    bit = move(rotate(prism(circle(3.5, segments=16), 5, 1), x=90), x=-40, y=-31)
    eye = stroke(arc(6, -80, 80, x=-41, y=34), 3.5, cap="flat")
    return [Part(yoke, "#4c9f38", "plastic"), Part(handle, "#4c9f38", "plastic", "convex"),
            Part(move(blade, x=-38, z=-1), "#aeb5bc", "steel", "convex"), Part(bit, STEEL, "steel", "convex"),
            Part(move(extrude(eye, 7), z=-3.5), "#4c9f38", "plastic", "convex")]


@household(category="pizza_cutter", family="utensils", mass=0.16, material="plastic",
           source="common pizza wheel: Ø86 mm wheel, 225 mm long, 160 g (retail data)")
def pizza_cutter() -> list[Part]:
    wheel = move(prism(circle(43, segments=56), 2.4, 1.1), z=-1.2)
    hub = move(prism(circle(9, segments=24), 17, 1.5), z=-8.5)
    cheek = hull(cylinder(11, 3, 24), move(box(6, 16, 3), x=52))
    cheeks = [difference(move(cheek, z=z), move(cylinder(9, 40), z=-20)) for z in (2.4, -5.4)]
    guard = grip([(46, 52, 11, 0), (49, 58, 16, 0), (56, 52, 17, 0), (62, 28, 17, 0)], power=3)
    handle = grip([(60, 24, 17, 0), (70, 23, 20, 0), (105, 28, 23, 0), (150, 24, 21, 0), (168, 25, 21, 0),
                   (178, 19, 15, 0), (182, 8, 6, 0)])
    return [Part(wheel, "#aeb5bc", "steel", "convex"), Part(hub, BLACK, "plastic", "convex"),
            *(Part(c, STEEL, "steel", "convex") for c in cheeks), Part(guard, "#c8322f", "plastic", "convex"),
            Part(handle, BLACK, "plastic", "convex")]


@household(category="ice_cream_scoop", family="utensils", mass=0.19, material="plastic",
           source="common trigger ice cream scoop: 215 mm, bowl Ø56 mm, 190 g (retail data)")
def ice_cream_scoop() -> list[Part]:
    cup = bowl(28, 28, 28, 2.2)
    band = stroke(arc(24.4, 185, 355, segments=14), 2, cap="flat")
    sweeper = rotate(move(rotate(extrude(band, 7), x=90), y=3.5), z=90)
    shaft = difference(rod(4.5, 24, 92, 16), sphere(27.6, 32))
    wheel = difference(move(extrude(star(14, 10, 8.2), 4), x=44, z=4.2), rod(4.5, 24, 92, 16))
    path = spline([(46, 0, 8), (54, 0, 15), (68, 0, 21), (84, 0, 22), (92, 0, 20)], 12)
    lever = sweep(rect(14, 3.2, 1.2), path)
    handle = grip([(78, 17, 17, 0), (84, 24, 23, 0), (110, 25, 22, 0), (140, 28, 24, 0), (172, 26, 22, 0),
                   (183, 19, 16, 0), (187, 8, 7, 0)])
    handle = difference(handle, move(box(60, 40, 10), x=80, z=18))
    return [Part(cup, STEEL, "steel", 0.15), Part(sweeper, "#8b9198", "steel", 0.1),
            Part(shaft, STEEL, "steel", "convex"), Part(wheel, "#8b9198", "steel", "convex"),
            Part(lever, STEEL, "steel"),            Part(handle, "#7a4fa3", "plastic", "convex")]


@household(category="meat_tenderizer", family="utensils", mass=0.42, material="wood",
           source="meat mallet: aluminium head 46 x 46 x 72 mm, beech handle, 232 mm, 420 g (retail)")
def meat_tenderizer() -> list[Part]:
    block = move(rotate(prism(rect(46, 46, 2), 60, 2), x=90), y=30)
    tooth = [(-5.5, -5.5), (5.5, -5.5), (5.5, 5.5), (-5.5, 5.5)]
    spikes = [move(extrude(tooth, 6.5, taper=0.12), x=x, y=y)
              for x in (-16.5, -5.5, 5.5, 16.5) for y in (-16.5, -5.5, 5.5, 16.5)]
    face = union(move(box(44, 44, 1.5), z=-1), *spikes)
    faces = [move(rotate(face, x=-90), y=30), move(rotate(face, x=90), y=-30)]
    collar = turned([(0, 22), (13, 22), (13, 27), (11, 33), (0, 33)], 24)
    handle = turned([(0, 31), (9.5, 31), (10.5, 60), (12, 110), (10, 150), (13, 185), (13.5, 200), (9, 208),
                     (0, 209)])
    return [Part(block, "#c3c8cd", "aluminium", "convex"),
            *(Part(f, "#a4abb2", "aluminium", "convex") for f in faces),
            Part(collar, "#c3c8cd", "aluminium", "convex"), Part(handle, BEECH, "wood", "convex")]
