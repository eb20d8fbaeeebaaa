"""Features of rectangles, and the rectangles that are searched, of Lenz, Lee & Saxena (2013).

A rectangle, turned so that its opening is horizontal, keeps its shape in 24×24 samples, the rest is masked:
depth, luminance and chroma, and the surface's normal, seven modes of 576 numbers each.

Beside the authors' code: depth is the height that all networks here are shown, whose holes are filled
already, so that the only mask is that of shape and of the image's border; normals are of the whole image,
turned with the rectangle, at 1.2 mm a pixel; a rectangle's corner grid is one of centres; sampling is
bilinear.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor
from torch.nn import functional

from grasp_bench.networks.rows import cut_out

SIDE = 24
MODES = 7
FEATURES = MODES * SIDE**2
UNIT = 0.1
"""Metres of a unit of height."""
PIXEL = 1.2e-3
"""Metres a pixel shows at the table."""
LEAST_DEVIATION = 0.01 / UNIT
"""Of the height within a rectangle."""
YUV = (
    (0.3, 0.5881, 0.1118),
    (-0.15 * 255 / 128, -0.2941 * 255 / 128, 0.3882 * 255 / 128),
    (0.35 * 255 / 128, -0.2941 * 255 / 128, -0.0559 * 255 / 128),
)
ANGLES = 12
SIZES = range(7, 64, 7)
STEP = 7
LEAST_HEIGHT = 0.003 / UNIT
DILATED = 14
"""Pixels about an object that are searched, too."""


def prepared(images: Tensor) -> Tensor:
    """Turn (B, 4, H, W), height and colour, into (B, 8, H, W): the seven modes, and ones."""
    height, colour = images[:, :1].float(), images[:, 1:].float()
    yuv = torch.einsum("ij,bjhw->bihw", colour.new_tensor(YUV), colour)
    padded = functional.pad(height * (UNIT / PIXEL), (1, 1, 1, 1), mode="replicate")
    right = (padded[..., 1:-1, 2:] - padded[..., 1:-1, :-2]) / 2
    down = (padded[..., 2:, 1:-1] - padded[..., :-2, 1:-1]) / 2
    normal = functional.normalize(torch.cat([-right, -down, torch.ones_like(down)], dim=1), dim=1)
    return torch.cat([height, yuv, normal, torch.ones_like(height)], dim=1)


def features(images: Tensor, rows: Tensor) -> tuple[Tensor, Tensor]:
    """Return features and their masks (B · K, 7, 576) of rectangles (B, K, ≥ 5) in prepared images."""
    square = rows[..., :5].clone()
    side = rows[..., 3:5].amax(-1).clamp(min=1)
    square[..., 3:5] = side[..., None]
    found = cut_out(images, square, SIDE).flatten(0, 1)
    angle = rows[..., 2].flatten()[:, None, None]
    nx, ny = found[:, 4], found[:, 5]
    turned = torch.stack([nx * angle.cos() - ny * angle.sin(), nx * angle.sin() + ny * angle.cos()], dim=1)
    at = ((torch.arange(SIDE, device=rows.device) + 0.5) / SIDE - 0.5).abs()
    wide, high = (at <= (rows[..., i].flatten() / side.flatten() / 2)[:, None] for i in (3, 4))
    mask = (high[:, :, None] & wide[:, None, :] & (found[:, 7] > 0.75)).float()
    number = mask.sum((1, 2)).clamp(min=1)[:, None, None]
    height = found[:, 0] - (found[:, 0] * mask).sum((1, 2), keepdim=True) / number
    deviation = ((height.square() * mask).sum((1, 2), keepdim=True) / number).sqrt()
    height = height / deviation.clamp(min=LEAST_DEVIATION)
    values = torch.cat([height[:, None], found[:, 1:4], turned, found[:, 6:7]], dim=1)
    values = (values * mask[:, None]).flatten(2)
    return values, mask[:, None].expand(-1, MODES, -1, -1).flatten(2)


def candidates(image: Tensor) -> Tensor:
    """Return the rectangles (N, 5) of a (1, 4, H, W) image that lie by half on what stands on the table."""
    high = (image[:, :1] > LEAST_HEIGHT).float()
    high = -functional.max_pool2d(-high, 3, 1, 1)  # single pixels are noise
    region = functional.max_pool2d(high, 2 * DILATED + 1, 1, DILATED)
    y, x = (region[0, 0, ::STEP, ::STEP] > 0).nonzero(as_tuple=True)
    if not len(y):
        return image.new_zeros(0, 5)
    shapes = [(w, h) for w in SIZES for h in SIZES if w >= h]
    turns = [math.pi * i / ANGLES for i in range(ANGLES)]
    kinds = image.new_tensor([(turn, w, h) for turn in turns for w, h in shapes])
    places = STEP * torch.stack([x, y], dim=-1).to(image.dtype) + 0.5
    rows = torch.cat([places[:, None].expand(-1, len(kinds), -1), kinds.expand(len(places), -1, -1)], dim=-1)
    rows = rows.flatten(0, 1)
    share = torch.cat([cut_out(region, part[None], 4).mean((2, 3, 4))[0] for part in rows.split(20_000)])
    half = rows[:, 3:5] / 2
    reach = half[:, :1] * rows[:, 2:3].cos().abs() + half[:, 1:] * rows[:, 2:3].sin().abs()
    reach = torch.cat(
        [reach, half[:, :1] * rows[:, 2:3].sin().abs() + half[:, 1:] * rows[:, 2:3].cos().abs()], dim=1
    )
    limit = rows.new_tensor([image.shape[3], image.shape[2]])
    inside = ((rows[:, :2] >= reach) & (rows[:, :2] + reach <= limit)).all(1)
    return rows[(share >= 0.5) & inside]
