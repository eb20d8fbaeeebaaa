"""Depth images as points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import CameraPose, RgbdImage
from grasp_bench.scenario.sections import Table


def point_cloud(
    image: RgbdImage, pose: CameraPose, step: int = 2
) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Return world points (N, 3) [m] and colours (N, 3) of every ``step``-th valid pixel of such rows.

    ``pose`` is the camera's as the robot believes it.
    """
    intrinsics = image.intrinsics
    u, v = np.meshgrid(np.arange(0, intrinsics.width, step), np.arange(0, intrinsics.height, step))
    depth = image.depth[v, u]
    valid = depth > 0
    pixels = np.stack([u[valid] + 0.5, v[valid] + 0.5], axis=-1)
    return pose.to_world(intrinsics.deproject(pixels, depth[valid])), image.rgb[v, u][valid]


def on_table(points: NDArray[np.float64], table: Table) -> NDArray[np.bool_]:
    """Return (N,) which of (N, 3) world points [m] lie on or over the table, not beside it."""
    aside = np.abs(points[:, :2] - np.array(table.center))
    inside = aside <= np.array(table.size) / 2
    return inside[:, 0] & inside[:, 1]
