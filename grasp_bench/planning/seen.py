"""The heights that a depth image shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import CameraPose, RgbdImage
from grasp_bench.grasps import Grasp
from grasp_bench.planning.heightfield import TABLE_NOISE
from grasp_bench.planning.refusals import Blocked
from grasp_bench.scenario.sections import Table
from grasp_bench.system.arrays import Floats

STRAYS = 3
"""From this many points on, what is seen is no noise; a thin rod under a finger's corner may show no more."""
STRAYS_UNDER_HAND = 20
"""The same for the hand, under which some 3,000 pixels see."""
NEIGHBOURS, SAME_SURFACE = 3, 0.010
"""A reading counts in the cloud where so many of its eight neighbours differ by less than this [m]."""


class SeenScene:
    """What a depth image shows of the heights on the table.

    Args:
        camera: pose of the camera that took it.
        directions: (H, W, 3) world directions of the pixels' rays; computed where they are not given.
        others: what other pictures show of the same table.
    """

    def __init__(
        self,
        image: RgbdImage,
        camera: CameraPose,
        directions: Floats | None = None,
        others: Sequence[SeenScene] = (),
    ) -> None:
        self.image, self.camera, self._others = image, camera, others
        self._rays = image.intrinsics.rays() @ camera.rotation.T if directions is None else directions
        self.heights = camera.position[2] + image.depth * self._rays[..., 2]
        self.heights[~image.valid] = np.nan

    def places(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Floats:
        """Return x and y (N, 2) in the world of what pixels show [m]."""
        depth = self.image.depth[rows, columns][:, None]
        return self.camera.position[:2] + self._rays[rows, columns, :2] * depth

    def highest(self, table: Table) -> float:
        """Return the greatest height seen on the table, robust against single pixels [m].

        What is seen beside the table top, such as the arm's own base, is not in the way.
        """
        heights = self.heights.ravel()
        tall = np.flatnonzero(heights > TABLE_NOISE)
        depth = self.image.depth.ravel()[tall]
        on_table = np.ones(len(tall), bool)
        for axis in (0, 1):
            places = self.camera.position[axis] + self._rays[..., axis].ravel()[tall] * depth
            on_table &= np.abs(places - table.center[axis]) <= table.size[axis] / 2
        return max(highest(heights[tall[on_table]], STRAYS_UNDER_HAND), 0.0)

    @cached_property
    def points(self) -> Floats:
        """(N, 3) places of what stands higher than the table's noise in any picture [m], flying pixels left
        out."""
        chosen = self.image.valid & steady(self.image.depth) & (self.heights > TABLE_NOISE)
        own = self.camera.position + self._rays[chosen] * self.image.depth[chosen][:, None]
        return np.concatenate([own, *(other.points for other in self._others)])

    def on_plane(self, pixel: Floats, height: float) -> Floats:
        """Return the world point where the ray through ``pixel`` (2,) meets the plane z = ``height``.

        Raises:
            Blocked: where the ray does not go down.
        """
        ray = self.camera.rotation @ self.image.intrinsics.deproject(pixel, np.ones(()))
        if ray[2] > -1e-6:
            raise Blocked(f"the ray through pixel ({pixel[0]:.0f}, {pixel[1]:.0f}) does not meet the table")
        return self.camera.position + ray * (height - self.camera.position[2]) / ray[2]

    def _depth_of_table(self, grasp: Grasp) -> float:
        """Return the depth at which the ray through a grasp's centre meets the table [m]; seen from above,
        the camera's height."""
        ray = self.camera.rotation[2] @ self.image.intrinsics.deproject([grasp.x, grasp.y], np.ones(()))
        return float(self.camera.position[2] / max(-ray, 0.1))

    def heights_in(self, grasp: Grasp, jaw: float) -> Floats:
        """Return the heights [m] of the points seen inside the grasp's rectangle, jaws ``jaw`` metres
        wide."""
        across = jaw * self.image.intrinsics.fx / max(self._depth_of_table(grasp) - 0.03, 0.1)
        inside_image = min(grasp.width, 2.0 * sum(self.heights.shape))  # of absurd widths, no more is in view
        corners = np.round(replace(grasp, width=inside_image).rectangle(height=across) - 0.5).astype(np.int32)
        window = self._window(corners.min(0), corners.max(0) + 1)
        heights = self.heights[window]
        mask = np.zeros(heights.shape, np.uint8)
        if mask.size:
            cv2.fillPoly(mask, [corners - [window[1].start, window[0].start]], (1,))
        inside = heights[mask > 0]
        return inside[np.isfinite(inside)]

    def local(self, centre: Floats, axis: Floats, reach: float) -> tuple[Floats, Floats]:
        """Return the points within ``reach`` [m] of ``centre`` as (N, 2) offsets along and across ``axis``,
        and their heights (N,)."""
        low = max(float(centre[2]) - 0.15, 0.0)
        corners = centre[:2] + reach * np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])
        cloud = np.array([[*c, z] for c in corners for z in (low, float(centre[2]) + 0.05)])
        pixels = self.image.intrinsics.project(self.camera.to_camera(cloud))
        window = self._window(np.floor(pixels.min(0)).astype(int), np.ceil(pixels.max(0)).astype(int))
        heights, depth = self.heights[window], self.image.depth[window]
        x, y = (
            self.camera.position[i] + self._rays[(*window, i)] * depth - centre[i]  # along the world's axes
            for i in (0, 1)
        )
        near = np.isfinite(heights) & (np.abs(x) < reach) & (np.abs(y) < reach)
        offset, across = np.column_stack([x[near], y[near]]), np.array([-axis[1], axis[0]])
        return np.column_stack([offset @ axis[:2], offset @ across]), heights[near]

    def _window(self, low: NDArray[np.intp], high: NDArray[np.intp]) -> tuple[slice, slice]:
        """Return the rows and columns between two pixels, clipped to the image."""
        h, w = self.heights.shape
        (left, top), (right, bottom) = np.clip([low, high], 0, [w, h])
        return slice(int(top), int(bottom)), slice(int(left), int(right))


def steady(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return the (H, W) mask of pixels of whose eight neighbours :data:`NEIGHBOURS` lie about as far away.

    Cameras mix near and far at edges, and such readings hang in the air.
    """
    padded, (h, w) = np.pad(depth, 1), depth.shape
    beside = [padded[1 + r : 1 + r + h, 1 + c : 1 + c + w] for r in (-1, 0, 1) for c in (-1, 0, 1) if r or c]
    near = sum((np.abs(other - depth) < SAME_SURFACE).astype(np.uint8) for other in beside)
    return np.asarray(near >= NEIGHBOURS)


def highest(heights: Floats, strays: int = STRAYS) -> float:
    """Return the greatest height among seen points (N,) [m], −inf where there are fewer than ``strays``."""
    return float(np.partition(heights, -strays)[-strays]) if len(heights) >= strays else -np.inf
