"""A model of what an RGB-D camera makes of a perfect picture.

Terms, each seeded and each with its parameters in the scenario (:class:`grasp_bench.scenario.sensors.Sensor`,
whose module names the sources of the presets). In the order in which they are applied to depth:

* *Lateral jitter*: every pixel looks ``lateral_sigma_px`` beside where it should.
* *Mixed pixels*: beside a depth step larger than ``edge_step`` a pixel sees both surfaces and reports, with
  probability ``mixed_pixels``, something between them.
* *Bias*: ``bias`` + ``bias_per_metre`` · d is added to every reading.
* *Axial noise*: Gaussian, σ = ``axial_sigma`` + ``axial_sigma_per_metre`` · x
  + ``axial_sigma_per_metre2`` · x² with x = max(d − ``axial_onset``, 0).
* *Steps*: 1/d is rounded to multiples of ``depth_step_per_metre2``, as cameras that measure disparity do; the
  steps of d are that times d².
* *Dropout*: readings are lost beside steps, at grazing incidence, out of range and at random (speckle), anew
  in every frame. Lost in every frame alike, in patches of ``patch_px`` pixels, are readings of dark, shiny
  and distant surfaces, with probability ``dark_dropout`` · (1 − albedo/``dark_albedo``),
  ``shiny_dropout`` · (1 − roughness/``shiny_roughness``) and
  ``distant_dropout`` · (d − ``distant_onset``)/(``maximum_range`` − ``distant_onset``), each clipped to
  0 … 1. The albedo is that of the visible colour: what a surface reflects in the near infrared is not known.
* *Whole pictures*: what the sensor's projector or second eye, ``projector_baseline`` beside it, does not see,
  is lost; windows of 5 · ``window_px`` pixels lose what is thin; light by way of nearer things within
  ``multipath_reach_px`` adds ``multipath`` metres a metre; where the picture does not vary,
  ``textureless_dropout`` of the patches is lost. ``filled`` closes all holes at the end.
* *Average*: of ``frames`` pictures, over the frames that measured; a pixel needs half of them.

Colour: ``exposure`` · white balance · (light · c + noise) with variance ``rgb_sigma``² + ``rgb_shot_noise`` ·
light · c, rounded and clipped to 0 … 255. Exposure and the balance of each channel vary from picture to
picture by a factor exp(σ n), n standard normal. A longer exposure brightens a dim scene and its noise alike.
``auto_exposure`` brings the mean of the picture to that share of white before. Last come blur and JPEG.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.scenario.sensors import Sensor
from grasp_bench.scene import sensor_effects as effects
from grasp_bench.scene.rendering import Picture
from grasp_bench.scene.surfaces import Surfaces

NORMAL = ndtri((np.arange(65536) + 0.5) / 65536).astype(np.float32)
"""Standard normal numbers, all as likely: quantiles in the middle of 65,536 equal parts, −4.3 to 4.3."""

Image = NDArray[np.float32]
Mask = NDArray[np.bool_]


def sense(
    picture: Picture,
    intrinsics: Intrinsics,
    sensor: Sensor,
    rng: np.random.Generator,
    surfaces: Surfaces | None = None,
    light: float = 1.0,
) -> RgbdImage:
    """Return the image a real camera might have delivered of a perfect one.

    Args:
        picture: the perfect (H, W) image.
        rng: the trial's sensor stream; how many numbers are drawn does not depend on the image, and
            the terms that came later have streams of their own (children of this one).
        surfaces: albedo and roughness of the picture's geoms; without them nothing is dark or shiny.
        light: how bright the scene is, 1 for the light the picture was made in.
    """
    tone, pattern, *later = rng.spawn(1 + sensor.frames)
    perfect = picture
    if sensor.window_px or sensor.multipath:
        picture = picture._replace(depth=_spread(picture.depth, sensor))
    measured, lost = _frame(picture, sensor, rng)
    color_noise = _bits(rng, (*picture.depth.shape, 3))
    if later:
        total, count = np.where(lost, 0, measured).astype(np.float64), (~lost).astype(np.int32)
        for stream in later:
            another, gone = _frame(picture, sensor, stream)
            total += np.where(gone, 0, another)
            count += ~gone
        lost = 2 * count < sensor.frames
        measured = (total / np.maximum(count, 1)).astype(np.float32)
    if sensor.dark_dropout or sensor.shiny_dropout or sensor.distant_dropout:
        lost = lost | _unreflected(picture, sensor, surfaces, pattern)
    if sensor.projector_baseline:
        lost = lost | effects.projector_shadow(perfect.depth, intrinsics.fx, sensor.projector_baseline)
    if sensor.textureless_dropout:
        plain = effects.textureless(picture.rgb)
        lost = lost | (_patches(picture.depth.shape, sensor, tone) < sensor.textureless_dropout * plain)
    depth = np.where(lost, np.float32(0), measured)
    if sensor.filled:
        depth = effects.filled(depth)
    rgb = _color(picture.rgb, sensor, color_noise, light, tone)
    if sensor.rgb_blur_px:
        rgb = cv2.GaussianBlur(rgb, (0, 0), sensor.rgb_blur_px).astype(np.uint8, copy=False)
    if sensor.jpeg_quality:
        rgb = effects.compressed(rgb, sensor.jpeg_quality)
    return RgbdImage(rgb, depth, intrinsics)


def _spread(depth: Image, sensor: Sensor) -> Image:
    """Return what reaches a sensor whose windows and whose light take in more than a pixel."""
    if sensor.window_px:
        depth = effects.matched(depth, sensor.window_px)
    if sensor.multipath:
        depth = depth + effects.echoes(depth, sensor.multipath, sensor.multipath_reach_px)
    return depth


def _patches(shape: tuple[int, ...], sensor: Sensor, rng: np.random.Generator) -> Image:
    """Return uniform numbers (H, W), the same all over each patch."""
    coarse = rng.random([-(-n // sensor.patch_px) for n in shape], dtype=np.float32)
    return coarse.repeat(sensor.patch_px, 0).repeat(sensor.patch_px, 1)[: shape[0], : shape[1]]


def _frame(picture: Picture, sensor: Sensor, rng: np.random.Generator) -> tuple[Image, Mask]:
    """Return the depth of one frame [m], and which pixels of it hold no reading."""
    depth = picture.depth
    h, w = depth.shape
    axial = NORMAL[_bits(rng, (h, w))]
    jitter = _bits(rng, (2, h, w))
    mix, mixed_at, drop, speckle = (rng.random((h, w), dtype=np.float32) for _ in range(4))

    far = np.where(depth > 0, depth, np.float32(sensor.maximum_range + 1))
    low, high = cv2.erode(far, np.ones((3, 3))), cv2.dilate(far, np.ones((3, 3)))
    edge = high - low > sensor.edge_step
    measured = far.copy()
    if sensor.lateral_sigma_px:
        aside = np.rint(np.float32(sensor.lateral_sigma_px) * NORMAL).astype(np.int8)[jitter]
        moved = np.flatnonzero(aside.any(axis=0))  # few, where the sigma is a fraction of a pixel
        rows, columns = np.divmod(moved, w)
        down, right = aside.reshape(2, -1)[:, moved]
        source = np.clip(rows + down, 0, h - 1) * w + np.clip(columns + right, 0, w - 1)
        measured.ravel()[moved] = far.ravel()[source]
    mixed = edge & (mix < sensor.mixed_pixels)
    if mixed.any():
        nearest, farthest = low[mixed], np.minimum(high[mixed], np.float32(sensor.maximum_range))
        measured[mixed] = nearest + mixed_at[mixed] * (farthest - nearest)
    beyond = np.maximum(measured - np.float32(sensor.axial_onset), 0)
    sigma = np.float32(sensor.axial_sigma) + np.float32(sensor.axial_sigma_per_metre) * beyond
    if sensor.axial_sigma_per_metre2:
        sigma += np.float32(sensor.axial_sigma_per_metre2) * beyond**2
    if sensor.bias or sensor.bias_per_metre:
        measured = measured + np.float32(sensor.bias) + np.float32(sensor.bias_per_metre) * measured
    measured += sigma * axial
    if sensor.depth_step_per_metre2:
        disparity = np.rint(1 / (np.maximum(measured, 0.01) * sensor.depth_step_per_metre2))
        measured = (1 / (np.maximum(disparity, 1) * sensor.depth_step_per_metre2)).astype(np.float32)

    grazing = picture.cosine < np.cos(np.radians(sensor.grazing_angle_deg))
    lost = (edge & (drop < sensor.edge_dropout)) | (grazing & (drop < sensor.grazing_dropout))
    lost |= (speckle < sensor.speckle_dropout) | (measured < sensor.minimum_range)
    lost |= measured > sensor.maximum_range
    return measured, lost


def _unreflected(
    picture: Picture, sensor: Sensor, surfaces: Surfaces | None, rng: np.random.Generator
) -> Mask:
    """Return the pixels whose surface sends too little light back: dark, shiny or distant."""
    h, w = picture.depth.shape
    patch = sensor.patch_px
    coarse = rng.random((3, -(-h // patch), -(-w // patch)), dtype=np.float32)
    dark, shiny, distant = coarse.repeat(patch, axis=1).repeat(patch, axis=2)[:, :h, :w]
    lost = np.zeros((h, w), bool)
    if surfaces is not None:

        def share(of: NDArray[np.float64], threshold: float) -> NDArray[np.float64]:
            """Return (H, W) how far below the threshold the seen surface is, 0 to 1."""
            return np.append(np.clip(1 - of / threshold, 0, 1), 0)[picture.geom]  # nothing hit: the last

        lost |= dark < sensor.dark_dropout * share(surfaces.albedo, sensor.dark_albedo)
        lost |= shiny < sensor.shiny_dropout * share(surfaces.roughness, sensor.shiny_roughness)
    if sensor.distant_dropout:
        beyond = (picture.depth - sensor.distant_onset) / (sensor.maximum_range - sensor.distant_onset)
        lost |= distant < sensor.distant_dropout * np.clip(beyond, 0, 1)
    return lost


def _color(
    rgb: NDArray[np.uint8], sensor: Sensor, bits: NDArray[np.uint16], light: float, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """Return the colour picture; ``bits`` (H, W, 3) choose the normal numbers of its noise."""
    drawn = rng.standard_normal(4)
    gain = (
        sensor.exposure
        * np.exp(sensor.exposure_sigma * drawn[0])
        * np.array(sensor.white_balance)
        * np.exp(sensor.white_balance_sigma * drawn[1:])
    )
    if sensor.auto_exposure:
        gain = gain * effects.exposed(rgb, sensor.auto_exposure)
    if light == 1 and not sensor.rgb_shot_noise and (gain == 1).all():
        # Whole numbers with the same noise everywhere: rounding the sum is adding the rounded noise.
        noise = np.rint(np.float32(sensor.rgb_sigma) * NORMAL).astype(np.int16)[bits]
        noise += rgb
        return np.clip(noise, 0, 255, out=noise).astype(np.uint8)
    signal = rgb * np.float32(light)
    noise = NORMAL[bits]
    noise *= np.sqrt(np.float32(sensor.rgb_sigma**2) + np.float32(sensor.rgb_shot_noise) * signal)
    noise += signal
    noise *= gain.astype(np.float32)
    return np.clip(np.rint(noise, out=noise), 0, 255).astype(np.uint8)


def _bits(rng: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.uint16]:
    """Random indices into :data:`NORMAL`; drawing these costs a tenth of drawing normal numbers."""
    return rng.integers(0, len(NORMAL), shape, dtype=np.uint16)
