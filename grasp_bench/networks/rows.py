"""Grasp rectangles as rows of numbers: what detectors learn from and what they put out.

A row is x, y, angle, width, height, value: centre [px of the input, edge 0], direction in which the jaws open
[rad, counter-clockwise], opening and jaw size [px], and a value. In labels it is 1 for a grasp that holds,
0 for one that failed, and :data:`NONE` for a row that only fills up; in answers it is the score, which is 0
where there is no grasp.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn

from grasp_bench.grasps import Grasp, angle_difference, wrap_angle

ROW = 6
NONE = -1.0
"""Value of rows that fill up a table of labels."""
NEAR, ALIKE = 8.0, math.radians(30)
"""Of answers that are nearer than this [px] and differ by less than this [rad], the best is given only."""


class Detector(nn.Module):
    """A network that gives grasps instead of maps.

    ``forward`` maps images (B, C, H, W) to rows (B, N, 6), in any order.
    """

    warm_up = 0
    """Batches that :meth:`prepare` is to be given."""

    def loss(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return 'loss' and its parts, always the same ones.

        Args:
            inputs: (B, C, H, W).
            targets: what the registration says: maps (B, 4, H, W), or rows (B, M, 6).
        """
        raise NotImplementedError

    def prepare(self, inputs: Tensor, targets: Tensor) -> None:
        """Look at the first data before the first step, to set what is not learnt by steps."""


def grasps_from_rows(rows: Tensor, count: int) -> list[Grasp]:
    """Turn rows (N, 6) into at most ``count`` grasps, best first, none of them nearly another."""
    table = rows.detach().float().cpu()
    found: list[Grasp] = []
    for index in table[:, 5].argsort(descending=True, stable=True).tolist():
        x, y, angle, width, _, score = table[index].tolist()
        if len(found) == count or not score > 0:
            break
        grasp = Grasp(x, y, wrap_angle(angle), max(width, 1.0), min(score, 1.0))
        if all(
            math.hypot(grasp.x - other.x, grasp.y - other.y) > NEAR
            or angle_difference(grasp.angle, other.angle) > ALIKE
            for other in found
        ):
            found.append(grasp)
    return found


def rows_from_grasps(grasps: list[tuple[Grasp, float]], side: int, most: int) -> Tensor:
    """Make a table (``most``, 6) of grasps in a picture of ``side`` px with their values.

    Jaws are half as high as the opening, as the rectangle metric takes them. Of more than fit, those of
    highest quality stay; those outside of the picture go.
    """
    inside = [(g, v) for g, v in grasps if 0 <= g.x < side and 0 <= g.y < side]
    inside.sort(key=lambda pair: -pair[0].quality)
    table = torch.zeros(most, ROW)
    table[:, 5] = NONE
    for row, (g, value) in zip(table, inside[:most], strict=False):
        row.copy_(torch.tensor([g.x, g.y, g.angle, g.width, g.width / 2, value]))
    return table


def drawn(targets: Tensor, count: int) -> tuple[Tensor, Tensor]:
    """Draw up to ``count`` different labels that hold of each image.

    Args:
        targets: rows (B, M, 6).

    Returns:
        rows (B, count, 6), and whether each is one (B, count).
    """
    chance = torch.rand(targets.shape[:2], device=targets.device)
    chance = chance.masked_fill(targets[..., 5] <= 0, -1)
    best, index = chance.topk(count, dim=1)
    return targets.gather(1, index[..., None].expand(-1, -1, ROW)), best >= 0


def turned(angle: Tensor, reference: Tensor | float = 0.0) -> Tensor:
    """Return angle − reference of two jaw directions, in [−π/2, π/2)."""
    return torch.remainder(angle - reference + math.pi / 2, math.pi) - math.pi / 2


def cut_out(images: Tensor, rows: Tensor, size: int | tuple[int, int]) -> Tensor:
    """Sample rectangles of images, turned so that their opening lies along x.

    Args:
        images: (B, C, H, W).
        rows: (B, K, 5 or more) x, y, angle, width, height in pixels of ``images``.
        size: samples (rows, columns), evenly spread over a rectangle.

    Returns:
        (B, K, C, *size), bilinear; zero outside of the images.
    """
    high, wide = (size, size) if isinstance(size, int) else size
    b, k = rows.shape[:2]
    rows = rows.float()
    across = (torch.arange(wide, device=rows.device) + 0.5) / wide - 0.5
    down = (torch.arange(high, device=rows.device) + 0.5) / high - 0.5
    u = across * rows[..., 3, None]
    v = down * rows[..., 4, None]
    cos, sin = rows[..., 2].cos()[..., None, None], rows[..., 2].sin()[..., None, None]
    # Along the jaws is (cos, −sin) as rows grow downwards, and down in the patch is (sin, cos).
    x = rows[..., 0, None, None] + u[:, :, None, :] * cos + v[:, :, :, None] * sin
    y = rows[..., 1, None, None] - u[:, :, None, :] * sin + v[:, :, :, None] * cos
    h, w = images.shape[2:]
    grid = torch.stack([2 * x / w - 1, 2 * y / h - 1], dim=-1).reshape(b, k * high, wide, 2)
    found = nn.functional.grid_sample(images.float(), grid, align_corners=False)
    return found.view(b, -1, k, high, wide).transpose(1, 2)
