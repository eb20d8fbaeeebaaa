"""Parametric solids from which the benchmark's household objects are modelled.

Every function returns a watertight :class:`trimesh.Trimesh`. Lengths are
**millimetres**, angles **degrees**, and z points up, because that is how product
drawings and data sheets read; :mod:`grasp_bench.workshop.build` converts to metres.
Booleans, extrusions and revolutions go through Manifold, which guarantees a closed
2-manifold result.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import manifold3d as m3
import numpy as np
import trimesh
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation
from shapely.geometry import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from grasp_bench.workshop.figures import Figure, Floats, circle, polygon
from grasp_bench.workshop.figures import arc as arc
from grasp_bench.workshop.figures import bezier as bezier
from grasp_bench.workshop.figures import ellipse as ellipse
from grasp_bench.workshop.figures import figures as figures
from grasp_bench.workshop.figures import place as place
from grasp_bench.workshop.figures import rect as rect
from grasp_bench.workshop.figures import regular as regular
from grasp_bench.workshop.figures import rounded as rounded
from grasp_bench.workshop.figures import spline as spline
from grasp_bench.workshop.figures import star as star
from grasp_bench.workshop.figures import stroke as stroke

Mesh = trimesh.Trimesh


# ---------------------------------------------------------------- plumbing


def _from_manifold(solid: m3.Manifold) -> Mesh:
    raw = solid.to_mesh()
    return Mesh(np.asarray(raw.vert_properties)[:, :3], np.asarray(raw.tri_verts), process=False)


def _to_manifold(mesh: Mesh) -> m3.Manifold:
    raw = m3.Mesh(np.asarray(mesh.vertices, dtype=np.float32), np.asarray(mesh.faces, dtype=np.uint32))
    solid = m3.Manifold(raw)
    if solid.status() != m3.Error.NoError:
        raise ValueError(f"mesh is not a closed 2-manifold: {solid.status()}")
    return solid


def _cross_section(shape: Figure) -> m3.CrossSection:
    if not isinstance(shape, BaseGeometry):
        shape = Polygon(np.asarray(shape, dtype=float))
    parts = shape.geoms if isinstance(shape, MultiPolygon) else [shape]
    rings: list[Floats] = []
    for part in parts:
        if not isinstance(part, Polygon):
            raise TypeError(f"a {part.geom_type} is not a plane figure")
        for ringline in (part.exterior, *part.interiors):
            rings.append(np.asarray(ringline.coords)[:-1])
    return m3.CrossSection(rings, m3.FillRule.EvenOdd)


def _outline(shape: Figure) -> Polygon:
    if isinstance(shape, BaseGeometry) and not isinstance(shape, Polygon):
        raise TypeError(f"a {shape.geom_type} is not a polygon")
    return shape if isinstance(shape, Polygon) else polygon(shape)


# ---------------------------------------------------------------- solids


def box(x: float, y: float, z: float) -> Mesh:
    """Make a box centred on the origin in x and y, standing on z = 0."""
    return move(trimesh.creation.box((x, y, z)), z=z / 2)


def rounded_box(x: float, y: float, z: float, radius: float, segments: int = 3) -> Mesh:
    """Make a box with all edges rounded, centred in x and y, standing on z = 0."""
    ball = trimesh.creation.uv_sphere(radius, count=(2 * segments + 1, 4 * segments)).vertices
    corner = np.array([x, y, z]) / 2 - radius
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    cloud = (ball[None] + signs[:, None] * corner).reshape(-1, 3)
    return move(trimesh.convex.convex_hull(cloud), z=z / 2)


def cylinder(radius: float, height: float, segments: int = 48, top: float | None = None) -> Mesh:
    """Make a cylinder (or frustum ending in radius ``top``) standing on z = 0."""
    end = radius if top is None else top
    return _from_manifold(m3.Manifold.cylinder(height, radius, end, segments))


def cone(radius: float, height: float, segments: int = 48) -> Mesh:
    """Make a cone standing on z = 0 with its apex at ``height``."""
    return cylinder(radius, height, segments, top=0.0)


def sphere(radius: float, segments: int = 32) -> Mesh:
    """Make a ball about the origin."""
    return _from_manifold(m3.Manifold.sphere(radius, segments))


def ellipsoid(rx: float, ry: float, rz: float, segments: int = 32) -> Mesh:
    """Make an ellipsoid about the origin."""
    return scale(sphere(1.0, segments), rx, ry, rz)


def superellipsoid(rx: float, ry: float, rz: float, e1: float, e2: float, segments: int = 32) -> Mesh:
    """Make a superellipsoid with exponents ``e1`` (vertical) and ``e2`` (horizontal); 1 is an ellipsoid,
    towards 0 a box, towards 2 an octahedron (Barr 1981)."""
    ball = sphere(1.0, segments)
    v = np.asarray(ball.vertices)
    phi = np.arcsin(np.clip(v[:, 2], -1, 1))
    lam = np.arctan2(v[:, 1], v[:, 0])

    def power(a: Floats, e: float) -> Floats:
        return np.sign(a) * np.abs(a) ** e

    c = power(np.cos(phi), e1)
    new = np.column_stack(
        [rx * c * power(np.cos(lam), e2), ry * c * power(np.sin(lam), e2), rz * power(np.sin(phi), e1)]
    )
    return Mesh(new, ball.faces, process=False)


def capsule(radius: float, length: float, segments: int = 24) -> Mesh:
    """Make a capsule along z, ``length`` between the centres of its end caps, lower centre at 0."""
    ball = sphere(radius, segments)
    return hull(ball, move(ball, z=length))


def torus(major: float, minor: float, segments: int = 48, sides: int = 16) -> Mesh:
    """Make a torus about z."""
    return revolve(circle(minor, x=major, segments=sides), segments=segments)


def extrude(shape: Figure, height: float, *, twist: float = 0.0, taper: float = 1.0, steps: int = 0) -> Mesh:
    """Extrude a plane figure from z = 0 to ``height``.

    Args:
        shape: figure in the xy plane; may have holes.
        twist: rotation of the top against the bottom, degrees.
        taper: scale of the top against the bottom about the origin.
        steps: intermediate layers (wanted with ``twist``).
    """
    section = _cross_section(shape)
    layers = max(steps, int(abs(twist) // 8))
    return _from_manifold(m3.Manifold.extrude(section, height, layers, twist, (taper, taper)))


def prism(shape: Figure, height: float, bevel: float) -> Mesh:
    """Extrude a *convex* figure, with its top and bottom edges chamfered by ``bevel``."""
    outline = _outline(shape)
    inset = np.asarray(outline.buffer(-bevel).exterior.coords)[:-1]
    full = np.asarray(outline.exterior.coords)[:-1]
    cloud = [
        np.column_stack([ring_, np.full(len(ring_), z)])
        for ring_, z in ((inset, 0.0), (full, bevel), (full, height - bevel), (inset, height))
    ]
    return trimesh.convex.convex_hull(np.vstack(cloud))


def revolve(profile: Figure, segments: int = 48, angle: float = 360.0) -> Mesh:
    """Turn a closed profile of (r, z) points, r ≥ 0, about the z axis."""
    solid = m3.Manifold.revolve(_cross_section(profile), segments, angle)
    return _from_manifold(solid)


def vessel(profile: ArrayLike, wall: float, floor: float | None = None, segments: int = 48) -> Mesh:
    """Make an open hollow body: the outer profile of (r, z) points from foot to rim, wall inside.

    The cavity is the profile moved inwards by ``wall``, cut off ``floor`` (default
    ``wall``) above the lowest point and open at the top.
    """
    outer = np.asarray(profile, dtype=float)
    floor = wall if floor is None else floor
    solid = Polygon(np.vstack([[0, outer[0, 1]], outer, [0, outer[-1, 1]]]))
    top = outer[-1, 1]
    # Extended above the rim before the inward offset, so that the mouth stays open.
    tall = Polygon(
        np.vstack(
            [
                [-outer[0, 0], outer[0, 1]],
                outer,
                [outer[-1, 0], top + 4 * wall],
                [-outer[-1, 0], top + 4 * wall],
                outer[::-1] * [-1, 1],
            ]
        )
    )
    cavity = tall.buffer(0).buffer(-wall, quad_segs=4)
    keep = Polygon([(0, outer[0, 1] + floor), (1e4, outer[0, 1] + floor), (1e4, 1e4), (0, 1e4)])
    wall_section = solid.buffer(0).difference(cavity.intersection(keep))
    return revolve(wall_section, segments)


def ring(outer: float, inner: float, height: float, segments: int = 48) -> Mesh:
    """Make a flat ring (tube) standing on z = 0."""
    return extrude(circle(outer, segments=segments).difference(circle(inner, segments=segments)), height)


def loft(rings: Sequence[ArrayLike], closed: bool = False) -> Mesh:
    """Make a skin over cross-sections, each (N, 3) with the same N and sense of rotation.

    ``closed`` joins the last ring to the first; otherwise star-shaped end caps are added.
    """
    stack = np.asarray([np.asarray(r, dtype=float) for r in rings])
    k, n, _ = stack.shape
    vertices = stack.reshape(-1, 3)
    faces: list[tuple[int, int, int]] = []
    for i in range(k if closed else k - 1):
        lower, upper = i * n, ((i + 1) % k) * n
        for j in range(n):
            j2 = (j + 1) % n
            faces += [(lower + j, lower + j2, upper + j2), (lower + j, upper + j2, upper + j)]
    if not closed:
        first, last = len(vertices), len(vertices) + 1
        vertices = np.vstack([vertices, stack[0].mean(0), stack[-1].mean(0)])
        for j in range(n):
            j2 = (j + 1) % n
            faces += [(first, j2, j), (last, (k - 1) * n + j, (k - 1) * n + j2)]
    mesh = Mesh(vertices, faces, process=False)
    if mesh.volume < 0:
        mesh.invert()
    return mesh


def sweep(
    section: Figure | float,
    path: ArrayLike,
    *,
    scales: ArrayLike | None = None,
    closed: bool = False,
    up: Sequence[float] = (0, 0, 1),
    segments: int = 16,
) -> Mesh:
    """Move a plane section along a path.

    Args:
        section: polygon without holes (its x runs along ``path tangent × up`` and its y
            along the frame's up), or a radius for a round bar.
        path: points (N, 3).
        scales: factor of the section at each point: (N,) or (N, 2) for x and y apart.
        closed: join the end of the path to its start.
        up: reference direction that the section's y follows where the path allows.
        segments: sides of a round bar.
    """
    if isinstance(section, (int, float)):
        section = circle(float(section), segments=segments)
    outline = _outline(section)
    flat = np.asarray(outline.exterior.coords)[:-1]
    if not outline.exterior.is_ccw:
        flat = flat[::-1]
    points = np.asarray(path, dtype=float)
    n = len(points)
    factor = np.ones((n, 2)) if scales is None else np.asarray(scales, dtype=float)
    factor = np.column_stack([factor, factor]) if factor.ndim == 1 else factor
    if closed:
        tangent = np.roll(points, -1, 0) - np.roll(points, 1, 0)
    else:
        tangent = np.gradient(points, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    reference = np.asarray(up, dtype=float)
    if np.abs(tangent @ reference).max() > 0.999:  # vertical stretches: carry the frame along
        reference = np.eye(3)[np.argmin(np.abs(tangent).max(0))]
    rings = []
    for point, t, s in zip(points, tangent, factor, strict=True):
        side = np.cross(t, reference)
        side /= np.linalg.norm(side)
        top = np.cross(side, t)
        rings.append(point + s[0] * flat[:, :1] * side + s[1] * flat[:, 1:] * top)
    return loft(rings, closed=closed)


def helix(radius: float, pitch: float, turns: float, per_turn: int = 16) -> Floats:
    """Return the path (N, 3) of a helix about z, starting at z = 0."""
    t = np.linspace(0, 2 * np.pi * turns, int(per_turn * turns) + 1)
    return np.column_stack([radius * np.cos(t), radius * np.sin(t), pitch * t / (2 * np.pi)])


# ---------------------------------------------------------------- combining and placing


def union(*meshes: Mesh) -> Mesh:
    """Unite solids."""
    return _from_manifold(m3.Manifold.batch_boolean([_to_manifold(m) for m in meshes], m3.OpType.Add))


def difference(body: Mesh, *tools: Mesh) -> Mesh:
    """Cut every tool out of ``body``."""
    return _from_manifold(
        m3.Manifold.batch_boolean([_to_manifold(m) for m in (body, *tools)], m3.OpType.Subtract)
    )


def intersection(first: Mesh, second: Mesh) -> Mesh:
    """Return the common volume of two solids."""
    return _from_manifold(_to_manifold(first) ^ _to_manifold(second))


def hull(*meshes: Mesh) -> Mesh:
    """Return the convex hull of all meshes together."""
    return trimesh.convex.convex_hull(np.vstack([m.vertices for m in meshes]))


def move(mesh: Mesh, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Mesh:
    """Return a translated copy."""
    return Mesh(np.asarray(mesh.vertices) + [x, y, z], mesh.faces, process=False)


def rotate(
    mesh: Mesh, x: float = 0.0, y: float = 0.0, z: float = 0.0, about: Sequence[float] = (0, 0, 0)
) -> Mesh:
    """Return a copy rotated about the fixed axes x, then y, then z (degrees) through ``about``."""
    r = Rotation.from_euler("xyz", [x, y, z], degrees=True).as_matrix()
    pivot = np.asarray(about, dtype=float)
    return Mesh((np.asarray(mesh.vertices) - pivot) @ r.T + pivot, mesh.faces, process=False)


def scale(mesh: Mesh, x: float, y: float | None = None, z: float | None = None) -> Mesh:
    """Return a copy scaled about the origin; one factor scales all axes."""
    y, z = x if y is None else y, x if z is None else z
    new = Mesh(np.asarray(mesh.vertices) * [x, y, z], mesh.faces, process=False)
    if x * y * z < 0:
        new.invert()
    return new


def mirror(mesh: Mesh, axis: str = "x") -> Mesh:
    """Return a mirrored copy, through the plane normal to ``axis``."""
    factors = {a: -1.0 if a == axis else 1.0 for a in "xyz"}
    return scale(mesh, factors["x"], factors["y"], factors["z"])


def spin(mesh: Mesh, copies: int, about_z: float = 360.0) -> list[Mesh]:
    """Return ``copies`` rotated about z, evenly over ``about_z`` degrees."""
    return [rotate(mesh, z=i * about_z / copies) for i in range(copies)]


def smooth(mesh: Mesh, iterations: int = 5) -> Mesh:
    """Smooth a mesh (Laplacian, Taubin), after subdividing coarse meshes once."""
    new = mesh.subdivide() if len(mesh.faces) < 1500 else mesh.copy()
    new.merge_vertices()
    trimesh.smoothing.filter_taubin(new, iterations=iterations)
    return new


def deform(mesh: Mesh, f: Callable[[Floats], Floats], max_edge: float | None = None) -> Mesh:
    """Return a copy with its vertices (N, 3) mapped by ``f``; edges longer than ``max_edge`` are split
    first."""
    if max_edge is not None:
        solid = _to_manifold(mesh).refine_to_length(max_edge)
        mesh = _from_manifold(solid)
    return Mesh(f(np.asarray(mesh.vertices).copy()), mesh.faces, process=False)
