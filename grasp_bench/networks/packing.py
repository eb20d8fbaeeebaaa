"""Large matrices in eight bits, for weights whose file would otherwise be too large to ship.

Each row of a matrix (output channel of a convolution) is stored as int8 multiples of its own scale, the
largest magnitude over 127: symmetric quantisation by channel, as is usual for weights. In use they are
float32 again; the error of a weight is at most half a scale, 0.4 % of the row's largest.
"""

from __future__ import annotations

import torch
from torch import Tensor

from grasp_bench.errors import AssetError

SCALE = ".scale"
"""What is appended to a tensor's name for its rows' scales."""
SMALLEST = 4096
"""Matrices with fewer numbers stay as they are: they would save nothing."""


def packed(tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    """Return the tensors with the large float16 matrices as int8, and their scales (rows,) beside them."""
    stored = {}
    for name, value in tensors.items():
        if value.ndim < 2 or value.numel() < SMALLEST or value.dtype != torch.float16:
            stored[name] = value
            continue
        rows = value.float().flatten(1)
        scale = rows.abs().amax(1).clamp(min=1e-12) / 127
        stored[name] = (rows / scale[:, None]).round().to(torch.int8).reshape(value.shape).contiguous()
        stored[name + SCALE] = scale
    return stored


def unpacked(tensors: dict[str, Tensor], source: object) -> dict[str, Tensor]:
    """Return the tensors that :func:`packed` was given, as float32 where they were packed.

    Raises:
        AssetError: when scales do not fit their matrix; ``source`` is what to call the file.
    """
    scales = {name.removesuffix(SCALE): tensors[name] for name in tensors if name.endswith(SCALE)}
    plain = {name: value for name, value in tensors.items() if not name.endswith(SCALE)}
    for name, scale in scales.items():
        value = plain.get(name)
        if value is None or value.dtype != torch.int8 or value.ndim < 2 or scale.shape != value.shape[:1]:
            raise AssetError(
                f"{source}: {name}{SCALE} does not belong to a matrix in 8 bits; "
                "fetch or train the file again."
            )
        plain[name] = value.float() * scale.float().reshape(-1, *[1] * (value.ndim - 1))
    return plain
