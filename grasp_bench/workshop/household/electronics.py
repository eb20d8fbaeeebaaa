"""Electronic things with keys, lenses and antennas."""

from collections.abc import Iterable

import numpy as np
from shapely.geometry import Polygon

from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Floats,
    Mesh,
    arc,
    box,
    capsule,
    circle,
    cylinder,
    deform,
    difference,
    ellipse,
    ellipsoid,
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
    ring,
    rotate,
    rounded,
    rounded_box,
    sphere,
    superellipsoid,
    sweep,
    union,
)

STEEL, BLACK, DARK, WHITE = "#b9bec4", "#26282b", "#3b3f45", "#f2f1ec"


def _convex(mesh: Mesh, color: str, material: str = "plastic") -> Part:
    """A part that is its own convex hull."""
    return Part(mesh, color, material, "convex")


def _keys(figures_: Iterable[Polygon], z: float, proud: float = 1.2) -> Mesh:
    """Keys standing out of a face at height ``z``, joined by a thin plate hidden beneath it."""
    keys = list(figures_)
    plate = figures(keys).convex_hull
    return union(move(extrude(plate, 0.8), z=z - 1), *(move(extrude(k, proud + 1), z=z - 1) for k in keys))


def _grid(columns: tuple[float, ...], rows: tuple[float, ...], width: float, height: float,
          radius: float) -> list[Polygon]:
    """Equal keys at every column x and row y."""
    return [rect(width, height, radius, x, y) for x in columns for y in rows]


def _facing(mesh: Mesh, z: float, y: float = 0.0, x: float = 0.0) -> Mesh:
    """A solid modelled upright, turned so that its top looks towards -y."""
    return move(rotate(mesh, x=90), x=x, y=y, z=z)


def _lying(mesh: Mesh, z: float) -> Mesh:
    """A solid modelled upright, laid down along x with its axis at height ``z``."""
    return move(rotate(mesh, y=90), z=z)


@household(category="calculator", family="office", mass=0.12, material="plastic",
           source="common 8-digit mini desk calculator: 70 x 122 x 26 mm, 120 g (retail data sheets)")
def desk_calculator() -> list[Part]:
    wedge = polygon([(-61, 0), (61, 0), (61, 23), (57, 26), (-58, 12), (-61, 9)])
    case = move(rotate(prism(wedge, 70, 2), x=90, z=90), x=-35)
    slope = np.degrees(np.arctan2(14, 115))

    def on_face(mesh: Mesh) -> Mesh:
        return move(rotate(mesh, x=slope), z=19 + 0.06)

    columns, rows = (-24, -8.5, 7), (-50, -36, -22, -8)
    return [_convex(case, "#d9dade"),
            _convex(on_face(move(prism(rect(60, 24, 2, y=44), 1.4, 0.4), z=-0.7)), BLACK),
            _convex(on_face(move(box(52, 15, 0.8), y=44, z=0.4)), "#b4c4a2"),
            _convex(on_face(move(box(26, 8, 1), x=15, y=23, z=-0.4)), "#5b2a22"),
            _convex(on_face(_keys(_grid(columns, rows, 12.5, 9.5, 2), 0, 2)), DARK),
            _convex(on_face(_keys(_grid((24,), rows, 12.5, 9.5, 2), 0, 2)), "#e87722"),
            _convex(on_face(_keys(_grid(columns[:1], (6.5,), 12.5, 9, 2), 0, 2)), "#c8202f")]


@household(category="computer_mouse", family="office", mass=0.095, material="plastic",
           source="common full-size office mouse: 114 x 63 x 38 mm, 95 g (retail data sheets)")
def computer_mouse() -> list[Part]:
    def arch(v: Floats) -> Floats:
        v[:, 2] *= 1 - 0.32 * ((v[:, 1] + 12) / 60) ** 2
        v[:, 0] *= 1 - 0.10 * np.exp(-(((v[:, 1] - 8) / 25) ** 2))
        return v

    egg = deform(superellipsoid(33, 57, 38, 0.62, 0.75, 40), arch)
    shape = intersection(egg, box(90, 130, 60))
    front = [move(box(40, 60, 60), x=s * 20.5, y=36, z=15) for s in (-1, 1)]
    groove = move(box(9, 26, 60), y=36, z=15)
    wheel = move(rotate(cylinder(10, 6, 28), y=90), x=-3, y=34, z=24)
    body = difference(shape, *front, move(box(1.5, 60, 60), y=36, z=18), groove)
    parts = [_convex(body, "#2f3338")]
    parts += [_convex(difference(intersection(shape, move(f, y=0.4)), groove), "#565c64") for f in front]
    parts.append(_convex(wheel, "#d0382f", "rubber"))
    return [Part(rotate(p.mesh, z=-90), p.color, p.material, p.threshold) for p in parts]


@household(category="remote_control", family="office", mass=0.11, material="plastic",
           source="common TV remote control: 178 x 46 x 22 mm, 110 g with two AA cells (retail data sheets)")
def tv_remote_control() -> list[Part]:
    top = 22.0
    shell = prism(rect(46, 178, 9), top, 3)
    window = move(prism(rect(24, 4), 8, 0.5), y=88, z=8)
    ringed = move(ring(14, 8, 2.2, 32), y=14, z=top - 1)
    ok = move(prism(circle(6, y=14, segments=24), 2.4, 0.4), z=top - 1)
    return [_convex(shell, BLACK), _convex(window, "#6b1020"),
            _convex(_keys([circle(5, -13, 74, 20)], top, 1.5), "#e0262d"),
            _convex(_keys(_grid((-13, 0, 13), (36, 46, 56), 9, 6, 2), top), "#c9ccd1"),
            _convex(ringed, "#c9ccd1"), _convex(ok, "#c9ccd1"),
            _convex(_keys([rect(9, 22, 4, s * 13, -20) for s in (-1, 1)], top, 1.6), "#c9ccd1"),
            *(_convex(_keys([rect(7, 4, 1, x, -40)], top), c)
              for x, c in ((-14, "#d4202a"), (-5, "#2f9a45"), (5, "#f2c21c"), (14, "#2255bb"))),
            _convex(_keys(_grid((-13, 0, 13), (-52, -62, -72), 9, 6, 2), top), "#8f949b")]


@household(category="game_controller", family="office", mass=0.26, material="plastic",
           source="common wireless gamepad: 152 x 108 x 46 mm, 260 g (retail data sheets)")
def game_controller() -> list[Part]:
    deck = 40.0
    core = move(superellipsoid(64, 33, 17, 0.5, 0.6, 28), z=deck - 16)
    grip = hull(move(ellipsoid(26, 26, 17, 18), x=48, y=4, z=deck - 17),
                move(ellipsoid(14, 16, 13, 16), x=62, y=-54, z=14))
    body = union(core, grip, mirror(grip, "x"))
    z = deck - 0.8
    stick = revolve([(0, 0), (5, 0), (9.2, 7), (9.2, 8.5), (7.5, 9.5), (0, 9.5)], 24)
    cross = extrude(figures([rect(24, 8, 1.5), rect(8, 24, 1.5)]), 4)
    parts = [Part(body, "#f2f1ec", "plastic"),
             *(_convex(move(stick, x=x, y=y, z=z - 1), BLACK, "rubber") for x, y in ((-22, -16), (22, -16))),
             _convex(move(cross, x=-48, y=8, z=z - 1.2), BLACK),
             _convex(move(prism(circle(6, segments=20), 3, 0.6), y=10, z=z), "#3b3f45")]
    for (dx, dy), color in zip(arc(10.5, 0, 270, segments=3), ("#d4202a", "#f2c21c", "#2255bb", "#2f9a45"),
                               strict=True):
        parts.append(_convex(move(prism(circle(4.8, segments=18), 5, 0.8), x=48 + dx, y=8 + dy, z=z - 2),
                             color))
    for sign in (-1, 1):
        bumper = move(superellipsoid(21, 8, 8, 0.6, 0.6, 16), x=sign * 44, y=30, z=deck - 14)
        parts.append(_convex(bumper, DARK))
    return parts


@household(category="phone", family="office", mass=0.14, material="plastic",
           source="mobile phone of about 1999: 113 x 48 x 22 mm without its aerial, 140 g (Nokia 3210/3310 "
                  "data sheets)")
def old_mobile_phone() -> list[Part]:
    top = 22.0
    outline = rounded(polygon([(-21, -57), (21, -57), (24, -30), (22, 5), (24, 40), (21, 56), (-21, 56),
                               (-24, 40),
                               (-22, 5), (-24, -30)]), 7)
    case = prism(outline.convex_hull, top, 4)
    antenna = move(rotate(union(cylinder(4.2, 22, 16), move(capsule(4.8, 8, 16), z=20)), x=-90), x=14, y=52,
                   z=12)
    screen_rim = move(prism(rect(36, 32, 5, y=27), 2, 0.6), z=top - 0.8)
    screen = move(prism(rect(30, 22, 2, y=26), 1, 0.3), z=top + 0.9)
    return [_convex(case, "#24407a"), Part(antenna, BLACK, "rubber"),
            _convex(screen_rim, "#c9ccd1"), _convex(screen, "#9fc06a", "glass"),
            _convex(_keys([ellipse(3.2, 1.1, 0, 49, 16)], top, 0.4), BLACK),
            _convex(_keys([rect(18, 6, 2.5, 0, 3)], top, 1.6), "#4f8fe0"),
            _convex(_keys(_grid((-12, 0, 12), (-9, -20, -31, -42), 9.5, 6.5, 3), top, 1.6), WHITE)]


@household(category="camera", family="office", mass=0.29, material="plastic",
           source="common 35 mm compact camera: 118 x 62 x 68 mm, 290 g (retail data sheets)")
def compact_camera() -> list[Part]:
    lower = prism(rect(118, 34, 8), 46, 1)
    upper = move(prism(rect(118, 34, 8), 17, 2), z=46)
    barrel = _facing(revolve([(0, 0), (24, 0), (24, 10), (22, 11), (22, 20), (20, 22), (0, 22)], 36), 28,
                     -16.5, 6)
    bezel = _facing(ring(17, 12, 1.6, 32), 28, -38, 6)
    glass = _facing(intersection(move(sphere(20, 32), z=-16), cylinder(12.2, 6, 28)), 28, -38, 6)
    finder = move(rounded_box(22, 8, 12, 1.5), x=6, y=-14, z=48.5)
    pane = _facing(extrude(rect(14, 7, 1), 1), 54.5, -17.6, 6)
    flash = _facing(prism(rect(20, 9, 1.5), 2, 0.5), 54, -16.2, -38)
    button = move(prism(circle(6, segments=24), 5, 0.8), x=-40, y=-2, z=62)
    dial = move(prism(circle(10, segments=20), 6, 0.6), x=40, y=0, z=62)
    grip = move(hull(cylinder(5, 42, 16), move(cylinder(4, 42, 16), x=8, y=3)), x=-54, y=-17, z=2)
    eyepiece = move(rounded_box(18, 5, 11, 1.5), x=6, y=17.5, z=49)
    return [_convex(lower, BLACK), _convex(upper, "#c4c8cc"),
            Part(barrel, "#55595f", "plastic"), _convex(bezel, STEEL, "aluminium"), _convex(glass, "#3a5f9a",
                                                                                         "glass"),
            _convex(finder, BLACK), _convex(pane, "#9fc4d8", "glass"),
            _convex(flash, "#fbf7df", "glass"), _convex(button, "#c8202f"),
            _convex(dial, DARK),
            _convex(eyepiece, BLACK), _convex(grip, DARK, "rubber")]


@household(category="headphones", family="office", mass=0.23, material="plastic",
           source="common closed over-ear headphones: 189 x 172 x 80 mm, 230 g (retail data sheets)")
def over_ear_headphones() -> list[Part]:
    half, z = 80.0, 40.0
    bow = np.vstack([[(half, -30)], arc(half, 0, 180, segments=24), [(-half, -30)]])
    path = np.column_stack([bow, np.full(len(bow), z)])
    band = sweep(rect(7, 26, 2), path)
    pad_bow = arc(half - 5.5, 40, 140, segments=12)
    pad = sweep(rect(6, 30, 2.5), np.column_stack([pad_bow, np.full(len(pad_bow), z)]))
    parts = [Part(band, BLACK, "plastic"), Part(pad, "#8c9096", "leather")]
    shell = revolve([(0, -2), (30, -2), (37, -7), (38, -20), (0, -20)], 36)
    disc = prism(circle(24, segments=32), 3, 1)
    cushion = revolve(rounded(rect(17, 18, x=31.5, y=-29), 6, 3), 32)
    for sign in (-1, 1):
        for mesh, color, material, threshold in (
                (shell, "#2b2e33", "plastic", "convex"), (move(disc, z=-2.5), "#c8202f", "plastic", "convex"),
                (cushion, "#5d6268", "leather", 0.15)):
            turned = move(rotate(mesh, y=90), x=half + 14, y=-48, z=z)
            parts.append(Part(turned if sign > 0 else mirror(turned, "x"), color, material, threshold))
    return parts


@household(category="usb_stick", family="office", mass=0.016, material="plastic",
           source="common rugged USB-A memory stick: 69 x 22 x 11 mm, plug 12 x 4.5 mm (USB 2.0 "
                  "specification), 16 g")
def usb_stick() -> list[Part]:
    eye = move(cylinder(3.2, 20, 20), x=-25, z=-1)
    body = difference(prism(rect(50, 22, 5, x=-8), 11, 1.5), eye)
    collar = move(prism(rect(6, 18, 1), 9, 0.8), x=18.5, z=1)
    plug = move(box(16, 12, 4.5), x=28, z=3.25)
    windows = _keys([rect(2.4, 2.4, x=29, y=s * 2.8) for s in (-1, 1)], 7.75, 0.15)
    tongue = move(box(1, 10, 1.6), x=35.8, z=5.4)
    label = move(prism(rect(24, 14, 2, x=-6), 1, 0.2), z=10.3)
    return [Part(body, "#1f6fc4", "rubber"), _convex(collar, BLACK), _convex(plug, "#cdd1d5", "steel"),
            _convex(windows, BLACK), _convex(tongue, BLACK),
            _convex(label, WHITE)]


@household(category="microphone", family="office", mass=0.298, material="aluminium",
           source="Shure SM58 data sheet: Ø51 x 162 mm, 298 g")
def vocal_microphone() -> list[Part]:
    z = 25.8
    grille = move(sphere(25.2, 40), z=136)
    band = move(revolve([(0, -4), (25.4, -4), (25.8, -1), (25.8, 1), (25.4, 4), (0, 4)], 36), z=136)
    collar = revolve([(0, 103), (17.5, 103), (20, 108), (18, 114), (0, 114)], 32)
    handle = revolve([(0, 0), (10, 0), (11.5, 3), (17.5, 103), (0, 103)], 32)
    switch = move(rounded_box(14, 7, 4, 1), x=72, z=z + 14.5)
    connector = move(cylinder(8.5, 2, 24), z=-1.5)
    return [_convex(_lying(grille, z), "#a4a9af", "steel"), _convex(_lying(band, z), "#d2d6da", "steel"),
            _convex(_lying(collar, z), DARK, "aluminium"), _convex(_lying(handle, z), "#303338", "aluminium"),
            _convex(switch, "#d2d6da"), _convex(_lying(connector, z), STEEL, "steel")]


@household(category="joystick", family="office", mass=0.21, material="rubber",
           source="classic one-button home-computer joystick (CX40 type): 90 x 90 mm base, 128 mm high, 210 "
                  "g")
def arcade_joystick() -> list[Part]:
    base = prism(rect(90, 90, 6), 32, 3)
    plate = move(prism(circle(36, segments=40), 3, 0.8), z=31.5)
    boot = revolve([(0, 34), (21, 34), (17, 39), (18, 41), (13, 46), (14, 48), (10, 53), (0, 53)], 28)
    shaft = revolve([(0, 53), (8, 53), (9, 90), (12, 104), (12.5, 116), (10, 125), (5, 128), (0, 128)], 28)
    button = move(prism(circle(8, segments=28), 6, 1), x=-33, y=33, z=31)
    stripe = move(ring(33, 30.5, 0.8, 40), z=34.2)
    return [_convex(base, BLACK), _convex(plate, DARK),
            _convex(stripe, "#e8622a"), Part(boot, "#1b1c1e", "rubber"), Part(shaft, "#1b1c1e",
                                                                                      "rubber"),
            _convex(button, "#e0262d")]


@household(category="walkie_talkie", family="office", mass=0.19, material="plastic",
           source="common PMR446 two-way radio: 58 x 190 x 36 mm with aerial, 190 g with cells (retail data "
                  "sheets)")
def walkie_talkie() -> list[Part]:
    top, yellow = 34.0, "#f0b81c"
    case = prism(rounded(polygon([(-25, -60), (25, -60), (29, -50), (29, 45), (24, 52), (-24, 52), (-29, 45),
                                  (-29, -50)]), 4),
                 top, 4)
    panel = move(prism(rect(48, 98, 8, y=-4), 2.4, 1), z=top - 1.2)
    aerial = rotate(union(cylinder(7.5, 14, 20), move(cylinder(6.5, 64, 20, top=4.5), z=13)), x=-90)
    knob = rotate(extrude(figures([circle(7, segments=24),
                                   *(place(rect(1.6, 1.6), *p) for p in arc(7, 0, 330, segments=11))]), 12),
                  x=-90)
    z = top + 1.2
    grille = _keys([rect(32, 2.6, 1, 0, y) for y in (-20, -26, -32, -38, -44)], z, 0.8)
    screen = move(prism(rect(34, 20, 2, y=28), 1.6, 0.4), z=z - 0.6)
    keys = _keys([rect(9, 6, 2, x, 6) for x in (-13, 0, 13)], z, 1.4)
    call = _keys([circle(4, 0, -7, 20)], z, 1.4)
    talk = move(prism(rect(4, 30, 1.5), 14, 1), x=-29.5, y=14, z=10)
    return [_convex(case, yellow), _convex(panel, BLACK),
            Part(move(aerial, x=-17, y=51.5, z=17), BLACK, "rubber"), _convex(move(knob, x=14, y=51.5, z=17),
                                                                              BLACK),
            _convex(grille, "#6f757c"), _convex(screen, "#a9cbb0", "glass"),
            _convex(keys, WHITE), _convex(call, "#e8622a"), _convex(talk, BLACK, "rubber")]
