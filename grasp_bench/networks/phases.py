"""Up-sampling in training: all phases of the larger map in one convolution, then moved into place.

Same weights and, but for rounding, same values as ``nn.ConvTranspose2d`` and ``nn.PixelShuffle``, whose
kernels for a CPU are slow with channels last: GR-ConvNet's two transposed convolutions took as long as
three times as many multiplications elsewhere. With the phase before the channel, as here, whole runs of
channels are copied. Evaluation keeps PyTorch's own layers, and with them their results to the bit.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional


def interleaved(x: Tensor, stride: int) -> Tensor:
    """Map (B, stride² · C, H, W), phase before channel, to (B, C, stride · H, stride · W)."""
    b, c, h, w = x.shape
    phases = x.permute(0, 2, 3, 1).reshape(b, h, w, stride, stride, c // stride**2).transpose(2, 3)
    return phases.reshape(b, stride * h, stride * w, -1).permute(0, 3, 1, 2)


class Transposed(nn.ConvTranspose2d):
    """A transposed convolution whose kernel is ``taps`` strides wide.

    Args:
        inputs, outputs: numbers of channels.
        kernel, stride, padding: as of ``nn.ConvTranspose2d``, square; ``kernel`` a multiple of ``stride``.
        output_padding: rows and columns added on the far sides, at most ``padding``.
    """

    def __init__(
        self, inputs: int, outputs: int, kernel: int, stride: int, padding: int, output_padding: int
    ) -> None:
        super().__init__(inputs, outputs, kernel, stride, padding, output_padding)
        if kernel % stride or output_padding > padding:
            raise ValueError(f"kernel {kernel}, stride {stride}, padding {padding} have no whole phases.")

    def forward(self, x: Tensor, output_size: list[int] | None = None) -> Tensor:
        """Map (B, inputs, H, W) to (B, outputs, H', W'), as ``nn.ConvTranspose2d`` does."""
        if not self.training:
            return super().forward(x, output_size)
        stride, kernel, cut, more = (
            int(sides[0]) for sides in (self.stride, self.kernel_size, self.padding, self.output_padding)
        )
        assert self.bias is not None
        taps = kernel // stride
        # Value ``stride · m + phase`` of the result is the sum of x[m − tap] · weight[stride · tap + phase].
        weight = self.weight.unflatten(3, (taps, stride)).unflatten(2, (taps, stride)).flip(2, 4)
        weight = weight.permute(3, 5, 1, 0, 2, 4).flatten(0, 2)
        y = functional.conv2d(x, weight, self.bias.repeat(stride**2), padding=taps - 1)
        h, w = (stride * (n - 1) - 2 * cut + kernel + more for n in x.shape[2:])
        y = interleaved(y, stride)[:, :, cut : cut + h, cut : cut + w]
        # Batch norm's backward pass takes thirty times as long on a part of a larger map.
        return y.contiguous(memory_format=torch.channels_last)
