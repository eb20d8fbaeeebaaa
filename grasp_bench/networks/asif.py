"""A reconstruction after the abstract of Asif, Tang & Harrer, GraspNet: An Efficient Convolutional Neural
Network for Real-time Grasp Detection for Low-powered Devices (IJCAI 2018). Not their network.

Known, from the abstract: an encoder of dilated dense fire modules, a decoder by transposed convolutions to
the input's size, fused with maps of the encoder; 3.71 million weights, of which this has nearly as many.
All else is a choice: widths and dilations, a class of direction for each pixel (18 of 10°, and none) with a
width, fusion by addition. Input is colour, or red, green and depth.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional

from grasp_bench.networks.fit import fit
from grasp_bench.networks.resnet import convolved, start_kaiming
from grasp_bench.networks.rows import Detector

BINS = 18
BACKGROUND_WEIGHT = 0.1
LAST = 462
"""Channels at the bottom, the one number that is fitted to the printed count of weights."""
LEAST_QUALITY = 0.5
"""Pixels whose label is below this have nothing to grasp."""


class Fire(nn.Module):
    """Squeezes by 1×1, spreads by two 3×3 of other dilation, and appends that to what came in."""

    def __init__(self, inputs: int, squeezed: int, spread: int, dilation: int) -> None:
        super().__init__()
        self.squeeze = nn.Sequential(*convolved(inputs, squeezed, 1))
        self.spread = nn.ModuleList(
            nn.Conv2d(squeezed, spread // 2, 3, padding=d, dilation=d, bias=False) for d in (1, dilation)
        )
        self.norm = nn.Sequential(nn.BatchNorm2d(spread), nn.ReLU(inplace=True))

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, C + spread, H, W)."""
        squeezed = self.squeeze(x)
        return torch.cat([x, self.norm(torch.cat([part(squeezed) for part in self.spread], dim=1))], dim=1)


class Asif(Detector):
    """3,711,792 parameters on three channels.

    Args:
        inputs: number of channels of the image.
    """

    def __init__(self, inputs: int = 3) -> None:
        super().__init__()
        self.stem = nn.Sequential(*convolved(inputs, 64, 3, 2))
        self.encoder = nn.ModuleList(
            nn.Sequential(nn.MaxPool2d(2, ceil_mode=True), *fires, *convolved(before, after, 1))
            for fires, before, after in (
                ([Fire(64, 16, 64, 2), Fire(128, 16, 64, 2)], 192, 128),
                ([Fire(128, 32, 128, 2), Fire(256, 32, 128, 4)], 384, 256),
                ([Fire(256, 48, 192, 2), Fire(448, 48, 192, 4), Fire(640, 64, 256, 8)], 896, LAST),
            )
        )
        self.enlarge = nn.ModuleList(
            nn.ConvTranspose2d(before, after, 4, 2, 1, bias=False)
            for before, after in ((LAST, 256), (256, 128), (128, 64), (64, 32))
        )
        self.beside = nn.ModuleList(
            nn.Conv2d(before, after, 1, bias=False) for before, after in ((256, 256), (128, 128), (64, 64))
        )
        self.norm = nn.ModuleList(
            nn.Sequential(nn.BatchNorm2d(c), nn.ReLU(inplace=True)) for c in (256, 128, 64, 32)
        )
        self.head = nn.Conv2d(32, BINS + 2, 3, padding=1)
        start_kaiming(self)
        nn.init.normal_(self.head.weight, std=0.01)

    def found(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """Map (B, C, H, W) to logits (B, 19, H, W), the last of no grasp, and widths (B, H, W)."""
        size = x.shape[2:]
        maps = [self.stem(x)]
        for part in self.encoder:
            maps.append(part(maps[-1]))
        y = maps.pop()
        for i, (enlarge, norm) in enumerate(zip(self.enlarge, self.norm, strict=True)):
            y = enlarge(y)
            if i < len(self.beside):
                beside = self.beside[i](maps.pop())
                y = fit(y, beside.shape[2:]) + beside
            y = norm(y)
        y = fit(self.head(y), size).float()
        return y[:, :-1], y[:, -1]

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, 4, H, W): quality, sin 2θ, cos 2θ, width."""
        logits, width = self.found(x)
        share = logits.softmax(1)
        angle = 2 * (math.pi * (share[:, :-1].argmax(1) + 0.5) / BINS - math.pi / 2)
        return torch.stack([1 - share[:, -1], angle.sin(), angle.cos(), width], dim=1)

    def loss(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return the cross-entropy of directions and the smooth L1 of widths where there is a grasp.

        Args:
            inputs: (B, C, H, W).
            targets: maps (B, 4, H, W).
        """
        logits, width = self.found(inputs)
        positive = targets[:, 0] >= LEAST_QUALITY
        angle = 0.5 * torch.atan2(targets[:, 1], targets[:, 2])
        bins = ((angle + math.pi / 2) / math.pi * BINS).long().clamp(0, BINS - 1)
        weight = logits.new_ones(BINS + 1)
        weight[-1] = BACKGROUND_WEIGHT
        entropy = functional.cross_entropy(logits, torch.where(positive, bins, BINS), weight)
        error = functional.smooth_l1_loss(width, targets[:, 3], reduction="none")
        widths = (error * positive).sum() / positive.sum().clamp(min=1)
        return {"loss": entropy + widths, "orientation": entropy, "width": widths}
