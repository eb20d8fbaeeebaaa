"""Large matrices in eight or four bits, for weights whose file would otherwise be too large to ship.

Eight bits: each row of a matrix (output channel of a convolution) is stored as int8 multiples of its own
scale, the largest magnitude over 127: symmetric quantisation by channel, as is usual for weights. The error
of a weight is at most half a scale, 0.4 % of the row's largest.

Four bits: each 64 consecutive weights of a row share a scale, and are stored as multiples −7 … 7 of it, two
in a byte. The scale is that of a few whose squared error is smallest: cutting the largest weight off a little
makes the others finer (groups: Dettmers & Zettlemoyer, The case for 4-bit precision, ICML 2023). Only
matrices of :data:`BULK` numbers and more, where nearly all of a large network is; others have eight bits.

In use all are float32 again.
"""

from __future__ import annotations

from typing import Literal

import torch
from torch import Tensor
from torch.nn import functional

from grasp_bench.errors import AssetError

Bits = Literal[8, 4]

SCALE, SHAPE = ".scale", ".shape"
"""What is appended to a tensor's name for its scales (rows,) or (rows, groups), and for its shape in four
bits."""
SMALLEST = 4096
"""Matrices with fewer numbers stay as they are: they would save nothing."""
BULK = 65_536
"""Matrices with fewer numbers are not stored in four bits."""
GROUP = 64
"""Weights that share a scale in four bits."""
CUTS = (1.0, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65)
"""Shares of a group's largest magnitude that are tried as its greatest multiple."""


def packed(tensors: dict[str, Tensor], bits: Bits = 8) -> dict[str, Tensor]:
    """Return the tensors with the large float16 matrices in few bits, and what they need beside them."""
    stored = {}
    for name, value in tensors.items():
        if value.ndim < 2 or value.numel() < SMALLEST or value.dtype != torch.float16:
            stored[name] = value
        elif bits == 4 and value.numel() >= BULK:
            stored[name], stored[name + SCALE] = _in_four(value.float().flatten(1))
            stored[name + SHAPE] = torch.tensor(value.shape, dtype=torch.int32)
        else:
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
    shapes = {name.removesuffix(SHAPE): tensors[name] for name in tensors if name.endswith(SHAPE)}
    plain = {name: value for name, value in tensors.items() if not name.endswith((SCALE, SHAPE))}
    for name in {*scales, *shapes}:
        value, scale = plain.get(name), scales.get(name)
        try:
            if value is None or scale is None:
                raise ValueError
            plain[name] = (
                _from_four(value, scale, shapes[name]) if name in shapes else _from_eight(value, scale)
            )
        except (ValueError, RuntimeError) as error:
            raise AssetError(
                f"{source}: {name}{SCALE} does not belong to a matrix in {4 if name in shapes else 8} bits; "
                "fetch or train the file again."
            ) from error
    return plain


def _from_eight(value: Tensor, scale: Tensor) -> Tensor:
    if value.dtype != torch.int8 or value.ndim < 2 or scale.shape != value.shape[:1]:
        raise ValueError
    return value.float() * scale.float().reshape(-1, *[1] * (value.ndim - 1))


def _in_four(rows: Tensor) -> tuple[Tensor, Tensor]:
    """Return two multiples a byte (rows, bytes), the former in the low half, and scales (rows, groups)."""
    groups = functional.pad(rows, (0, -rows.shape[1] % GROUP)).unflatten(1, (-1, GROUP))
    largest = groups.abs().amax(2, keepdim=True)
    least = torch.full_like(largest, torch.inf)
    best, scale = torch.zeros_like(groups), torch.ones_like(largest)
    for cut in CUTS:
        tried = (cut * largest / 7).half().float().clamp(min=1e-7)
        multiples = (groups / tried).round().clamp(-7, 7)
        error = (multiples * tried - groups).square().sum(2, keepdim=True)
        better = error < least
        least = torch.where(better, error, least)
        best, scale = torch.where(better, multiples, best), torch.where(better, tried, scale)
    halves = (best.flatten(1) + 8).to(torch.uint8).unflatten(1, (-1, 2))
    return halves[..., 0] | halves[..., 1] << 4, scale[..., 0].half()


def _from_four(value: Tensor, scale: Tensor, shape: Tensor) -> Tensor:
    size = [int(n) for n in shape]
    rows, columns = size[0], torch.Size(size[1:]).numel()
    groups = -(-columns // GROUP)
    if min(size) < 1 or value.dtype != torch.uint8 or scale.shape != (rows, groups):
        raise ValueError
    if value.shape != (rows, groups * GROUP // 2):
        raise ValueError
    multiples = torch.stack([value & 15, value >> 4], dim=2).float() - 8
    whole = multiples.reshape(rows, groups, GROUP) * scale.float()[..., None]
    return whole.flatten(1)[:, :columns].reshape(size).contiguous()
