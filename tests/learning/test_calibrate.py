"""Openings and qualities are calibrated by what holds in physics, and stored with the weights."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from test_course import Answers, best_grasp, scenes  # noqa: F401 (six held-out scenes)
from torch import Tensor, nn
from typer.testing import CliRunner

from grasp_bench.cli.commands import app
from grasp_bench.errors import AssetError
from grasp_bench.grasps import Grasp
from grasp_bench.learning.training import held_out
from grasp_bench.learning.training.calibrate import WIDENINGS, _least, calibrate
from grasp_bench.learning.training.held_out import HeldOut
from grasp_bench.networks.calibration import KEY, Calibration, calibration_of
from grasp_bench.networks.registry import build
from grasp_bench.networks.store import WeightsFile
from grasp_bench.networks.weights import load, save
from grasp_bench.predictors.network import NetworkPredictor
from grasp_bench.system.integrity import MANIFEST, sha256


class Bounded:
    """A scene in which openings from ``least`` pixels on hold, and qualities above a limit."""

    def __init__(self, scene: HeldOut, least: float, quality: float = 0.0) -> None:
        self.image, self.least, self.quality = scene.image, least, quality

    def holds(self, grasp: Grasp) -> bool:
        return grasp.width >= self.least and grasp.quality > self.quality


class Rows(nn.Module):
    """Puts out three grasps of falling quality, far from each other, always 40 px wide."""

    def __init__(self) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.zeros(1))

    def forward(self, x: Tensor) -> Tensor:
        return torch.tensor([[[50.0 * i, 50, 0, 40, 20, 1 - 0.3 * i] for i in (1, 2, 3)]])


def test_the_least_opening_with_which_most_hold_is_chosen(scenes: list[HeldOut]) -> None:  # noqa: F811
    found = calibrate(Rows(), "depth", [Bounded(s, 45) for s in scenes])  # type: ignore[misc]
    assert found.held == (0, 0, 6, 6, 6, 6, 6)
    assert WIDENINGS[2] == found.calibration.widening == 6
    assert found.scenes == 6
    assert found.grasps == 12


def test_nothing_is_widened_where_that_helps_nobody(scenes: list[HeldOut]) -> None:  # noqa: F811
    grasps = [best_grasp(scene) for scene in scenes]
    found = calibrate(Answers(grasps), "depth", scenes)
    held = [
        sum(s.holds(replace(g, width=g.width + w)) for s, g in zip(scenes, grasps, strict=True))
        for w in WIDENINGS
    ]
    assert list(found.held) == held
    assert found.calibration.widening == 0, held


def test_an_opening_that_loses_what_chance_might_is_wide_enough() -> None:
    held = np.zeros((200, 2))
    held[:150] = 1
    held[150:156, 1], held[160:163, 0] = 1, 1
    assert held.sum(0).tolist() == [153, 156]
    assert _least(held) == 0, "6 gained and 3 lost are 3 ± 3"
    held[156, 1] = 1
    assert _least(held) == 0, "7 gained and 3 lost are 4 - 1 ± 3.2"
    held[157, 1] = 1
    assert _least(held) == 1, "8 gained and 3 lost are 5 - 1 ± 3.3"
    held[:] = 1
    assert _least(held) == 0
    held[0, 0] = 0
    assert _least(held) == 0, "a single scene tells nothing"
    held[1, 0] = 0
    assert _least(held) == 0, "nor do two: 2 - 1 ± 1.4"
    held[2, 0] = 0
    assert _least(held) == 1, "3 gained are 3 - 1 ± 1.7, all on one side"


def test_quality_becomes_a_probability_and_keeps_its_order(scenes: list[HeldOut]) -> None:  # noqa: F811
    many = [Bounded(s, 0, 0.25 + 0.1 * i) for i, s in enumerate(scenes) for _ in range(5)]
    found = calibrate(Rows(), "depth", many)  # type: ignore[misc]
    judged = [found.calibration.judged(Grasp(0, 0, 0, 1, q)).quality for q in (0.1, 0.4, 0.7)]
    assert judged == sorted(judged)
    assert judged[0] < 0.15
    assert judged[1] == pytest.approx(2 / 6, abs=0.15)
    assert judged[2] == pytest.approx(5 / 6, abs=0.15)


def test_a_quality_that_misleads_stays_as_it_is(scenes: list[HeldOut]) -> None:  # noqa: F811
    class Backwards(Bounded):
        def holds(self, grasp: Grasp) -> bool:
            return grasp.quality < 0.5

    found = calibrate(Rows(), "depth", [Backwards(s, 0) for s in scenes])  # type: ignore[misc]
    assert found.calibration.slope is None
    grasp = Grasp(1, 2, 0.3, 40, 0.7)
    assert found.calibration.judged(grasp) == grasp


def test_the_command_stores_it_and_predictors_use_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    torch.manual_seed(1)
    file = tmp_path / "gg-cnn.safetensors"
    network = build("gg-cnn", "rgbd")
    facts = {
        "network": "gg-cnn", "input": "rgbd 224", "parameters": 1, "reference": "x", "steps": 1, "seed": 0,
        "config": {}, "commands": "grasp-bench train", "accuracy": {"top1": [0, 0], "rectangle": [0, 0]},
        "data": {"folders": ["d"], "fingerprint": "f", "train": 1, "val": 1},
    }  # fmt: skip
    save(network, file, facts)
    WeightsFile(file).enter_in_manifest()
    before = load("gg-cnn", file)[0].state_dict()
    plain = NetworkPredictor("gg-cnn", file)
    scene = held_out.held_out_scenes(1, 224)[0]
    monkeypatch.setattr(held_out, "_held_out", lambda index, crop: Bounded(scene, 1.0))
    result = CliRunner().invoke(
        app, ["calibrate", "gg-cnn", "--weights", str(file), "--scenes", "20"], catch_exceptions=False
    )
    assert result.exit_code == 0, result.output
    stored = WeightsFile(file).metadata()
    assert stored[KEY]["scenes"] == 20
    assert {k: v for k, v in stored.items() if k != KEY} == facts
    assert f"--weights runs/gg-cnn/{file.name} --scenes 20" in file.with_suffix(".md").read_text()
    after = load("gg-cnn", file)[0].state_dict()
    assert all(torch.equal(before[k], after[k]) for k in before)

    digests = json.loads((tmp_path / MANIFEST).read_text())
    assert digests == {file.name: sha256(file)}, "the manifest follows"

    widened = NetworkPredictor("gg-cnn", file)
    widened.calibration = Calibration(8.0, -1.0, 3.0)
    for a, b in zip(plain.predict(scene.image), widened.predict(scene.image), strict=True):
        assert (a.x, a.y, a.angle) == (b.x, b.y, b.angle)
        assert b.width >= a.width  # all negative widths of an untrained network become one pixel
        assert b.quality == pytest.approx(1 / (1 + math.exp(1 - 3 * a.quality)))
    maps = plain.maps(scene.image).width, widened.maps(scene.image).width
    wide = maps[0] > 0
    np.testing.assert_allclose(maps[1][wide], maps[0][wide] + 8, atol=1e-4)


def test_weights_of_a_fold_are_calibrated_and_have_no_page(
    tmp_path: Path,
    scenes: list[HeldOut],  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    file = tmp_path / "gg-cnn.safetensors"
    save(build("gg-cnn", "rgbd"), file, {"network": "gg-cnn", "input": "rgbd 224", "left_out": ["a"]})
    monkeypatch.setattr(held_out, "_held_out", lambda index, crop: Bounded(scenes[0], 1.0))
    result = CliRunner().invoke(
        app, ["calibrate", "gg-cnn", "--weights", str(file), "--scenes", "1"], catch_exceptions=False
    )
    assert result.exit_code == 0, result.output
    assert WeightsFile(file).metadata()[KEY]["scenes"] == 1
    assert [p.name for p in tmp_path.iterdir()] == [file.name]


@pytest.mark.parametrize(
    "told",
    [
        [],
        {},
        {"widening_px": -1},
        {"widening_px": float("nan")},
        {"widening_px": 1e9},
        {"widening_px": 3, "quality": [1]},
        {"widening_px": 3, "quality": [0, -2]},
        {"widening_px": 3, "quality": "ab"},
        {"widening_px": 3, "quality": [0, float("inf")]},
    ],
)
def test_what_is_no_calibration_is_refused_naming_the_file(told: object) -> None:
    with pytest.raises(AssetError, match=r"strange.safetensors.*grasp-bench calibrate"):
        calibration_of({KEY: told}, "strange.safetensors")


def test_weights_without_one_answer_as_they_are() -> None:
    assert calibration_of({}, "x") == Calibration()
    output = torch.rand(4, 5, 5)
    assert Calibration().widened(output) is output
    rows = torch.rand(3, 6)
    torch.testing.assert_close(Calibration(6.0).widened(rows)[:, 3], rows[:, 3] + 6)
