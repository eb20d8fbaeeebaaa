"""Off-screen colour and depth images, by MuJoCo's ray caster or by OpenGL.

The ray caster needs no graphics library at all and gives the same pixels on every machine,
so it is what ``auto`` means. EGL and OSMesa draw the same scene with OpenGL; which renderer
made a run's images is part of its record.
"""

from __future__ import annotations

import os
from typing import Literal, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.errors import GraspBenchError, UnknownNameError

Renderer = Literal["auto", "raycast", "egl", "osmesa"]
RENDERERS: tuple[str, ...] = ("auto", "raycast", "egl", "osmesa")
FAR = 10.0
"""Rays that hit nothing within this distance are invalid [m]."""
LIGHTS = ((np.array([0.25, -0.45, 0.86]), 0.45), (np.array([-0.6, 0.5, 0.62]), 0.2))
"""Directions towards two distant lamps, and their strength."""
AMBIENT = 0.40
SHOWN_GROUPS = np.array([1, 1, 1, 0, 0, 0], dtype=np.uint8)


class Picture(NamedTuple):
    """A noise-free image.

    Attributes:
        rgb: (H, W, 3) uint8.
        depth: (H, W) float32 z-depth [m], 0 where nothing was hit.
        geom: (H, W) int32 geom ids, −1 where nothing was hit.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    geom: NDArray[np.int32]


def resolve_renderer(name: str) -> str:
    """The renderer that ``name`` stands for on this machine.

    Raises:
        UnknownNameError: for a name that is not in :data:`RENDERERS`.
    """
    if name not in RENDERERS:
        raise UnknownNameError("renderer", name, RENDERERS)
    return "raycast" if name == "auto" else name


def render(model: mujoco.MjModel, data: mujoco.MjData, intrinsics: Intrinsics, pose: CameraPose,
           renderer: str = "raycast") -> Picture:
    """Image of the scene in ``data`` from a pinhole camera at ``pose``."""
    if resolve_renderer(renderer) == "raycast":
        return raycast(model, data, intrinsics, pose)
    return _render_gl(model, data, intrinsics, pose, renderer)


def raycast(model: mujoco.MjModel, data: mujoco.MjData, intrinsics: Intrinsics, pose: CameraPose,
            region: tuple[slice, slice] | None = None) -> Picture:
    """Ray-cast image, optionally only of a (rows, columns) ``region`` of the full image."""
    rays = intrinsics.rays()
    if region is not None:
        rays = rays[region]
    shape = rays.shape[:2]
    # Rays with z = 1 in the camera frame: the distance returned is z-depth itself.
    directions = np.ascontiguousarray((rays.reshape(-1, 3) @ pose.rotation.T))
    count = len(directions)
    geom = np.full(count, -1, dtype=np.int32)
    distance = np.zeros(count)
    normal = np.zeros((count, 3))
    mujoco.mj_multiRay(model, data, pose.position, directions.ravel(), SHOWN_GROUPS, True, -1, geom, distance,
                       normal.ravel(), count, FAR)
    hit = geom >= 0
    facing = -np.sign(np.einsum("ij,ij->i", normal, directions))[:, None]
    normal *= np.where(facing == 0, 1, facing)
    light = np.full(count, AMBIENT)
    for direction, strength in LIGHTS:
        light += strength * np.clip(normal @ (direction / np.linalg.norm(direction)), 0, None)
    color = geom_colors(model)[geom] * light[:, None]
    rgb = np.where(hit[:, None], np.clip(color * 255, 0, 255), 0).astype(np.uint8)
    depth = np.where(hit, distance, 0).astype(np.float32)
    return Picture(rgb.reshape(*shape, 3), depth.reshape(shape), geom.reshape(shape))


def geom_colors(model: mujoco.MjModel) -> NDArray[np.float64]:
    """(ngeom, 3) base colours; a material's colour replaces the geom's own."""
    colors = model.geom_rgba[:, :3].astype(float)
    made_of = model.geom_matid >= 0
    colors[made_of] = model.mat_rgba[model.geom_matid[made_of], :3]
    return colors


def _render_gl(model: mujoco.MjModel, data: mujoco.MjData, intrinsics: Intrinsics, pose: CameraPose,
               backend: str) -> Picture:
    if os.environ.setdefault("MUJOCO_GL", backend) != backend:
        raise GraspBenchError(f"MUJOCO_GL={os.environ['MUJOCO_GL']} is set, which contradicts the renderer "
                              f"{backend!r}; unset it or choose --renderer raycast.")
    width, height = intrinsics.width, intrinsics.height
    model.vis.global_.offwidth = max(model.vis.global_.offwidth, width)
    model.vis.global_.offheight = max(model.vis.global_.offheight, height)
    try:
        context = mujoco.Renderer(model, height, width)
    except Exception as error:
        raise GraspBenchError(f"The renderer {backend!r} cannot start ({error}); install its library "
                              "or choose --renderer raycast, which needs none.") from error
    with context as gl:
        camera = model.camera("sensor").id
        option = mujoco.MjvOption()
        option.geomgroup[:] = SHOWN_GROUPS
        gl.update_scene(data, camera, option)
        rgb = gl.render().copy()
        gl.enable_depth_rendering()
        gl.update_scene(data, camera, option)
        depth = gl.render().astype(np.float32)
        gl.disable_depth_rendering()
        gl.enable_segmentation_rendering()
        gl.update_scene(data, camera, option)
        segments = gl.render()
    geom = np.where(segments[..., 1] == mujoco.mjtObj.mjOBJ_GEOM, segments[..., 0], -1).astype(np.int32)
    depth = np.where((geom >= 0) & (depth < FAR), depth, 0).astype(np.float32)
    return Picture(rgb, depth, geom)
