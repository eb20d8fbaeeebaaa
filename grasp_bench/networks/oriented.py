"""Oriented anchors (Zhou et al., IROS 2018): grasps as shifts of turned boxes at the cells of a map.

At each cell there are k anchors of one size, turned by 180°/k from one to the next. An anchor is positive
where a label's centre lies in its cell and its direction in the anchor's sector. Five offsets and two
scores belong to an anchor; of the others the hardest three times as many as there are positive ones count.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional

from grasp_bench.networks.boxes import LARGEST_LOG
from grasp_bench.networks.rows import turned

HARD = 3
"""Negative anchors for each positive one."""


@dataclass(frozen=True)
class Oriented:
    """A set of anchors and how offsets of them are coded.

    Attributes:
        number: k, anchors at a cell; for four they are at ±22.5° and ±67.5°.
        units: of the five offsets x, y, log height, log width, angle in sectors.
    """

    number: int
    units: tuple[float, float, float, float, float]

    @property
    def sector(self) -> float:
        """Half of the angle between two anchors [rad]."""
        return math.pi / (2 * self.number)

    def anchors(self, centres: Tensor, size: Tensor | float) -> Tensor:
        """Return rows (…, N · k, 5) x, y, angle, width, height at ``centres`` (…, N, 2).

        Args:
            size: side of the anchors [px], broadcast with (…, 1, 1).
        """
        angle = torch.arange(self.number, device=centres.device) * 2 * self.sector
        angle = angle - math.pi / 2 + self.sector
        shape = (*centres.shape[:-1], self.number)
        side = torch.as_tensor(size, device=centres.device).expand(shape)
        parts = (centres[..., 0, None].expand(shape), centres[..., 1, None].expand(shape))
        return torch.stack([*parts, angle.expand(shape), side, side], dim=-1).flatten(-3, -2)

    def encode(self, anchors: Tensor, rows: Tensor) -> Tensor:
        """Return offsets (…, 5) that bring anchors (…, 5) to rows (…, ≥ 5)."""
        shift = (rows[..., :2] - anchors[..., :2]) / anchors[..., 3:]
        logs = (rows[..., [4, 3]].clamp(min=1) / anchors[..., [4, 3]]).log()
        turn = turned(rows[..., 2], anchors[..., 2])[..., None] / self.sector
        return torch.cat([shift, logs, turn], dim=-1) / shift.new_tensor(self.units)

    def decode(self, anchors: Tensor, offsets: Tensor, score: Tensor) -> Tensor:
        """Undo :meth:`encode`; rows (…, 6) with scores (…,)."""
        offsets = offsets * offsets.new_tensor(self.units)
        centre = anchors[..., :2] + offsets[..., :2] * anchors[..., 3:]
        sides = anchors[..., 3:] * offsets[..., [3, 2]].clamp(max=LARGEST_LOG).exp()
        angle = turned(anchors[..., 2] + offsets[..., 4] * self.sector)
        return torch.cat([centre, angle[..., None], sides, score[..., None]], dim=-1)

    def loss(
        self, logits: Tensor, offsets: Tensor, anchors: Tensor, cell: Tensor, rows: Tensor
    ) -> tuple[Tensor, Tensor]:
        """Return cross-entropy and smooth L1 of images or regions.

        Where several labels match an anchor the nearest counts.

        Args:
            logits: (B, N, 2); ``offsets``: (B, N, 5); ``anchors``: (B or 1, N, 5).
            cell: width and height of a cell [px], broadcast with (B, N, M, 2).
            rows: labels (B, M, 6).
        """
        apart = (rows[:, None, :, :2] - anchors[:, :, None, :2]).abs()
        turn = turned(rows[:, None, :, 2], anchors[:, :, None, 2]).abs()
        match = (apart <= cell / 2).all(-1) & (turn <= self.sector) & (rows[:, None, :, 5] > 0)
        distance = (apart.sum(-1) + turn).masked_fill(~match, torch.inf)
        nearest = distance.argmin(2)
        positive = match.any(2)
        entropies = functional.cross_entropy(
            logits.flatten(0, 1), positive.long().flatten(), reduction="none"
        )
        entropies = entropies.view_as(positive)
        number = positive.sum().clamp(min=1)
        hardness = entropies.detach().masked_fill(positive, -1).flatten()
        hard = hardness.topk(min(int(HARD * number), hardness.numel()))[1]
        entropy = (entropies[positive].sum() + entropies.flatten()[hard].sum()) / ((1 + HARD) * number)
        aim = self.encode(anchors, rows.gather(1, nearest[..., None].expand(-1, -1, 6)))
        error = functional.smooth_l1_loss(offsets, aim, reduction="none").sum(-1)
        return entropy, torch.where(positive, error, 0.0).sum() / number


def cell_middles(height: int, width: int, device: torch.device) -> Tensor:
    """Return x, y of the middles of a map's cells, in cells: (height · width, 2)."""
    y, x = torch.meshgrid(torch.arange(height), torch.arange(width), indexing="ij")
    return (torch.stack([x, y], dim=-1).view(-1, 2) + 0.5).to(device)
