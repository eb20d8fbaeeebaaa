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

import cv2
import numpy as np

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.scenario import Sensor
from grasp_bench.scene.rendering import Picture


def sense(picture: Picture, intrinsics: Intrinsics, sensor: Sensor, rng: np.random.Generator) -> RgbdImage:
    """The image a real camera might have delivered of a perfect one.

    Args:
        picture: perfect (H, W) image.
        intrinsics: of the image.
        sensor: parameters.
        rng: the trial's sensor stream; how many numbers are drawn does not depend on the image.
    """
    depth = picture.depth
    h, w = depth.shape
    axial = rng.standard_normal((h, w), dtype=np.float32)
    jitter = rng.standard_normal((2, h, w), dtype=np.float32)
    mix, mixed_at, drop, speckle = (rng.random((h, w), dtype=np.float32) for _ in range(4))
    color_noise = rng.standard_normal((h, w, 3), dtype=np.float32)

    far = np.where(depth > 0, depth, np.float32(sensor.maximum_range + 1))
    low, high = cv2.erode(far, np.ones((3, 3))), cv2.dilate(far, np.ones((3, 3)))
    edge = high - low > sensor.edge_step
    jitter *= np.float32(sensor.lateral_sigma_px)
    rows, columns = np.rint(jitter, out=jitter).astype(np.int32)
    rows += np.arange(h, dtype=np.int32)[:, None]
    columns += np.arange(w, dtype=np.int32)
    source = np.clip(rows, 0, h - 1) * w + np.clip(columns, 0, w - 1)
    measured = far.ravel()[source]
    mixed = edge & (mix < sensor.mixed_pixels)
    between = low + mixed_at * (np.minimum(high, np.float32(sensor.maximum_range)) - low)
    measured = np.where(mixed, between, measured)
    sigma = sensor.axial_sigma + sensor.axial_sigma_per_metre * np.maximum(measured - sensor.axial_onset, 0)
    measured += sigma.astype(np.float32) * axial

    grazing = picture.cosine < np.cos(np.radians(sensor.grazing_angle_deg))
    lost = (edge & (drop < sensor.edge_dropout)) | (grazing & (drop < sensor.grazing_dropout))
    lost |= (speckle < sensor.speckle_dropout) | (measured < sensor.minimum_range)
    lost |= measured > sensor.maximum_range
    color_noise *= np.float32(sensor.rgb_sigma)
    color_noise += picture.rgb
    noisy = np.clip(np.rint(color_noise, out=color_noise), 0, 255).astype(np.uint8)
    return RgbdImage(noisy, np.where(lost, np.float32(0), measured), intrinsics)
