"""What networks that judge one grasp at a time learn from: grasps that held, and grasps that did not."""

from __future__ import annotations

import math

import torch
from torch import Tensor


def examples(targets: Tensor, each: int) -> tuple[Tensor, Tensor, Tensor]:
    """Draw as many grasps of each image that hold as such that do not.

    Half of the latter are grasps that failed in physics, where the image has any; the others are grasps that
    hold, turned by 45° to 90° either way, or moved by up to their opening.

    Args:
        targets: rows (B, M, 6), see :mod:`grasp_bench.networks.rows`.
        each: of both kinds.

    Returns:
        rows (B, 2 · each, 6), whether each holds, and whether it is one at all (B, 2 · each).
    """
    b, _, _ = targets.shape
    held, failed = targets[..., 5] > 0, targets[..., 5] == 0

    def draw(allowed: Tensor) -> Tensor:
        chance = allowed.float() + 1e-9  # some row of an image without any; it is marked as none
        index = torch.multinomial(chance, each, replacement=True)
        return targets.gather(1, index[..., None].expand(-1, -1, 6))

    good, bad, wrong = draw(held), draw(failed), draw(held)
    amount = torch.rand(b, each, 3, device=targets.device)
    turn = math.pi / 4 * (1 + 2 * amount[..., 0])
    moves = amount[..., 0] < 0.3
    wrong[..., 2] = torch.where(moves, wrong[..., 2], wrong[..., 2] + turn)
    far = (0.5 + amount[..., 1, None]) * wrong[..., 3, None]
    way = 2 * math.pi * amount[..., 2]
    step = far * torch.stack([way.cos(), way.sin()], dim=-1)
    wrong[..., :2] = torch.where(moves[..., None], wrong[..., :2] + step, wrong[..., :2])
    really = (torch.rand(b, each, device=targets.device) < 0.5) & failed.any(1)[:, None]
    really |= ~held.any(1)[:, None]
    rows = torch.cat([good, torch.where(really[..., None], bad, wrong)], dim=1)
    label = torch.arange(2 * each, device=targets.device).expand(b, -1) < each
    known = torch.where(label, held.any(1)[:, None], (held | failed).any(1)[:, None])
    return rows, label, known
