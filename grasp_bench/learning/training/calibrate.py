"""Finds out in physics how much wider than predicted to open, and how likely grasps of a quality hold.

A network that learns openings by their mean error opens too little as often as too much, and only the
first is punished: a finger comes down on the object. And a quality ranks grasps, but says nothing until it
is held against what happens. Both are measured on held-out scenes that are neither trained on nor validated
on (:mod:`grasp_bench.learning.training.held_out`): the best two grasps of each are carried out as
predicted, at each of a few openings. The least opening with which no fewer *best* grasps hold than with any
other counts, but for chance; with it a logistic curve is fitted through all grasps (J. Platt, "Probabilistic
outputs for support vector machines", 1999), which keeps their order.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from torch import nn

from grasp_bench.grasps import Grasp
from grasp_bench.learning.training.held_out import HeldOut, answered
from grasp_bench.networks.calibration import Calibration
from grasp_bench.networks.spec import Kind
from grasp_bench.report.difficulty import logistic
from grasp_bench.system.arrays import Floats

FIRST = 10_000
"""First of the held-out scenes for this; those before it are validated on."""
WIDENINGS = (0.0, 3.0, 6.0, 9.0, 12.0, 16.0, 20.0)
"""Openings tried beyond the predicted one [px]."""
GRASPS = 2
"""Best grasps of a scene that are tried."""


@dataclass(frozen=True)
class Calibrated:
    """A calibration, and what it was chosen by.

    Attributes:
        calibration: what was found.
        held: scenes whose best grasp held, for each of ``WIDENINGS``.
        scenes: of how many.
        grasps: number of grasps that the curve of qualities was fitted to.
    """

    calibration: Calibration
    held: tuple[int, ...]
    scenes: int
    grasps: int

    def facts(self) -> dict[str, Any]:
        """Return what stands in the metadata of weights."""
        found = self.calibration
        fit = None if found.slope is None else [round(found.intercept or 0.0, 4), round(found.slope, 4)]
        return {
            "widening_px": found.widening,
            "quality": fit,
            "held": {f"{w:g}": k for w, k in zip(WIDENINGS, self.held, strict=True)},
            "scenes": self.scenes,
            "grasps": self.grasps,
        }

    def __str__(self) -> str:
        told = ", ".join(f"{w:g} px {k}" for w, k in zip(WIDENINGS, self.held, strict=True))
        return f"best grasps held of {self.scenes}, opened wider by: {told}"


@torch.inference_mode()
def calibrate(network: nn.Module, kind: Kind, scenes: Iterable[HeldOut]) -> Calibrated:
    """Calibrate a network.

    Args:
        network: in evaluation mode; its answers are taken as they are.
        kind: what it is shown.
        scenes: held-out scenes, each looked at once.
    """
    tried: list[list[tuple[float, list[bool]]]] = []
    for scene in scenes:
        grasps = answered(network, scene, kind, GRASPS)
        tried.append([(grasp.quality, _held(scene, grasp)) for grasp in grasps])
    best = np.array([rows[0][1] if rows else [False] * len(WIDENINGS) for rows in tried], bool)
    best = best.reshape(-1, len(WIDENINGS)).astype(float)
    held, chosen = best.sum(0), _least(best)
    pairs = [(quality, outcomes[chosen]) for rows in tried for quality, outcomes in rows]
    return Calibrated(_fitted(WIDENINGS[chosen], pairs), tuple(map(int, held)), len(tried), len(pairs))


def _least(held: Floats) -> int:
    """Return the first column of (scenes, openings) that loses no more to the best than chance might.

    By the rule of one standard error (L. Breiman and others, Classification and Regression Trees, 1984), here
    McNemar's: the root of the number of scenes in which only one of two openings holds, with Edwards's
    correction for counts (Psychometrika 13, 1948), as two scenes to none are no evidence. The largest of
    several noisy counts alone says too much for wide openings, which collide where others stand near.
    """
    lost = held[:, [held.sum(0).argmax()]] - held
    return int((lost.sum(0) - 1 <= np.sqrt(np.abs(lost).sum(0))).argmax())


def _held(scene: HeldOut, grasp: Grasp) -> list[bool]:
    return [scene.holds(replace(grasp, width=grasp.width + wider)) for wider in WIDENINGS]


def _fitted(widening: float, pairs: Sequence[tuple[float, bool]]) -> Calibration:
    if not pairs:
        return Calibration(widening)
    quality, held = np.array(pairs, float).T
    one = np.ones_like(quality)
    intercept, slope = (float(v) for v in logistic(quality, held, one, one[None])[0])
    # A quality that does not rise with success is worth nothing as a probability, and its order must stay.
    return Calibration(widening, intercept, slope) if slope > 0 else Calibration(widening)
