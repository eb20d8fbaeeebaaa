"""The numbered examples are predictors that work."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.predictors import load_predictor
from grasp_bench.predictors.protocol import checked

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.mark.parametrize("path", ["01_my_predictor:Highest"])
def test_an_example_grasps_what_stands_out(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(EXAMPLES)
    intrinsics = Intrinsics.from_fov(640, 480, np.pi / 2)
    depth = np.full((480, 640), 0.55, np.float32)
    depth[200:230, 300:360] = 0.5
    image = RgbdImage(np.zeros((480, 640, 3), np.uint8), depth, intrinsics)
    best = checked(load_predictor(path).predict(image), intrinsics)[0]
    assert 300 <= best.x <= 360
    assert 200 <= best.y <= 230
