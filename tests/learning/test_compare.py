"""Figures of several predictors side by side."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from real_samples import write_cornell
from test_training import folder  # noqa: F401 (eight synthetic scenes)
from typer.testing import CliRunner

from grasp_bench.cli.data import data_app
from grasp_bench.errors import GraspBenchError
from grasp_bench.grasps import Grasp, GraspMaps
from grasp_bench.learning.evaluation.compare import BAR, compare, images
from grasp_bench.media.pictures import TILE
from grasp_bench.predictors.network import NetworkPredictor

GRASPS = [Grasp(300 + 5 * i, 250 - 4 * i, -1.2 + 0.4 * i, 60.0) for i in range(3)]


class Says:
    """Answers one grasp, with maps that are zero but for a square at the upper left."""

    crop_origin = (0, 0)

    def __init__(self, maps: bool) -> None:
        self.last_maps = None
        if maps:
            made = GraspMaps(*np.zeros((4, 224, 224), np.float32))
            made.quality[:50, :50] = 1
            made.cos2[:50, :50] = 1
            made.width[:50, :50] = 1000
            self.last_maps = made

    def predict(self, image) -> list[Grasp]:
        return [Grasp(120.0, 100.0, 0.5, 40.0, 0.75)]


def test_a_row_for_each_predictor_and_image(folder: Path) -> None:  # noqa: F811
    shown = list(images(folder, 2))
    assert len({one.name for one in shown}) == 2
    sheet = compare(shown, {"dense": Says(True), "sparse": Says(False)})
    assert sheet.shape == (BAR + 2 * (BAR + 2 * TILE), 4 * TILE, 3)
    dense = sheet[2 * BAR : 2 * BAR + TILE]
    best, quality, angle, width = (dense[:, TILE * i : TILE * (i + 1)].astype(int) for i in range(4))
    assert (best[60:140, 60:180] != shown[0].image.rgb[60:140, 60:180]).any(), "the grasp is drawn"
    for tile in (quality, angle, width):
        assert np.abs(tile[25, 25] - tile[150, 150]).max() > 80
        assert (tile[:49, :49] == tile[5, 5]).all(), "where the map is, and nowhere else"
        assert (tile[52:, 52:] == tile[150, 150]).all()
    grey = sheet[2 * BAR + TILE : 2 * BAR + 2 * TILE, TILE:]
    assert (grey == grey[0, 0]).all(), "a detector has no maps"


def test_real_samples_and_trials_that_are_none(tmp_path: Path) -> None:
    root = write_cornell(tmp_path / "cornell", GRASPS)
    out = tmp_path / "figure.png"
    command = ["compare", str(root), "--predictors", "gg-cnn,centroid", "--count", "2", "--out", str(out)]
    result = CliRunner().invoke(data_app, command)
    assert result.exit_code == 0, result.output
    assert "pcd0100" in result.output
    picture = cv2.imread(str(out))
    assert picture is not None
    assert picture.shape == (BAR + 2 * (BAR + 2 * TILE), 4 * TILE, 3)
    with pytest.raises(GraspBenchError, match="--trial is for a run"):
        list(images(root, 1, trial=3))
    for path in root.rglob("*d.tiff"):
        path.unlink()
    with pytest.raises(GraspBenchError, match="gg-cnn is shown depth, and cornell pcd0100 has no depth"):
        compare(list(images(root, 1)), {"gg-cnn": NetworkPredictor("gg-cnn")})
