"""A model of what a time-of-flight depth camera adds to a perfect depth image.

Terms, each seeded and each with its parameter in the scenario:

* *Lateral jitter*: every pixel looks ``lateral_sigma_px`` beside where it should (Khoshelham
  & Elberink 2012 and the BlenderProc Azure Kinect recipe use a quarter pixel).
* *Axial noise*: Gaussian with σ = ``axial_sigma`` + ``axial_sigma_per_metre`` · max(d −
  ``axial_onset``, 0): 0.5 mm near, 1 mm at 1 m, of the order tests of the Azure Kinect found
  (Tölgyessy et al., Sensors 2021, 21(2):413).
* *Mixed pixels*: beside a depth step larger than ``edge_step`` a pixel sees both surfaces
  and reports, with probability ``mixed_pixels``, something between them.
* *Dropout*: at steps, at grazing incidence, out of range, and at random (speckle), the
  camera reports nothing (0).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.scenario import Sensor

Depth = NDArray[np.float32]


def incidence_cosine(depth: Depth, intrinsics: Intrinsics) -> Depth:
    """(H, W) cosine between viewing ray and surface normal, from a perfect depth image [m]."""
    rays = intrinsics.rays()
    points = rays * depth[..., None]
    du, dv = np.gradient(points, axis=1), np.gradient(points, axis=0)
    normal = np.cross(du, dv)
    length = np.linalg.norm(normal, axis=-1) * np.linalg.norm(rays, axis=-1)
    cosine = np.abs(np.einsum("hwc,hwc->hw", normal, rays)) / np.maximum(length, 1e-12)
    return cosine.astype(np.float32)


def sense(rgb: NDArray[np.uint8], depth: Depth, intrinsics: Intrinsics, sensor: Sensor,
          rng: np.random.Generator) -> RgbdImage:
    """The image a real camera might have delivered of a perfect one.

    Args:
        rgb: (H, W, 3) uint8.
        depth: (H, W) float32 perfect z-depth [m], 0 invalid.
        intrinsics: of the image.
        sensor: parameters.
        rng: the trial's sensor stream; the numbers drawn do not depend on the image.
    """
    h, w = depth.shape
    axial = rng.standard_normal((h, w), dtype=np.float32)
    jitter = rng.standard_normal((2, h, w), dtype=np.float32)
    mix, mixed_at, drop, speckle = (rng.random((h, w), dtype=np.float32) for _ in range(4))
    color_noise = rng.standard_normal((h, w, 3), dtype=np.float32)

    valid = depth > 0
    far = np.where(valid, depth, sensor.maximum_range + 1).astype(np.float32)
    low, high = minimum_filter(far, 3), maximum_filter(far, 3)
    edge = high - low > sensor.edge_step
    rows, columns = np.indices((h, w), dtype=np.float32)
    r = np.clip(np.rint(rows + sensor.lateral_sigma_px * jitter[0]), 0, h - 1).astype(np.intp)
    c = np.clip(np.rint(columns + sensor.lateral_sigma_px * jitter[1]), 0, w - 1).astype(np.intp)
    measured = far[r, c]
    mixed = edge & (mix < sensor.mixed_pixels)
    measured = np.where(mixed, low + mixed_at * (np.minimum(high, sensor.maximum_range) - low), measured)
    sigma = sensor.axial_sigma + sensor.axial_sigma_per_metre * np.maximum(measured - sensor.axial_onset, 0)
    measured = measured + sigma * axial

    grazing = incidence_cosine(depth, intrinsics) < np.cos(np.radians(sensor.grazing_angle_deg))
    lost = (edge & (drop < sensor.edge_dropout)) | (grazing & (drop < sensor.grazing_dropout))
    lost |= speckle < sensor.speckle_dropout
    lost |= ~valid[r, c] | (measured < sensor.minimum_range) | (measured > sensor.maximum_range)
    noisy_rgb = np.clip(np.rint(rgb + sensor.rgb_sigma * color_noise), 0, 255).astype(np.uint8)
    return RgbdImage(noisy_rgb, np.where(lost, 0, measured).astype(np.float32), intrinsics)
