"""Output sizes that are those of the input, whatever the arithmetic of strides gives."""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor
from torch.nn import functional


def fit(x: Tensor, size: Sequence[int]) -> Tensor:
    """Bring (B, C, h, w) to (B, C, *size), two numbers: cut, or continued by its border, at the right and
    below.

    Strided and transposed convolutions here keep the upper left corner in place.
    """
    h, w = size
    x = x[:, :, :h, :w]
    missing = (0, w - x.shape[3], 0, h - x.shape[2])
    return functional.pad(x, missing, mode="replicate") if any(missing) else x
