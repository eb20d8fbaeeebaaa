"""What goes into a network and what comes out, the same in training and in use."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from grasp_bench.grasps import Grasp, GraspMaps
from grasp_bench.networks.spec import Kind

if TYPE_CHECKING:
    import torch

WIDTH_SCALE = 150.0
"""Networks give widths in units of this many pixels (GG-CNN's convention)."""

HEIGHT_SCALE = 0.1
"""Depth enters as height over the median, in units of this many metres."""


def fill_holes(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the (H, W) depth with zeros replaced by the nearest measured value (all zeros stay zero).

    Invents no values, and takes about a quarter of the time of the Navier–Stokes inpainting
    of GG-CNN's code. Nearest up to the error of a 5×5 distance mask.
    """
    holes = depth <= 0
    if not holes.any() or holes.all():
        return depth
    label = np.asarray(
        cv2.distanceTransformWithLabels(
            holes.astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
        )[1],
        dtype=np.int32,
    )
    value = np.zeros(int(label.max()) + 1, np.float32)
    value[label[~holes]] = depth[~holes]
    return value.take(label)


def encode_depth(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Turn (H, W) metres, 0 = invalid, into height over the median in units of 0.1 m, clipped to [−1, 3].

    The GG-CNN lineage clips (d − mean) in metres to [−1, 1]: there a cup 5 cm high is a step
    of 0.05 beside colours of ±0.5, and large objects move the zero. The median of a crop is
    the table wherever the objects cover less than half of it.
    """
    filled = fill_holes(depth)
    table = np.median(filled[::2, ::2])  # of every fourth pixel: a quarter of the time
    return np.clip((table - filled) / HEIGHT_SCALE, -1.0, 3.0).astype(np.float32)


def encode_rgb(rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Turn (H, W, 3) colours into (3, H, W) in [−1, 1] with the image's mean taken off."""
    planes = np.ascontiguousarray(rgb.transpose(2, 0, 1)).astype(np.float32)
    planes /= np.float32(255)
    planes -= planes.mean()
    return planes


def encode_rgd(rgb: NDArray[np.uint8], depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Turn (H, W, 3) colours and (H, W) metres into (3, H, W): red, green and depth as one picture.

    Redmon & Angelova (2015) and Chu et al. (2018) put depth, scaled to 0 … 255, in the place of blue, so that
    networks for pictures take it, and Redmon takes 144 off all values. Neither says the scale of depth: here
    heights from 2 cm below the table to 20 cm above it, the same in all images, so that low things keep
    their contrast.
    """
    height = HEIGHT_SCALE * encode_depth(depth)
    shown = np.clip((height + 0.02) / 0.22, 0.0, 1.0)
    planes = np.stack([*rgb.transpose(2, 0, 1)[:2].astype(np.float32) / 255, shown]) - 144 / 255
    return planes.astype(np.float32)


def to_input(rgb: NDArray[np.uint8], depth: NDArray[np.float32], kind: Kind = "rgbd") -> NDArray[np.float32]:
    """Return the network input (C, H, W) of an image.

    Args:
        rgb: (H, W, 3).
        depth: (H, W) metres, 0 where invalid.
        kind: 'rgbd' (depth first), 'rgb', 'depth', or 'rgd' (depth instead of blue).
    """
    if kind == "rgb":
        return encode_rgb(rgb)
    if kind == "rgd":
        return encode_rgd(rgb, depth)
    height = encode_depth(depth)[None]
    return height if kind == "depth" else np.concatenate([height, encode_rgb(rgb)])


def grasps_from_output(output: torch.Tensor, count: int) -> list[Grasp]:
    """Return at most ``count`` grasps, best first, of one image's output: maps (4, H, W), or rows (N, 6)."""
    if output.ndim == 3:
        return maps_from_output(output).smoothed().peaks(count)
    from grasp_bench.networks.rows import grasps_from_rows

    return grasps_from_rows(output, count)


def maps_from_output(output: torch.Tensor) -> GraspMaps:
    """Turn one image's (4, H, W) or (1, 4, H, W) network output into maps with widths in pixels."""
    q, sin2, cos2, width = output.detach().float().cpu().reshape(4, *output.shape[-2:]).numpy()
    return GraspMaps(np.clip(q, 0.0, 1.0), sin2, cos2, np.maximum(width * np.float32(WIDTH_SCALE), 0.0))


def targets_from_maps(maps: GraspMaps) -> NDArray[np.float32]:
    """Return what a network should have put out for ``maps``: (4, H, W)."""
    width = maps.width / np.float32(WIDTH_SCALE)
    return np.stack([maps.quality, maps.sin2, maps.cos2, width]).astype(np.float32, copy=False)
