"""The loss of section 3.3.3, and the variant that learns faster."""

from __future__ import annotations

from torch import Tensor
from torch.nn import functional


def grasp_loss(
    output: Tensor,
    target: Tensor,
    *,
    masked: bool = True,
    geometry_weight: float = 0.1,
    positive_weight: float = 0.0,
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

    Returns:
        'loss' and its parts 'quality', 'sin', 'cos', 'width' before weighting.
    """
    error = functional.smooth_l1_loss(output.float(), target, reduction="none")
    positive = (target[:, :1] > 0).float()
    quality = (error[:, :1] * (1 + positive_weight * positive)).mean()
    if masked:
        geometry = (error[:, 1:] * positive).sum(dim=(0, 2, 3)) / positive.sum().clamp(min=1)
    else:
        geometry = error[:, 1:].mean(dim=(0, 2, 3))
    loss = quality + (geometry_weight if masked else 1.0) * geometry.sum()
    return {"loss": loss, "quality": quality, "sin": geometry[0], "cos": geometry[1], "width": geometry[2]}
