"""What a point cloud of a table shows without any segmentation: the plane, what stands on it, and normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from grasp_bench.camera import RgbdImage
from grasp_bench.planning.seen import steady
from grasp_bench.system.arrays import Floats

TRIPLES = 200
"""Planes that are tried for the table."""
ON_PLANE = 0.004
"""Points this near to a plane count as on it [m]."""
VOXEL = 0.003
"""Of the points in a cube of this edge one is kept [m]."""
RADIUS = 0.009
"""Points within this make a normal [m]."""


@dataclass(frozen=True)
class Plane:
    """A plane in the camera's frame: ``normal`` (3,) · p = ``offset`` [m], normal to the camera's side."""

    normal: Floats
    offset: float

    def height(self, points: Floats) -> Floats:
        """Return how high points (…, 3) are above it [m]."""
        return points @ self.normal - self.offset


def table_plane(image: RgbdImage, rng: np.random.Generator) -> Plane | None:
    """Return the plane that most of the image shows, None where too little was measured.

    RANSAC (Fischler and Bolles 1981) over :data:`TRIPLES` planes, then least squares on the best's points.
    """
    points = image.points[::6, ::6][image.valid[::6, ::6]].astype(float)
    if len(points) < 50:
        return None
    best = np.zeros(len(points), bool)
    for corner, first, second in points[rng.integers(len(points), size=(TRIPLES, 3))]:
        normal = np.cross(first - corner, second - corner)
        length = float(np.linalg.norm(normal))
        if length < 1e-9:
            continue
        on = np.abs((points - corner) @ normal) < ON_PLANE * length
        if on.sum() > best.sum():
            best = on
    if best.sum() < 30:
        return None
    middle = points[best].mean(0)
    normal = np.linalg.svd(points[best] - middle, full_matrices=False)[2][2]
    normal *= -np.sign(normal @ middle)
    return Plane(normal, float(normal @ middle))


def standing(image: RgbdImage, plane: Plane, least: float) -> Floats:
    """Return the points (N, 3) that are ``least`` metres or more above a plane, thinned to one a voxel."""
    points = image.points[image.valid & steady(image.depth)].astype(float)
    points = points[plane.height(points) >= least]
    _, first = np.unique(np.floor(points / VOXEL).astype(int), axis=0, return_index=True)
    return points[np.sort(first)]


def normals(points: Floats, towards: Floats) -> Floats:
    """Return unit normals (N, 3) of points (N, 3), each on the side of ``towards`` (3,): the camera's place.

    The direction in which the neighbours within :data:`RADIUS` spread least.
    """
    found = np.empty_like(points)
    for i, near in enumerate(cKDTree(points).query_ball_point(points, RADIUS)):
        spread = points[near] - points[near].mean(0)
        found[i] = np.linalg.eigh(spread.T @ spread)[1][:, 0]
    found *= np.where(np.einsum("ij,ij->i", found, towards - points) < 0, -1.0, 1.0)[:, None]
    return found
