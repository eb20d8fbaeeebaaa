"""What was found about a network after its training: how much wider to open, how likely its grasps hold.

It stands in the metadata of the weights and belongs to the predictor: nothing of it is the planner's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from grasp_bench.errors import AssetError
from grasp_bench.grasps import Grasp
from grasp_bench.networks.encoding import WIDTH_SCALE

if TYPE_CHECKING:
    import torch

KEY = "calibration"
"""Where it stands in the metadata."""
WIDEST = 100.0
"""Pixels by which no calibration widens."""


@dataclass(frozen=True)
class Calibration:
    """Corrections of a network's answers.

    Attributes:
        widening: added to every predicted opening [px of the network's input].
        intercept, slope: a grasp of quality q holds with probability 1 / (1 + exp(−intercept − slope · q));
            None where qualities stay what the network says.
    """

    widening: float = 0.0
    intercept: float | None = None
    slope: float | None = None

    def widened(self, output: torch.Tensor) -> torch.Tensor:
        """Return one image's maps (4, H, W) or rows (N, 6) with wider openings."""
        if not self.widening:
            return output
        output = output.clone()
        if output.ndim == 3:
            output[3] += self.widening / WIDTH_SCALE
        else:
            output[:, 3] += self.widening
        return output

    def judged(self, grasp: Grasp) -> Grasp:
        """Return a grasp whose quality is the probability that it holds; their order stays."""
        if self.intercept is None or self.slope is None:
            return grasp
        exponent = self.intercept + self.slope * grasp.quality
        return replace(grasp, quality=1 / (1 + math.exp(-max(min(exponent, 30.0), -30.0))))


def calibration_of(metadata: dict[str, Any], file: str) -> Calibration:
    """Read what metadata of weights say; nothing where they say nothing.

    Args:
        metadata: as of :meth:`grasp_bench.networks.store.WeightsFile.metadata`.
        file: named in messages.

    Raises:
        AssetError: what stands there is no calibration.
    """
    told = metadata.get(KEY)
    if told is None:
        return Calibration()
    try:
        widening = float(told["widening_px"])
        fit = [float(value) for value in told["quality"]] if told.get("quality") is not None else None
        if not 0 <= widening <= WIDEST or (fit and not all(map(math.isfinite, fit))):
            raise ValueError
        intercept, slope = fit or (None, None)
        if slope is not None and slope <= 0:
            raise ValueError
    except (TypeError, ValueError, KeyError, AttributeError):
        raise AssetError(
            f"{file}: its calibration is not 'widening_px' from 0 to {WIDEST:g} and 'quality' of two "
            "numbers, the second above 0; run `grasp-bench calibrate` on the file again."
        ) from None
    return Calibration(widening, intercept, slope)
