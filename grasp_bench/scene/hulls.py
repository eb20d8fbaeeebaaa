"""Coarser convex decompositions, made from a fine one by merging neighbours."""

from __future__ import annotations

import itertools

import numpy as np

from grasp_bench.system.arrays import Floats


def merged(hulls: list[Floats], most: int) -> list[Floats]:
    """Merge convex pieces until at most ``most`` are left, with the same vertices inside.

    The two pieces whose common hull adds least volume are merged, again and again (greedy, as the merging
    step of convex decompositions is); with one piece left it is the hull of everything. Cavities close where
    pieces around them merge: that is what coarse collision geometry does.

    Args:
        hulls: vertices (V, 3) of each piece [m].
        most: how many to keep, at least 1; 0 keeps all.
    """
    if most <= 0 or len(hulls) <= most:
        return hulls
    pieces = [_hull(h) for h in hulls]
    cost = {(i, j): _added(pieces[i], pieces[j]) for i, j in itertools.combinations(range(len(pieces)), 2)}
    alive = set(range(len(pieces)))
    while len(alive) > most:
        first, second = min(cost, key=lambda pair: (cost[pair], pair))
        pieces.append(_hull(np.vstack([pieces[first][0], pieces[second][0]])))
        alive -= {first, second}
        cost = {pair: c for pair, c in cost.items() if not {first, second} & set(pair)}
        new = len(pieces) - 1
        cost |= {(i, new): _added(pieces[i], pieces[new]) for i in sorted(alive)}
        alive.add(new)
    return [pieces[i][0] for i in sorted(alive)]


def _hull(points: Floats) -> tuple[Floats, float]:
    """Return the vertices on the hull of a cloud, and its volume."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    return points[hull.vertices], float(hull.volume)


def _added(a: tuple[Floats, float], b: tuple[Floats, float]) -> float:
    from scipy.spatial import ConvexHull

    return float(ConvexHull(np.vstack([a[0], b[0]])).volume) - a[1] - b[1]
