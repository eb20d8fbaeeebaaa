"""Kumra & Kanan, Robotic Grasp Detection using Deep Convolutional Neural Networks (IROS 2017).

    colour, and depth three times over → a ResNet-50 each → mean over the map: 2048 numbers
      → of two trunks, each of length 1, side by side: 4096 → 512 → 512 → one grasp

Certain: trunks, L2 norms, and a shallow head of three fully connected layers; one grasp an image.
From memory of the paper: widths of 512. Ours: six numbers instead of five (sin 2θ and cos 2θ, as θ has a
seam), so that there are 24,822,854 and 49,379,464 weights, of which two scale the normalised numbers, which
are of the order of 0.02 and would leave the layers after them almost constant; and an error against the
nearest label of an image instead of one drawn (``nearest``), which does not average over grasps. The
originals begin with ImageNet's weights; here the trunk of a network trained on the same scenes may be given
by ``--init``, and nothing is dropped, as with :mod:`grasp_bench.networks.redmon`; that the original drops
some of the first 512 numbers is from memory, too.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from grasp_bench.networks.redmon import decoded, encoded
from grasp_bench.networks.resnet import RESNET_50, Trunk
from grasp_bench.networks.rows import Detector, drawn


class Kumra(Detector):
    """24,822,854 parameters on three channels (uni-modal), 49,379,464 on colour and depth (multi-modal).

    Args:
        inputs: 4 for two trunks (depth first), otherwise the channels of one trunk.
        nearest: learn the label nearest to what is predicted, instead of one drawn.
        blocks, width: of the trunks.
        dropout: share dropped before the second layer of the head.
    """

    def __init__(
        self,
        inputs: int = 3,
        nearest: bool = True,
        blocks: Sequence[int] = RESNET_50,
        width: int = 64,
        dropout: float = 0.0,
    ) -> None:
        super().__init__()
        self.nearest = nearest
        trunks = [Trunk(3, blocks, width=width) for _ in range(2 if inputs == 4 else 1)]
        self.trunks = nn.ModuleList(trunks)
        self.scales = nn.Parameter(torch.full((2,), 20.0)) if inputs == 4 else None
        self.head = nn.Sequential(
            nn.Linear(sum(trunk.channels[-1] for trunk in trunks), 512),
            nn.ReLU(inplace=True),
            nn.Dropout(dropout),
            nn.Linear(512, 512),
            nn.ReLU(inplace=True),
            nn.Linear(512, 6),
        )

    def numbers(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, 6), lengths in sides of the image."""
        pictures = [x] if self.scales is None else [x[:, :1].expand(-1, 3, -1, -1), x[:, 1:]]
        found = [trunk(p)[-1].mean((2, 3)) for trunk, p in zip(self.trunks, pictures, strict=True)]
        if self.scales is not None:
            found = [s * nn.functional.normalize(f) for s, f in zip(self.scales, found, strict=True)]
        return self.head(torch.cat(found, dim=1)).float()

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to rows (B, 1, 6)."""
        found = self.numbers(x)
        return decoded(found[:, None], found.new_ones(len(found), 1), x.shape[-1])

    def loss(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return the squared error of the six numbers."""
        found = self.numbers(inputs)
        if self.nearest:
            errors = (found[:, None] - encoded(targets, inputs.shape[-1])).square().sum(-1)
            error = errors.masked_fill(targets[..., 5] <= 0, torch.inf).amin(1)
        else:
            rows, _ = drawn(targets, 1)
            error = (found - encoded(rows[:, 0], inputs.shape[-1])).square().sum(-1)
        there = (targets[..., 5] > 0).any(1)
        return {"loss": torch.where(there, error, 0.0).sum() / there.sum().clamp(min=1)}
