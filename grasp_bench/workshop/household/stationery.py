"""Things one writes, cuts, sticks and staples with."""

import numpy as np
from numpy.typing import ArrayLike
from shapely import affinity
from shapely.geometry.base import BaseGeometry

from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Figure,
    Mesh,
    arc,
    box,
    circle,
    cylinder,
    difference,
    ellipse,
    extrude,
    figures,
    hull,
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
    sphere,
    spline,
    stroke,
    sweep,
    union,
)

STEEL, BLACK = "#b9bec4", "#26282b"


def _convex(mesh: Mesh, color: str, material: str = "plastic") -> Part:
    """A part that is its own convex hull."""
    return Part(mesh, color, material, "convex")


def _side(shape: Figure, width: float, bevel: float = 0.0) -> Mesh:
    """Figure of the xz plane, ``width`` thick in y; ``bevel`` wants a convex one."""
    solid = prism(shape, width, bevel) if bevel else extrude(shape, width)
    return move(rotate(solid, x=90), y=width / 2)


def _across(shape: Figure, width: float, bevel: float = 0.0) -> Mesh:
    """Figure of the yz plane, ``width`` thick in x; ``bevel`` wants a convex one."""
    return rotate(_side(shape, width, bevel), z=90)


def _lying(mesh: Mesh, z: float) -> Mesh:
    """A solid modelled upright, laid down along x with its axis at height ``z``."""
    return move(rotate(mesh, y=90), z=z)


@household(category="stapler", family="office", mass=0.24, material="plastic",
           source="common half-strip desk stapler for 24/6 staples: 142 x 36 x 57 mm, 240 g "
                  "(retail data sheets)")
def desk_stapler() -> list[Part]:
    heel = polygon([(-67, 6), (-67, 22), (-61, 22), (-61, 13), (-40, 13), (-36, 6)])
    base = union(prism(rect(142, 36, 9), 8, 2), _side(heel, 28))
    anvil = move(box(16, 12, 2), x=57, z=7)
    magazine = _side(polygon([(-60.5, 13.5), (67, 24), (67, 33.3), (-60.5, 21.5)]), 17)
    top = spline([(-71, 36), (-55, 47), (-10, 54), (40, 57), (64, 53), (71, 42)], 14)
    cover = _side(polygon([(71, 33), (-71, 20), *top]), 34, 5)
    return [Part(base, BLACK, "plastic"), _convex(anvil, STEEL, "steel"),
            _convex(magazine, STEEL, "aluminium"), _convex(cover, "#c8202f")]


@household(category="tape_dispenser", family="office", mass=0.56, material="plastic",
           source="common weighted desk dispenser for 19 mm x 33 m tape: 153 x 60 x 72 mm, 560 g "
                  "(retail data sheets)")
def tape_dispenser() -> list[Part]:
    hub_x, hub_z = -22, 40
    outline = polygon([(-75, 0), (70, 0), (76, 34), (62, 36), (46, 24), (20, 26), (2, 42), (-10, 52),
                       (-22, 55),
                       (-38, 53), (-56, 42), (-70, 22), (-75, 8)])
    outline = rounded(outline.buffer(-4).buffer(8).buffer(-4), 4)
    well = _side(circle(35, hub_x, hub_z), 25)
    body = difference(_side(outline, 60), well)

    def wheel(figure: BaseGeometry, width: float) -> Mesh:
        return _side(affinity.translate(figure, hub_x, hub_z), width)

    tape = wheel(circle(31).difference(circle(19)), 19)
    hub = wheel(circle(19.2, segments=24), 25.4)
    start, end = np.array([-11.3, 69.0]), np.array([75.0, 38.0])
    normal = np.array([0.34, 0.94])
    strip = _side(polygon([start - 1.4 * normal, end - normal, end + normal, start + 0.6 * normal]), 19)
    teeth = [(y, 37 + 3 * (i % 2)) for i, y in enumerate(np.linspace(-12, 12, 21))]
    blade = move(_across(polygon([(-12, 22), *teeth, (12, 22)]), 2.5), x=75.5)
    return [Part(body, "#2c3038", "stone"), Part(tape, "#e9d27a", "plastic"),
            _convex(hub, "#e8e6e0"), _convex(strip, "#f0dc8c"),
            _convex(blade, STEEL, "steel")]


def _scissors(blade: Figure, handles: tuple[Figure, Figure], half_angle: float, thickness: float,
              colors: tuple[str, str]) -> list[Part]:
    """Two halves turned about the origin; figures are those of the half whose handle lies at y < 0."""
    gauge, middle = 2.2, thickness / 2
    parts = []
    for side, (figure, color) in enumerate(zip(handles, colors, strict=True)):
        steel = move(extrude(blade, gauge), z=middle - gauge + side * gauge)
        grip = difference(extrude(figure, thickness), steel)
        for mesh, paint, material in ((steel, STEEL, "steel"), (grip, color, "plastic")):
            mesh = rotate(mesh, z=half_angle)
            parts.append(Part(mirror(mesh, "y") if side else mesh, paint, material))
    rivet = prism(circle(5, segments=24), 2 * gauge + 2.4, 0.8)
    return [*parts, _convex(move(rivet, z=middle - gauge - 1.2), "#7d838a", "steel")]


def _loop(x: float, y: float, length: float, width: float, wall: float, turn: float,
          neck: ArrayLike) -> BaseGeometry:
    """Handle of a scissor half: an oval ring on a neck."""
    outer = place(ellipse(length / 2, width / 2, segments=36), x, y, turn)
    inner = place(ellipse(length / 2 - wall, width / 2 - wall, segments=28), x, y, turn)
    return figures([outer, stroke(neck, 15)]).buffer(6).buffer(-6).difference(inner)


@household(category="scissors", family="office", mass=0.085, material="plastic",
           source="common 8 in office scissors: 203 mm long, blades 2 mm, handles 11 mm thick, 85 g "
                  "(retail data sheets)")
def office_scissors() -> list[Part]:
    blade = polygon([(-32, -16), (-20, -4), (0, 9), (50, 9), (105, 0), (104, -2), (0, -6.5), (-22, -13)])
    neck = [(-24, -9), (-36, -14)]
    fingers, thumb = _loop(-66, -24, 78, 44, 8, 8, neck), _loop(-58, -24, 58, 44, 8, 12, neck)
    return _scissors(blade, (fingers, thumb), 9, 11, (BLACK, BLACK))


@household(category="scissors", family="office", mass=0.045, material="plastic",
           source="common 5 in blunt-tip school scissors: 123 mm long, handles 9 mm thick, 45 g "
                  "(retail data sheets)")
def blunt_kids_scissors() -> list[Part]:
    blade = rounded(polygon([(-22, -13), (-12, -2), (0, 8), (40, 8.5), (66, 5), (66, -5), (0, -6),
                             (-14, -11)]), 4)
    blade = figures([blade, stroke([(-8, -3), (-20, -10)], 8)])
    neck = [(-15, -8), (-22, -11)]
    loop = _loop(-41, -21, 48, 38, 7, 18, neck)
    return _scissors(blade, (loop, loop), 11, 9, ("#f28c1e", "#1f8fd0"))


@household(category="marker", family="office", mass=0.032, material="plastic",
           source="common jumbo permanent marker: Ø20 x 123 mm, 32 g (retail data sheets)")
def permanent_marker() -> list[Part]:
    ink, z = "#d4202a", 10.0
    cap = revolve([(0, -26), (8.5, -26), (9.4, -24), (9.9, 16), (0, 16)], 32)
    clip = _side(polygon([(-26, z + 7), (12, z + 8.5), (12, z + 12), (8, z + 13.5), (-26, z + 12)]), 6)
    barrel = revolve([(0, 16), (9.2, 16), (9.2, 76), (0, 76)], 32)
    band = revolve([(0, 76), (9.2, 76), (9.2, 80), (7.2, 83), (0, 83)], 32)
    holder = revolve([(0, 83), (6.2, 83), (5.6, 88), (4.2, 90), (0, 90)], 24)
    chisel = hull(move(cylinder(3.4, 4, 20), z=89.5), move(box(2.2, 5.5, 1), x=-2, z=96),
                  move(box(1, 5.5, 1), x=2, z=93))
    return [_convex(_lying(cap, z), ink), _convex(clip, ink),
            _convex(_lying(barrel, z), "#eceae4"), _convex(_lying(band, z), ink),
            _convex(_lying(holder, z), BLACK), _convex(_lying(chisel, z), ink, "fabric")]


@household(category="pen", family="office", mass=0.028, material="plastic",
           source="common piston fountain pen, cap posted: Ø14 x 155 mm, 28 g (retail data sheets)")
def fountain_pen() -> list[Part]:
    z, gold, navy = 7.0, "#d8ac3c", "#1d2c63"
    crown = revolve([(0, -78), (4, -78), (5.8, -75), (6.2, -70), (0, -70)], 28)
    cap = revolve([(0, -70), (6.2, -70), (7, -26), (0, -26)], 28)
    lip = revolve([(0, -26), (7.2, -26), (7.2, -19), (0, -19)], 28)
    barrel = revolve([(0, -19), (5.6, -19), (6.2, 10), (6, 30), (0, 30)], 28)
    collar = revolve([(0, 30), (5.9, 30), (5.6, 33), (0, 33)], 28)
    section = revolve([(0, 33), (5.2, 33), (4.2, 50), (4.8, 54), (0, 54)], 28)
    plan = polygon([(53, -4.6), (60, -4.6), (78, -0.5), (78, 0.5), (60, 4.6), (53, 4.6)])
    shell = _lying(difference(cylinder(4.6, 80, 32), move(cylinder(2.6, 90, 32), z=-5)), z)
    nib = intersection(move(extrude(plan, 6), z=z), shell)
    feed = hull(move(rotate(cylinder(2.5, 2, 16), y=90), x=53, z=z), move(box(2, 1, 1), x=70, z=z + 1.5))
    clip = union(_side(polygon([(-74, z + 5), (-71, z + 9), (-34, z + 9), (-34, z + 7), (-70, z + 7),
                                (-70, z + 5)]), 4),
                 move(sphere(2, 12), x=-34, z=z + 8))
    parts = [_convex(_lying(m, z), c) for m, c in (
        (crown, gold), (cap, navy), (lip, gold), (barrel, navy), (collar, gold))]
    return [*parts, Part(_lying(section, z), BLACK, "plastic"), Part(nib, gold, "steel"),
            _convex(feed, BLACK), Part(clip, gold, "steel")]


@household(category="pencil_sharpener", family="office", mass=0.022, material="brass",
           source="common brass wedge sharpener: 26 x 16 x 12 mm, 22 g (retail data sheets)")
def pencil_sharpener() -> list[Part]:
    waist = [affinity.translate(circle(13, segments=48), 0, s * 19.5) for s in (-1, 1)]
    plan = rounded(rect(26, 16, 1), 1).difference(figures(waist))
    top = _side(polygon([(-14, -1), (14, -1), (14, 11.8), (-14, 8.2)]), 20)
    bore = rotate(cylinder(0.8, 28, 28, top=4.3), y=90, x=0)
    body = difference(intersection(extrude(plan, 13), top), move(bore, x=-14, z=5.2),
                      rotate(move(box(21, 10, 8), y=-7.2, z=7.2), y=-7.4))
    tilt = -7.4
    plate = rect(23, 9).difference(circle(1, segments=12))
    blade = move(rotate(extrude(plate, 1), y=tilt), y=0.2, z=9.9)
    screw = prism(circle(2.6, segments=20), 1.4, 0.3)
    slot = box(4, 0.9, 0.4)
    return [Part(body, "#cf9f3f", "brass", 0.13), _convex(blade, "#d9dde2", "steel"),
            _convex(move(rotate(screw, y=tilt), z=10.6), "#8d8f94", "steel"),
            _convex(move(rotate(rotate(slot, z=35), y=tilt), z=11.9), BLACK, "steel")]


@household(category="glue_stick", family="office", mass=0.036, material="plastic",
           source="common 21 g glue stick, uncapped: Ø26 x 100 mm, 36 g (retail data sheets)")
def glue_stick() -> list[Part]:
    ribs = [place(rect(2.4, 2.4), *p) for p in arc(12, 0, 340, segments=17)]
    knob = extrude(figures([circle(12, segments=36), *ribs]), 11)
    lower = move(cylinder(13, 16, 36), z=11)
    label = move(cylinder(13, 36, 36), z=27)
    upper = move(cylinder(13, 12, 36), z=63)
    sleeve = move(cylinder(11.5, 9, 36), z=75)
    glue = revolve([(0, 84), (9, 84), (9, 98), (7.5, 100.5), (0, 101.5)], 32)
    return [_convex(knob, "#c8202f"), _convex(lower, "#f5c51c"),
            _convex(label, "#c8202f"), _convex(upper, "#f5c51c"),
            _convex(sleeve, "#f4f2ea"), _convex(glue, "#fbfaf3", "soap")]


@household(category="hole_punch", family="office", mass=0.25, material="steel",
           source="common two-hole punch, 80 mm hole spacing (ISO 838): 112 x 64 x 59 mm, paper guide "
                  "drawn out, 250 g (retail data sheets)")
def hole_punch() -> list[Part]:
    tray = prism(rect(112, 64, 5, y=-2), 8, 1.5)
    slot = move(box(130, 24, 2.6), y=-14, z=11)
    post = difference(move(box(20, 30, 24), y=2, z=8), slot)
    pin = move(cylinder(4.5, 17, 20), y=-4, z=31.5)
    lever = polygon([(26, 12), (26, 48), (22, 54), (-24, 59), (-31, 57), (-31, 46), (-26, 44), (18, 42),
                     (20, 12)])
    hood = _across(lever, 104)
    guide = move(box(34, 10, 2.4), x=70, y=8, z=9)
    parts = [_convex(tray, BLACK), Part(hood, "#2a62b8", "aluminium"),
             _convex(guide, "#e9e7e0")]
    for x in (-40, 40):
        parts += [Part(move(post, x=x), "#8f959c", "aluminium"), _convex(move(pin, x=x), STEEL, "steel")]
    return parts


@household(category="binder_clip", family="office", mass=0.036, material="steel",
           source="common 51 mm (2 in) binder clip: body 51 x 26 x 35 mm, 36 g, sheet thickened to 2 mm "
                  "(retail data sheets)")
def binder_clip() -> list[Part]:
    sheet = stroke([(-3.2, 32), (-12.4, 1), (12.4, 1), (3.2, 32)], 2)
    curls = [circle(2.4, s * 3.4, 33, segments=16) for s in (-1, 1)]
    body = _across(figures([sheet, *curls]), 51)
    half = [(12, -1), (9, 12), (6, 26), (9, 38), (5, 46)]
    outline = spline([(-x, s) for x, s in half] + half[::-1], 26)
    wire = sweep(1.3, np.column_stack([outline[:, 0], 0 * outline[:, 0], outline[:, 1]]), up=(0, 1, 0),
                 segments=8)
    handle = move(rotate(wire, x=-24), y=4.4, z=34)
    return [Part(body, BLACK, "steel"), Part(handle, "#c9cdd2", "steel"),
            Part(mirror(handle, "y"), "#c9cdd2", "steel")]
