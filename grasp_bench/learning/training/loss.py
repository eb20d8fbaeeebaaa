"""The loss of section 3.3.3, and the variant that learns faster."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor
from torch.autograd import Function

WIDTH = 3
"""Which of the maps the width is."""


def grasp_loss(
    output: Tensor,
    target: Tensor,
    *,
    masked: bool = True,
    geometry_weight: float = 0.1,
    positive_weight: float = 0.0,
    width_weight: float = 1.0,
    width_expectile: float = 0.5,
) -> dict[str, Tensor]:
    """Compute the smooth L1 loss (equation 8) over the four maps (equation 7).

    Unmasked, the paper's sum of four means over all pixels: a network is then asked for
    sin 2θ = cos 2θ = width = 0 wherever there is nothing to grasp, 97 % of the image.
    Masked, angle and width count only where there is a grasp, as means over those pixels.

    Args:
        output, target: (B, 4, H, W) quality, sin 2θ, cos 2θ, width.
        masked: count angle and width only where there is a grasp.
        geometry_weight: factor of each masked mean; 1 is meant for unmasked, which ignores it.
        positive_weight: extra weight of quality errors where there is a grasp.
        width_weight: factor of width errors besides; as parts of ``WIDTH_SCALE`` they are far smaller than
            those of angles.
        width_expectile: share τ of the weight that too narrow openings have, the rest is of too wide ones:
            with small errors the expectile τ of the width is learnt instead of its mean (Newey and Powell,
            Econometrica 55, 1987), wider by more where the network is less sure.

    Returns:
        'loss' and its parts 'quality', 'sin', 'cos', 'width' before weighting.
    """
    loss, *parts = _Loss.apply(
        output, target, masked, geometry_weight, positive_weight, width_weight, width_expectile
    )
    return {"loss": loss, **dict(zip(("quality", "sin", "cos", "width"), parts, strict=True))}


class _Loss(Function):
    """The loss with its gradient at once, map by map: a quarter of the time of automatic differentiation,
    whose temporaries are as large as the output."""

    @staticmethod
    def forward(
        ctx: Any,
        output: Tensor,
        target: Tensor,
        masked: bool,
        geometry_weight: float,
        positive_weight: float,
        width_weight: float,
        width_expectile: float,
    ) -> tuple[Tensor, ...]:
        positive = (target[:, 0] > 0).float()
        stressed = 1 + positive_weight * positive if positive_weight else None
        pixels, grasps = positive.numel(), positive.sum().clamp_(min=1)
        geometry_weight = geometry_weight if masked else 1.0
        rest = (positive, grasps) if masked else (None, pixels)
        factors = (1.0, geometry_weight, geometry_weight, geometry_weight * width_weight)
        gradient = torch.empty_like(output)
        parts = []
        for i, (counted, count) in enumerate([(stressed, pixels), rest, rest, rest]):
            error = output[:, i] - target[:, i]
            if i == WIDTH and width_expectile != 0.5:
                aside = torch.where(error < 0, 2 * width_expectile, 2 * (1 - width_expectile))
                counted = aside if counted is None else aside * counted
            slope = error.clamp(-1, 1)
            error.sub_(slope, alpha=0.5).mul_(slope)  # smooth L1: e² / 2 up to 1, then |e| - 1/2
            if counted is not None:
                error.mul_(counted)
                slope.mul_(counted)
            parts.append(error.sum() / count)
            gradient[:, i] = slope.mul_(factors[i] / count)
        loss = torch.stack([factor * part for factor, part in zip(factors, parts, strict=True)]).sum()
        ctx.save_for_backward(gradient)
        ctx.mark_non_differentiable(*parts)
        return loss, *parts

    @staticmethod
    def backward(ctx: Any, *gradients: Tensor) -> tuple[Tensor | None, ...]:
        (gradient,) = ctx.saved_tensors
        return gradient * gradients[0], *[None] * 6
