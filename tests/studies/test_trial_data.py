"""A run's trials as a Parquet data set: images are those of the trials, numbers those of the records."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import grasp_bench
from grasp_bench.camera import RgbdImage
from grasp_bench.errors import ResultsError
from grasp_bench.predictors.controls import Centroid
from grasp_bench.studies import trial_data
from grasp_bench.studies.trial_data import DEPTH_UNIT, export_trials

pq = pytest.importorskip("pyarrow.parquet", reason="the extra parquet is not installed")


class Keeps(Centroid):
    """Keeps what it was shown."""

    def __init__(self) -> None:
        self.images: list[RgbdImage] = []

    def predict(self, image: RgbdImage) -> Any:
        self.images.append(image)
        return super().predict(image)


def test_a_row_is_a_trial(tmp_path: Path) -> None:
    keeps, out = Keeps(), tmp_path / "trials.parquet"
    run = grasp_bench.run(["egg", "tea_box"], 3, keeps, "graded", out=tmp_path / "run", progress=False)
    counted: list[int] = []
    assert export_trials(tmp_path / "run", out, progress=counted.append) == 3
    assert counted == [3]
    assert not list(tmp_path.glob("*.part"))
    table = pq.read_table(out)
    features = json.loads(table.schema.metadata[b"huggingface"])["info"]["features"]
    assert list(features) == table.column_names
    assert features["rgb"] == {"_type": "Image"}
    rows = table.to_pylist()
    for row, record, image in zip(rows, run.records, keeps.images, strict=True):
        assert (row["object"], row["outcome"]) == (record.object, str(record.outcome))
        rgb = cv2.imdecode(np.frombuffer(row["rgb"]["bytes"], np.uint8), cv2.IMREAD_COLOR)
        assert rgb is not None
        np.testing.assert_array_equal(rgb[..., ::-1], image.rgb)
        depth = cv2.imdecode(np.frombuffer(row["depth"]["bytes"], np.uint8), cv2.IMREAD_UNCHANGED)
        assert depth is not None
        np.testing.assert_allclose(depth * DEPTH_UNIT, image.depth, atol=DEPTH_UNIT)
        assert record.grasp is not None
        assert row["grasp_x"] == record.grasp.x
        assert row["margin_force"] == (record.margin.force if record.margin else None)
        if record.pose is not None:
            seen = np.array(row["tcp_position_camera"])
            assert image.intrinsics.project(seen)[0] == pytest.approx(record.grasp.x, abs=12)
            assert row["opening"] == record.pose.opening


def test_clutter_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Cluttered:
        class info:  # noqa: N801
            cluttered = True

    monkeypatch.setattr(trial_data, "RunResults", lambda folder: Cluttered)
    with pytest.raises(ResultsError, match="run of clutter"):
        export_trials(tmp_path, tmp_path / "x.parquet")
