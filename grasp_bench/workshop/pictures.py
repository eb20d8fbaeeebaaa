"""Pictures of objects: single, and contact sheets. Need OpenGL (EGL or OSMesa) unless traced."""

from __future__ import annotations

from colorsys import hsv_to_rgb

import mujoco
import numpy as np
from PIL import Image, ImageDraw
from scipy.spatial import ConvexHull

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.errors import GraspBenchError
from grasp_bench.objects.catalog import ObjectModel, VisualPart
from grasp_bench.scene.rendering import raycast
from grasp_bench.system.graphics import with_gl

TILE = 256
VIEWS = ((-35.0, 130.0), (-60.0, 220.0))
"""Elevation and azimuth of the two standard views [degrees]."""


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


def shoot(
    model: mujoco.MjModel, centre: np.ndarray, views: tuple[tuple[float, float], ...], size: int
) -> list[Image.Image]:
    """Take pictures (size × size) of a scene of :func:`scene_of` from each (elevation, azimuth) in degrees.

    Raises:
        GraspBenchError: where no OpenGL can be had.
    """
    with_gl()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    try:
        renderer = mujoco.Renderer(model, 2 * size, 2 * size)
    except Exception as error:
        raise GraspBenchError(
            f"Pictures need OpenGL, which cannot start here ({error}); try MUJOCO_GL=osmesa."
        ) from error
    pictures = []
    with renderer:
        for elevation, azimuth in views:
            camera = mujoco.MjvCamera()
            camera.lookat[:] = centre
            camera.distance, camera.elevation, camera.azimuth = 1.35, elevation, azimuth
            renderer.update_scene(data, camera)
            pictures.append(Image.fromarray(renderer.render()).resize((size, size), Image.Resampling.LANCZOS))
    return pictures


def render_parts(
    parts: list[VisualPart],
    views: tuple[tuple[float, float], ...] = VIEWS,
    size: int = TILE,
    rotation: np.ndarray | None = None,
) -> list[Image.Image]:
    """Draw pictures (size × size) of coloured parts from each (elevation, azimuth) in degrees.

    Args:
        rotation: (3, 3) by which the object is turned before it is put on the floor; upright when None.

    Raises:
        GraspBenchError: where no OpenGL can be had.
    """
    with_gl()
    spec, _, centre = scene_of(parts, np.eye(3) if rotation is None else rotation)
    return shoot(spec.compile(), centre, views, size)


def object_picture(model: ObjectModel, size: int = 2 * TILE) -> Image.Image:
    """Draw the object from its two standard views, side by side."""
    return _side_by_side(render_parts(model.visual, size=size), size)


def _side_by_side(sides: list[Image.Image], size: int) -> Image.Image:
    picture = Image.new("RGB", (len(sides) * size, size))
    for i, side in enumerate(sides):
        picture.paste(side, (i * size, 0))
    return picture


def traced_picture(model: ObjectModel, size: int = TILE) -> Image.Image:
    """Draw the object from its two standard views, and its convex pieces, each in a colour of its own.

    Drawn by MuJoCo's ray caster: needs no OpenGL.
    """
    hulls = [
        VisualPart(h, ConvexHull(h).simplices, hsv_to_rgb((0.381966 * i) % 1, 0.55, 0.95), 0.5)
        for i, h in enumerate(model.hulls)
    ]
    sides = [traced_parts(model.visual, view, size) for view in VIEWS]
    return _side_by_side([*sides, traced_parts(hulls, VIEWS[0], size)], size)


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


def contact_sheet(
    models: list[ObjectModel], columns: int = 12, names: bool = True, size: int = TILE // 2
) -> Image.Image:
    """Draw one tile an object, row by row, as the objects were modelled."""
    caption = 14 if names else 0
    rows = -(-len(models) // columns)
    sheet = Image.new("RGB", (columns * size, rows * (size + caption)), "white")
    draw = ImageDraw.Draw(sheet)
    for i, model in enumerate(models):
        x, y = i % columns * size, i // columns * (size + caption)
        sheet.paste(render_parts(model.visual, VIEWS[:1], size)[0], (x, y))
        if names:
            draw.text((x + 3, y + size + 1), model.name[: size // 6], fill="black")
    return sheet
