"""Objects of graded difficulty: seven sizes by seven grades of shape, made by a generator of our own.

The idea is that of EGAD (Morrison, Corke and Leitner, RA-L 2020): shapes from plain to rugged, so that
success can be told over difficulty. Here a shape is a box whose six faces are tilted at random, more with
every grade, and then swollen and dented. Its *smallest* side is scaled to a share of the gripper's stroke:
with the largest at the jaw's width, as users of EGAD found, everything is easy. They are of slippery plastic,
so that slanted faces slide out of the fingers. How difficult each is, is measured
(:mod:`grasp_bench.workshop.difficulty`): of the shapes that the seed makes, the one is taken for a grade
whose measured difficulty comes nearest to :data:`AIMS` (``scripts/search_grid.py``). Nothing is trained on
them.
"""

from __future__ import annotations

import colorsys
from dataclasses import dataclass

import numpy as np
import trimesh

from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.workshop.decompose import reduce_hull
from grasp_bench.workshop.materials import MATERIALS
from grasp_bench.workshop.model import ObjectSpec, Part
from grasp_bench.workshop.shapes import Mesh

SET = "grid"
SEED = 85
GRADES = "abcdefg"
SIZES = np.linspace(0.40, 0.95, 7)
"""Smallest side of the bounding box, in shares of the reference gripper's stroke."""
AIMS = (0.02, 0.15, 0.30, 0.50, 0.65, 0.80, 0.95)
"""Difficulty that is looked for in each grade: share of random antipodal tries that fail."""
SUBDIVISIONS = 3
"""Of the icosahedron whose corners are moved: 1,280 faces."""
MIDDLE, LONG = (1.0, 1.3), (1.25, 1.75)
"""Ranges of the other two sides, in shares of the smallest."""
SWELLINGS, SPREAD = 10, 0.6
"""Number and angular width [rad] of swellings and dents."""
LARGEST_TILT = 0.3
"""Least tilt of the largest: only slanted faces make them narrow enough at the top to be seen to fit."""
FARTHEST = 2.5
"""Corners at which tilted faces meet are cut off so far out, in half sides."""
NEARLY_CONVEX = 0.97
"""A shape that fills so much of its convex hull is made its hull, as its only piece will be."""
MATERIAL = "oiled_plastic"
DRAWS: tuple[tuple[int, ...], ...] = (
    (0, 2, 3, 4, 1, 4, 6),
    (0, 3, 3, 6, 5, 2, 0),
    (0, 5, 2, 3, 4, 5, 5),
    (2, 0, 3, 3, 0, 4, 4),
    (2, 2, 3, 1, 1, 4, 2),
    (0, 4, 10, 0, 1, 1, 3),
    (5, 20, 1, 10, 3, 2, 6),
)
"""Which of a cell's shapes is taken, a row a size, a column a grade; from ``scripts/search_grid.py``."""


@dataclass(frozen=True)
class Grade:
    """How a grade's shapes differ from a box.

    Attributes:
        tilt: standard deviation of the tilt of each face, as a tangent along each axis.
        swelling: that of the height of a swelling or dent, of the logarithm of the radius.
    """

    tilt: float
    swelling: float


def grade_of(index: int) -> Grade:
    """Return the grade of an index from 0 to 6."""
    return Grade(0.15 + 0.5 * index / 6, 0.2 * index / 6)


def shape(rng: np.random.Generator, grade: Grade, size: float, smallest: float) -> Mesh:
    """Make a closed mesh, star-shaped about its inside.

    Args:
        rng: what it is drawn from.
        grade: how it differs from a box.
        size: 0 to 1, smallest to largest; the larger, the rounder: a box nearly as wide as the jaws open
            leaves no room that a camera sees.
        smallest: least side of the bounding box [mm].
    """
    ball = trimesh.creation.icosphere(subdivisions=SUBDIVISIONS)
    rays = np.asarray(ball.vertices)
    roundness = (0.2 + 0.3 * size) * rng.uniform(0.8, 1.2)  # of a superellipsoid: 0 is a box, 1 an ellipsoid
    tilt = max(grade.tilt, LARGEST_TILT) if size == 1 else grade.tilt
    faces = np.vstack([np.eye(3), -np.eye(3)]) + tilt * rng.normal(size=(6, 3))
    faces /= np.linalg.norm(faces, axis=1, keepdims=True)
    inverse = (np.maximum(rays @ faces.T, 0) ** (2 / roundness)).sum(1)
    radius = np.maximum(inverse, FARTHEST ** (-2 / roundness)) ** (-roundness / 2)
    centres = rng.normal(size=(SWELLINGS, 3))
    centres /= np.linalg.norm(centres, axis=1, keepdims=True)
    heights = grade.swelling * rng.normal(size=SWELLINGS)
    radius *= np.exp(np.exp((rays @ centres.T - 1) / SPREAD**2) @ heights)
    vertices = rays * radius[:, None]
    sides = smallest * np.array([1.0, rng.uniform(*MIDDLE), rng.uniform(*LONG)])
    low, high = vertices.min(0), vertices.max(0)
    return Mesh((vertices - (low + high) / 2) * sides / (high - low), ball.faces, process=False)


def spec(size: int, grade: int, draw: int) -> ObjectSpec:
    """Return the ``draw``-th object of a size and a grade, indices from 0 to 6."""
    rng = np.random.default_rng(np.random.SeedSequence([SEED, size, grade, draw]))
    smallest = round(1000 * PARALLEL_85.opening * float(SIZES[size]), 1)
    mesh = shape(rng, grade_of(grade), size / (len(SIZES) - 1), smallest)
    convex = float(mesh.volume) > NEARLY_CONVEX * float(mesh.convex_hull.volume)
    if convex:
        mesh = reduce_hull(np.asarray(mesh.vertices))
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
        lambda: [Part(mesh, color, MATERIAL, "convex" if convex else None)],
    )


def specs() -> list[ObjectSpec]:
    """Return the 49 objects, plain before rugged, small before large."""
    return [spec(s, g, row[g]) for g in range(len(GRADES)) for s, row in enumerate(DRAWS)]
