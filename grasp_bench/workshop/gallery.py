"""The gallery: every object from two sides, its convex pieces laid over it, and its best reference grasp."""

from __future__ import annotations

from colorsys import hsv_to_rgb

import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy.spatial import ConvexHull

from grasp_bench.media.portraits import TILE, add_mesh, scene_of
from grasp_bench.objects.catalog import ObjectModel, ReferenceGrasp
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.workshop.pictures import shoot

FINGER = (PARALLEL_85.finger_thickness / 2, PARALLEL_85.finger_width / 2, 0.030)
"""Half sizes of a drawn finger: along the jaws, across them, upwards [m]."""
SWELL = 0.0007
"""The drawn pieces stand out by this [m], to be seen on the object's surface."""
SIDES = ((-28.0, 125.0), (-40.0, 305.0))
"""Elevation, and azimuth from the jaw direction, of the two sides [degrees]: no finger hides the object."""
UPRIGHT = 0.94
"""Cosine of the tilt up to which a pose counts as upright."""


def gallery_pictures(model: ObjectModel, size: int = TILE) -> list[Image.Image]:
    """Draw two pictures (size × size) of the object as it rests: upright if it can be grasped so, else as it
    most often does where it can.

    The first shows it plain, the second, from the other side, under its convex pieces; both with
    the fingers at the best reference grasp, open.
    """
    pose = next((p for p in model.graspable_poses if p.rotation[2, 2] > UPRIGHT), model.graspable_poses[0])
    rotation, grasp = pose.rotation, pose.grasps[0]
    reach = np.vstack([_finger_corners(rotation, grasp, side) for side in (-1, 1)])
    jaws = rotation @ grasp.axis
    pictures = []
    for hulls, (elevation, azimuth) in zip((False, True), SIDES, strict=True):
        view = (elevation, azimuth + float(np.degrees(np.arctan2(jaws[1], jaws[0]))))
        spec, scale, centre = scene_of(model.visual, rotation, reach)
        for side in (-1, 1):
            _add_finger(spec, rotation, grasp, side, scale)
        for i, hull in enumerate(model.hulls if hulls else []):
            outwards = hull - hull.mean(0)
            swollen = hull + SWELL * outwards / np.linalg.norm(outwards, axis=1, keepdims=True)
            color = (*hsv_to_rgb((0.381966 * i) % 1, 0.7, 0.95), 0.75)
            faces = ConvexHull(hull).simplices
            add_mesh(spec, f"h{i}", swollen @ rotation.T * scale, faces, color, convex=True)
        pictures += shoot(spec.compile(), centre, (view,), size)
    return pictures


def _place(
    rotation: NDArray[np.float64], grasp: ReferenceGrasp, side: int
) -> tuple[NDArray[np.float64], float]:
    """Return the middle of a finger in the resting object's axes, about its centre of mass, and its yaw."""
    axis = rotation @ grasp.axis
    middle = rotation @ grasp.tip + side * (grasp.width / 2 + FINGER[0]) * axis + [0, 0, FINGER[2]]
    return middle, float(np.arctan2(axis[1], axis[0]))


def _finger_corners(rotation: NDArray[np.float64], grasp: ReferenceGrasp, side: int) -> NDArray[np.float64]:
    middle, _ = _place(rotation, grasp, side)
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    return middle + signs * (FINGER[1], FINGER[1], FINGER[2])


def _add_finger(
    spec: mujoco.MjSpec, rotation: NDArray[np.float64], grasp: ReferenceGrasp, side: int, scale: float
) -> None:
    middle, yaw = _place(rotation, grasp, side)
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[scale * s for s in FINGER],
        pos=list(scale * middle),
        quat=[np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)],
        rgba=[0.15, 0.17, 0.2, 0.85],
        contype=0,
        conaffinity=0,
    )


def gallery_sheet(models: list[ObjectModel], columns: int = 5, size: int = 150) -> Image.Image:
    """Draw a contact sheet of :func:`gallery_pictures`, names below."""
    caption, rows = 14, -(-len(models) // columns)
    sheet = Image.new("RGB", (columns * (2 * size + 6), rows * (size + caption)), "white")
    draw = ImageDraw.Draw(sheet)
    for i, model in enumerate(models):
        x, y = i % columns * (2 * size + 6), i // columns * (size + caption)
        for k, picture in enumerate(gallery_pictures(model, size)):
            sheet.paste(picture, (x + k * size, y))
        draw.text((x + 3, y + size + 1), f"{model.name} ({model.category})"[: 2 * size // 6], fill="black")
    return sheet
