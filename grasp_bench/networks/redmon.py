"""Redmon & Angelova, Real-Time Grasp Detection Using Convolutional Neural Networks (ICRA 2015): AlexNet's
shape at 7 million weights, and grasps by regression.

    input (B, 3, 224, 224), red, green and depth → five convolutions → (B, 256, 7, 7)
      → two fully connected layers of 512 → six numbers, or seven for each of 7×7 cells (MultiGrasp)

Certain: layers, widths, the six numbers x, y, sin 2θ, cos 2θ, height, width, squared errors, that a label is
drawn at random each time an image is seen, and of MultiGrasp up to five, whose cells have heat 1.
Ours: numbers are in units of the image's side, in MultiGrasp of the cell's for x and y (the paper gives no
scale; errors balance so); norms, which the paper mentions and does not describe, are batch norms without
weights of their own, which leaves the count of weights the published one. No ImageNet weights, and without
them no dropout either (the paper's is 0.5): with it the answer was the same for every picture after 78,000 of
them, and after 250 steps of 16 of 64 pictures, which the network knows by heart in 100 without it.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from grasp_bench.networks.resnet import start_kaiming
from grasp_bench.networks.rows import Detector, drawn

CELL = 32
"""Side of a cell [px]."""
MOST_DRAWN = 5


def _layer(inputs: int, outputs: int, kernel: int, stride: int = 1) -> list[nn.Module]:
    return [
        nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2),
        nn.BatchNorm2d(outputs, affine=False),
        nn.ReLU(inplace=True),
    ]


def encoded(rows: Tensor, side: float) -> Tensor:
    """Turn rows (…, 6) into the six numbers x, y, sin 2θ, cos 2θ, height, width; lengths in ``side``."""
    x, y, angle, width, height = rows[..., :5].unbind(-1)
    return torch.stack(
        [x / side, y / side, (2 * angle).sin(), (2 * angle).cos(), height / side, width / side], dim=-1
    )


def decoded(numbers: Tensor, score: Tensor, side: float) -> Tensor:
    """Undo :func:`encoded`, with scores (…,)."""
    x, y, sin, cos, height, width = numbers.unbind(-1)
    angle = 0.5 * torch.atan2(sin, cos)
    return torch.stack([side * x, side * y, angle, side * width, side * height, score], dim=-1)


class Redmon(Detector):
    """7,357,830 parameters as direct regression, 7,530,711 as MultiGrasp.

    Args:
        inputs: number of channels of the image.
        multiple: MultiGrasp instead of one grasp.
        dropout: share dropped after both fully connected layers.
        side: of the image [px], a multiple of 32.
    """

    def __init__(
        self, inputs: int = 3, multiple: bool = False, dropout: float = 0.0, side: int = 224
    ) -> None:
        super().__init__()
        self.multiple, self.side, self.grid = multiple, side, side // CELL
        self.features = nn.Sequential(
            *_layer(inputs, 64, 5, 2),
            nn.MaxPool2d(2),
            *_layer(64, 128, 3, 2),
            nn.MaxPool2d(2),
            *_layer(128, 128, 3),
            *_layer(128, 128, 3),
            *_layer(128, 256, 3),
            nn.MaxPool2d(2),
        )
        start_kaiming(self)
        self.regress = nn.Sequential(
            nn.Flatten(),
            nn.Linear(256 * self.grid**2, 512),
            nn.ReLU(inplace=True),
            nn.Dropout(dropout),
            nn.Linear(512, 512),
            nn.ReLU(inplace=True),
            nn.Dropout(dropout),
            nn.Linear(512, 7 * self.grid**2 if multiple else 6),
        )

    def numbers(self, x: Tensor) -> Tensor:
        """Map (B, C, side, side) to (B, 6), or to (B, 49, 7) with the cell's heat first."""
        found = self.regress(self.features(x)).float()
        return found.view(-1, self.grid**2, 7) if self.multiple else found

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, side, side) to rows (B, 1 or 49, 6)."""
        found = self.numbers(x)
        if not self.multiple:
            return decoded(found[:, None], found.new_ones(len(found), 1), self.side)
        rows = decoded(found[..., 1:], found[..., 0].clamp(0, 1), self.side)
        rows[..., :2] = CELL * (found[..., 1:3] + _corners(self.grid, found.device))
        return rows

    def loss(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return the sum of squared errors, per image: of one label drawn, or of heats and labelled cells."""
        found = self.numbers(inputs)
        if not self.multiple:
            rows, there = drawn(targets, 1)
            error = (found - encoded(rows[:, 0], self.side)).square().sum(-1)
            return {"loss": (error * there[:, 0]).sum() / there.sum().clamp(min=1)}
        rows, there = drawn(targets, MOST_DRAWN)
        place = (rows[..., :2] / CELL).floor().clamp(0, self.grid - 1)
        cell = (self.grid * place[..., 1] + place[..., 0]).long()
        wanted = encoded(rows, self.side)
        wanted[..., :2] = rows[..., :2] / CELL - place
        image = torch.arange(len(found), device=found.device)[:, None]
        heat = torch.zeros_like(found[..., 0])
        heat[image.expand_as(cell)[there], cell[there]] = 1
        heats = (found[..., 0] - heat).square().sum() / len(found)
        errors = (found[image, cell, 1:] - wanted).square().sum(-1)
        grasps = (errors * there).sum() / len(found)
        return {"loss": heats + grasps, "heat": heats, "grasp": grasps}


def _corners(grid: int, device: torch.device) -> Tensor:
    """Return the upper left corners (grid², 2) of the cells, x and y in cells."""
    axis = torch.arange(grid, dtype=torch.float32, device=device)
    y, x = torch.meshgrid(axis, axis, indexing="ij")
    return torch.stack([x, y], dim=-1).view(-1, 2)
