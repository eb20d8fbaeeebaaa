"""HTC-Grasp: a hierarchical Transformer encoder with external attention and a CNN decoder
with Res-channel attention (section 3.3 of the paper, whose code was never published).

    input (B, 4, H, W), depth then colour
      → four stages of overlapping patch embedding + Transformer blocks:
        (B, 32, H/4, W/4), (B, 64, H/8, W/8), (B, 128, H/16, W/16), (B, 256, H/32, W/32)
      → all brought to 1/4 resolution and fused to C = 256 channels
      → Res-channel attention → two up-sampling layers → four maps (B, 4, H, W)

Where the paper is silent or misprinted:

- "L1..L4 = 256 encoder layers" cannot be meant as depth: 1024 blocks would hold 340 million
  weights and could not run in the 5.4 ms the paper reports. 256 is what the official code of
  multi-head external attention has as memory size (heads' multiplier 4 times S = 64), so the
  depths are those of SegFormer's smallest encoder, MiT-B0: (2, 2, 2, 2), with S = 64.
- Patch embeddings have SegFormer's kernel/stride/padding: 7/4/3, then 3/2/1.
- There are no position codes: zero padding in the overlapping embeddings reveals position.
- Features are merged by a 1×1 convolution ("a CNN layer"), the only costly choice in the
  network: a 3×3 kernel on the 480 concatenated channels needs 2.5 times the time in total.
- C = 256 is kept at 1/4 resolution; the two up-sampling layers narrow it to 32 and 16
  channels by pixel shuffling. Keeping 256 → 128 → 64 would make it 4 times slower.
- The head starts near zero (standard deviation 0.01): with a Kaiming start training failed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import torch
from torch import Tensor, nn
from torch.autograd import Function
from torch.nn import functional

from grasp_bench.networks.phases import interleaved

CHANNELS = (32, 64, 128, 256)
HEADS = (1, 2, 4, 8)
DEPTHS = (2, 2, 2, 2)
DECODER_CHANNELS = 256
MEMORY = 64


class Tokenwise(nn.Linear):
    """A linear map of tokens; in training a 1×1 convolution, the same function.

    A convolution's backward pass spreads over the images of a batch, while the product of matrices that
    gives a linear map's gradient, 50,000 tokens deep, is left to one core.
    """

    def forward(self, input: Tensor) -> Tensor:
        """Map (B, …, C) to (B, …, outputs)."""
        if not self.training:
            return super().forward(input)
        x = input.reshape(input.shape[0], -1, 1, input.shape[-1]).permute(0, 3, 1, 2)
        y = functional.conv2d(x, self.weight[:, :, None, None], self.bias)
        return y.permute(0, 2, 3, 1).reshape(*input.shape[:-1], -1)


class _DoubleNormalised(Function):
    """``ExternalAttention.double_normalise`` with its gradient by hand, in half the time.

    With softmax p, row sum r and result w = p / r, the gradient of p times p is w (g − Σ g w) in each row,
    whatever r is.
    """

    @staticmethod
    def forward(ctx: Any, scores: Tensor) -> Tensor:
        weights = scores.softmax(1, dtype=torch.float32)
        total = weights.sum(-1, keepdim=True).add_(1e-9)
        weights /= total
        ctx.save_for_backward(weights, total)
        return weights.to(scores.dtype)

    @staticmethod
    def backward(ctx: Any, *gradients: Tensor) -> Tensor:
        weights, total = ctx.saved_tensors
        gradient = gradients[0] * weights
        gradient.addcmul_(weights, gradient.sum(-1, keepdim=True), value=-1)
        gradient.addcmul_(weights * total, gradient.sum(1, keepdim=True), value=-1)
        return gradient.to(gradients[0].dtype)


class ExternalAttention(nn.Module):
    """Multi-head external attention, equations 4–6 (Guo et al. 2021).

    Tokens attend to two learnt memories, M_k and M_v of S rows, shared by all images and by
    all heads, which costs O(N·S) for N tokens where self-attention costs O(N²).

    Args:
        widening: factor of channels and heads within; 4, with biases of the memories, is what the class of
            external attention's authors does (Guo et al., EANet), and 1 what the paper's equations say,
            whose output layer has equal input and output size.
    """

    def __init__(self, channels: int, heads: int, memory: int = MEMORY, widening: int = 1) -> None:
        super().__init__()
        self.heads = heads * widening
        self.query = Tokenwise(channels, channels * widening)
        self.memory_key = Tokenwise(channels // heads, memory, bias=widening > 1)
        self.memory_value = Tokenwise(memory, channels // heads, bias=widening > 1)
        self.output = Tokenwise(channels * widening, channels)

    @staticmethod
    def double_normalise(scores: Tensor) -> Tensor:
        """Turn (B, N, heads, S) scores into weights: softmax over the tokens, then L1 over the memory.

        In float32 whatever the autocast type: after the softmax over thousands of tokens the
        values are of the order of 1/N.
        """
        weights = scores.float().softmax(dim=1)
        return weights / (weights.sum(dim=-1, keepdim=True) + 1e-9)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, N, C) to (B, N, C)."""
        b, n, _ = x.shape
        query = self.query(x).view(b, n, self.heads, -1)
        scores = self.memory_key(query)
        normalise = _DoubleNormalised.apply if self.training else self.double_normalise
        weights = normalise(scores).to(query.dtype)
        return self.output(self.memory_value(weights).reshape(b, n, -1))


class SelfAttention(nn.Module):
    """Plain multi-head self-attention, equation 3: what external attention replaces.

    No spatial reduction (SegFormer's remedy for O(N²)): PyTorch's fused kernel never stores
    the N×N matrix, so that the 3136 tokens of the first stage fit in memory, only slowly.
    """

    def __init__(self, channels: int, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.query_key_value = Tokenwise(channels, 3 * channels)
        self.output = Tokenwise(channels, channels)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, N, C) to (B, N, C)."""
        b, n, c = x.shape
        q, k, v = self.query_key_value(x).view(b, n, 3, self.heads, c // self.heads).permute(2, 0, 3, 1, 4)
        if x.device.type == "cpu":  # the kernel's backward pass takes 1.5 times as long in bfloat16
            with torch.autocast("cpu", enabled=False):
                mixed = functional.scaled_dot_product_attention(q.float(), k.float(), v.float())
        else:
            mixed = functional.scaled_dot_product_attention(q, k, v)
        return self.output(mixed.transpose(1, 2).reshape(b, n, c))


Attend = Callable[[int, int], nn.Module]
"""Makes the attention of a block from numbers of channels and heads."""


class TransformerBlock(nn.Module):
    """Attention, then a feed-forward layer of ratio 4; pre-norm and residual both."""

    def __init__(self, channels: int, attention: nn.Module) -> None:
        super().__init__()
        self.norm_attention = nn.LayerNorm(channels)
        self.attention = attention
        self.norm_feed_forward = nn.LayerNorm(channels)
        self.feed_forward = nn.Sequential(
            Tokenwise(channels, 4 * channels), nn.GELU(), Tokenwise(4 * channels, channels)
        )

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, N, C) to (B, N, C)."""
        x = x + self.attention(self.norm_attention(x))
        return x + self.feed_forward(self.norm_feed_forward(x))


class Stage(nn.Module):
    """Overlapping patch embedding and Transformer blocks (section 3.3.1)."""

    def __init__(
        self, inputs: int, channels: int, heads: int, depth: int, *, first: bool, attend: Attend
    ) -> None:
        super().__init__()
        kernel, stride = (7, 4) if first else (3, 2)
        self.embed = nn.Conv2d(inputs, channels, kernel, stride, kernel // 2)
        self.norm_embed = nn.LayerNorm(channels)
        self.blocks = nn.Sequential(
            *(TransformerBlock(channels, attend(channels, heads)) for _ in range(depth))
        )
        self.norm = nn.LayerNorm(channels)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C_in, H, W) to (B, C, H/stride, W/stride), rounded up."""
        x = self.embed(x)
        b, c, h, w = x.shape
        tokens = self.norm_embed(x.flatten(2).transpose(1, 2))
        tokens = self.norm(self.blocks(tokens))
        return tokens.transpose(1, 2).view(b, c, h, w)


class ResChannelAttention(nn.Module):
    """Bottleneck of 1×1, 3×3 and 1×1 convolutions, reweighted by channel (figure 3).

    The channel branch is global average pooling and two fully connected layers (squeeze and
    excite). Bottleneck C/4 and squeeze C/16 are the usual choices; the paper names none.
    """

    def __init__(self, channels: int, channel_attention: bool) -> None:
        super().__init__()
        narrow = channels // 4
        self.residual = nn.Sequential(
            nn.Conv2d(channels, narrow, 1, bias=False),
            nn.BatchNorm2d(narrow),
            nn.ReLU(inplace=True),
            nn.Conv2d(narrow, narrow, 3, padding=1, bias=False),
            nn.BatchNorm2d(narrow),
            nn.ReLU(inplace=True),
            nn.Conv2d(narrow, channels, 1, bias=False),
            nn.BatchNorm2d(channels),
        )
        self.excite = (
            nn.Sequential(
                nn.Linear(channels, channels // 16),
                nn.ReLU(inplace=True),
                nn.Linear(channels // 16, channels),
                nn.Sigmoid(),
            )
            if channel_attention
            else None
        )

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, C, H, W)."""
        residual = self.residual(x)
        if self.excite is None:
            return functional.relu(x + residual, inplace=True)
        if self.training:  # over pixels as one dimension: otherwise the gradient comes with channels first
            pooled = residual.permute(0, 2, 3, 1).flatten(1, 2).mean(dim=1)
        else:
            pooled = residual.mean(dim=(2, 3))
        gain = self.excite(pooled)[:, :, None, None]
        return functional.relu(torch.addcmul(x, residual, gain), inplace=True)


class Fuse(nn.Module):
    """Up-samples all maps to the first one's size, concatenates them and merges them by a
    1×1 convolution (section 3.3.2) — computed in another order.

    A 1×1 convolution without bias commutes with bilinear up-sampling and splits over
    concatenated channels, so that each map is convolved at its own resolution and the results
    are up-sampled and added: the same function for an eighth of the multiplications.
    """

    def __init__(self, channels: tuple[int, ...], outputs: int) -> None:
        super().__init__()
        self.merge = nn.ModuleList(nn.Conv2d(c, outputs, 1, bias=False) for c in channels)
        self.norm = nn.BatchNorm2d(outputs)

    def forward(self, maps: list[Tensor]) -> Tensor:
        """Map (B, C_i, H_i, W_i) each to (B, outputs, H_1, W_1)."""
        size = maps[0].shape[2:]
        fused = self.merge[0](maps[0])
        for merge, x in zip(self.merge[1:], maps[1:], strict=True):
            fused += functional.interpolate(merge(x), size=size, mode="bilinear", align_corners=False)
        return functional.relu(self.norm(fused), inplace=True)


class Upsample(nn.Sequential):
    """Doubles the resolution: convolution to 4× the channels, pixel shuffle, norm, ReLU."""

    def __init__(self, inputs: int, outputs: int, kernel: int) -> None:
        super().__init__(
            nn.Conv2d(inputs, 4 * outputs, kernel, padding=kernel // 2, bias=False),
            nn.PixelShuffle(2),
            nn.BatchNorm2d(outputs),
            nn.ReLU(inplace=True),
        )

    def forward(self, input: Tensor) -> Tensor:
        """Map (B, inputs, H, W) to (B, outputs, 2H, 2W)."""
        if not self.training:
            return super().forward(input)
        weight = self.get_parameter("0.weight")
        weight = weight.unflatten(0, (-1, 4)).transpose(0, 1).flatten(0, 1)
        _, _, norm, activation = self
        return activation(norm(interleaved(functional.conv2d(input, weight, padding="same"), 2)))


class HTCGrasp(nn.Module):
    """The network; the two switches are the paper's ablations (table 3).

    Args:
        external_attention: False for multi-head self-attention (equation 3) in all blocks.
        channel_attention: False for a decoder without squeeze-and-excite branch.
        inputs: number of channels of the image.
        widening: of external attention.
    """

    def __init__(
        self,
        external_attention: bool = True,
        channel_attention: bool = True,
        inputs: int = 4,
        widening: int = 1,
    ) -> None:
        super().__init__()
        attend = partial(ExternalAttention, widening=widening) if external_attention else SelfAttention
        sizes = (inputs, *CHANNELS)
        self.stages = nn.ModuleList(
            Stage(sizes[i], sizes[i + 1], HEADS[i], DEPTHS[i], first=i == 0, attend=attend)
            for i in range(len(CHANNELS))
        )
        self.fuse = Fuse(CHANNELS, DECODER_CHANNELS)
        self.refine = ResChannelAttention(DECODER_CHANNELS, channel_attention)
        self.upsample = nn.Sequential(Upsample(DECODER_CHANNELS, 32, kernel=1), Upsample(32, 16, kernel=3))
        # The four sub-task heads as one convolution: same function, one pass over memory.
        self.head = nn.Conv2d(16, 4, 3, padding=1)
        self._initialise()
        # Tokens (B, N, C) are maps with channels last: convolutions that expect them so save
        # copying back and forth, a third to a half of the time on a CPU.
        self.to(memory_format=torch.channels_last)  # pyright: ignore[reportCallIssue]

    def _initialise(self) -> None:
        for module in self.modules():
            if isinstance(module, nn.Linear):
                nn.init.trunc_normal_(module.weight, std=0.02)
                if module.bias is not None:
                    nn.init.zeros_(module.bias)
            elif isinstance(module, nn.Conv2d):
                nn.init.kaiming_normal_(module.weight, mode="fan_out", nonlinearity="relu")
                if module.bias is not None:
                    nn.init.zeros_(module.bias)
        nn.init.normal_(self.head.weight, std=0.01)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, 4, H, W): quality, sin 2θ, cos 2θ, width / WIDTH_SCALE."""
        h, w = x.shape[2:]
        maps = []
        features = x
        for stage in self.stages:
            features = stage(features)
            maps.append(features)
        return self.head(self.upsample(self.refine(self.fuse(maps))))[:, :, :h, :w]
