"""Packaged food: cans, bottles, cartons, a box and a jar, full and closed."""

from __future__ import annotations

import numpy as np
import trimesh
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from grasp_bench.workshop.model import Part, household
from grasp_bench.workshop.shapes import (
    Floats,
    Mesh,
    bezier,
    box,
    circle,
    cylinder,
    deform,
    difference,
    ellipse,
    extrude,
    figures,
    loft,
    move,
    place,
    polygon,
    prism,
    rect,
    regular,
    revolve,
    rotate,
    rounded_box,
    spline,
    star,
    stroke,
    sweep,
    union,
)

STEEL = "#b9bdc2"
STROKES: dict[str, list[list[tuple[float, float]]]] = {
    "A": [[(0, 0), (0.34, 1), (0.68, 0)], [(0.13, 0.35), (0.55, 0.35)]],
    "C": [[(0.6, 0.8), (0.42, 1), (0.15, 1), (0, 0.8), (0, 0.2), (0.15, 0), (0.42, 0), (0.6, 0.2)]],
    "E": [[(0.55, 0), (0, 0), (0, 1), (0.55, 1)], [(0, 0.5), (0.45, 0.5)]],
    "I": [[(0.1, 0), (0.1, 1)]],
    "J": [[(0.5, 1), (0.5, 0.2), (0.36, 0), (0.14, 0), (0, 0.2)]],
    "K": [[(0, 0), (0, 1)], [(0.55, 1), (0.03, 0.45)], [(0.2, 0.6), (0.6, 0)]],
    "L": [[(0, 1), (0, 0), (0.5, 0)]],
    "M": [[(0, 0), (0, 1), (0.38, 0.35), (0.76, 1), (0.76, 0)]],
    "O": [[(0.2, 0), (0, 0.25), (0, 0.75), (0.2, 1), (0.45, 1), (0.65, 0.75), (0.65, 0.25), (0.45, 0),
           (0.2, 0)]],
    "P": [[(0, 0), (0, 1), (0.4, 1), (0.58, 0.85), (0.58, 0.65), (0.4, 0.48), (0, 0.48)]],
    "S": [[(0.55, 0.85), (0.4, 1), (0.15, 1), (0, 0.85), (0, 0.65), (0.15, 0.52), (0.42, 0.48),
           (0.57, 0.35), (0.57, 0.15), (0.42, 0), (0.15, 0), (0, 0.15)]],
    "T": [[(0.3, 0), (0.3, 1)], [(0, 1), (0.6, 1)]],
    "U": [[(0, 1), (0, 0.2), (0.16, 0), (0.44, 0), (0.6, 0.2), (0.6, 1)]],
}
"""Letters as polylines in a unit-high box."""


def _word(word: str, height: float, weight: float = 0.2) -> BaseGeometry:
    """``word`` in block letters, centred on the origin."""
    shapes, x = [], 0.0
    for letter in word:
        lines = [np.array(line) * height + [x, -height / 2] for line in STROKES[letter]]
        shapes.append(figures(stroke(line, weight * height, cap="square") for line in lines))
        x += height * (max(p[0] for line in STROKES[letter] for p in line) + 0.38)
    centred = [place(s, -(x - 0.38 * height) / 2) for s in shapes]
    return figures(s.simplify(0.02 * height) for s in centred)


def _label(figure: BaseGeometry, front: float, z: float, wrap: bool = False,
           proud: float = 0.4) -> Mesh:
    """Figure printed on the side at x = ``front``, ``z`` up; ``wrap`` bends it round the z axis
    (and turns it 35 degrees towards the usual viewer).

    Its shapes are joined by a bar behind the surface, which makes them one body.
    """
    left, low, right, high = figure.bounds
    bar = rect(right - left - 1, (high - low) * 0.3, x=(left + right) / 2, y=(low + high) / 2)
    flat = union(move(extrude(figure, 1.6 + proud), z=-1.6), move(extrude(bar, 1), z=-1.6))

    def bend(v: Floats) -> Floats:
        return np.column_stack([(front + v[:, 2]) * np.cos(v[:, 0] / front),
                                (front + v[:, 2]) * np.sin(v[:, 0] / front), v[:, 1] + z])

    if wrap:
        return rotate(deform(flat, bend, max_edge=8), z=-35)
    return Mesh(flat.vertices[:, [2, 0, 1]] + [front, 0, z], flat.faces, process=False)


def _turned(*points: tuple[float, float], segments: int = 36) -> Mesh:
    """Solid of revolution below a (r, z) polyline, closed along the axis."""
    return revolve([(0, points[0][1]), *points, (0, points[-1][1])], segments)


def _ribbed(radius: float, low: float, high: float, ribs: int, depth: float) -> list[tuple[float, float]]:
    """Profile of a cylinder with ``ribs`` rounded grooves."""
    z = np.linspace(low, high, 5 * ribs + 1)
    r = radius - depth * (1 - np.cos(2 * np.pi * ribs * (z - low) / (high - low))) / 2
    return list(zip(r.tolist(), z.tolist(), strict=True))


def _ring_pull(x: float = 0.0) -> Mesh:
    """Flat tab with a finger hole, along x with its rivet at ``x``."""
    tab = rect(24, 15, 6, x=x + 6).difference(ellipse(5, 4.5, x + 11, 0, 16))
    return extrude(tab, 2)


def _tear(width: float, length: float) -> Polygon:
    """Leaf or drop outline, pointed end up, centred on the origin."""
    side = bezier((0, length / 2), (width * 0.1, length * 0.25), (width * 1.1, -length * 0.5),
                  (0, -length / 2), segments=12)
    return polygon(np.vstack([side, side[-2:0:-1] * [-1, 1]]))


@household(category="can", family="food", mass=0.349, material="paper",
           source="YCB 005_tomato_soup_can: Ø66 x 101 mm, 349 g")
def tomato_soup_can() -> list[Part]:
    foot = _turned((32, 0), (33, 0.8), (33, 3.2), (31.8, 4.5))
    white = _turned(*_ribbed(32.5, 4.5, 50, 5, 1.0))
    red = _turned(*_ribbed(32.5, 50, 96.5, 5, 1.0))
    rim = difference(_turned((31.8, 96.5), (33, 97.8), (33, 100.4), (32.2, 101)),
                     move(cylinder(30.5, 10), z=98))
    medal = _label(regular(20, 10), 32.5, 50, wrap=True, proud=0.7)
    soup = _label(_word("SOUP", 13), 32.2, 24, wrap=True)
    tab = move(_ring_pull(9), z=97.6)
    return [Part(foot, STEEL, "steel", "convex"), Part(white, "#f5f1e6", "liquid", "convex"),
            Part(red, "#c3161f", "liquid", "convex"), Part(rim, STEEL, "steel", "convex"),
            Part(tab, "#8f949a", "steel", "convex"), Part(medal, "#d8a93a", "paper", "convex"),
            Part(soup, "#c3161f", "paper", "convex")]


@household(category="can", family="food", mass=0.265, material="aluminium",
           source="250 ml slim aluminium beverage can (can maker's data sheet): Ø53 x 134 mm, 265 g full")
def slim_soda_can() -> list[Part]:
    foot = _turned((20, 0), (22, 0.5), (26.5, 11), (26.5, 14))
    low = _turned((26.5, 14), (26.5, 78))
    band = _turned((26.5, 78), (26.5, 88))
    high = _turned((26.5, 88), (26.5, 118))
    neck = difference(_turned((26.5, 118), (24, 128), (24.5, 130), (25.3, 132), (25.3, 133.5), (24.5, 134)),
                      move(cylinder(22.5, 10), z=130))
    tab = move(_ring_pull(), z=129.6)
    cola = _label(_word("COLA", 14.5), 26.5, 46, wrap=True)
    return [Part(foot, STEEL, "aluminium", "convex"), Part(low, "#1f5fa8", "liquid", "convex"),
            Part(band, "#f2f2f0", "liquid", "convex"), Part(high, "#d42a2f", "liquid", "convex"),
            Part(neck, STEEL, "aluminium", "convex"), Part(tab, "#8f949a", "aluminium", "convex"),
            Part(cola, "#f2f2f0", "paper", "convex")]


@household(category="can", family="food", mass=0.155, material="aluminium",
           source="EN 10202 club can 125 ml: 104 x 60 x 24 mm, 120 g net, about 155 g gross")
def sardine_tin() -> list[Part]:
    body = prism(rect(103, 58.5, 18), 21, 1)
    seam = extrude(rect(105, 60.5, 19).difference(rect(100, 55.5, 16.5)), 3)
    lid = extrude(rect(101, 56.5, 17), 1.2)
    tab = rotate(_ring_pull(), z=180)
    head = bezier((-22, 0), (-14, 11), (4, 13), (16, 2), segments=10)
    tail = np.array([(26, 9), (23, 0)])
    fish = polygon(np.vstack([head, tail, [(26, -9)], head[::-1][:-1] * [1, -1]]))
    eye = move(cylinder(1.8, 0.6, 12), -26, 3, 22.9)
    return [Part(body, "#c8cbd0", "liquid", "convex"), Part(move(seam, z=20.5), STEEL, "aluminium", "convex"),
            Part(move(lid, z=21), "#e3b23c", "aluminium", "convex"),
            Part(move(extrude(fish, 1), -10, 0, 22), "#24507e", "paper", "convex"),
            Part(eye, "#ffffff", "paper", "convex"),
            Part(move(tab, 46, 0, 22.1), "#8f949a", "aluminium", "convex")]


@household(category="bottle", family="food", mass=0.52, material="plastic",
           source="common 0.5 l PET water bottle (retail data): Ø65 x 215 mm, 0.52 kg full")
def water_bottle() -> list[Part]:
    lower = _turned((24, 0), (28, 1), (32, 7), *_ribbed(32.5, 12, 72, 5, 2.6))
    label = _turned((32, 72), (32.6, 72.5), (32.6, 119.5), (32, 120))
    upper = _turned(*_ribbed(32.5, 120, 144, 2, 2.6), *spline([(32.5, 146), (29, 162), (18, 182), (13, 194)],
                                                              12).tolist())
    neck = _turned((12.5, 193), (12.5, 197), (16.5, 197), (16.5, 199), (12.5, 199), (12.5, 202), segments=32)
    cap = move(prism(star(28, 15.2, 14.2), 14, 0.8), z=201)
    drop = _label(_tear(22, 34), 32.6, 96, wrap=True)
    water = "#a9d8ee"
    return [Part(lower, water, "liquid", "convex"), Part(label, "#1766b5", "liquid", "convex"),
            Part(upper, water, "liquid"), Part(neck, water, "liquid", "convex"),
            Part(cap, "#1766b5", "polyethylene", "convex"), Part(drop, "#eef6fb", "paper", "convex")]


@household(category="bottle", family="food", mass=0.68, material="glass",
           source="common 375 ml half Bordeaux bottle (glass maker's data): Ø60 x 240 mm, 0.68 kg full")
def wine_bottle() -> list[Part]:
    low = _turned((28, 0), (30, 2), (30, 28))
    label = _turned((30.4, 28), (30.4, 92))
    shoulder = spline([(30, 120), (29.5, 134), (26, 148), (17, 160), (13, 172), (12.5, 190)], 16).tolist()
    high = _turned((30, 92), *shoulder)
    capsule = _turned((13.2, 189), (12.8, 228), (15, 229), (15, 237), (14.5, 240))
    grapes = [circle(4.6, 9.4 * (i - j / 2), 7.6 * j, 10) for j in range(3) for i in range(j + 1)]
    bunch = _label(figures(grapes), 30.4, 54, wrap=True)
    return [Part(low, "#1f3a2a", "liquid", "convex"), Part(label, "#efe5cb", "liquid", "convex"),
            Part(high, "#1f3a2a", "glass"), Part(capsule, "#7a1428", "glass"),
            Part(bunch, "#6d2350", "paper", "convex"),
            Part(_label(rect(38, 3), 30.4, 83, wrap=True), "#b08d3c", "paper", "convex"),
            Part(_label(rect(38, 3), 30.4, 37, wrap=True), "#b08d3c", "paper", "convex")]


def _oval(rx: float, ry: float, z: float, segments: int = 36) -> Floats:
    """Ring of points of a rounded-rectangular (superelliptic) section."""
    t = np.linspace(0, 2 * np.pi, segments, endpoint=False)
    c, s = np.cos(t), np.sin(t)
    return np.column_stack([rx * np.sign(c) * np.abs(c) ** 0.8, ry * np.sign(s) * np.abs(s) ** 0.8,
                            np.full(segments, z)])


@household(category="bottle", family="food", mass=0.38, material="polyethylene",
           source="common 340 g squeeze ketchup bottle (retail data): 64 x 48 x 190 mm, 0.38 kg full")
def ketchup_bottle() -> list[Part]:
    levels = np.array([(20, 28, 0), (23, 31, 3), (24, 32, 10), (22.5, 29.5, 45), (22, 29, 70),
                       (24, 32, 110), (23, 30, 122), (17, 20, 134), (13, 13, 140)])
    body = loft([_oval(*level) for level in levels])
    collar = move(prism(star(24, 18, 17), 16, 1), z=139)
    spout = _turned((15, 154), (12, 159), (5, 174), (3.5, 188), (2.5, 190), segments=28)
    tomato = _label(ellipse(14, 12.5, segments=24), 24.1, 84, proud=0.6)
    tomato_leaf = _label(place(star(5, 9, 3.5), 0, 9), 24.7, 84, proud=0.5)
    plate = _label(ellipse(22, 26, segments=32), 23.2, 84, proud=0.8)
    white = "#f4f2ec"
    return [Part(body, "#c01a1a", "liquid"), Part(collar, white, "polyethylene", "convex"),
            Part(spout, white, "polyethylene"), Part(plate, white, "paper", "convex"),
            Part(tomato, "#d5281f", "paper", "convex"), Part(tomato_leaf, "#3f8b3a", "paper", "convex")]


@household(category="carton", family="food", mass=0.53, material="cardboard",
           source="0.5 l gable-top carton (carton maker's data sheet): 70 x 70 x 143 mm, 0.53 kg full")
def milk_carton() -> list[Part]:
    low = box(70, 70, 32)
    high = move(box(70, 70, 63), z=32)
    roof = trimesh.convex.convex_hull(np.array(
        [(x, y, z) for x in (-35, 35) for y, z in ((-35, 95), (35, 95), (-2, 128), (2, 128))], dtype=float))
    folds = [trimesh.convex.convex_hull(np.array(
        [(s * 36, -33, 96), (s * 36, 33, 96), (s * 36, 0, 129), (s * 14, 0, 124.0)])) for s in (-1, 1)]
    fin = move(box(70, 4, 15.5), z=127.5)
    cap = move(rotate(prism(star(20, 12, 11.2), 9, 0.8), x=45), 0, -18.5, 110.5)
    milk = _label(_word("MILK", 17), 35, 64)
    wave = [(-35, -4), *bezier((-35, 3), (-12, 14), (12, -10), (35, 3), segments=14).tolist(), (35, -4)]
    blue, white = "#2c6fb7", "#f6f6f2"
    return [Part(low, blue, "liquid", "convex"), Part(high, white, "liquid", "convex"),
            Part(difference(roof, *folds), blue, "cardboard", 0.2), Part(fin, white, "cardboard", "convex"),
            Part(cap, "#d6322e", "polyethylene", "convex"), Part(milk, blue, "paper", "convex"),
            Part(_label(polygon(wave), 35, 34, proud=0.3), blue, "paper", "convex")]


@household(category="carton", family="food", mass=0.215, material="cardboard",
           source="200 ml brick carton, base format (carton maker's data sheet): 48 x 38 x 117 mm, 215 g")
def juice_box() -> list[Part]:
    body = rounded_box(38, 48, 117, 1.2, 1)
    flap = move(box(5, 48, 2.4), x=-6, z=116.8)
    straw = sweep(2.5, [(8, 12, 112), (8, 12, 122), (8, 12, 136), (8, 13, 139), (8, 16, 141), (8, 28, 147)],
                  segments=12)
    foil = move(cylinder(5.5, 0.6, 20), 8, 12, 116.8)
    base = _label(rect(47, 26), 19, 15)
    fruit = _label(circle(17, segments=28), 19, 72, proud=0.4)
    flesh = _label(figures(place(polygon([(0, 1.5), (4.6, 12), (0, 14), (-4.6, 12)]), 0, 0, 45 * i)
                           for i in range(8)), 19.2, 72, proud=0.5)
    leaf = _label(place(_tear(11, 20), 12, 20, -50), 19, 72)
    return [Part(body, "#f7e9b8", "liquid", "convex"), Part(flap, "#e9d79a", "cardboard", "convex"),
            Part(straw, "#e04a3a", "plastic"), Part(foil, STEEL, "aluminium", "convex"),
            Part(base, "#2f8f4e", "paper", "convex"), Part(fruit, "#ee8a1d", "paper", "convex"),
            Part(flesh, "#f9c15a", "paper", "convex"), Part(leaf, "#2f8f4e", "paper", "convex")]


@household(category="box", family="food", mass=0.085, material="cardboard",
           source="common 25-bag tea box (retail data): 130 x 66 x 75 mm, 50 g net, 85 g gross")
def tea_box() -> list[Part]:
    body = box(66, 130, 54)
    lid = move(box(67.5, 131.5, 21), z=54)
    plate = _label(rect(96, 38, 8), 33, 26)
    word = _label(place(_word("TEA", 21), -13, 0), 33.3, 26, proud=0.5)
    sprig = _label(figures([place(_tear(11, 26), 27, 1, -40), place(_tear(11, 26), 38, 3, 30)]),
                   33.3, 24, proud=0.5)
    band = _label(rect(131, 3.5), 33.75, 59)
    top = move(extrude(rect(46, 108, 6), 1), z=74.4)
    top_word = rotate(_label(_word("TEA", 28), 75.4, 0), y=-90)
    return [Part(body, "#1f6b4a", "cardboard", "convex"), Part(lid, "#2f8a5e", "cardboard", "convex"),
            Part(plate, "#f3ead2", "paper", "convex"), Part(word, "#8c2f22", "paper", "convex"),
            Part(sprig, "#4c9a3f", "paper", "convex"), Part(band, "#d9b24a", "paper", "convex"),
            Part(top, "#f3ead2", "paper", "convex"), Part(top_word, "#8c2f22", "paper", "convex")]


@household(category="jar", family="food", mass=0.40, material="glass",
           source="hexagonal 212 ml jam jar with TO 58 lid (glass maker's data): 64 x 84 mm, 0.40 kg full")
def jam_jar() -> list[Part]:
    hexagon = regular(6, 36.5, turn=30).buffer(-4).buffer(4, quad_segs=2)
    glass = prism(hexagon, 8, 2.5)
    jam = move(extrude(hexagon, 52), z=5.5)
    shoulder = move(prism(hexagon, 12, 5), z=56)
    neck = move(cylinder(27, 5, 36), z=66)
    lid = move(prism(star(36, 30.8, 30), 14, 1.2), z=70)
    front = 36.5 * np.cos(np.radians(30))
    plate = _label(rect(30, 36, 2), front, 34, proud=0.3)
    word = _label(_word("JAM", 8.5), front + 0.3, 25, proud=0.4)
    berry = _label(place(_tear(13, 17), 0, 0, 180), front + 0.3, 42, proud=0.4)
    leaf = _label(place(star(5, 6.5, 2.5), 0, 7), front + 0.6, 42, proud=0.4)
    parts = [(glass, "#e3d3d3", "glass"), (jam, "#8e1230", "liquid"), (shoulder, "#e3d3d3", "glass"),
             (neck, "#e3d3d3", "glass"), (lid, "#d8b04a", "steel"), (plate, "#f7f2e4", "paper"),
             (word, "#8e1230", "paper"), (berry, "#d3202c", "paper"), (leaf, "#3f8b3a", "paper")]
    return [Part(rotate(mesh, z=-30), color, material, "convex") for mesh, color, material in parts]
