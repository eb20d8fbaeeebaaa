"""Convex decomposition, and how far it strays from the true shape.

Every part of an object is decomposed by CoACD (Wei et al., SIGGRAPH 2022) on its own, so
that a handle never melts into the wall it sits on; parts that are convex already keep
their hull. CoACD is neither quick nor reproducible between machines, so the results are
shipped and hashed, and never made again at run time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import coacd
import numpy as np
import trimesh
from scipy.spatial import ConvexHull, QhullError

from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.model import Part
from grasp_bench.workshop.shapes import Mesh, difference, union

MAX_HULLS = 32
MAX_VERTICES = 64
BOUNDS = {"volume_ratio": (0.88, 1.65), "mean_distance": (0.0, 0.0015), "max_distance": (0.0, 0.012)}
"""What the decomposition error of every shipped object stays within (distances in metres)."""
THRESHOLDS = (0.04, 0.06, 0.09, 0.13, 0.2, 0.3)
"""CoACD concavities tried in turn until an object has at most :data:`MAX_HULLS` pieces."""


@dataclass(frozen=True)
class DecompositionError:
    """Difference between the union of hulls and the true solid.

    Attributes:
        volume_ratio: volume of the hulls' union over the mesh's volume.
        mean_distance, max_distance: one-sided distance to the mesh's surface from the surface
            of what the hulls add to it [m], over 4,000 points.
    """

    volume_ratio: float
    mean_distance: float
    max_distance: float


def _qhull(points: Floats) -> ConvexHull:
    """Compute a convex hull; nearly coplanar points that defeat Qhull's merging are joggled."""
    try:
        return ConvexHull(points)
    except QhullError:
        return ConvexHull(points, qhull_options="QJ")


def reduce_hull(points: Floats, limit: int = MAX_VERTICES) -> Mesh:
    """Return the convex hull of (N, 3) points with at most ``limit`` vertices.

    Starts from the extreme points along the axes and keeps adding the point that lies
    farthest outside, which bounds the deviation and keeps flat faces flat.
    """
    corners = points[_qhull(points).vertices]
    if len(corners) <= limit:
        return trimesh.convex.convex_hull(corners)
    rng = np.random.default_rng(0)
    directions = np.vstack([np.eye(3), -np.eye(3), rng.normal(size=(6, 3))])
    chosen = list(dict.fromkeys(np.argmax(corners @ directions.T, axis=0).tolist()))
    while len(chosen) < limit:
        hull = _qhull(corners[chosen])
        outside = (corners @ hull.equations[:, :3].T + hull.equations[:, 3]).max(1)
        farthest = int(np.argmax(outside))
        if outside[farthest] < 1e-9 * np.ptp(corners):
            break
        chosen.append(farthest)
    return trimesh.convex.convex_hull(corners[chosen])


def coacd_pieces(mesh: Mesh, threshold: float, **settings: Any) -> list[Floats]:
    """Cut a watertight mesh with CoACD and return the vertices (V, 3) of each piece.

    Args:
        mesh: in millimetres.
        threshold: greatest concavity of a piece.
        settings: further ones of ``coacd.run_coacd``.
    """
    coacd.set_log_level("error")
    pieces = coacd.run_coacd(
        coacd.Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces)),
        threshold=threshold,
        preprocess_mode="off",
        mcts_nodes=10,
        mcts_iterations=60,
        mcts_max_depth=2,
        resolution=1000,
        merge=True,
        seed=0,
        **settings,
    )
    return [np.asarray(vertices, dtype=float) for vertices, _ in pieces]


def decompose(parts: list[Part]) -> list[Mesh]:
    """Return convex hulls of an object, at most :data:`MAX_HULLS` in all, in the parts' units.

    Raises:
        ValueError: when even the coarsest concavity leaves more pieces.
    """
    for floor in THRESHOLDS:
        hulls: list[Mesh] = []
        for part in parts:
            if part.threshold == "convex":
                hulls.append(reduce_hull(np.asarray(part.mesh.vertices)))
            else:
                wanted = floor if part.threshold is None else max(float(part.threshold), floor)
                pieces = coacd_pieces(part.mesh, wanted, decimate=True, max_ch_vertex=MAX_VERTICES)
                hulls += [reduce_hull(piece) for piece in pieces]
        if len(hulls) <= MAX_HULLS:
            return hulls
    raise ValueError(f"more than {MAX_HULLS} convex pieces even at concavity {THRESHOLDS[-1]}: {len(hulls)}")


def compare(solid: Mesh, hulls: list[Mesh]) -> DecompositionError:
    """Measure how far the union of ``hulls`` strays from ``solid`` (both in metres)."""
    body = union(*hulls)
    # Measured on what the hulls add: faces inside the solid, where parts only touch, do not count.
    added = difference(body, solid)
    if len(added.faces) == 0:
        return DecompositionError(float(body.volume / solid.volume), 0.0, 0.0)
    points = trimesh.sample.sample_surface(added, 4000, seed=0)[0]
    _, distance, _ = trimesh.proximity.closest_point(solid, points)
    return DecompositionError(
        float(body.volume / solid.volume), float(distance.mean()), float(distance.max())
    )
