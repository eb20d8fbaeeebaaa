"""Few convex pieces of a whole mesh, near enough to it that cavities stay open.

Shipped objects are decomposed part by part; a scan is one surface, so CoACD cuts it whole.
"""

from __future__ import annotations

from dataclasses import asdict

import numpy as np

from grasp_bench.objects.decompose import (
    BOUNDS,
    MAX_HULLS,
    MAX_VERTICES,
    DecompositionError,
    compare,
    reduce_hull,
)
from grasp_bench.objects.importing.folder import RefusedError
from grasp_bench.objects.shapes import Mesh, hull, scale

CONVEX = 0.97
"""A solid that fills this share of its hull, and is nowhere :data:`CONVEX_DEPTH` off it, is convex."""
CONVEX_DEPTH = 0.002
THRESHOLDS = (0.06, 0.035, 0.1)
"""CoACD concavities tried in turn, until one is within bounds."""
ADDED = 0.003
"""Walls may become thicker by this on each side, on average [m]: what thin walls are held to, whose
volume a millimetre more multiplies."""


def decompose_whole(solid: Mesh) -> tuple[list[Mesh], DecompositionError]:
    """At most 32 hulls of at most 64 vertices (metres), and how far they stray.

    Raises:
        RefusedError: where no setting keeps within bounds.
    """
    own = reduce_hull(np.asarray(solid.vertices))
    error = compare(solid, [own])
    if solid.volume > CONVEX * hull(solid).volume and error.max_distance < CONVEX_DEPTH:
        return [own], error
    found: list[tuple[list[Mesh], DecompositionError]] = []
    for threshold in THRESHOLDS:
        hulls = _coacd(solid, threshold)
        found.append((hulls, compare(solid, hulls)))
        if not beyond(found[-1][1], solid):
            return found[-1]
    _, best = min(found, key=lambda f: f[1].mean_distance)
    raise RefusedError(f"no decomposition into {MAX_HULLS} convex pieces stays near the shape: "
                       f"{', '.join(beyond(best, solid))} ({asdict(best)})")


def beyond(error: DecompositionError, solid: Mesh) -> list[str]:
    """Names of the bounds that are not kept."""
    bad = [n for n in ("mean_distance", "max_distance") if getattr(error, n) > BOUNDS[n][1]]
    low, high = BOUNDS["volume_ratio"]
    added = (error.volume_ratio - 1) * solid.volume / (solid.area / 2)
    if error.volume_ratio < low or (error.volume_ratio > high and added > 2 * ADDED):
        bad.append("volume_ratio")
    return bad


def _coacd(solid: Mesh, threshold: float) -> list[Mesh]:
    import coacd

    coacd.set_log_level("error")
    mesh = scale(solid, 1000)
    pieces = coacd.run_coacd(
        coacd.Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces)), threshold=threshold,
        max_convex_hull=MAX_HULLS, preprocess_mode="off", mcts_nodes=10, mcts_iterations=60,
        mcts_max_depth=2, resolution=1000, merge=True, decimate=True, max_ch_vertex=MAX_VERTICES, seed=0)
    hulls = [reduce_hull(np.asarray(v, float)) for v, _ in pieces]
    return [scale(h, 0.001) for h in hulls if h.volume > 1e-3]
