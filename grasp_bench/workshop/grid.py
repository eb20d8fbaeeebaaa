"""Objects of graded difficulty: seven sizes by seven grades of shape, made by a generator of our own.

The idea is that of EGAD (Morrison, Corke and Leitner, RA-L 2020): shapes from plain to hard, so that success
can be told over difficulty. Here a shape is a box of which each pair of opposite faces is tapered like a
wedge, more with every grade, and whose edges are rounded. Beyond the friction angle of slippery plastic (17°)
such faces slide out of the fingers, while from above a steep flank looks like any other edge; what holds are
edges, corners and the odd pair of faces that is flat enough. Its *smallest* side is scaled to a share of the
gripper's stroke: with the largest at the jaw's width, as users of EGAD found, everything is easy. How
difficult each is, is measured (:mod:`grasp_bench.workshop.difficulty`): of the shapes that the seed makes,
the one is taken for a grade whose measured difficulty comes nearest to :data:`AIMS`
(``scripts/search_grid.py``). Nothing is trained on them.
"""

from __future__ import annotations

import colorsys

import numpy as np
import trimesh

from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.workshop.decompose import reduce_hull
from grasp_bench.workshop.materials import MATERIALS
from grasp_bench.workshop.model import ObjectSpec, Part
from grasp_bench.workshop.shapes import Mesh

SET = "grid"
SEED = 4085
GRADES = "abcdefg"
SIZES = np.linspace(0.40, 0.95, 7)
"""Smallest side of the bounding box, in shares of the reference gripper's stroke."""
AIMS = (0.35, 0.50, 0.65, 0.78, 0.88, 0.95, 1.00)
"""Difficulty that is looked for in each grade: share of random antipodal tries that fail."""
SUBDIVISIONS = 3
"""Of the icosahedron whose corners are moved: 642 of them, of which the convex hull keeps a few."""
TAPER = (11.0, 26.0)
"""Median tilt of a face, towards the end at which its pair converges, of the first and the last grade [°]."""
SPREAD = 0.35
"""Standard deviation of the logarithm of a pair's tilt."""
MIDDLE = ((1.6, 2.4), (1.0, 1.3))
LONG = ((1.8, 3.4), (1.25, 1.75))
"""Ranges of the other two distances between opposite faces, in shares of the least, for the smallest size and
the largest: what is small all round lies wholly between the fingers, which hold it whatever its faces."""
ROUNDNESS = (0.15, 0.5)
"""Of a superellipsoid, 0 a box and 1 an ellipsoid, for the smallest size and the largest: a box nearly as
wide as the jaws open leaves no room that a camera sees."""
FARTHEST = 2.5
"""Tips at which tapered faces meet are cut off so far out, in halves of the longest distance."""
MATERIAL = "oiled_plastic"
DRAWS: tuple[tuple[int, ...], ...] = (
    (1, 7, 5, 3, 12, 1, 4),
    (8, 11, 2, 14, 2, 11, 7),
    (11, 2, 0, 13, 5, 0, 10),
    (2, 7, 7, 12, 9, 0, 7),
    (13, 2, 12, 6, 2, 8, 15),
    (5, 10, 5, 16, 14, 13, 14),
    (15, 13, 20, 10, 85, 9, 12),
)
"""Which of a cell's shapes is taken, a row a size, a column a grade; from ``scripts/search_grid.py``."""


def shape(rng: np.random.Generator, grade: float, size: float, smallest: float) -> Mesh:
    """Make a convex mesh.

    Args:
        rng: what it is drawn from.
        grade: 0 to 1, plain to hard.
        size: 0 to 1, smallest to largest.
        smallest: least side of the bounding box [mm].
    """

    def between(ranges: tuple[tuple[float, float], tuple[float, float]]) -> float:
        (low, high), (last_low, last_high) = ranges
        return rng.uniform(low + (last_low - low) * size, high + (last_high - high) * size)

    rays = np.asarray(trimesh.creation.icosphere(subdivisions=SUBDIVISIONS).vertices)
    roundness = (ROUNDNESS[0] + (ROUNDNESS[1] - ROUNDNESS[0]) * size) * rng.uniform(0.8, 1.2)
    taper = np.radians((TAPER[0] + (TAPER[1] - TAPER[0]) * grade) * np.exp(SPREAD * rng.normal(size=3)))
    distances = np.array([1.0, between(MIDDLE), between(LONG)])
    faces = []
    for axis, tilt, turn in zip(np.eye(3), taper, rng.uniform(0, 2 * np.pi, 3), strict=True):
        towards = np.cos(turn) * np.roll(axis, 1) + np.sin(turn) * np.roll(axis, 2)
        faces += [side * axis * np.cos(tilt) + towards * np.sin(tilt) for side in (1, -1)]
    outwards = np.maximum(rays @ np.transpose(faces), 0) / np.repeat(distances / 2, 2)
    farthest = FARTHEST * distances.max() / 2
    inverse = np.maximum((outwards ** (2 / roundness)).sum(1), farthest ** (-2 / roundness))
    mesh = reduce_hull(rays * (inverse ** (-roundness / 2))[:, None])
    vertices = np.asarray(mesh.vertices)
    low, high = vertices.min(0), vertices.max(0)
    return Mesh((vertices - (low + high) / 2) * smallest / (high - low).min(), mesh.faces, process=False)


def spec(size: int, grade: int, draw: int) -> ObjectSpec:
    """Return the ``draw``-th object of a size and a grade, indices from 0 to 6."""
    rng = np.random.default_rng(np.random.SeedSequence([SEED, size, grade, draw]))
    smallest = round(1000 * PARALLEL_85.opening * float(SIZES[size]), 1)
    mesh = shape(rng, grade / (len(GRADES) - 1), size / (len(SIZES) - 1), smallest)
    color = "#" + "".join(
        f"{round(255 * c):02x}" for c in colorsys.hsv_to_rgb(grade / 9, 0.6, 0.9 - 0.06 * size)
    )
    return ObjectSpec(
        f"grid_{GRADES[grade]}{size + 1}",
        f"grade_{GRADES[grade]}",
        SET,
        round(MATERIALS[MATERIAL].density * 1e-9 * float(mesh.volume), 4),
        MATERIAL,
        f"generated: grade {GRADES[grade]}, smallest side {smallest:g} mm, seed {SEED}, draw {draw}",
        lambda: [Part(mesh, color, MATERIAL, "convex")],
    )


def specs() -> list[ObjectSpec]:
    """Return the 49 objects, plain before rugged, small before large."""
    return [spec(s, g, row[g]) for g in range(len(GRADES)) for s, row in enumerate(DRAWS)]
