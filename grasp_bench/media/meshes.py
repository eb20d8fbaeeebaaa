"""A compiled scene's shown geometry as meshes, for viewers that are not MuJoCo's."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from grasp_bench.scene.rendering import SHOWN_GROUPS
from grasp_bench.scene.surfaces import geom_colors

PLANE_SIZE = 1.5
"""Half the edge of the part that is shown of an endless plane [m]."""


@dataclass(frozen=True)
class ShownMesh:
    """A geom's surface in the axes of its body.

    Attributes:
        body: id of its body.
        vertices: (V, 3) [m].
        faces: (F, 3) indices.
        color: red, green, blue, 0 to 255.
    """

    body: int
    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    color: tuple[int, int, int]


def shown_meshes(model: mujoco.MjModel) -> list[ShownMesh]:
    """Return all geoms that pictures show, except the invisible."""
    colors = geom_colors(model)
    found = []
    for geom in range(model.ngeom):
        if not SHOWN_GROUPS[model.geom_group[geom]] or (
            model.geom_matid[geom] < 0 and model.geom_rgba[geom, 3] == 0
        ):
            continue
        surface = _surface(model, geom)
        if surface is None:
            continue
        vertices, faces = surface
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
        placed = vertices @ rotation.reshape(3, 3).T + model.geom_pos[geom]
        red, green, blue = np.round(255 * np.clip(colors[geom], 0, 1)).astype(int).tolist()
        found.append(
            ShownMesh(
                int(model.geom_bodyid[geom]),
                placed.astype(np.float32),
                np.asarray(faces, np.int32),
                (red, green, blue),
            )
        )
    return found


def _surface(model: mujoco.MjModel, geom: int) -> tuple[NDArray[np.float64], NDArray[np.int32]] | None:
    """Return vertices and faces in the geom's own axes; None for kinds that scenes do not show."""
    import trimesh.creation as make

    kind, size = model.geom_type[geom], model.geom_size[geom]
    types = mujoco.mjtGeom
    if kind == types.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        face, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
        vertices = model.mesh_vert[first : first + count].astype(float)
        return vertices, model.mesh_face[face : face + faces].copy()
    if kind == types.mjGEOM_PLANE:
        x, y = (s or PLANE_SIZE for s in size[:2])
        corners = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]], float)
        return corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    if kind == types.mjGEOM_BOX:
        made = make.box(extents=2 * size)
    elif kind == types.mjGEOM_CYLINDER:
        made = make.cylinder(radius=size[0], height=2 * size[1])
    elif kind == types.mjGEOM_CAPSULE:
        made = make.capsule(radius=size[0], height=2 * size[1])
    elif kind == types.mjGEOM_SPHERE:
        made = make.icosphere(radius=size[0])
    else:
        return None
    return np.asarray(made.vertices, float), np.asarray(made.faces, np.int32)


class Stage:
    """The shown surfaces of a model (``meshes``), and the poses of its bodies in recorded states."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.meshes = shown_meshes(model)
        self._model, self._data = model, mujoco.MjData(model)
        self._bodies = sorted({m.body for m in self.meshes})

    def poses(self, qpos: NDArray[np.float64]) -> dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Return position (3,) [m] and quaternion (4,) w, x, y, z of every shown body in a state."""
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        return {b: (self._data.xpos[b].copy(), self._data.xquat[b].copy()) for b in self._bodies}
