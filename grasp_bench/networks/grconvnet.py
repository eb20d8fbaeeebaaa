"""GR-ConvNet (Kumra et al., IROS 2020; variant 3 of the authors' code), written anew from the
published layer table."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from grasp_bench.networks.dropout import Dropout
from grasp_bench.networks.fit import fit
from grasp_bench.networks.phases import Transposed


def _convolution(inputs: int, outputs: int, kernel: int, stride: int, padding: int) -> list[nn.Module]:
    return [
        nn.Conv2d(inputs, outputs, kernel, stride, padding),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    ]


def _transposed(inputs: int, outputs: int, padding: int) -> list[nn.Module]:
    return [
        Transposed(inputs, outputs, 4, 2, padding, output_padding=1),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    ]


class Residual(nn.Module):
    """Two 3×3 convolutions added to their input, without a ReLU after the sum."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.body = nn.Sequential(
            *_convolution(channels, channels, 3, 1, 1),
            nn.Conv2d(channels, channels, 3, 1, 1),
            nn.BatchNorm2d(channels),
        )

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, C, H, W)."""
        return x + self.body(x)


class GRConvNet(nn.Module):
    """Convolutions to 1/4 resolution, five residual blocks, transposed convolutions.

    Args:
        channels: those of the first layer: 32 (1,900,900 parameters) or 16 (479,156) on RGB-D.
        inputs: number of channels of the image.
    """

    def __init__(self, channels: int = 32, inputs: int = 4) -> None:
        super().__init__()
        c = channels
        self.body = nn.Sequential(
            *_convolution(inputs, c, 9, 1, 4),
            *_convolution(c, 2 * c, 4, 2, 1),
            *_convolution(2 * c, 4 * c, 4, 2, 1),
            *(Residual(4 * c) for _ in range(5)),
            *_transposed(4 * c, 2 * c, padding=1),
            *_transposed(2 * c, c, padding=2),
            nn.Conv2d(c, c, 9, 1, 4),
        )
        # Separate heads: in training each drops other channels.
        self.heads = nn.ModuleList(nn.Sequential(Dropout(0.1), nn.Conv2d(c, 1, 2)) for _ in range(4))
        for module in self.modules():
            if isinstance(module, nn.Conv2d | nn.ConvTranspose2d):
                nn.init.xavier_uniform_(module.weight)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, 4, H, W): quality, sin 2θ, cos 2θ, width."""
        features = self.body(x)
        return fit(torch.cat([head(features) for head in self.heads], dim=1), x.shape[2:])
