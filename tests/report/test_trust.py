"""Quality against success, and picks an hour: from records alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_runs import write_run

from grasp_bench.report.tables import markdown
from grasp_bench.report.trust import Trust, calibration, trust_table
from grasp_bench.runs.folder import load_timings
from grasp_bench.runs.results import RunResults

RNG = np.random.default_rng(7)
TRUE = RNG.uniform(0.2, 1.0, 400)
HELD = RNG.random(400) < TRUE


def test_a_probability_is_taken_for_one() -> None:
    found = calibration(TRUE, HELD.tolist())
    assert found is not None
    assert found.verdict == "in keeping with a probability"
    assert found.error < 2 * found.by_chance
    assert sum(b.held.trials for b in found.bins) == 400
    rates = [found.coverage[share].rate for share in (0.25, 0.5, 0.75, 0.9, 1.0)]
    assert rates == sorted(rates, reverse=True), "the surest grasps hold most often"
    assert found.coverage[1.0] == found.held


@pytest.mark.parametrize(
    ("said", "verdict"),
    [
        (0.5 + TRUE / 2, "over-confident"),
        (TRUE / 2, "under-confident"),
        (np.where(TRUE.mean() < TRUE, 1.0, 0.2), "no probability: too high here, too low there"),
    ],
)
def test_a_planted_bias_is_caught(said: np.ndarray, verdict: str) -> None:
    found = calibration(said, HELD.tolist())
    assert found is not None
    assert found.verdict == verdict
    assert found.error > 2 * found.by_chance


def test_bins_and_error_by_hand() -> None:
    found = calibration(np.array([0.1, 0.11, 0.95, 1.0]), [False, True, True, True])
    assert found is not None
    assert [(round(b.quality, 3), str(b.held)[:3]) for b in found.bins] == [(0.105, "1/2"), (0.975, "2/2")]
    assert found.error == pytest.approx((2 * (0.5 - 0.105) + 2 * (1 - 0.975)) / 4)
    assert found.area == pytest.approx((0 + 0 + 0 + 1 / 4) / 4), "the third is the 0.11 that held"


def test_nothing_said_is_nothing_found() -> None:
    assert calibration(np.array([]), []) is None
    assert calibration(np.full(9, 0.5), [True] * 9) is None


def test_of_a_run(tmp_path: Path) -> None:
    def grasped(record: dict[str, Any]) -> dict[str, Any]:
        if record["trial"] == 8:  # nothing was carried out
            return record
        grasp = {"x": 1.0, "y": 1.0, "angle": 0.0, "width": 9.0, "quality": 0.1 * record["trial"]}
        return record | {"grasp": grasp, "sim_steps": 1000}

    folder = write_run(tmp_path / "run", 9, lambda trial: trial % 2 == 0, change=grasped)
    lines = [{"trial": t, "predict": 0.5, "plan": 0.25, "execute": 60.0} for t in range(9)]
    (folder / "timings.jsonl").write_text("".join(json.dumps(t) + "\n" for t in lines))
    found = Trust.of(RunResults(folder), load_timings(folder))
    assert (found.without, found.picks.lifted) == (1, 5)
    assert found.picks.motion == pytest.approx(8 * 1000 * 0.002)
    assert found.picks.computing == pytest.approx(9 * 0.75), "what simulates costs a robot nothing"
    assert found.picks.an_hour == pytest.approx(3600 * 5 / (16 + 6.75))
    assert json.loads(json.dumps(found.to_json(), allow_nan=False))["no_grasp_carried_out"] == 1
    table = markdown([trust_table([("mine", found)])])
    assert "| mine | 0.35 | 4/8 |" in table
