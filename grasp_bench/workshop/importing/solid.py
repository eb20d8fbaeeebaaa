"""The solid that a mended mesh encloses, as one closed manifold.

A mesh that is closed already is taken as it is. Otherwise its surface is rebuilt from distances
on a grid: what can be reached from outside is outside, and pieces that stay open, such as a
bowl drawn as a bare surface, become walls of :data:`WALL`.
"""

from __future__ import annotations

from itertools import permutations
from typing import Any

import manifold3d as m3
import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.importing.folder import RefusedError
from grasp_bench.workshop.importing.repair import Mended, pieces
from grasp_bench.workshop.shapes import Mesh

WALL = 0.0016
"""Thickness given to bare surfaces [m]."""
TOLERANCE = 0.0002
"""How far the solid may stray from the mesh where it is simplified [m]."""
GRID = 150
"""Cells along the longest side of what is rebuilt."""


def solidify(mesh: Mended) -> Mesh:
    """Return the enclosed solid, simplified within :data:`TOLERANCE`; adds to the mesh's notes.

    Raises:
        RefusedError: where there is no volume.
    """
    solid = None if mesh.open.any() else _closed(mesh)
    if solid is None:
        solid = _rebuilt(mesh)
    # Manifold works in 32-bit floats with a tolerance relative to the size: millimetres suit it.
    solid = solid.simplify(1000 * TOLERANCE)
    raw = solid.to_mesh()
    vertices = np.asarray(raw.vert_properties, float)[:, :3] / 1000
    result = Mesh(vertices, np.asarray(raw.tri_verts), process=False)
    if len(result.faces) < 4 or result.volume <= 1e-10:
        raise RefusedError("it encloses no volume")
    return result


def _manifold(vertices: Floats, faces: NDArray) -> m3.Manifold | None:
    raw = m3.Mesh(np.asarray(1000 * vertices, np.float32), np.asarray(faces, np.uint32))
    solid = m3.Manifold(raw)
    return solid if solid.status() == m3.Error.NoError else None


def _closed(mesh: Mended) -> m3.Manifold | None:
    """Unite the closed pieces, less those that face inwards; None where one is no manifold."""
    label = pieces(mesh.faces)
    whole, holes = [], []
    for i in range(label.max() + 1):
        faces = mesh.faces[label == i]
        used, index = np.unique(faces, return_inverse=True)
        index = index.reshape(-1, 3)
        part = _manifold(mesh.vertices[used], index)
        if part is None:
            return None
        if part.volume() < 0:
            inverse = _manifold(mesh.vertices[used], index[:, ::-1])
            assert inverse is not None
            holes.append(inverse)
        else:
            whole.append(part)
    if not whole:
        return None
    solid = m3.Manifold.batch_boolean(whole, m3.OpType.Add) if len(whole) > 1 else whole[0]
    for hole in holes:
        solid = solid - hole
    return solid


def _rebuilt(mesh: Mended) -> m3.Manifold:
    """Rebuild the solid from distances on a grid."""
    low, high = mesh.vertices.min(0), mesh.vertices.max(0)
    cell = max(0.0006, float((high - low).max()) / GRID)
    margin = 4 * cell + WALL
    origin = low - margin
    shape = np.ceil((high - low + 2 * margin) / cell).astype(int) + 1
    points, is_sheet = _samples(mesh, cell)
    index = np.round((points - origin) / cell).astype(int)
    touched = np.zeros(shape, bool)
    touched[tuple(index.T)] = True
    near = ndimage.binary_dilation(touched, iterations=4)
    distance = _distance(points, near, origin, cell, shape)
    skin = distance < 0.9 * cell
    label, _ = ndimage.label(~skin)
    outside = label == label[0, 0, 0]
    # Inside the skin the sign is not known from the flood: it changes half-way through.
    depth = ndimage.distance_transform_edt(~outside) * cell
    sign = np.where(outside | (skin & (depth < 0.9 * cell + 0.3 * cell)), -1.0, 1.0)
    enclosed = (~outside & ~skin).sum() * cell**3
    field = sign * distance
    if enclosed < 1e-9:
        field = np.full(shape, -5 * cell)
    if is_sheet.any():
        thick = distance if is_sheet.all() else _distance(points[is_sheet], near, origin, cell, shape)
        wall = max(WALL, 1.8 * cell)
        field = np.maximum(field, wall / 2 - thick)
        mesh.notes.append(f"gave bare surfaces a wall of {1000 * wall:.1f} mm")
    else:
        mesh.notes.append(f"rebuilt the surface on a grid of {1000 * cell:.1f} mm: it was no closed manifold")
    if not (field > 0).any():
        raise RefusedError("it encloses no volume")
    points, triangles = isosurface(field / cell)
    solid = _manifold(points * cell + origin, triangles)
    if solid is None:
        raise RefusedError("its surface cannot be rebuilt")
    return solid


TETRAHEDRA = np.array(
    [np.cumsum([[0, 0, 0], *np.eye(3, dtype=int)[list(order)]], axis=0) for order in permutations(range(3))]
)
"""Corners (6, 4, 3) of the tetrahedra of a unit cube, the same in every cube, so that their faces match."""


def isosurface(field: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Return the closed surface between positive (inside) and negative samples, by marching tetrahedra.

    Args:
        field: (N, M, K) distances in cells, negative on the border.

    Returns:
        Vertices (V, 3) in cells and faces (F, 3), facing outwards.
    """
    values = np.where(np.abs(field) < 1e-3, np.where(field > 0, 1e-3, -1e-3), field)  # no vertex on a corner
    inside = values > 0
    n, m, k = (size - 1 for size in inside.shape)
    corners = np.stack(
        [inside[x : x + n, y : y + m, z : z + k] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    )
    cubes = np.argwhere(corners.any(0) & ~corners.all(0))
    ends, outward = [], []
    for tetrahedron in TETRAHEDRA:
        places = cubes[:, None] + tetrahedron  # (C, 4, 3)
        at = np.ravel_multi_index(tuple(np.moveaxis(places, -1, 0)), values.shape)
        within = inside.ravel()[at]
        at = np.take_along_axis(at, np.argsort(~within, axis=1, kind="stable"), axis=1)  # inside ones first
        for count, edges in (
            (1, [[(0, 1), (0, 2), (0, 3)]]),
            (3, [[(0, 3), (1, 3), (2, 3)]]),
            (2, [[(0, 2), (0, 3), (1, 3)], [(0, 2), (1, 3), (1, 2)]]),
        ):
            some = at[within.sum(1) == count]
            place = np.stack(np.unravel_index(some, values.shape), axis=-1).astype(float)
            for triangle in edges:
                ends.append(some[:, triangle])  # (T, 3, 2)
                outward.append(place[:, count:].mean(1) - place[:, :count].mean(1))
    pairs, directions = np.concatenate(ends), np.concatenate(outward)
    keys, index = np.unique(pairs[..., 0].astype(np.int64) * values.size + pairs[..., 1], return_inverse=True)
    edge = np.stack(np.divmod(keys, values.size), axis=-1)
    first, second = values.ravel()[edge].T
    start, end = (np.stack(np.unravel_index(edge[:, i], values.shape), axis=-1).astype(float) for i in (0, 1))
    vertices = start + (first / (first - second))[:, None] * (end - start)
    faces = index.reshape(-1, 3)
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    turned = np.einsum("fi,fi->f", np.cross(b - a, c - a), directions) < 0
    faces[turned] = faces[turned][:, ::-1]
    return vertices, faces


def _samples(mesh: Mended, cell: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Return points on the surface no farther apart than half a cell, and which are on open pieces."""
    divided: Any = trimesh.remesh.subdivide_to_size(
        mesh.vertices, mesh.faces, 0.7 * cell, max_iter=40, return_index=True
    )
    points, faces, origin = (np.asarray(part) for part in divided)
    centres = points[faces].mean(1)
    corner_open = np.zeros(len(points), bool)
    corner_open[faces[mesh.open[origin]].ravel()] = True
    return np.vstack([points, centres]), np.concatenate([corner_open, mesh.open[origin]])


def _distance(
    points: Floats, near: NDArray[np.bool_], origin: Floats, cell: float, shape: NDArray
) -> NDArray[np.float64]:
    distance = np.full(shape, 5 * cell)
    where = origin + cell * np.argwhere(near)
    distance[near] = cKDTree(points).query(where, distance_upper_bound=5 * cell)[0].clip(max=5 * cell)
    return distance
