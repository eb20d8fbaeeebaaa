"""Outlines of the solid geoms of a compiled model."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from grasp_bench.system.arrays import Floats


def solids(model: mujoco.MjModel, bodies: Iterable[int]) -> list[int]:
    """Return the geoms of ``bodies`` that collide with something."""
    wanted = set(bodies)
    return [
        g
        for g in range(model.ngeom)
        if int(model.geom_bodyid[g]) in wanted and (model.geom_contype[g] or model.geom_conaffinity[g])
    ]


def subtree(model: mujoco.MjModel, body: int) -> list[int]:
    """Return a body and all below it."""
    found = [body]
    for other in range(body + 1, model.nbody):
        if int(model.body_parentid[other]) in found:
            found.append(other)
    return found


def extent(
    model: mujoco.MjModel, data: mujoco.MjData, geoms: Iterable[int], above: float = -np.inf
) -> Floats | None:
    """Return lower and upper corner (2, 3) of the box, square to the world, around solid geoms [m].

    Args:
        geoms: boxes, spheres, capsules, cylinders, ellipsoids or meshes, whose convex hull counts.
        above: only what of a mesh has a greater z, and only geoms that reach above it [m].

    Returns:
        None where nothing is left.
    """
    boxes = [b for g in geoms if (b := _extent(model, data, g, above)) is not None]
    return np.array([np.min([b[0] for b in boxes], 0), np.max([b[1] for b in boxes], 0)]) if boxes else None


def _extent(model: mujoco.MjModel, data: mujoco.MjData, geom: int, above: float) -> Floats | None:
    kind, size = model.geom_type[geom], model.geom_size[geom]
    place, turn = data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)
    types = mujoco.mjtGeom
    if kind == types.mjGEOM_MESH:
        points = _above(mesh_points(model, int(model.geom_dataid[geom])) @ turn.T + place, above)
        return None if points is None else np.array([points.min(0), points.max(0)])
    if kind == types.mjGEOM_BOX:
        half = np.abs(turn) @ size
    elif kind == types.mjGEOM_SPHERE:
        half = np.full(3, size[0])
    elif kind == types.mjGEOM_CAPSULE:
        half = size[0] + np.abs(turn[:, 2]) * size[1]
    elif kind == types.mjGEOM_CYLINDER:
        half = np.abs(turn[:, 2]) * size[1] + size[0] * np.sqrt(np.clip(1 - turn[:, 2] ** 2, 0, 1))
    elif kind == types.mjGEOM_ELLIPSOID:
        half = np.sqrt(((turn * size) ** 2).sum(1))
    else:
        return None
    return np.array([place - half, place + half]) if place[2] + half[2] > above + 1e-9 else None


def mesh_points(model: mujoco.MjModel, mesh: int) -> Floats:
    """Return the vertices (V, 3) of a mesh [m]."""
    start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    return np.asarray(model.mesh_vert[start : start + count], float)


def _above(points: Floats, z: float) -> Floats | None:
    """Return the corners of what of the convex hull of ``points`` (V, 3) is above the height ``z``."""
    from scipy.spatial import ConvexHull

    if (points[:, 2] >= z).all():
        return points
    if not (points[:, 2] > z).any():
        return None
    edges = ConvexHull(points).simplices
    pairs = points[np.vstack([edges[:, [0, 1]], edges[:, [1, 2]], edges[:, [2, 0]]])]  # (E, 2, 3)
    crossing = (pairs[:, 0, 2] - z) * (pairs[:, 1, 2] - z) < 0
    first, second = pairs[crossing, 0], pairs[crossing, 1]
    share = ((z - first[:, 2]) / (second[:, 2] - first[:, 2]))[:, None]
    return np.vstack([points[points[:, 2] >= z], first + share * (second - first)])
