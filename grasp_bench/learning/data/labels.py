"""Labels of synthetic scenes: from the analysis of true heights to grasps at pixels.

The field of best grasps is made free of what its grid causes, corrected where there are
several objects, marked down where physics refuted it, and projected into the image.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter, grey_closing

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.learning.data.candidates import Candidates
from grasp_bench.planning.heightfield import CELL, GraspField, HeightField, balance
from grasp_bench.scene.rendering import Picture
from grasp_bench.system.arrays import Floats

Arrays = dict[str, NDArray]

NEAR, ALIKE = 0.008, np.radians(15)
"""A tried grasp speaks for cells this near [m] whose jaws differ by less than this."""


@dataclass(frozen=True)
class View:
    """The stored part of the camera's image: its intrinsics, and world rays (S, S, 3) with z-depth 1."""

    intrinsics: Intrinsics
    pose: CameraPose
    rays: Floats

    def on_plane(self, height: Floats, rays: Floats | None = None) -> Floats:
        """Return world x, y (S, S, 2) at which each pixel sees the plane of its ``height`` (S, S).

        The same for some pixels, whose ``rays`` (M, 3) and heights (M,) are given: (M, 2).
        """
        rays = self.rays if rays is None else rays
        distance = (height - self.pose.position[2]) / rays[..., 2]
        return self.pose.position[:2] + rays[..., :2] * distance[..., None]

    def grasps(
        self, centre: NDArray[np.floating], yaw: NDArray, opening: NDArray
    ) -> tuple[Floats, Floats, Floats]:
        """Project grasps about points (…, 3) to pixel (…, 2), angle and width, as the planner reads them."""
        half = 0.5 * opening[..., None] * np.stack([np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)], axis=-1)
        ends = [self.intrinsics.project(self.pose.to_camera(centre + s * half)) for s in (-1, 1)]
        dx, dy = np.moveaxis(ends[1] - ends[0], -1, 0)
        angle = np.arctan2(-dy, dx)
        wrapped = angle - np.pi * np.ceil(angle / np.pi - 0.5)
        return (ends[0] + ends[1]) / 2, wrapped, np.hypot(dx, dy)


def polished(found: GraspField) -> GraspField:
    """Return the field without the stripes that edges oblique to the cells leave in it: quality closed
    over 5×5 cells and blurred a little, and each cell's grasp the best of its 3×3 neighbours'."""
    shifts = [(0, 0), *((r, c) for r in (-1, 0, 1) for c in (-1, 0, 1) if r or c)]
    best = np.argmax([np.roll(found.quality, s, (0, 1)) for s in shifts], axis=0)
    rows, columns = np.indices(best.shape) - np.array(shifts)[best].transpose(2, 0, 1)
    source = rows % best.shape[0], columns % best.shape[1]
    smooth = gaussian_filter(grey_closing(found.quality, size=(5, 5)), 0.7)
    quality = np.where(found.quality[source] > 0, np.clip(smooth, 0, 1), 0).astype(np.float32)
    return GraspField(quality, found.yaw[source], found.opening[source], found.tip[source], found.top[source])


def balanced(
    found: GraspField, field: HeightField, view: View, owner: NDArray[np.int64], centres: Floats
) -> GraspField:
    """Grade each cell for the centre of mass of the object there, or of the nearest one seen.

    Args:
        found: analysis for one centre of mass, that of ``field``.
        field: true heights of the scene.
        view: the stored part of the camera's image.
        owner: (S, S) number of the object that each pixel shows, −1 for none.
        centres: (objects, 2) centres of mass [m].
    """
    nearest = distance_transform_edt(owner < 0, return_distances=False, return_indices=True)
    owner = owner[tuple(nearest)]
    rows, columns = np.indices(found.top.shape)
    xy = np.array(field.origin) + CELL * np.stack([columns, rows], axis=-1)
    pixel = view.intrinsics.project(view.pose.to_camera(np.concatenate([xy, found.top[..., None]], axis=-1)))
    u, v = np.clip(pixel, 0, len(owner) - 1).astype(int).transpose(2, 0, 1)
    own = centres[owner[v, u]]
    quality = found.quality * balance(xy - own) / balance(xy - np.array(field.centre_of_mass))
    return replace(found, quality=np.clip(quality, 0, 1).astype(np.float32))


def refute(found: GraspField, tried: Candidates, held: NDArray[np.bool_], factor: float) -> GraspField:
    """Multiply quality by ``factor`` where the nearest grasp tried with like jaws failed."""
    nearest, verdict = np.full(found.quality.shape, NEAR + 1e-6), np.ones(found.quality.shape, bool)
    reach = int(NEAR / CELL) + 1
    for row, column, yaw, success in zip(tried.rows, tried.columns, tried.yaw, held, strict=True):
        near = tuple(slice(max(at - reach, 0), at + reach + 1) for at in (int(row), int(column)))
        rows, columns = np.ogrid[near]
        distance = CELL * np.hypot(rows - row, columns - column)
        turn = np.abs((found.yaw[near] - yaw + np.pi / 2) % np.pi - np.pi / 2)
        closer = (distance < nearest[near]) & (turn <= ALIKE)
        nearest[near][closer], verdict[near][closer] = distance[closer], success
    return replace(found, quality=(found.quality * np.where(verdict, 1, factor)).astype(np.float32))


def dense(view: View, found: GraspField, field: HeightField, picture: Picture) -> Arrays:
    """Make label maps: each pixel has the best grasp of the cell it sees on the plane of that grasp's top."""
    top = np.clip(view.pose.position[2] + view.rays[..., 2] * picture.depth, 0, None).ravel()
    rays = view.rays.reshape(-1, 3)
    cell, value = _at(view.on_plane(top, rays), found, field)  # what each pixel sees itself
    seen = np.flatnonzero(value > 0)  # the others will see no grasp on any plane that they are given
    rays, top = rays[seen], found.top[cell][seen].astype(float)
    for _ in range(2):  # twice more accurately
        cell, value = _at(view.on_plane(top, rays), found, field)
        top = np.where(value > 0, found.top[cell], top)
    stored = np.rint(255 * value).astype(np.uint8)
    centre = np.column_stack([view.on_plane(top, rays), top])
    _, angle, width = view.grasps(centre, found.yaw[cell], found.opening[cell])
    on = stored > 0
    maps: Arrays = {}
    for name, kind, values in (
        ("quality", np.uint8, stored),
        ("angle", np.float16, np.where(on, angle, 0)),
        ("width", np.float16, np.where(on, width, 0)),
    ):
        maps[name] = np.zeros(picture.depth.shape, kind)
        np.put(maps[name], seen, values)
    return maps


def _at(
    xy: Floats, found: GraspField, field: HeightField
) -> tuple[tuple[NDArray[np.int64], NDArray[np.int64]], NDArray[np.float32]]:
    """Return the cells (rows, columns) under world points (M, 2), and their quality, 0 outside the field."""
    columns, rows = np.rint((xy - field.origin) / CELL).astype(int).T
    inside = (rows >= 0) & (columns >= 0) & (rows < found.top.shape[0]) & (columns < found.top.shape[1])
    cell = np.where(inside, rows, 0), np.where(inside, columns, 0)
    return cell, np.where(inside, found.quality[cell], 0)
