"""A reconstruction of the idea of Wu, Zhang & Fu's anchor-free grasp detector (IEEE TIE, 2022), after one
sentence on it in the HTC-Grasp paper. Not their network: neither code nor text could be read.

Known: it is fully convolutional, and a grasp is the closest upright rectangle, by regression, with a class
of its angle. The rest follows FCOS (Tian et al., ICCV 2019): a ResNet-18 with a pyramid's map of stride 8,
distances to the four sides by the exponential function, focal loss of 18 directions, GIoU, centreness.
A rectangle is turned to the nearer axis: upright it is width by height up to 45°, height by width beyond.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from grasp_bench.networks.oriented import cell_middles
from grasp_bench.networks.resnet import RESNET_18, Pyramid, convolved, start_kaiming
from grasp_bench.networks.rows import Detector

BINS = 18
ALPHA, GAMMA = 0.25, 2.0
PRIOR = 0.01
"""Chance of a class at the start."""
REACH = 0.75
"""A cell this near to a label's centre, in cells, is positive wherever the label's middle part ends."""


def upright_sides(rows: Tensor) -> Tensor:
    """Return width and height (…, 2) of rows turned to the nearer axis."""
    flat = rows[..., 2].cos().abs() >= math.sqrt(0.5)
    return torch.where(flat[..., None], rows[..., 3:5], rows[..., [4, 3]])


class Wu(Detector):
    """Three heads at each cell of a map of stride 8; 12,056,663 parameters.

    Args:
        inputs: number of channels of the image.
        blocks, width: of the trunk.
    """

    def __init__(self, inputs: int = 3, blocks: Sequence[int] = RESNET_18, width: int = 64) -> None:
        super().__init__()
        self.pyramid = Pyramid(inputs, 2 * width, blocks, width)
        self.towers = nn.ModuleList(
            nn.Sequential(*convolved(2 * width, 2 * width, 3), *convolved(2 * width, 2 * width, 3))
            for _ in range(2)
        )
        start_kaiming(self.towers)
        self.classify = nn.Conv2d(2 * width, BINS, 3, padding=1)
        self.sides = nn.Conv2d(2 * width, 5, 3, padding=1)
        for layer in (self.classify, self.sides):
            nn.init.normal_(layer.weight, std=0.01)
            nn.init.zeros_(layer.bias)  # pyright: ignore[reportArgumentType]
        nn.init.constant_(self.classify.bias, -math.log((1 - PRIOR) / PRIOR))  # pyright: ignore[reportArgumentType]

    def found(self, x: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Map (B, C, H, W) to logits (B, N, 18), distances to left, top, right, bottom (B, N, 4) [px],
        centreness (B, N) and the cells' middles (N, 2)."""
        features = self.pyramid(x)
        logits = self.classify(self.towers[0](features)).flatten(2).transpose(1, 2).float()
        sides = self.sides(self.towers[1](features)).flatten(2).transpose(1, 2).float()
        h, w = features.shape[2:]
        middles = Pyramid.stride * cell_middles(h, w, x.device)
        return logits, 16 * sides[..., :4].clamp(max=4).exp(), sides[..., 4], middles

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to rows (B, cells, 6)."""
        logits, sides, centred, middles = self.found(x)
        share = logits.sigmoid()
        best, which = share.max(-1)
        near = torch.stack([(which + step) % BINS for step in (-1, 0, 1)], dim=-1)
        weight = share.gather(-1, near)
        bias = (weight[..., 2] - weight[..., 0]) / weight.sum(-1)
        angle = math.pi * (which + 0.5 + bias) / BINS - math.pi / 2
        low, high = middles - sides[..., :2], middles + sides[..., 2:]
        flat = (angle.cos().abs() >= math.sqrt(0.5))[..., None]
        span = torch.where(flat, high - low, (high - low).flip(-1))
        score = (best * centred.sigmoid()).sqrt()
        return torch.cat([(low + high) / 2, angle[..., None], span, score[..., None]], dim=-1)

    def loss(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return focal loss, GIoU loss and cross-entropy of centreness, by the number of positive cells."""
        logits, sides, centred, middles = self.found(inputs)
        positive, row = assigned(middles, targets)
        number = positive.sum().clamp(min=1)
        bins = ((row[..., 2] + math.pi / 2) / math.pi * BINS).long() % BINS
        wanted = functional.one_hot(bins, BINS) * positive[..., None]
        entropy = functional.binary_cross_entropy_with_logits(logits, wanted.float(), reduction="none")
        chance = logits.sigmoid()
        wrong = torch.where(wanted > 0, 1 - chance, chance)
        balance = torch.where(wanted > 0, ALPHA, 1 - ALPHA)
        focal = (balance * wrong**GAMMA * entropy).sum() / number
        half = upright_sides(row) / 2
        aim = torch.cat([middles - (row[..., :2] - half), row[..., :2] + half - middles], dim=-1)
        aim = aim.clamp(min=1e-3)
        overlap = ((1 - _giou(sides, aim)) * positive).sum() / number
        narrow = torch.minimum(aim[..., :2], aim[..., 2:]) / torch.maximum(aim[..., :2], aim[..., 2:])
        centre = functional.binary_cross_entropy_with_logits(
            centred, narrow.prod(-1).sqrt(), reduction="none"
        )
        centre = (centre * positive).sum() / number
        return {"loss": focal + overlap + centre, "angle": focal, "box": overlap, "centreness": centre}


def assigned(middles: Tensor, rows: Tensor) -> tuple[Tensor, Tensor]:
    """Tell which cells (B, N) learn a label, and which row (B, N, 6) each: the smallest of those in whose
    middle third along the opening, and half across, the cell lies."""
    apart = middles[None, :, None] - rows[:, None, :, :2]
    cos, sin = rows[:, None, :, 2].cos(), rows[:, None, :, 2].sin()
    along = (apart[..., 0] * cos - apart[..., 1] * sin).abs()
    across = (apart[..., 0] * sin + apart[..., 1] * cos).abs()
    inside = (along <= rows[:, None, :, 3] / 6) & (across <= rows[:, None, :, 4] / 4)
    inside |= apart.abs().amax(-1) <= REACH * Pyramid.stride
    half = upright_sides(rows)[:, None] / 2
    inside &= (apart.abs() < half).all(-1) & (rows[:, None, :, 5] > 0)
    area = (rows[..., 3] * rows[..., 4])[:, None].masked_fill(~inside, torch.inf)
    which = area.argmin(2)
    return inside.any(2), rows.gather(1, which[..., None].expand(-1, -1, 6))


def _giou(a: Tensor, b: Tensor) -> Tensor:
    """Return generalised IoU of boxes about the same point, by their distances to the sides (…, 4)."""
    low = torch.minimum(a, b)
    high = torch.maximum(a, b)

    def area(sides: Tensor) -> Tensor:
        return (sides[..., :2] + sides[..., 2:]).prod(-1)

    common, hull = area(low), area(high)
    whole = area(a) + area(b) - common
    return common / whole - (hull - whole) / hull
