"""TF-Grasp (Wang et al., RA-L 2022): a U-Net of Swin Transformer blocks, written anew.

Four levels of 48, 96, 192 and 384 channels, two blocks each on the way down and up, windows of
7×7 tokens, every second block shifted by 3. A habit of the authors' code is kept: ReLU in the
feed-forward layers. Another is an option only: their released file expands by a plain reshape, which puts
the parts of a token into one row, so that whatever the decoder draws is in another column than what the
skip connections bring. Expanding here is Swin-UNet's (Cao et al., 2021), a block of pixels for each token.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

WINDOW = 7
DEPTH = 2
HEADS = (1, 2, 4, 8)
DROP_PATH = 0.1


def _to_windows(x: Tensor) -> Tensor:
    """Turn (B, H, W, C) into (B · windows, 49, C)."""
    b, h, w, c = x.shape
    x = x.view(b, h // WINDOW, WINDOW, w // WINDOW, WINDOW, c)
    return x.transpose(2, 3).reshape(-1, WINDOW * WINDOW, c)


def _from_windows(windows: Tensor, shape: torch.Size) -> Tensor:
    """Undo ``_to_windows``."""
    b, h, w, c = shape
    return windows.view(b, h // WINDOW, w // WINDOW, WINDOW, WINDOW, c).transpose(2, 3).reshape(shape)


def _relative_index() -> Tensor:
    """Return the (49, 49) row of the bias table for each pair of tokens of a window."""
    axis = torch.arange(WINDOW)
    row, column = (g.flatten() for g in torch.meshgrid(axis, axis, indexing="ij"))
    down, right = row[:, None] - row[None, :] + WINDOW - 1, column[:, None] - column[None, :] + WINDOW - 1
    return down * (2 * WINDOW - 1) + right


class SwinBlock(nn.Module):
    """Attention inside windows and a feed-forward layer, both residual and pre-norm.

    Args:
        channels, heads: width and number of heads of the attention.
        shift: tokens by which the windows are moved, cyclically, before attending.
        drop_path: chance that a residual branch is left out for a training sample.
    """

    relative_index: Tensor

    def __init__(self, channels: int, heads: int, shift: int, drop_path: float) -> None:
        super().__init__()
        self.heads, self.shift, self.drop_path = heads, shift, drop_path
        self.norm_attention = nn.LayerNorm(channels)
        self.query_key_value = nn.Linear(channels, 3 * channels)
        self.bias = nn.Parameter(torch.empty((2 * WINDOW - 1) ** 2, heads))
        self.output = nn.Linear(channels, channels)
        self.norm_feed_forward = nn.LayerNorm(channels)
        self.feed_forward = nn.Sequential(
            nn.Linear(channels, 4 * channels), nn.ReLU(inplace=True), nn.Linear(4 * channels, channels)
        )
        self.register_buffer("relative_index", _relative_index(), persistent=False)
        nn.init.trunc_normal_(self.bias, std=0.02)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, H, W, C) to (B, H, W, C), H and W multiples of 7."""
        x = x + self._drop(self._attend(self.norm_attention(x)))
        return x + self._drop(self.feed_forward(self.norm_feed_forward(x)))

    def _attend(self, x: Tensor) -> Tensor:
        shift = self.shift if min(x.shape[1:3]) > WINDOW else 0
        if shift:
            x = x.roll((-shift, -shift), (1, 2))
        windows = _to_windows(x)
        n, t, c = windows.shape
        split = self.query_key_value(windows).view(n, t, 3, self.heads, c // self.heads)
        q, k, v = split.permute(2, 0, 3, 1, 4)
        bias = self.bias[self.relative_index].permute(2, 0, 1)[None]
        if shift:
            apart = self._apart(x.shape[1], x.shape[2], shift, x.device)
            bias = (bias + apart.to(bias.dtype)).repeat(x.shape[0], 1, 1, 1)
        windows = functional.scaled_dot_product_attention(q, k, v, attn_mask=bias.to(q.dtype))
        x = _from_windows(self.output(windows.transpose(1, 2).reshape(n, t, c)), x.shape)
        return x.roll((shift, shift), (1, 2)) if shift else x

    @staticmethod
    def _apart(h: int, w: int, shift: int, device: torch.device) -> Tensor:
        """Return (windows, 1, 49, 49): −100 between tokens that only the cyclic shift put side by side."""

        def zone(n: int) -> Tensor:
            i = torch.arange(n, device=device)
            return (i >= n - WINDOW).long() + (i >= n - shift).long()

        zones = _to_windows((3 * zone(h)[:, None] + zone(w)[None, :])[None, :, :, None])
        return -100.0 * (zones != zones.transpose(1, 2)).float()[:, None]

    def _drop(self, branch: Tensor) -> Tensor:
        if not self.training or not self.drop_path:
            return branch
        keep = 1 - self.drop_path
        kept = torch.rand(branch.shape[0], 1, 1, 1, device=branch.device) < keep
        return branch * kept.to(branch.dtype) / keep


class Merge(nn.Module):
    """Halves the resolution: 2×2 tokens are concatenated and mapped to twice the channels."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.norm = nn.LayerNorm(4 * channels)
        self.reduce = nn.Linear(4 * channels, 2 * channels, bias=False)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, H, W, C) to (B, H/2, W/2, 2C)."""
        parts = [x[:, i::2, j::2] for j in (0, 1) for i in (0, 1)]
        return self.reduce(self.norm(torch.cat(parts, dim=-1)))


class Reshaped(nn.Module):
    """Multiplies the resolution by ``factor`` as the release does: a linear map, then a plain reshape."""

    def __init__(self, channels: int, outputs: int, factor: int) -> None:
        super().__init__()
        self.factor, self.outputs = factor, outputs
        self.expand = nn.Linear(channels, factor * factor * outputs, bias=False)
        self.norm = nn.LayerNorm(outputs)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, H, W, C) to (B, factor · H, factor · W, outputs)."""
        b, h, w, _ = x.shape
        return self.norm(self.expand(x).reshape(b, self.factor * h, self.factor * w, self.outputs))


class Expand(nn.Module):
    """Multiplies the resolution by ``factor``: what a token is mapped to is a block of ``factor``² pixels.

    The map is not called as in :class:`Reshaped`, whose weights mean something else.
    """

    def __init__(self, channels: int, outputs: int, factor: int) -> None:
        super().__init__()
        self.factor = factor
        self.spread = nn.Linear(channels, factor * factor * outputs, bias=False)
        self.norm = nn.LayerNorm(outputs)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, H, W, C) to (B, factor · H, factor · W, outputs)."""
        b, h, w, _ = x.shape
        blocks = self.spread(x).view(b, h, w, self.factor, self.factor, -1).transpose(2, 3)
        return self.norm(blocks.reshape(b, self.factor * h, self.factor * w, -1))


class TFGrasp(nn.Module):
    """6,812,108 parameters at embedding 48 on RGB-D.

    Args:
        inputs: number of channels of the image.
        embedding: number of channels of the first level.
        reshape: expand as the released code does.
    """

    def __init__(self, inputs: int = 4, embedding: int = 48, reshape: bool = False) -> None:
        super().__init__()
        expand = Reshaped if reshape else Expand
        channels = [embedding * 2**level for level in range(len(HEADS))]
        drops = torch.linspace(0, DROP_PATH, DEPTH * len(HEADS), device="cpu").tolist()

        def blocks(level: int) -> nn.Sequential:
            return nn.Sequential(
                *(
                    SwinBlock(
                        channels[level],
                        HEADS[level],
                        shift=WINDOW // 2 * (i % 2),
                        drop_path=drops[DEPTH * level + i],
                    )
                    for i in range(DEPTH)
                )
            )

        self.embed = nn.Conv2d(inputs, embedding, 4, 4)
        self.norm_embed = nn.LayerNorm(embedding)
        self.down = nn.ModuleList(blocks(level) for level in range(len(HEADS)))
        self.merge = nn.ModuleList(Merge(c) for c in channels[:-1])
        self.norm_bottom = nn.LayerNorm(channels[-1])
        self.expand = nn.ModuleList(expand(2 * c, c, 2) for c in channels[:-1])
        self.skip = nn.ModuleList(nn.Linear(2 * c, c) for c in channels[:-1])
        self.up = nn.ModuleList(blocks(level) for level in range(len(HEADS) - 1))
        self.norm_top = nn.LayerNorm(embedding)
        self.expand_last = expand(embedding, embedding, 4)
        self.head = nn.Conv2d(embedding, 4, 1, bias=False)
        for module in self.modules():
            if isinstance(module, nn.Linear):
                nn.init.trunc_normal_(module.weight, std=0.02)
                if module.bias is not None:
                    nn.init.zeros_(module.bias)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, 4, H, W): quality, sin 2θ, cos 2θ, width.

        Sides that are not multiples of 224 are padded by zeros, as the windows need.
        """
        h, w = x.shape[2:]
        side = 4 * WINDOW * 2 ** (len(HEADS) - 1)
        x = functional.pad(x, (0, -w % side, 0, -h % side))
        x = self.norm_embed(self.embed(x).permute(0, 2, 3, 1))
        before = []
        for level, down in enumerate(self.down):
            before.append(x)  # as the authors do: what enters a level, not what leaves it
            x = down(x)
            if level < len(self.merge):
                x = self.merge[level](x)
        x = self.norm_bottom(x)
        for level in reversed(range(len(self.up))):
            x = self.expand[level](x)
            x = self.up[level](self.skip[level](torch.cat([x, before[level]], dim=-1)))
        x = self.expand_last(self.norm_top(x))
        return self.head(x.permute(0, 3, 1, 2))[:, :, :h, :w]
