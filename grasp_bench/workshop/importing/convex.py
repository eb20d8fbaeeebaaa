"""Few convex pieces of a whole mesh, near enough to it that cavities stay open.

Shipped objects are decomposed part by part; a scan is one surface, so CoACD cuts it whole.
"""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import trimesh

from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.decompose import (
    BOUNDS,
    MAX_HULLS,
    DecompositionError,
    coacd_pieces,
    compare,
    reduce_hull,
)
from grasp_bench.workshop.importing.folder import RefusedError
from grasp_bench.workshop.shapes import Mesh, hull, scale

CONVEX = 0.97
"""A solid that fills this share of its hull, and is nowhere :data:`CONVEX_DEPTH` off it, is convex."""
CONVEX_DEPTH = 0.002
THRESHOLDS = (0.06, 0.03)
"""CoACD concavities; the finer one is tried where the first leaves pieces unused and a gap to close."""
FEW, NEAR = 16, 0.0015
"""With fewer pieces than this, and the surface this far off somewhere [m], the finer concavity is tried."""
SHRUNK = 0.98
"""Hulls that lose more of their volume than this when vertices are dropped are swollen to it again."""
ADDED = 0.003
"""Walls may become thicker by this on each side, on average [m]: what thin walls are held to, whose
volume a millimetre more multiplies."""


def decompose_whole(solid: Mesh) -> tuple[list[Mesh], DecompositionError]:
    """Return at most 32 hulls of at most 64 vertices (metres), and how far they stray.

    Raises:
        RefusedError: where no setting keeps within bounds.
    """
    own = few_vertices(np.asarray(solid.vertices))
    error = compare(solid, [own])
    if solid.volume > CONVEX * hull(solid).volume and error.max_distance < CONVEX_DEPTH:
        return [own], error
    apart = _separate(solid)
    if apart is not None:
        error = compare(solid, apart)
        if not beyond(error, solid):
            return apart, error
    found: list[tuple[list[Mesh], DecompositionError]] = []
    for threshold in THRESHOLDS:
        # CoACD's own decimation cuts tips off by millimetres.
        cut = coacd_pieces(scale(solid, 1000), threshold, max_convex_hull=MAX_HULLS, decimate=False)
        hulls = [h for h in (few_vertices(piece / 1000) for piece in cut) if h.volume > 1e-12]
        found.append((hulls, compare(solid, hulls)))
        if not beyond(found[-1][1], solid) and (len(hulls) >= FEW or found[-1][1].max_distance < NEAR):
            break
    sound = [f for f in found if not beyond(f[1], solid)]
    if sound:
        return min(sound, key=lambda f: f[1].mean_distance)
    worst = found[-1][1]
    raise RefusedError(
        f"no decomposition into {MAX_HULLS} convex pieces stays near the shape: "
        f"{', '.join(beyond(worst, solid))} ({asdict(worst)})"
    )


def _separate(solid: Mesh) -> list[Mesh] | None:
    """Return the hulls of separate pieces that are convex each; None for anything else. CoACD takes
    minutes over empty space between them."""
    pieces = solid.split(only_watertight=False)
    if not 1 < len(pieces) <= MAX_HULLS:
        return None
    hulls = [few_vertices(np.asarray(p.vertices)) for p in pieces]
    if any(p.volume < CONVEX * h.volume for p, h in zip(pieces, hulls, strict=True)):
        return None
    return hulls


def beyond(error: DecompositionError, solid: Mesh) -> list[str]:
    """Return the names of the bounds that are not kept."""
    bad = [n for n in ("mean_distance", "max_distance") if getattr(error, n) > BOUNDS[n][1]]
    low, high = BOUNDS["volume_ratio"]
    added = (error.volume_ratio - 1) * solid.volume / (solid.area / 2)
    if error.volume_ratio < low or (error.volume_ratio > high and added > 2 * ADDED):
        bad.append("volume_ratio")
    return bad


def few_vertices(points: Floats) -> Mesh:
    """Return the hull of (N, 3) points with at most 64 vertices; round ones keep their volume, not their
    girth."""
    reduced = reduce_hull(points)
    whole = trimesh.convex.convex_hull(points).volume
    if reduced.volume > SHRUNK * whole:
        return reduced
    centre = reduced.center_mass
    factor = (whole / reduced.volume) ** (1 / 3)
    return Mesh((reduced.vertices - centre) * factor + centre, reduced.faces, process=False)
