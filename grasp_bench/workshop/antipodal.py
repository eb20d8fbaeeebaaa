"""Pairs of opposite points on true surfaces, sampled as Dex-Net does (Mahler et al., RSS 2017).

Rims, handles, thin edges and all else that two fingers could close on.
"""

from __future__ import annotations

import mujoco
import numpy as np

from grasp_bench.planning.heightfield import CELL, HeightField
from grasp_bench.scene.floating import FloatingGripper
from grasp_bench.scene.rendering import SHOWN_GROUPS
from grasp_bench.system.arrays import Floats

Rng = np.random.Generator
Jaws = tuple[int, int, float]
"""Row and column of the centre's cell, and jaw direction [rad]."""
STEEPEST = 0.5
"""Antipodal pairs start on surfaces whose normal's vertical part is smaller."""
CONE = np.radians(20)
"""Angle between jaws and surface normal up to which points are antipodal (friction 0.36)."""


def antipodal(gripper: FloatingGripper, field: HeightField, count: int, rng: Rng) -> list[Jaws]:
    """Find up to ``count`` pairs of opposite points of the true surfaces, as cells and jaw directions.

    From a random point of a steep surface a ray goes in, within the friction cone: to the
    inside of the same wall, or from beyond the far side back to it, whichever is drawn. It is a
    grasp where the surface met there faces away within the cone and the jaws can span the pair.
    """
    model, data = gripper.model, gripper.data
    corners, normals = _steep_faces(model, data)
    found: list[Jaws] = []
    geom, normal = np.zeros(1, np.int32), np.zeros(3)
    widest = gripper.gripper.opening - 0.006
    for _ in range(8 * count if len(corners) else 0):
        if len(found) == count:
            break
        face = int(rng.integers(len(corners)))
        weights = rng.dirichlet(np.ones(3))
        point, outward = weights @ corners[face], normals[face]
        heading = np.arctan2(-outward[1], -outward[0]) + rng.uniform(-CONE, CONE)
        inward = np.array([np.cos(heading), np.sin(heading), 0.0])
        across = bool(rng.integers(2))
        start, ray = (point + inward * widest, -inward) if across else (point + 2e-4 * inward, inward)
        gap = mujoco.mj_ray(model, data, start, ray, SHOWN_GROUPS, True, -1, geom, normal)
        span = widest - gap if across else gap
        if gap < 0 or not 0.001 < span < widest:
            continue
        if abs(normal @ inward) < np.cos(CONE) * np.linalg.norm(normal):
            continue
        middle = point + inward * span / 2
        column, row = np.rint((middle[:2] - field.origin) / CELL).astype(int)
        if 0 <= row < len(field.heights) and 0 <= column < len(field.heights):
            found.append((int(row), int(column), float(heading % np.pi)))
    return found


def _steep_faces(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Floats, Floats]:
    """Return corners (F, 3, 3) and unit normals (F, 3) in the world of the shown faces that stand upright,
    drawn with equal chance whatever their size: rims and thin edges have small ones."""
    corners, normals = [np.zeros((0, 3, 3))], [np.zeros((0, 3))]
    for geom in range(model.ngeom):
        body = model.body(model.geom_bodyid[geom]).name
        if not body.startswith("object") or not SHOWN_GROUPS[model.geom_group[geom]]:
            continue
        mesh = model.geom_dataid[geom]
        first, many = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        vertices = model.mesh_vert[first : first + many] @ data.geom_xmat[geom].reshape(3, 3).T
        faces = model.mesh_face[
            model.mesh_faceadr[mesh] : model.mesh_faceadr[mesh] + model.mesh_facenum[mesh]
        ]
        triangles = (vertices + data.geom_xpos[geom])[faces]
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        area = np.linalg.norm(normal, axis=1)
        unit = normal / np.maximum(area, 1e-12)[:, None]
        steep = (area > 1e-9) & (np.abs(unit[:, 2]) < STEEPEST) & (triangles[:, :, 2].mean(1) > 0.003)
        corners.append(triangles[steep])
        normals.append(unit[steep])
    return np.concatenate(corners), np.concatenate(normals)
