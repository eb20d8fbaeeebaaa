"""A predictor that fuses the depth image into a TSDF, as the Volumetric Grasping Network and its like take.

The grid is a cube of 30 cm in 40³ voxels that stands on the table below the image's middle. A network of
your own takes it (1, 40, 40, 40) and returns quality (40, 40, 40), rotations (40, 40, 40, 4) as quaternions
x, y, z, w with z the approach and x the jaws, and openings (40, 40, 40) in voxels; its weights are yours:

    cd examples
    grasp-bench run --trials 20 --predictor 10_tsdf_predictor:Fused
    grasp-bench run --trials 20 --predictor '10_tsdf_predictor:Fused(network="my_net:run")'

Without one, geometry alone says where: the middle of what stands in the grid, jaws across it, from above.
That lifts 16 of 20.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from grasp_bench import GraspPose, RgbdImage
from grasp_bench.predictors.pointcloud import Plane, table_plane

SIDE, VOXELS = 0.30, 40
VOXEL = SIDE / VOXELS
TRUNCATION = 4 * VOXEL
MOST = 50


class Fused:
    def __init__(self, network: str | None = None) -> None:
        module, _, function = (network or "").partition(":")
        self.network: Callable | None = (
            getattr(importlib.import_module(module), function) if network else None
        )

    def begin(self, rng: np.random.Generator) -> None:
        self.rng = rng

    def predict(self, image: RgbdImage) -> list[GraspPose]:
        rng = getattr(self, "rng", None) or np.random.default_rng(0)
        plane = table_plane(image, rng)
        if plane is None:
            return []
        turn, corner = cube(plane)
        grid = tsdf(image, turn, corner)
        found = from_above(grid) if self.network is None else from_network(grid, self.network)
        return [  # from the cube's frame to the camera's
            GraspPose(corner + turn @ (VOXEL * place), turn @ rotation, VOXEL * opening, quality)
            for place, rotation, opening, quality in found
        ]


def cube(plane: Plane) -> tuple[np.ndarray, np.ndarray]:
    """Rotation (3, 3) and corner (3,) in the camera's frame of a cube on the table, its z against gravity."""
    z = plane.normal
    x = np.array([1.0, 0.0, 0.0]) - z[0] * z
    x /= np.linalg.norm(x)
    turn = np.column_stack([x, np.cross(z, x), z])
    middle = np.array([0.0, 0.0, plane.offset / z[2]])  # where the optical axis meets the table
    return turn, middle - turn @ [SIDE / 2, SIDE / 2, 0.0]


def tsdf(image: RgbdImage, turn: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """Truncated signed distance (40, 40, 40) along the view, ½ at a surface, 0 where nothing is known."""
    places = VOXEL * (np.stack(np.meshgrid(*3 * [np.arange(VOXELS)], indexing="ij"), -1) + 0.5)
    points = corner + places @ turn.T
    u, v = np.moveaxis(np.floor(image.intrinsics.project(points)).astype(int), -1, 0)
    height, width = image.depth.shape
    inside = (u >= 0) & (u < width) & (v >= 0) & (v < height) & (points[..., 2] > 0)
    depth = np.where(inside, image.depth[v.clip(0, height - 1), u.clip(0, width - 1)], 0)
    distance = depth - points[..., 2]
    known = (depth > 0) & (distance > -TRUNCATION)
    return np.where(known, 0.5 + 0.5 * np.clip(distance / TRUNCATION, -1, 1), 0.0).astype(np.float32)


def from_network(grid: np.ndarray, network: Callable) -> list[tuple]:
    """What a network says, best first."""
    quality, rotations, openings = network(grid[None])
    best = np.argsort(-quality, axis=None)[:MOST]
    voxels = np.stack(np.unravel_index(best, quality.shape), -1)
    return [
        (v + 0.5, Rotation.from_quat(rotations[tuple(v)]).as_matrix(), openings[tuple(v)], quality[tuple(v)])
        for v in voxels
    ]


def from_above(grid: np.ndarray) -> list[tuple]:
    """The middle of what stands in the grid, jaws across it."""
    surface = (grid > 0.3) & (grid < 0.7)
    surface[:, :, :2] = False  # the table
    columns = np.argwhere(surface.any(2))
    if len(columns) < 3:
        return []
    top = float(np.percentile(np.argwhere(surface)[:, 2], 95)) + 0.5
    middle, spread = columns.mean(0) + 0.5, np.cov(columns.T) + 1e-6 * np.eye(2)
    across = np.linalg.eigh(spread)[1][:, 0]
    x, z = np.array([*across, 0.0]), np.array([0.0, 0.0, -1.0])
    tip = max(top - 0.025 / VOXEL, 0.004 / VOXEL)
    return [(np.array([*middle, tip]), np.column_stack([x, np.cross(z, x), z]), 0.08 / VOXEL, 0.5)]
