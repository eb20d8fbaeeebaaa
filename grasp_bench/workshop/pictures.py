"""Pictures of objects: single, and contact sheets. Need OpenGL (EGL or OSMesa) unless traced."""

from __future__ import annotations

from colorsys import hsv_to_rgb

import mujoco
import numpy as np
from PIL import Image, ImageDraw
from scipy.spatial import ConvexHull

from grasp_bench.errors import GraspBenchError
from grasp_bench.media.portraits import TILE, VIEWS, scene_of, traced_parts
from grasp_bench.objects.catalog import ObjectModel, VisualPart
from grasp_bench.system.graphics import with_gl


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
