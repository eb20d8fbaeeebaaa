"""Fasteners, fittings and other things from a hardware shop."""

import numpy as np

from grasp_bench.workshop.household.hand_tools import (
    BLACK,
    DARK,
    STEEL,
    along_x,
    along_y,
    fluted,
    thread,
    upright,
)
from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    arc,
    bezier,
    box,
    circle,
    cone,
    cylinder,
    difference,
    extrude,
    figures,
    hull,
    intersection,
    move,
    place,
    polygon,
    prism,
    rect,
    regular,
    revolve,
    rotate,
    rounded,
    rounded_box,
    sphere,
    spline,
    sweep,
    torus,
    union,
)

BRASS = "#cfa23c"


@household(category="flashlight", family="tools", mass=0.19, material="aluminium",
           source="estimate, typical: aluminium LED flashlight, head Ø43, body Ø32, 156 mm, 190 g")
def flashlight() -> list[Part]:
    tail = along_x([(0, 0), (12, 0), (15, 3), (16, 6), (16, 16), (0, 16)])
    grip = fluted([(0, 15), (16.5, 15), (16.5, 90), (0, 90)], 16, 2.2, 17.6)
    neck = along_x([(0, 89), (15, 89), (15, 113), (0, 113)], segments=32)
    flare = along_x([(0, 112), (15, 112), (21, 128), (0, 128)], segments=32)
    head = move(rotate(prism(regular(8, 23, 22.5), 24, 1), y=90), 127)
    rim = along_x([(0, 150), (20.5, 150), (19.5, 156), (0, 156)], segments=32)
    lens = along_x([(0, 154), (16.5, 154), (16.5, 156), (12, 157), (0, 157.5)], segments=32)
    switch = move(rounded_box(17, 9, 6, 2), 100, 0, 12)
    red = "#b8211e"
    return [Part(tail, BLACK, "rubber", "convex"), Part(grip, red, "aluminium", "convex"),
            Part(difference(neck, switch), red, "aluminium", "convex"),
            Part(flare, red, "aluminium", "convex"),
            Part(head, BLACK, "aluminium", "convex"), Part(difference(rim, lens), STEEL, "aluminium",
                                                           "convex"),
            Part(lens, "#fff3b0", "plastic", "convex"), Part(switch, BLACK, "rubber", "convex")]


@household(category="padlock", family="tools", mass=0.34, material="brass",
           source="estimate, typical: 50 mm brass padlock, body 50 x 42 x 24 mm, shackle Ø8 mm, 340 g")
def padlock() -> list[Part]:
    body = hull(upright(rounded(rect(50, 42, y=21), 6), 20), upright(rounded(rect(47, 39, y=21), 5), 24))
    bend = arc(16, 0, 180, 0, 62, 12)
    path = np.vstack([[(16, 36), (16, 50)], bend, [(-16, 50), (-16, 36)]])
    shackle = sweep(4.2, np.column_stack([path[:, 0], np.zeros(len(path)), path[:, 1]]), up=(0, 1, 0),
                    segments=14)
    plate = upright(circle(12, 0, 22, 32), 24.8)
    key = upright(figures([circle(3.6, 0, 25, 16), polygon([(-1.6, 25), (1.6, 25), (3, 15), (-3, 15)])]),
                  25.4)
    return [Part(difference(body, shackle, plate), BRASS, "brass", "convex"), Part(shackle, STEEL, "steel"),
            Part(difference(plate, key), "#e2c06a", "brass", "convex"), Part(key, BLACK, "plastic")]


@household(category="bolt", family="tools", mass=0.24, material="steel",
           source="ISO 4017 hexagon head screw M20 x 80: 30 mm across flats, head 12.5 mm; mass from volume")
def hex_bolt() -> list[Part]:
    head = intersection(extrude(regular(6, 30 / np.sqrt(3)), 12.5),
                        revolve([(0, 0), (14.5, 0), (19, 3), (19, 12.5), (0, 12.5)], 36))
    shaft = union(move(cylinder(9.9, 24, 24), z=12), move(thread(10, 58, 4, 24), z=34))
    return [Part(head, "#8b9198", "steel", "convex"), Part(shaft, STEEL, "steel", "convex")]


@household(category="nut", family="tools", mass=0.235, material="steel",
           source="ISO 4032 hexagon nut M30: 46 mm across flats, 25.6 mm high; mass from volume")
def hex_nut() -> list[Part]:
    blank = intersection(extrude(regular(6, 46 / np.sqrt(3)), 25.6),
                         revolve([(0, 0), (22, 0), (27, 3), (27, 22.6), (22, 25.6), (0, 25.6)], 36))
    bore = union(move(thread(15, 24, 5, 28), z=0.6), cone(17, 17, 28),
                 move(rotate(cone(17, 17, 28), x=180), z=25.6),
                 move(cylinder(13.5, 30, 28), z=-1))
    return [Part(difference(blank, bore), "#a88f52", "steel", 0.1)]


@household(category="pipe_fitting", family="tools", mass=0.09, material="plastic",
           source="estimate, typical: PVC elbow for 32 mm pipe, socket Ø40 mm, 53 mm to centre, 90 g")
def pipe_elbow() -> list[Part]:
    def run(radius: float, start: float, stop: float):
        pipe = [(0, start), (radius, start), (radius, stop), (0, stop)]
        return union(along_x(pipe, segments=28), along_y(pipe, segments=28))

    bend = difference(union(run(18.5, 0, 27), sphere(18.5, 28)), run(13.5, 0, 60), sphere(13.5, 28))
    sockets = [along([(16, 26), (20, 26), (20, 52), (18.5, 53), (16, 53)], segments=20)
               for along in (along_x, along_y)]
    bend = difference(bend, run(20, 26, 60))
    return [Part(bend, "#7d868f", "plastic", 0.3), *(Part(s, "#7d868f", "plastic", 0.08) for s in sockets)]


@household(category="faucet", family="tools", mass=0.38, material="brass",
           source="estimate, typical: half inch brass bib tap, 118 x 58 x 96 mm, handwheel Ø58 mm, 380 g")
def garden_tap() -> list[Part]:
    inlet = move(rotate(thread(10.2, 22, 3.6), y=90), -58)
    flange = move(rotate(prism(regular(6, 17), 9, 1.5), y=90), -38)
    barrel = union(along_x([(0, -30), (12.5, -30), (14, -22), (14, 12), (0, 12)]), move(sphere(15, 28), 8),
                   move(cylinder(13, 24, 28), 5), move(extrude(regular(6, 15), 8), 5, 0, 22))
    spout_path = bezier((8, 0, 0), (44, 0, 8), (48, 0, -12), (48, 0, -32), segments=12)
    spout = sweep(11, spout_path, up=(0, 1, 0), segments=20, scales=np.linspace(1.15, 0.9, 13))
    lip = move(revolve([(0, 0), (10.5, 0), (10.5, 3), (12, 4), (12, 7), (10.5, 8), (10.5, 11), (12, 12),
                        (12, 15), (0, 15)], 24), 48, 0, -42)
    body = difference(union(barrel, spout, lip), move(cylinder(7.5, 24, 20), 48, 0, -43))
    stem = move(revolve([(0, 0), (8, 0), (8, 10), (4.5, 12), (4.5, 17), (0, 17)], 20), 5, 0, 29)
    hub = move(cylinder(9, 7, 20), 5, 0, 45.5)
    spoke = difference(move(box(46, 8, 6), 5, 0, 46), hub)
    spokes = [m for turn in (0, 90) for m in rotate(spoke, z=turn, about=(5, 0, 0)).split()]
    rim = move(torus(24, 5, 20, 8), 5, 0, 49)
    screw = move(cylinder(5, 2.5, 16), 5, 0, 51.5)
    red = "#c8241f"
    return [Part(inlet, BRASS, "brass", "convex"), Part(flange, BRASS, "brass", "convex"),
            Part(difference(body, flange), BRASS, "brass", 0.1), Part(stem, "#b5b9bd", "brass"),
            Part(rim, red, "plastic", 0.1), Part(difference(hub, screw), red, "plastic", "convex"),
            *(Part(m, red, "plastic", "convex") for m in spokes), Part(screw, STEEL, "steel", "convex")]


@household(category="door_knob", family="tools", mass=0.36, material="brass",
           source="estimate, typical: brass entry knob, knob Ø54 mm, rose Ø66 mm, 61 mm deep, 360 g")
def door_knob() -> list[Part]:
    rose = revolve([(0, 0), (33, 0), (33, 2), (30, 6), (16, 9), (0, 9)], 40)
    neck = revolve(np.vstack([[(0, 8), (15, 8)], bezier((15, 8), (10, 14), (10, 20), (15, 27), segments=6),
                              [(0, 27)]]), 32)
    outline = spline([(14, 26), (24, 31), (27, 41), (25.5, 52), (19, 60)], 16)
    knob = revolve(np.vstack([[(0, 26)], outline, [(0, 60)]]), 40)
    core = move(cylinder(10, 7, 28), z=54)
    slot = move(box(2.4, 12, 5), z=59)
    screws = [move(cylinder(3, 3, 12), s * 25, 0, 4.8) for s in (-1, 1)]
    return [Part(difference(rose, *screws), BRASS, "brass", "convex"),
            Part(difference(neck, knob), BRASS, "brass"),
            Part(difference(knob, core), BRASS, "brass", "convex"),
            Part(difference(core, slot), "#c2c5c8", "steel", "convex"),
            Part(intersection(slot, move(cylinder(10, 1, 28), z=58.7)), BLACK, "plastic", "convex"),
            *(Part(s, "#8a6a20", "brass", "convex") for s in screws)]


@household(category="carabiner", family="tools", mass=0.095, material="aluminium",
           source="estimate, typical: screw gate carabiner, 113 x 70 mm, bar 11 mm, 95 g")
def carabiner() -> list[Part]:
    path = spline([(-24, 31), (-33, 31.5), (-47, 24), (-51, 8), (-44, -14), (-30, -21), (0, -25), (30, -26),
                   (46, -18), (51, 2), (46, 22), (38, 29.5), (27, 31)], 44)
    frame = sweep(5.6, np.column_stack([path, np.zeros(len(path))]), segments=12)
    pins = [move(sphere(5.8, 16), x, 31) for x in (-24, 27)]
    gate = move(along_x([(0, -25), (4.6, -25), (4.6, 28), (0, 28)], segments=16), 0)
    gate = difference(move(gate, y=31), *pins)
    ridges = circle(7.6, segments=32).difference(figures(place(circle(1.2, 8, segments=8), turn=a)
                                                         for a in range(0, 360, 30)))
    sleeve = move(rotate(extrude(ridges, 26), y=90), -2, 31)
    return [Part(union(frame, *pins), "#d8541c", "aluminium", 0.08),
            Part(difference(gate, sleeve), STEEL, "aluminium", 0.15),
            Part(sleeve, BLACK, "aluminium", "convex")]


@household(category="caster_wheel", family="tools", mass=0.42, material="steel",
           source="estimate, typical: 75 mm swivel caster, wheel 25 mm wide, plate 70 x 60 mm, 100 mm high")
def caster_wheel() -> list[Part]:
    """Upside down, on its plate, as it rests without furniture."""
    plate = rounded(rect(70, 60), 6).difference(figures(circle(3.6, x, y, 12) for x in (-27,
                                                                                        27) for y in (-22,
                                                                                                      22)))
    race = revolve([(0, 0), (23, 0), (23, 4), (20, 9), (0, 9)], 32)
    axle = (26.0, 62.0)
    bridge = move(box(34, 37, 4), 3, 0, 12)
    cheek = hull(rotate(cylinder(9, 3, 20), x=90), move(box(34, 3, 4), 3 - axle[0], -1.5, 12 - axle[1]))
    cheeks = [move(cheek, axle[0], y, axle[1]) for y in (18.5, -15.5)]
    fork = union(bridge, *cheeks)
    tire = difference(along_y([(0, -12.5), (34, -12.5), (37.5, -8), (37.5, 8), (34, 12.5), (0, 12.5)],
                              segments=40),
                      along_y([(0, -20), (25, -20), (25, 20), (0, 20)], segments=32))
    hub = along_y([(0, -15.4), (9, -15.4), (9, -10), (25, -10), (25, 10), (9, 10), (9, 15.4), (0, 15.4)],
                  segments=32)
    tire, hub = (move(m, axle[0], 0, axle[1]) for m in (tire, hub))
    bolt = [move(rotate(extrude(regular(6, 7.5), 5), x=90), axle[0], y, axle[1]) for y in (23, -18)]
    return [Part(extrude(plate, 3.5), STEEL, "steel", "convex"),
            Part(move(race, z=3.4), "#8b9198", "steel", "convex"),
            Part(fork, STEEL, "steel"), Part(tire, BLACK, "rubber"), Part(hub, "#c9ccd0", "plastic"),
            *(Part(b, DARK, "steel", "convex") for b in bolt)]
