"""Pictures of objects by themselves, drawn by MuJoCo's ray caster: needs no OpenGL."""

from __future__ import annotations

import io
from contextlib import suppress

import mujoco
import numpy as np
from PIL import Image

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.objects.catalog import ObjectModel, VisualPart
from grasp_bench.scene.rendering import raycast
from grasp_bench.system import cache
from grasp_bench.system.integrity import write_whole

TILE = 256
VIEWS = ((-35.0, 130.0), (-60.0, 220.0))
"""Elevation and azimuth of the two standard views [degrees]."""
THUMBNAIL = 64
"""Width and height of :func:`thumbnail` [px]."""


def scene_of(
    parts: list[VisualPart], rotation: np.ndarray, reach: np.ndarray | None = None
) -> tuple[mujoco.MjSpec, float, np.ndarray]:
    """Put parts on a light floor, scaled so that the diagonal is 1.

    Args:
        rotation: (3, 3) by which the parts are turned.
        reach: (N, 3) further points, in the rotated axes, that the pictures must show.

    Returns:
        The specification, the scale, and the middle of what is shown.
    """
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth = spec.visual.global_.offheight = 4 * TILE
    spec.visual.headlight.ambient = [0.45, 0.45, 0.45]
    spec.visual.headlight.diffuse = [0.45, 0.45, 0.45]
    spec.visual.quality.shadowsize = 2048
    cloud = np.vstack([p.vertices @ rotation.T for p in parts])
    floor = float(cloud[:, 2].min())
    cloud = cloud if reach is None else np.vstack([cloud, reach])
    low, high = cloud.min(0), cloud.max(0)
    scale = 1 / float(np.linalg.norm(high - low))
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[25, 25, 0.1],
        pos=[0, 0, floor * scale],
        rgba=[0.93, 0.93, 0.91, 1],
    )
    spec.worldbody.add_light(
        pos=[-1.5, -2, 4], dir=[0.35, 0.45, -0.9], diffuse=[0.5, 0.5, 0.5], castshadow=True
    )
    for i, part in enumerate(parts):
        add_mesh(spec, f"p{i}", part.vertices @ rotation.T * scale, part.faces, (*part.rgb, 1))
    return spec, scale, (low + high) / 2 * scale


def add_mesh(
    spec: mujoco.MjSpec,
    name: str,
    vertices: np.ndarray,
    faces: np.ndarray,
    rgba: tuple[float, float, float, float],
    convex: bool = False,
) -> None:
    """Add a mesh that is only seen: ``vertices`` (V, 3), ``faces`` (F, 3), colour in [0, 1]."""
    kinds = mujoco.mjtMeshInertia
    inertia = kinds.mjMESH_INERTIA_CONVEX if convex else kinds.mjMESH_INERTIA_SHELL
    spec.add_mesh(name=name, uservert=vertices.ravel(), userface=np.ravel(faces), inertia=inertia)
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, rgba=rgba, contype=0, conaffinity=0
    )


def traced_parts(parts: list[VisualPart], view: tuple[float, float], size: int = TILE) -> Image.Image:
    """Draw coloured parts (size × size) from (elevation, azimuth) in degrees, without OpenGL."""
    spec, _, centre = scene_of(parts, np.eye(3))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    elevation, azimuth = np.radians(view)
    forward = np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )
    position = centre - 1.35 * forward
    pose = CameraPose.look_at(tuple(position), tuple(centre), (0.0, 0.0, 1.0))
    rays = Intrinsics.from_fov(2 * size, 2 * size, np.radians(45)).rays()
    picture = raycast(model, data, position, rays @ pose.rotation.T).rgb
    return Image.fromarray(picture).resize((size, size), Image.Resampling.LANCZOS)


def thumbnail(model: ObjectModel) -> bytes:
    """Return a small picture of an object as WebP, kept in the cache of compiled models under its digest."""
    path = cache.folder() / f"{model.digest}.webp"
    if model.digest and cache.used(path):
        with suppress(OSError):
            return path.read_bytes()
    buffer = io.BytesIO()
    traced_parts(model.visual, VIEWS[0], THUMBNAIL).save(buffer, "WEBP", quality=60)
    if model.digest and cache.limit():
        with suppress(OSError):
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, buffer.getvalue())
    return buffer.getvalue()
