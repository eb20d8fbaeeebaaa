"""Random views of a scene: rotation, mirror, scale, shift, crop and colour (paper, section 4.1).

All geometry of one sample is a single affine map from pixels of the scene to pixels of the
crop, applied once to every array. Coordinates have the image's edge at 0, x right, y down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from grasp_bench.grasps import Grasp, GraspMaps, wrap_angle
from grasp_bench.learning.data.scenes import DEPTH_UNIT, Scene, unpacked
from grasp_bench.system.arrays import Floats

USUAL = 1.1
"""Greatest magnification of most views."""
NEAR = 1 / 3
"""Share of views that are magnified more, where that is asked for."""


@dataclass(frozen=True)
class View:
    """How a crop is taken.

    Attributes:
        rotation: turn of the picture's content about the scene's middle, counter-clockwise [rad].
        mirror: left and right exchanged, before the rotation.
        scale: magnification.
        shift: (x, y) by which the content is moved [px of the crop], after all else.
    """

    rotation: float = 0.0
    mirror: bool = False
    scale: float = 1.0
    shift: tuple[float, float] = (0.0, 0.0)

    def matrix(self, size: int, crop: int) -> Floats:
        """Return the map (2, 3) from pixels of the scene (size²) to pixels of the crop (crop²)."""
        c, s = self.scale * math.cos(self.rotation), self.scale * math.sin(self.rotation)
        linear = np.array([[c, s], [-s, c]])
        if self.mirror:
            linear[:, 0] *= -1
        offset = crop / 2 + np.array(self.shift) - linear @ np.full(2, size / 2)
        return np.column_stack([linear, offset])

    def angle(self, angle: NDArray | float) -> NDArray | float:
        """Turn jaw angle(s) in the scene into those in the crop, not wrapped."""
        return self.rotation - angle if self.mirror else self.rotation + angle

    def grasp(self, grasp: Grasp, size: int, crop: int) -> Grasp:
        """Turn a grasp of the scene into pixels of the crop."""
        x, y = self.matrix(size, crop) @ (grasp.x, grasp.y, 1.0)
        return Grasp(
            float(x),
            float(y),
            wrap_angle(float(self.angle(grasp.angle))),
            grasp.width * self.scale,
            grasp.quality,
        )


def random_view(rng: np.random.Generator, zoom: float = USUAL) -> View:
    """Draw any rotation, mirrored or not, scale 0.9 to 1.1, shift up to 24 px.

    With a ``zoom`` above 1.1 every third view is magnified by 1.1 to that instead, as seen from nearer.
    """
    rotation, mirror = rng.uniform(-math.pi, math.pi), bool(rng.integers(2))
    near = zoom > USUAL and rng.random() < NEAR
    scale = rng.uniform(USUAL, zoom) if near else rng.uniform(0.9, USUAL)
    return View(rotation, mirror, scale, (rng.uniform(-24, 24), rng.uniform(-24, 24)))


def crop_scene(
    scene: Scene, view: View, crop: int = 224
) -> tuple[NDArray[np.uint8], NDArray[np.float32], GraspMaps]:
    """Cut a view out of a scene.

    Magnifying by s is what a camera nearer by the factor s sees: the depth of the table is
    divided by s and heights above it stay, so that widths and heights keep their metres.
    Outside of the scene, colour goes on as at its border, depth is invalid, quality 0.

    Returns:
        rgb (crop, crop, 3), depth (crop, crop) in metres with 0 = invalid, and the labels.
    """
    matrix = view.matrix(scene.size, crop)
    # OpenCV has pixel centres at integers.
    matrix[:, 2] += matrix[:, :2] @ (0.5, 0.5) - 0.5

    def warp(array: NDArray, flags: int, border: int) -> NDArray:
        return cv2.warpAffine(array, matrix, (crop, crop), flags=flags, borderMode=border)

    rgb = warp(scene.rgb, cv2.INTER_LINEAR, cv2.BORDER_REPLICATE)
    # All that takes its nearest value is moved at once, by its bits.
    bits = (
        scene.depth,
        scene.quality.astype(np.uint16),
        scene.angle.view(np.uint16),
        scene.width.view(np.uint16),
    )
    moved = cv2.split(warp(cv2.merge(bits), cv2.INTER_NEAREST, cv2.BORDER_CONSTANT))
    depth = unpacked(moved[0].view(np.uint16))
    valid = depth > 0
    if view.scale != 1 and valid.any():
        nearer = np.median(depth[valid][::4]) * (1 - 1 / view.scale)
        depth = np.where(valid, np.maximum(depth - nearer, DEPTH_UNIT), 0).astype(np.float32)
    # The stored quality ranks grasps and is no probability: most of those below 0.3 hold in physics.
    # Its root keeps the order, and keeps low but sound grasps (thin things) apart from the background.
    labels = GraspMaps(*np.zeros((4, crop, crop), np.float32))
    on = np.nonzero(moved[1])
    double = 2 * view.angle(moved[2][on].view(np.float16).astype(np.float32))
    labels.quality[on] = np.sqrt(moved[1][on].astype(np.float32) / np.float32(255))
    labels.sin2[on], labels.cos2[on] = np.sin(double), np.cos(double)
    labels.width[on] = moved[3][on].view(np.float16).astype(np.float32) * np.float32(view.scale)
    return rgb, depth, labels


def jitter_colour(rgb: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Change brightness (±25), contrast (0.7 to 1.3) and white balance (each channel ±10 %) at random."""
    gain = rng.uniform(0.7, 1.3) * rng.uniform(0.9, 1.1, 3)
    offset = 128 * (1 - gain) + rng.uniform(-25, 25)
    table = np.clip(np.arange(256)[:, None] * gain + offset, 0, 255).astype(np.uint8)
    return cv2.LUT(rgb, table[:, None, :]).astype(np.uint8, copy=False)


def jitter_depth(depth: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Add a random offset of up to 5 cm; holes are left as they are."""
    offset = np.float32(rng.uniform(-0.05, 0.05))
    return np.where(depth > 0, np.maximum(depth + offset, np.float32(DEPTH_UNIT)), np.float32(0))
