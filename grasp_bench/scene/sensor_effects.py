"""What depth cameras do to whole pictures, each a function of a picture: shadows, windows, echoes, filling.

Which of them a sensor has, and how strongly, is in its section of the scenario
(:class:`grasp_bench.scenario.sensors.Sensor`).
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]
Mask = NDArray[np.bool_]

BESIDE = 0.25
"""Pixels that a second viewpoint sees nearer to each other than this hide each other."""


def projector_shadow(depth: Image, focal: float, baseline: float) -> Mask:
    """Return the pixels (H, W) that see what a second viewpoint does not: a projector or another camera.

    Args:
        depth: (H, W) perfect z-depth [m], 0 where nothing is.
        focal: focal length [px].
        baseline: how far the second viewpoint lies to the right of the camera, negative for the left [m].

    Along a row, what is at column u and depth z is at u' = u − f·b/z seen from there. Of a viewpoint to the
    right, a pixel is hidden where another one farther right has no greater u', and the other way round.
    """
    shift = focal * baseline / np.where(depth > 0, depth, np.inf)
    seen = np.arange(depth.shape[1], dtype=np.float32) - shift
    if baseline < 0:
        reached = np.maximum.accumulate(seen, axis=1)[:, :-1]
        return np.pad(reached > seen[:, 1:] - BESIDE, ((0, 0), (1, 0)))
    reached = np.minimum.accumulate(seen[:, ::-1], axis=1)[:, ::-1][:, 1:]
    return np.pad(reached < seen[:, :-1] + BESIDE, ((0, 0), (0, 1)))


def matched(depth: Image, size: int) -> Image:
    """Return the depth (H, W) as windows of 5·``size`` px see it: what is thinner than half of one is lost,
    and borders are rounded and moved."""
    h, w = depth.shape
    small = cv2.resize(depth, (-(-w // size), -(-h // size)), interpolation=cv2.INTER_NEAREST)
    return np.asarray(
        cv2.resize(cv2.medianBlur(small, 5), (w, h), interpolation=cv2.INTER_NEAREST), np.float32
    )


def echoes(depth: Image, strength: float, reach: float, limit: float = 0.03) -> Image:
    """Return what is added to the depth (H, W) where light came by way of nearer things around [m].

    Args:
        strength: metres for each metre by which the surroundings are nearer.
        reach: standard deviation of the surroundings' weight [px].
        limit: greatest addition [m].
    """
    nearer = depth - _smoothed(depth, reach)
    return np.where(depth > 0, np.clip(strength * nearer, 0, limit), 0).astype(np.float32)


def _smoothed(depth: Image, reach: float) -> Image:
    """Return the weighted mean of what is measured around each pixel; worked out at a quarter of the size."""
    h, w = depth.shape
    small = cv2.resize(depth, (max(w // 4, 1), max(h // 4, 1)), interpolation=cv2.INTER_NEAREST)
    sigma = max(reach / 4, 0.5)
    weight = cv2.GaussianBlur((small > 0).astype(np.float32), (0, 0), sigma)
    mean = cv2.GaussianBlur(small, (0, 0), sigma) / np.maximum(weight, 1e-6)
    return np.asarray(cv2.resize(mean, (w, h), interpolation=cv2.INTER_LINEAR), np.float32)


def textureless(rgb: NDArray[np.uint8], window: int = 9) -> Image:
    """Return (H, W) how plain a picture is around each pixel: 1 where nothing varies, 0 from a standard
    deviation of 4 grey levels on."""
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    mean = cv2.blur(grey, (window, window))
    variance = cv2.blur(grey * grey, (window, window)) - mean * mean
    return np.clip(1 - np.sqrt(np.maximum(variance, 0)) / 4, 0, 1).astype(np.float32)


def filled(depth: Image) -> Image:
    """Return the depth (H, W) with its holes filled smoothly from around, as inpainted data sets have it.

    Coarser and coarser means of what is measured fill what finer ones leave.
    """
    if not (depth > 0).any():
        return depth
    levels: list[tuple[Image, Image]] = [(depth, (depth > 0).astype(np.float32))]
    while (levels[-1][1] == 0).any() and min(levels[-1][0].shape) > 1:
        value, weight = levels[-1]
        h, w = value.shape
        half = ((w + 1) // 2, (h + 1) // 2)
        total = cv2.resize(value * weight, half, interpolation=cv2.INTER_AREA)
        known = cv2.resize(weight, half, interpolation=cv2.INTER_AREA)
        mean = (total / np.maximum(known, 1e-6)).astype(np.float32)
        levels.append((mean, (known > 0).astype(np.float32)))
    value = levels[-1][0]
    for finer, weight in reversed(levels[:-1]):
        coarse = cv2.resize(value, finer.shape[::-1], interpolation=cv2.INTER_LINEAR)
        value = np.where(weight > 0, finer, coarse)
    return np.asarray(value, np.float32)


def compressed(rgb: NDArray[np.uint8], quality: int) -> NDArray[np.uint8]:
    """Return the picture (H, W, 3) after JPEG of the given quality, 1 to 100."""
    done, data = cv2.imencode(".jpg", rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    assert done
    return np.ascontiguousarray(np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.uint8)[..., ::-1])


def exposed(rgb: NDArray[np.uint8], target: float) -> float:
    """Return the factor that brings the picture's mean to ``target`` (0 to 1), at most fourfold either way,
    and leaves nine tenths of it below white."""
    part = rgb[::4, ::4]
    wanted = min(255 * target / max(float(part.mean()), 1.0), 250 / max(float(np.percentile(part, 90)), 1.0))
    return float(np.clip(wanted, 0.25, 4.0))
