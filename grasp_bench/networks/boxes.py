"""Boxes along the axes: anchors, overlap, offsets, suppression, and features of regions.

What two-stage detectors share (Ren et al., Faster R-CNN, NIPS 2015; He et al., Mask R-CNN, ICCV 2017).
torchvision has these, too, but its wheel on PyPI does not load beside PyTorch's wheel for CPUs. A box is
x1, y1, x2, y2 in pixels of the input, edge 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor

LARGEST_LOG = math.log(1000 / 16)
"""Sides are not multiplied by more than e to this."""


def anchors(height: int, width: int, stride: int, scales: Sequence[float], ratios: Sequence[float]) -> Tensor:
    """Return boxes (height · width · A, 4) about the middles of a map's cells.

    Args:
        scales: roots of the areas [px].
        ratios: height over width of each; A is their number times that of the scales.
    """
    shapes = torch.tensor([(s / r**0.5, s * r**0.5) for s in scales for r in ratios]) / 2
    y, x = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    middle = (torch.stack([x, y], dim=-1).view(-1, 1, 2) + 0.5) * stride
    return torch.cat([middle - shapes, middle + shapes], dim=-1).view(-1, 4)


def overlaps(a: Tensor, b: Tensor) -> Tensor:
    """Return intersection over union (…, N, M) of boxes (…, N, 4) and (…, M, 4)."""
    a, b = a[..., :, None, :], b[..., None, :, :]
    sides = (torch.minimum(a[..., 2:], b[..., 2:]) - torch.maximum(a[..., :2], b[..., :2])).clamp(min=0)
    common = sides.prod(-1)
    whole = (a[..., 2:] - a[..., :2]).prod(-1) + (b[..., 2:] - b[..., :2]).prod(-1) - common
    return common / whole.clamp(min=1e-6)


def box_offsets(boxes: Tensor, wanted: Tensor) -> Tensor:
    """Return what brings boxes (…, 4) to ``wanted``: shifts in their sides, and logs of ratios."""
    side, target = boxes[..., 2:] - boxes[..., :2], wanted[..., 2:] - wanted[..., :2]
    middle, aim = (boxes[..., 2:] + boxes[..., :2]) / 2, (wanted[..., 2:] + wanted[..., :2]) / 2
    side = side.clamp(min=1e-3)
    return torch.cat([(aim - middle) / side, (target.clamp(min=1e-3) / side).log()], dim=-1)


def moved(boxes: Tensor, offsets: Tensor) -> Tensor:
    """Undo :func:`box_offsets`."""
    side, middle = boxes[..., 2:] - boxes[..., :2], (boxes[..., 2:] + boxes[..., :2]) / 2
    aim = middle + offsets[..., :2] * side
    half = side * offsets[..., 2:].clamp(max=LARGEST_LOG).exp() / 2
    return torch.cat([aim - half, aim + half], dim=-1)


def suppressed(boxes: Tensor, scores: Tensor, overlap: float, most: int) -> Tensor:
    """Return the indices of at most ``most`` boxes (N, 4), best first, none of which overlaps a better one
    by more than ``overlap``."""
    order = scores.argsort(descending=True, stable=True)
    clash = overlaps(boxes[order], boxes[order]).cpu() > overlap
    alive = torch.ones(len(order), dtype=torch.bool)
    kept: list[int] = []
    while len(kept) < most and alive.any():
        best = int(alive.int().argmax())
        kept.append(best)
        alive &= ~clash[best]
        alive[best] = False
    return order[torch.tensor(kept, dtype=torch.long, device=order.device)]


def aligned(features: Tensor, boxes: Tensor, stride: float, size: int = 7) -> Tensor:
    """Return features of regions (B, K, C, size, size): means of 2×2 samples, bilinear, in each of its cells.

    Outside of the features there are zeros, as in ``grid_sample``. Regions lie along the axes, so that a
    sample's weights are a product of those of its row and its column; one multiplication of matrices then
    gives all regions, channels last. No gradient goes to the boxes.

    Args:
        features: (B, C, H, W), a pixel of it ``stride`` of the input.
        boxes: (B, K, 4).
    """
    b, c, h, w = features.shape
    boxes = boxes.detach() / stride
    steps = (torch.arange(2 * size, device=boxes.device) + 0.5) / (2 * size)

    def weights(low: Tensor, high: Tensor, cells: int) -> Tensor:
        place = low[..., None] + (high - low)[..., None] * steps
        middles = torch.arange(cells, device=boxes.device) + 0.5
        near = (1 - (place[..., None] - middles).abs()).clamp(min=0)
        return near.unflatten(2, (size, 2)).mean(3)  # (B, K, size, cells)

    rows = weights(boxes[..., 1], boxes[..., 3], h)
    columns = weights(boxes[..., 0], boxes[..., 2], w)
    both = (rows[:, :, :, None, :, None] * columns[:, :, None, :, None, :]).view(b, -1, h * w)
    found = both.to(features.dtype) @ features.flatten(2).transpose(1, 2)
    return found.view(b, -1, size, size, c).permute(0, 1, 4, 2, 3)
