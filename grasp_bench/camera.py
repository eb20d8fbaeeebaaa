"""The pinhole camera, and the RGB-D image every predictor is given.

Camera frames have OpenCV axes: x right, y down, z forward. Pixel centres lie at
integers + 0.5, so the left edge of the image is u = 0 and the right edge u = width.
Depth is z-depth (distance along the optical axis, not range) in metres, 0 where invalid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grasp_bench.system.arrays import Floats

FARTHEST = 20.0
"""Median depth above which an image cannot be in metres [m]."""


@dataclass(frozen=True)
class Intrinsics:
    """Pinhole intrinsics without distortion.

    Attributes:
        width, height: image size in pixels.
        fx, fy: focal lengths in pixels.
        cx, cy: principal point in pixels (image edge = 0, so the middle of a 640 px row is 320).
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise ValueError(f"image size must be positive, got {self.width}×{self.height}")
        if not (np.isfinite([self.fx, self.fy, self.cx, self.cy]).all() and self.fx > 0 and self.fy > 0):
            raise ValueError(f"focal lengths must be positive and finite, got fx={self.fx}, fy={self.fy}")

    @classmethod
    def from_fov(cls, width: int, height: int, horizontal_fov: float) -> Intrinsics:
        """Make intrinsics of square pixels and a centred principal point; ``horizontal_fov`` in radians."""
        f = width / 2 / np.tan(horizontal_fov / 2)
        return cls(width, height, float(f), float(f), width / 2, height / 2)

    @property
    def matrix(self) -> Floats:
        """The 3×3 matrix K."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]])

    @property
    def vertical_fov(self) -> float:
        """Vertical field of view in radians of a centred principal point."""
        return float(2 * np.arctan(self.height / 2 / self.fy))

    def project(self, points: ArrayLike) -> Floats:
        """Project camera-frame points (…, 3) [m] to pixels (…, 2)."""
        p = np.asarray(points, dtype=float)
        return np.stack(
            [self.fx * p[..., 0] / p[..., 2] + self.cx, self.fy * p[..., 1] / p[..., 2] + self.cy], axis=-1
        )

    def deproject(self, pixels: ArrayLike, depth: ArrayLike) -> Floats:
        """Turn pixels (…, 2) with z-depth (…) [m] into camera-frame points (…, 3) [m]."""
        uv, z = np.asarray(pixels, dtype=float), np.asarray(depth, dtype=float)
        return np.stack(
            [(uv[..., 0] - self.cx) / self.fx * z, (uv[..., 1] - self.cy) / self.fy * z, z], axis=-1
        )

    def rays(self) -> Floats:
        """Return camera-frame directions (height, width, 3) through all pixel centres, with z = 1;
        read-only."""
        return _rays(self)


@lru_cache(maxsize=4)
def _rays(camera: Intrinsics) -> Floats:
    """Return the rays, read-only, because all who ask for the same camera share them."""
    u, v = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    rays = camera.deproject(np.stack([u, v], axis=-1), np.ones((camera.height, camera.width)))
    rays.flags.writeable = False
    return rays


@dataclass(frozen=True)
class CameraPose:
    """Where a camera stands in the world.

    Attributes:
        position: (3,) world coordinates of the optical centre [m].
        rotation: (3, 3) whose columns are the camera's x, y, z axes in the world.
    """

    position: Floats
    rotation: Floats

    @classmethod
    def look_at(cls, position: ArrayLike, target: ArrayLike, image_up: ArrayLike) -> CameraPose:
        """Put a camera at ``position`` that looks at ``target``, the image's upper edge towards ``image_up``.

        Raises:
            ValueError: when target and position coincide, or ``image_up`` is along the view.
        """
        eye = np.asarray(position, dtype=float)
        z = np.asarray(target, dtype=float) - eye
        if np.linalg.norm(z) < 1e-9:
            raise ValueError("camera position and target coincide")
        z /= np.linalg.norm(z)
        x = np.cross(z, np.asarray(image_up, dtype=float))
        if np.linalg.norm(x) < 1e-6:
            raise ValueError("image_up is parallel to the viewing direction")
        x /= np.linalg.norm(x)
        return cls(eye, np.column_stack([x, np.cross(z, x), z]))

    def moved(self, shift: ArrayLike, turn: ArrayLike) -> CameraPose:
        """Return the pose moved by ``shift`` (3,) [m] and turned by the rotation vector ``turn`` (3,) [rad],
        both in world coordinates, about its optical centre."""
        vector = np.asarray(turn, dtype=float)
        angle = float(np.linalg.norm(vector))
        x, y, z = vector / max(angle, 1e-300)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])  # Rodrigues' formula
        rotation = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
        return CameraPose(self.position + np.asarray(shift, dtype=float), rotation @ self.rotation)

    def to_world(self, points: ArrayLike) -> Floats:
        """Turn camera-frame points (…, 3) into world points (…, 3)."""
        return np.asarray(points, dtype=float) @ self.rotation.T + self.position

    def to_camera(self, points: ArrayLike) -> Floats:
        """Turn world points (…, 3) into camera-frame points (…, 3)."""
        return (np.asarray(points, dtype=float) - self.position) @ self.rotation


@dataclass(frozen=True)
class RgbdImage:
    """A registered colour and depth image.

    Attributes:
        rgb: (H, W, 3) uint8.
        depth: (H, W) float32 z-depth in metres, 0 where the camera measured nothing.
        intrinsics: those of the camera, for images of this size.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    intrinsics: Intrinsics

    def __post_init__(self) -> None:
        h, w = self.intrinsics.height, self.intrinsics.width
        if self.rgb.shape != (h, w, 3) or self.rgb.dtype != np.uint8:
            raise ValueError(f"rgb must be ({h}, {w}, 3) uint8, got {self.rgb.shape} {self.rgb.dtype}")
        if self.depth.shape != (h, w) or self.depth.dtype != np.float32:
            raise ValueError(f"depth must be ({h}, {w}) float32, got {self.depth.shape} {self.depth.dtype}")
        if not np.isfinite(self.depth).all() or (self.depth < 0).any():
            raise ValueError(
                "depth must be finite and not negative (0 marks invalid pixels); "
                "replace NaN by 0 before building an RgbdImage"
            )
        if self.depth.max(initial=0) > FARTHEST and (middle := np.median(self.depth[self.valid])) > FARTHEST:
            raise ValueError(
                f"depth must be in metres, but the middle of its values is {middle:.4g}: it seems to be in "
                "millimetres; divide it by 1000"
            )

    @property
    def valid(self) -> NDArray[np.bool_]:
        """(H, W) mask of the pixels whose depth was measured."""
        return self.depth > 0

    @property
    def points(self) -> NDArray[np.float32]:
        """(H, W, 3) point of each pixel in the camera's frame [m], NaN where nothing was measured."""
        found = (self.intrinsics.rays() * self.depth[..., None]).astype(np.float32)
        found[~self.valid] = np.nan
        return found

    def cloud(self, within: NDArray[np.bool_] | None = None) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
        """Return the measured points (N, 3) in the camera's frame [m], row by row, and their colours (N, 3).

        Args:
            within: (H, W) mask of the pixels that are wanted; all by default.
        """
        chosen = self.valid if within is None else self.valid & within
        return self.points[chosen], self.rgb[chosen]


@dataclass(frozen=True)
class View:
    """One of several pictures of a scene.

    Attributes:
        image: the picture.
        position, rotation: where its camera stands in the frame of the first one's, (3,) [m] and (3, 3), as
            the robot believes.
    """

    image: RgbdImage
    position: Floats
    rotation: Floats


def fused(views: Sequence[View]) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Return the points (N, 3) [m] of all views in the first camera's frame, and their colours (N, 3)."""
    clouds = [view.image.cloud() for view in views]
    places = [
        points @ view.rotation.T + view.position for view, (points, _) in zip(views, clouds, strict=True)
    ]
    return np.concatenate(places).astype(np.float32), np.concatenate([colours for _, colours in clouds])
