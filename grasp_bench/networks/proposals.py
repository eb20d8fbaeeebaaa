"""The region proposal network that two-stage detectors share (Ren et al., Faster R-CNN, NIPS 2015).

Anchors of three sizes and shapes at each cell; those that overlap a wanted box by 0.7, and the best of each
box, are positive, those below 0.3 negative, and half of the 256 that are drawn are positive where there are
as many. All loops over images are short; tables are filled up, so that images stay in one tensor.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from grasp_bench.networks.boxes import anchors, box_offsets, moved, overlaps, suppressed

Found = tuple[Tensor, Tensor, Tensor]
"""Logits (B, N, 2), offsets (B, N, 4) and anchors (N, 4)."""
RATIOS = (0.5, 1.0, 2.0)
POSITIVE, NEGATIVE = 0.7, 0.3
DRAWN = 256
SMOOTH = 1 / 9
"""Where smooth L1 turns straight, σ = 3 in the authors' words."""
LEAST_SIDE = 2.0
"""Proposals narrower than this [px] are dropped."""


class Proposals(nn.Module):
    """A 3×3 convolution of 512 channels, and two of 1×1: two scores and four offsets for each anchor.

    Args:
        channels: of the features.
        stride: of the features [px].
        scales: roots of the anchors' areas [px].
        before: best anchors that are suppressed among each other, in training and in use.
        after: proposals that are left at most.
    """

    def __init__(
        self,
        channels: int,
        stride: int,
        scales: Sequence[float],
        before: tuple[int, int] = (1000, 600),
        after: tuple[int, int] = (200, 100),
    ) -> None:
        super().__init__()
        self.stride, self.scales, self.before, self.after = stride, scales, before, after
        number = len(scales) * len(RATIOS)
        self.convolution = nn.Conv2d(channels, 512, 3, padding=1)
        self.score = nn.Conv2d(512, 2 * number, 1)
        self.offset = nn.Conv2d(512, 4 * number, 1)
        for layer in (self.convolution, self.score, self.offset):
            nn.init.normal_(layer.weight, std=0.01)
            nn.init.zeros_(layer.bias)  # pyright: ignore[reportArgumentType]

    def forward(self, features: Tensor) -> Found:
        """Map (B, C, H, W) to logits (B, N, 2), offsets (B, N, 4) and anchors (N, 4)."""
        h, w = features.shape[2:]
        x = functional.relu(self.convolution(features))

        def listed(y: Tensor, numbers: int) -> Tensor:
            return y.permute(0, 2, 3, 1).reshape(len(y), -1, numbers).float()

        found = anchors(h, w, self.stride, self.scales, RATIOS).to(features.device)
        return listed(self.score(x), 2), listed(self.offset(x), 4), found

    @torch.no_grad()
    def propose(self, found: Found, side: tuple[int, int]) -> tuple[Tensor, Tensor]:
        """Return boxes (B, K, 4) and their scores (B, K), best first, 0 for those that fill up.

        Args:
            found: what ``forward`` gives.
            side: height and width of the input [px], to which boxes are cut.
        """
        logits, offsets, fixed = found
        which = 0 if self.training else 1
        before, after = self.before[which], self.after[which]
        scores = logits.softmax(-1)[..., 1]
        boxes = moved(fixed, offsets)
        limit = torch.tensor([side[1], side[0]] * 2, dtype=boxes.dtype, device=boxes.device)
        boxes = torch.minimum(boxes.clamp(min=0), limit)
        scores = scores.masked_fill((boxes[..., 2:] - boxes[..., :2]).amin(-1) < LEAST_SIDE, 0.0)
        best, index = scores.topk(min(before, scores.shape[1]), dim=1)
        boxes = boxes.gather(1, index[..., None].expand(-1, -1, 4))
        table, value = boxes.new_zeros(len(boxes), after, 4), best.new_zeros(len(boxes), after)
        table[..., 2:] = LEAST_SIDE
        for b in range(len(boxes)):
            kept = suppressed(boxes[b], best[b], POSITIVE, after)
            table[b, : len(kept)], value[b, : len(kept)] = boxes[b, kept], best[b, kept]
        return table, value

    def loss(self, found: Found, wanted: Tensor, there: Tensor) -> tuple[Tensor, Tensor]:
        """Return cross-entropy and smooth L1 of anchors that are drawn.

        Args:
            found: what ``forward`` gives.
            wanted: boxes (B, M, 4); ``there``: which of them are any (B, M).
        """
        logits, offsets, fixed = found
        shared = overlaps(fixed, wanted).masked_fill(~there[:, None], 0.0)  # (B, N, M)
        best, which = shared.max(2)
        top = shared.amax(1, keepdim=True)
        best_of_box = ((shared == top) & (top > 0)).any(2)
        positive, negative = (best >= POSITIVE) | best_of_box, (best < NEGATIVE) & ~best_of_box
        positive = pick(positive, DRAWN // 2)
        negative = pick(negative, DRAWN - positive.sum(1))
        chosen = positive | negative
        entropy = functional.cross_entropy(logits[chosen], positive[chosen].long())
        aim = box_offsets(fixed, wanted.gather(1, which[..., None].expand(-1, -1, 4)))
        error = functional.smooth_l1_loss(offsets, aim, reduction="none", beta=SMOOTH).sum(-1)
        return entropy, (error * positive).sum() / chosen.sum().clamp(min=1)


def pick(allowed: Tensor, most: int | Tensor) -> Tensor:
    """Draw at most ``most`` of those allowed (B, N) in each row, as (B, N) again."""
    order = torch.rand(allowed.shape, device=allowed.device).masked_fill(~allowed, -1)
    rank = order.argsort(dim=1, descending=True).argsort(dim=1)
    limit = most[:, None] if isinstance(most, Tensor) else most
    return allowed & (rank < limit)


def with_wanted(boxes: Tensor, wanted: Tensor, there: Tensor) -> Tensor:
    """Return proposals (B, K, 4) with the wanted boxes (B, M, 4) among them, for training a second stage."""
    some = torch.where(there[..., None], wanted, boxes[:, :1])
    return torch.cat([some, boxes], dim=1)
