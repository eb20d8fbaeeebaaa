"""Random objects to train on, made of random solids.

They share no model with the objects of the benchmark: networks trained on them have seen
none of the things they are tested with. Each object knows its mass properties, its coloured
parts and its convex pieces, all from construction.
"""

from __future__ import annotations

import colorsys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from grasp_bench.learning.data import random_solids as solids
from grasp_bench.learning.data.random_solids import Floats, Rng, Solid, log_uniform
from grasp_bench.objects.catalog import VisualPart

LARGEST, SMALLEST = 300.0, 15.0
"""Bounds of an object's longest edge [mm]."""
MAX_HULLS = 40
MASS = (0.010, 1.2)
"""Bounds of an object's mass [kg]."""
Parts = list[list[Solid]]
"""Solids grouped by colour."""


@dataclass(frozen=True)
class RandomObject:
    """A random object about its centre of mass, as :class:`grasp_bench.scene.builder.SceneObject`.

    Attributes:
        kind: name of the function that made it.
        mass: kilograms.
        inertia: (3, 3) about the centre of mass [kg m²].
        friction: sliding friction coefficient against the finger pads.
        visual: closed coloured meshes [m].
        hulls: vertices (V, 3) of each convex piece [m].
    """

    kind: str
    mass: float
    inertia: Floats
    friction: float
    visual: list[VisualPart]
    hulls: list[Floats]


# ---------------------------------------------------------------- sizes and colours


def box_size(rng: Rng) -> Floats:
    """Draw (3,) edges [mm]: compact, elongated, flat or small."""
    kind = rng.random()
    if kind < 0.35:
        return np.clip(log_uniform(rng, 20, 80) * rng.uniform(0.45, 1.3, 3), 12, 110)
    if kind < 0.65:
        return np.array([log_uniform(rng, 80, 290), log_uniform(rng, 9, 50), log_uniform(rng, 9, 40)])
    if kind < 0.85:
        return np.array([log_uniform(rng, 40, 200), log_uniform(rng, 18, 78), log_uniform(rng, 7, 22)])
    return rng.uniform(12, 40, 3)


def random_color(rng: Rng) -> tuple[float, float, float]:
    """Draw a dark, white, grey, saturated, pale or brownish colour, each channel in [0, 1]."""
    kind = rng.random()
    if kind < 0.16:
        return _tinted(rng, rng.uniform(0.02, 0.2))
    if kind < 0.32:
        return _tinted(rng, rng.uniform(0.82, 1.0))
    if kind < 0.48:
        return _tinted(rng, rng.uniform(0.25, 0.75))
    if kind < 0.58:
        return colorsys.hsv_to_rgb(rng.uniform(0.04, 0.13), rng.uniform(0.25, 0.75), rng.uniform(0.25, 0.85))
    return colorsys.hsv_to_rgb(rng.random(), rng.uniform(0.35, 1.0), rng.uniform(0.25, 1.0))


def _tinted(rng: Rng, value: float) -> tuple[float, float, float]:
    return tuple(np.clip(value + rng.normal(0, 0.02, 3), 0, 1).tolist())


# ---------------------------------------------------------------- kinds of objects


def lump(rng: Rng) -> Parts:
    """Make one convex solid."""
    return [[solids.lump(rng, box_size(rng))]]


def turned(rng: Rng) -> Parts:
    """Make a turned solid: spindle, knob, disc or stand."""
    if rng.random() < 0.4:
        return [[solids.turned(rng, log_uniform(rng, 9, 40), log_uniform(rng, 60, 280))]]
    return [[solids.turned(rng, log_uniform(rng, 20, 90), log_uniform(rng, 10, 110))]]


def vessel(rng: Rng) -> Parts:
    """Make a thin-walled vessel, with or without handle."""
    diameter, height = log_uniform(rng, 30, 150), log_uniform(rng, 15, 150)
    parts = [[solids.vessel(rng, diameter, height)]]
    if rng.random() < 0.4:
        span, thick = rng.uniform(0.45, 0.85) * height, rng.uniform(6, 14)
        grip_ = solids.handle(rng, max(span, 15), rng.uniform(15, 45), thick)
        parts.append([grip_.placed((90, 0, 0), (0.42 * diameter, 0, 0))])
    return parts


def cutout(rng: Rng) -> Parts:
    """Make an extruded figure: angle, cross, star, ring or plate with holes."""
    if rng.random() < 0.6:
        size = [log_uniform(rng, 30, 200), log_uniform(rng, 25, 130), log_uniform(rng, 7, 30)]
    else:
        size = [log_uniform(rng, 15, 90), log_uniform(rng, 15, 90), log_uniform(rng, 15, 160)]
    return [[solids.cutout(rng, size)]]


def bar(rng: Rng) -> Parts:
    """Make a straight, curved or hooked bar."""
    return [[solids.bar(rng, log_uniform(rng, 60, 290), log_uniform(rng, 8, 32), log_uniform(rng, 8, 26))]]


def loop(rng: Rng) -> Parts:
    """Make a closed loop, perhaps with a stem."""
    width, thick = log_uniform(rng, 40, 150), log_uniform(rng, 7, 18)
    depth, height = width * rng.uniform(0.5, 1), thick * rng.uniform(0.8, 1.6)
    parts = [[solids.loop(rng, width, depth, thick, height)]]
    if rng.random() < 0.5:
        stem = solids.bar(rng, log_uniform(rng, 40, 140), thick * rng.uniform(0.8, 2), height)
        parts.append([stem.placed(offset=(width / 2 + stem.size[0] / 2 - thick / 2, 0, 0))])
    return parts


def body_and_handle(rng: Rng) -> Parts:
    """Make a compact body with a bowed or a straight handle."""
    body = solids.lump(rng, np.clip(log_uniform(rng, 25, 90) * rng.uniform(0.6, 1.3, 3), 18, 130))
    thick = rng.uniform(7, 18)
    if rng.random() < 0.5:
        arm = solids.handle(rng, max(0.8 * body.size[1], 20), rng.uniform(20, 50), thick)
        return [[body], [arm.placed(offset=(0.4 * body.size[0], 0, 0))]]
    arm = solids.bar(rng, log_uniform(rng, 50, 170), thick, thick * rng.uniform(0.7, 1.3))
    lift = rng.uniform(-0.3, 0.3) * body.size[2]
    return [[body], [arm.placed(offset=(0.42 * body.size[0] + arm.size[0] / 2, 0, lift))]]


def tool(rng: Rng) -> Parts:
    """Make a thin shaft in a thick handle, perhaps with a head at its end."""
    shaft_length, shaft = log_uniform(rng, 50, 180), log_uniform(rng, 5, 14)
    thick = shaft * rng.uniform(1.4, 4)
    length = log_uniform(rng, 50, 130)
    flat = rng.uniform(0.5, 1) if rng.random() < 0.5 else 1.0
    if rng.random() < 0.5:
        hold = solids.turned(rng, thick, length).placed((0, 90, 0)).scaled((1, 1, flat))
    else:
        hold = solids.lump(rng, [length, thick, thick * flat])
    stick = solids.bar(rng, shaft_length, shaft, shaft * rng.uniform(0.7, 1))
    start = hold.size[0] / 2
    parts = [[hold], [stick.placed(offset=(0.85 * start + stick.size[0] / 2, 0, 0))]]
    if rng.random() < 0.6:
        head = _head(rng, shaft)
        parts.append([head.placed(offset=(0.85 * start + stick.size[0] + 0.2 * head.size[0], 0, 0))])
    return parts


def _head(rng: Rng, shaft: float) -> Solid:
    size = shaft * rng.uniform(1.2, 5, 3)
    size[2] = min(size[2], 40)
    if rng.random() < 0.3:
        size[2] = max(0.3 * size[2], 6)
        return solids.cutout(rng, np.clip(size, 6, 70))
    return solids.lump(rng, np.clip(size, 6, 70))


def rod_and_head(rng: Rng) -> Parts:
    """Make a rod with one or two heads, in line or across."""
    length, thick = log_uniform(rng, 60, 260), log_uniform(rng, 7, 28)
    rod = solids.bar(rng, length, thick, thick * rng.uniform(0.6, 1))
    parts = [[rod]]
    for side in (1, -1)[: 1 + int(rng.random() < 0.3)]:
        head = _head(rng, thick)
        parts.append([head.placed(offset=(side * rod.size[0] / 2, 0, rng.uniform(-0.2, 0.2) * head.size[2]))])
    return parts


def plate_and_knob(rng: Rng) -> Parts:
    """Make a plate with one to three things standing on it."""
    size = np.array([log_uniform(rng, 40, 160), log_uniform(rng, 30, 110), log_uniform(rng, 6, 16)])
    plate = solids.cutout(rng, size) if rng.random() < 0.3 else solids.lump(rng, size)
    parts = [[plate]]
    for _ in range(int(rng.integers(1, 4))):
        knob = solids.lump(rng, [log_uniform(rng, 8, 40), log_uniform(rng, 8, 40), log_uniform(rng, 12, 50)])
        x, y = rng.uniform(-0.32, 0.32, 2) * size[:2]
        parts.append([knob.placed(offset=(x, y, 0.3 * size[2] + knob.size[2] / 2))])
    return parts


def crossing(rng: Rng) -> Parts:
    """Make two bars that cross, with or without loops at their ends."""
    length, width, height = log_uniform(rng, 90, 230), log_uniform(rng, 7, 18), log_uniform(rng, 6, 14)
    opening = rng.uniform(12, 70)
    pivot = rng.uniform(-0.25, 0.25) * length
    ring = rng.random() < 0.5
    parts: Parts = []
    for i, side in enumerate((-1, 1)):
        arm = [
            solids.swept(
                [(-length / 2, 0), (length / 2, 0)],
                solids.section(rng, width, height),
                rng.uniform(0.5, 1, 2),
            ).placed(offset=(pivot, 0, 0))
        ]
        if ring:
            eye = solids.loop(rng, rng.uniform(28, 60), rng.uniform(25, 45), rng.uniform(7, 10), height)
            arm.append(eye.placed(offset=(pivot - length / 2 - 0.4 * eye.size[0], 0, 0)))
        parts.append([s.placed((0, 0, side * opening / 2), (0, 0, i * 0.6 * height)) for s in arm])
    return parts


def two_loops(rng: Rng) -> Parts:
    """Make two loops side by side, joined by a bridge."""
    width, thick, height = log_uniform(rng, 35, 75), log_uniform(rng, 7, 12), log_uniform(rng, 7, 16)
    depth, gap = width * rng.uniform(0.6, 1), rng.uniform(0, 40)
    reach = (width + gap) / 2
    eyes = [
        solids.loop(rng, width, depth, thick, height).placed((0, 0, turn), (x, 0, 0))
        for x, turn in ((-reach, 180), (reach, 0))
    ]
    bridge = solids.block(rng, np.array([gap + 1.6 * thick, thick, height]))
    return [eyes, [bridge.placed(offset=(0, rng.uniform(-0.2, 0.2) * depth, 0))]]


def stack(rng: Rng) -> Parts:
    """Make two to four convex solids one after the other along an axis."""
    parts: Parts = []
    end, base = 0.0, log_uniform(rng, 12, 65)
    for _ in range(int(rng.integers(2, 5))):
        piece = solids.lump(rng, base * np.array([log_uniform(rng, 0.4, 2), *rng.uniform(0.5, 1.2, 2)]))
        shift = rng.uniform(-0.25, 0.25, 2) * base
        parts.append([piece.placed(offset=(end + 0.4 * piece.size[0], *shift))])
        end += 0.8 * piece.size[0]
    return parts


KINDS: dict[Callable[[Rng], Parts], float] = {
    lump: 0.17,
    turned: 0.07,
    vessel: 0.12,
    cutout: 0.09,
    bar: 0.11,
    loop: 0.04,
    body_and_handle: 0.07,
    tool: 0.12,
    rod_and_head: 0.07,
    plate_and_knob: 0.04,
    crossing: 0.04,
    two_loops: 0.02,
    stack: 0.04,
}
"""Kinds of objects and how often each is drawn."""


# ---------------------------------------------------------------- the object


def random_object(rng: np.random.Generator) -> RandomObject:
    """Make a new random object; redrawn while it has too many pieces."""
    kinds = list(KINDS)
    while True:
        kind = kinds[int(rng.choice(len(kinds), p=list(KINDS.values())))]
        parts = kind(rng)
        if sum(len(s.pieces) for part in parts for s in part) <= MAX_HULLS:
            return assemble(rng, parts, kind.__name__)


def assemble(rng: np.random.Generator, parts: Parts, kind: str) -> RandomObject:
    """Give solids [mm] grouped by colour a scale, colours, mass properties and friction."""
    vertices = np.vstack([s.mesh.vertices for part in parts for s in part])
    longest = float(np.ptp(vertices, axis=0).max())
    scale = 1e-3 * float(np.clip(longest, SMALLEST, LARGEST)) / longest
    placed = [[s.scaled(scale) for s in part] for part in parts]
    densities = np.array([log_uniform(rng, 0.6, 1.6) for part in placed for _ in part])
    meshes = [s.mesh for part in placed for s in part]
    volumes = np.array([abs(m.volume) for m in meshes])
    mass = float(np.clip(log_uniform(rng, 150, 2500) * volumes.sum(), *MASS))
    shares = mass * densities * volumes / (densities @ volumes)
    centres = np.array([m.center_mass for m in meshes])
    centre = shares @ centres / mass
    inertia = np.zeros((3, 3))
    for mesh, share, own, volume in zip(meshes, shares, centres, volumes, strict=True):
        arm = own - centre
        inertia += np.asarray(mesh.moment_inertia) * share / volume
        inertia += share * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    color = random_color(rng)
    visual, hulls = [], []
    for part in placed:
        for s in part:
            visual.append(
                VisualPart(
                    np.asarray(s.mesh.vertices) - centre,
                    np.asarray(s.mesh.faces, np.int32),
                    color,
                    float(rng.uniform(0.2, 0.9)),
                )
            )
            hulls += [p - centre for p in s.pieces]
        if rng.random() < 0.75:
            color = random_color(rng)
    return RandomObject(kind, mass, inertia, float(rng.uniform(0.45, 0.95)), visual, hulls)
