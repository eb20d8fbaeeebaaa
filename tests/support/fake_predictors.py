"""Predictors that misbehave, for tests; found by workers as ``fake_predictors:NAME``."""

from __future__ import annotations

import os
import time

import numpy as np

from grasp_bench.camera import RgbdImage
from grasp_bench.grasps import Grasp


class ByColour:
    """Fails by what it sees: dies at the red pot, sleeps at the blue block, proposes nothing for the rest."""

    def predict(self, image: RgbdImage) -> list[Grasp]:
        rgb = image.rgb.astype(int)
        red, blue = rgb[..., 0] - rgb[..., 2], rgb[..., 2] - rgb[..., 0]
        if np.count_nonzero(blue > 50) > 200:
            time.sleep(120)
        if np.count_nonzero((red > 50) & (rgb[..., 1] < 90)) > 200:
            os._exit(7)
        return []


class Unbuildable:
    """Cannot even be made."""

    def __init__(self) -> None:
        raise RuntimeError("no weights here")


class Silent:
    """Has no method predict."""


def function(image: RgbdImage) -> list[Grasp]:
    """A function is no predictor."""
    return []
