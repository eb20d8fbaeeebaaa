"""Dropout whose mask is drawn four elements at a time.

On a CPU ``torch.nn.Dropout`` draws its mask with one thread, a random number for each element: at
GR-ConvNet's four full-resolution heads that took half of a training step. One 64-bit number holds
four 16-bit draws.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

STEPS = 2**16  # values of one draw


class Dropout(nn.Module):
    """Zeroes elements with probability ``p`` in training and scales the rest by 1 / (1 - p).

    Args:
        p: probability, within [0, 1); applied to the nearest 1/65,536.
    """

    def __init__(self, p: float) -> None:
        super().__init__()
        if not 0 <= p < 1:
            raise ValueError(f"p = {p} is not within [0, 1).")
        self.dropped = round(p * STEPS)

    def extra_repr(self) -> str:
        """Return what ``repr`` of a network says of this layer."""
        return f"p={self.dropped / STEPS:g}"

    def forward(self, x: Tensor) -> Tensor:
        """Map any shape to the same shape and memory layout."""
        if not self.training or not self.dropped:
            return x
        words = torch.empty((x.numel() + 3) // 4, dtype=torch.int64, device=x.device)
        draws = words.random_(-(2**63), None).view(torch.int16)
        # In the order of x in memory, so that the product walks straight through both.
        draws = draws[: x.numel()].as_strided(x.shape, torch.empty_like(x).stride())
        keep = draws >= self.dropped - STEPS // 2
        # Through int8, which has a fast way to bfloat16; bool has none.
        return x * keep.view(torch.int8).to(x.dtype).mul_(STEPS / (STEPS - self.dropped))
