"""Grasps by predicted quality: the intervals of a reliability diagram, and how far they are off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grasp_bench.runs.statistics import Rate
from grasp_bench.system.arrays import Floats


@dataclass(frozen=True)
class Bin:
    """Grasps of about the same predicted quality: its mean, and how many of them held."""

    quality: float
    held: Rate


def intervals(quality: Floats, bins: int) -> NDArray[np.int_]:
    """Return (n,) the interval of each quality in [0, 1], of ``bins`` intervals of equal width."""
    return (quality * bins).astype(int).clip(max=bins - 1)


def binned(quality: Floats, success: NDArray, index: NDArray[np.int_]) -> list[Bin]:
    """Return the intervals ``index`` (n,) that hold a grasp, in order."""
    return [
        Bin(float(quality[index == i].mean()), Rate(int(success[index == i].sum()), int((index == i).sum())))
        for i in np.unique(index)
    ]


def calibration_error(quality: Floats, success: NDArray, index: NDArray[np.int_]) -> float:
    """Return the expected calibration error: the mean over grasps of |quality − rate| of their intervals.

    M. P. Naeini et al., “Obtaining well calibrated probabilities using Bayesian binning”, AAAI 2015.
    """
    return float(np.abs(np.bincount(index, quality - success)).sum() / len(quality))
