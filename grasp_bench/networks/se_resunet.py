"""SE-ResUNet (Yu et al., RA-L 7(2), 2022) and SKGNet (T-ASE 20(4), 2023), dense networks of one group,
written anew from the layers in their published code.

SE-ResUNet is a U-Net of bottlenecks with squeeze-and-excitation, of which those of 128 and 256 channels are
the same, weights and norms, on the way down and up. Its release declares 16,404,260 parameters, of which
82,976 are of a 9×9 deconvolution that is never called and is left out here. SKGNet's class, 3,897,668
parameters, has its selective kernels commented out: what is published is a chain of 1×1 bottlenecks.
Both learn four maps, as GR-ConvNet does.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from grasp_bench.networks.dropout import Dropout
from grasp_bench.networks.fit import fit


def _xavier(network: nn.Module) -> None:
    for module in network.modules():
        if isinstance(module, nn.Conv2d | nn.ConvTranspose2d):
            nn.init.xavier_uniform_(module.weight)


def _heads(kernel: int) -> nn.ModuleList:
    return nn.ModuleList(
        nn.Sequential(Dropout(0.1), nn.Conv2d(32, 1, kernel, padding=kernel // 2)) for _ in range(4)
    )


class Excited(nn.Module):
    """A bottleneck that does not narrow, reweighted by channel, added to its input."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        for kernel in (1, 3, 1):
            layers += [
                nn.Conv2d(channels, channels, kernel, padding=kernel // 2, bias=False),
                nn.BatchNorm2d(channels),
                nn.ReLU(inplace=True),
            ]
        self.body = nn.Sequential(*layers[:-1])
        self.excite = nn.Sequential(
            nn.Linear(channels, channels // 16, bias=False),
            nn.ReLU(inplace=True),
            nn.Linear(channels // 16, channels, bias=False),
            nn.Sigmoid(),
        )

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, C, H, W)."""
        residual = self.body(x)
        gain = self.excite(residual.mean((2, 3)))[:, :, None, None]
        return functional.relu(x + residual * gain)


def _twice(inputs: int, middle: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, middle, 3, padding=1),
        nn.BatchNorm2d(middle),
        nn.ReLU(inplace=True),
        nn.Conv2d(middle, outputs, 3, padding=1),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    )


class Joined(nn.Module):
    """Doubles the running map and the one from the way down, and convolves both twice."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.body = _twice(inputs, inputs // 2, outputs)

    def forward(self, x: Tensor, beside: Tensor) -> Tensor:
        """Map two maps of (B, ·, H, W) to (B, outputs, 2H, 2W)."""
        x = fit(x, beside.shape[2:])
        both = torch.cat([beside, x], dim=1)
        return self.body(functional.interpolate(both, scale_factor=2, mode="bilinear", align_corners=True))


class SEResUNet(nn.Module):
    """16,321,284 parameters on RGB-D.

    Args:
        inputs: number of channels of the image.
    """

    def __init__(self, inputs: int = 4) -> None:
        super().__init__()
        self.stem = nn.ModuleList(
            nn.Sequential(
                nn.Conv2d(before, after, kernel, stride, padding),
                nn.BatchNorm2d(after),
                nn.ReLU(inplace=True),
            )
            for before, after, kernel, stride, padding in (
                (inputs, 32, 9, 1, 4),
                (32, 64, 4, 2, 1),
                (64, 128, 4, 2, 1),
            )
        )
        self.excited = nn.ModuleDict({str(c): Excited(c) for c in (64, 128, 256, 512)})
        self.down = nn.ModuleList(
            nn.Sequential(nn.MaxPool2d(2, ceil_mode=True), _twice(c, 2 * c, 2 * c)) for c in (128, 256)
        )
        self.up = nn.ModuleList(
            Joined(before, after) for before, after in ((1024, 256), (512, 128), (256, 64), (128, 32))
        )
        self.heads = _heads(3)
        _xavier(self)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, 4, H, W): quality, sin 2θ, cos 2θ, width."""
        size = x.shape[2:]
        first = self.stem[1](self.stem[0](x))
        second = self.stem[2](first)
        third = self.down[0](self.excited["128"](second))
        fourth = self.down[1](self.excited["256"](third))
        y = self.up[0](self.excited["512"](fourth), fourth)
        y = self.up[1](self.excited["256"](y), third)
        y = self.up[2](self.excited["128"](y), second)
        y = self.up[3](self.excited["64"](y), first)
        return fit(torch.cat([head(y) for head in self.heads], dim=1), size)


class Unit(nn.Module):
    """Three 1×1 convolutions with norms and no ReLU between, added to the input or its projection."""

    def __init__(self, inputs: int, outputs: int, middle: int, stride: int) -> None:
        super().__init__()
        self.body = nn.Sequential(
            nn.Conv2d(inputs, middle, 1),
            nn.BatchNorm2d(middle),
            nn.Conv2d(middle, middle, 1, stride),
            nn.BatchNorm2d(middle),
            nn.Conv2d(middle, outputs, 1),
            nn.BatchNorm2d(outputs),
        )
        projection = [nn.Conv2d(inputs, outputs, 1, stride), nn.BatchNorm2d(outputs)]
        self.shortcut = nn.Sequential(*([] if inputs == outputs else projection))

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, inputs, H, W) to (B, outputs, H / stride, W / stride)."""
        return functional.relu(self.body(x) + self.shortcut(x))


class SKGNet(nn.Module):
    """3,897,668 parameters on RGB-D.

    Args:
        inputs: number of channels of the image.
    """

    def __init__(self, inputs: int = 4) -> None:
        super().__init__()
        layers: list[nn.Module] = [
            nn.Conv2d(inputs, 64, 3, padding=1),
            nn.BatchNorm2d(64),
            nn.Conv2d(64, 64, 4, 2, 1),
            nn.BatchNorm2d(64),
        ]
        for c in (64, 128, 256):
            layers += [Unit(c, 2 * c, c, 2), Unit(2 * c, 2 * c, c, 1)]
        for i, c in enumerate((512, 256, 128, 64)):
            layers += [
                nn.ConvTranspose2d(c, c // 2, 4, 2, 2 if i else 1, 0 if i == 3 else 1),
                nn.BatchNorm2d(c // 2),
            ]
        self.body = nn.Sequential(*layers, nn.ConvTranspose2d(32, 32, 9, padding=4))
        self.heads = _heads(1)
        for module in self.modules():
            if isinstance(module, nn.Conv2d):
                nn.init.kaiming_normal_(module.weight)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, 4, H, W): quality, sin 2θ, cos 2θ, width."""
        y = self.body(x)
        return fit(torch.cat([head(y) for head in self.heads], dim=1), x.shape[2:])
