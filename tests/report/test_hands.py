"""Predictors against robots, on the trials in common."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from grasp_bench.report.hands import Hands
from grasp_bench.report.screen import screen
from grasp_bench.report.table4 import build_report
from grasp_bench.runs.folder import RunFolder
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.runs.results import RunResults

WON, LOST = "success", "missed"


def run(
    folder: Path,
    predictor: str,
    gripper: str | None,
    trials: dict[str, str],
    arm: str = "ec66",
    seed: int = 0,
) -> Path:
    """A run that tried each object once."""
    content: dict[str, Any] = {
        "predictor": predictor,
        "scenario": {"name": "table4", "version": 2},
        "seed": seed,
        "trials": len(trials),
        "objects": {},
        "weights": None,
        "versions": {},
        "renderer": "raycast",
    }
    if gripper is not None:
        content["robot"] = {"arm": {"name": arm, "digest": ""}, "gripper": {"name": gripper, "digest": ""}}
    name = folder / f"{predictor}-{(gripper or 'none').replace('/', '_')}-{arm}-{seed}"
    with RunFolder(name) as results:
        results.start(RunInfo.read(content))
        for i, (thing, outcome) in enumerate(trials.items()):
            record = {"trial": i, "object": thing, "category": "mug", "outcome": outcome, "seed": seed}
            results.append(TrialRecord.read(record), Timings.read({"trial": i, "plan": 0.1}))
    return name


def test_rates_are_those_of_the_trials_that_all_robots_did(tmp_path: Path) -> None:
    folders = [
        run(tmp_path, "oracle", None, {"mug": WON, "pan": WON, "key": WON}),
        run(tmp_path, "oracle", "./own/suction-20", {"mug": WON, "pan": LOST}),
        run(tmp_path, "random", None, {"mug": LOST, "pan": WON, "key": WON}),
    ]
    hands = Hands.of([RunResults(f) for f in folders])
    assert hands is not None
    assert hands.robots == ("parallel-85", "suction-20")
    counted = {key: (rate.successes, rate.trials) for key, rate in hands.cells.items()}
    assert counted == {
        ("oracle", "parallel-85"): (2, 2),
        ("oracle", "suction-20"): (1, 2),
        ("random", "parallel-85"): (1, 2),
    }
    assert (hands.common, hands.left_out) == (2, 2)
    table = hands.table()
    assert [row[0] for row in table.rows] == ["oracle", "random"]
    assert [row[2] for row in table.rows][1] == "–"
    assert build_report(folders).to_json()["robots"]["common_trials"] == 2
    assert "Predictors and robots" in [t.title for t in screen(folders, tmp_path)]


def test_several_arms_and_seeds(tmp_path: Path) -> None:
    folders = [run(tmp_path, "oracle", "panda-hand", {"mug": WON}, "panda", seed=seed) for seed in (0, 1)] + [
        run(tmp_path, "oracle", "panda-hand", {"mug": LOST}, seed=seed) for seed in (0, 1)
    ]
    hands = Hands.of([RunResults(f) for f in folders])
    assert hands is not None
    assert hands.robots == ("panda-hand on panda", "panda-hand on ec66")
    assert [r.trials for r in hands.cells.values()] == [2, 2]


@pytest.mark.parametrize("second", [None, "parallel-50"])
def test_one_robot_makes_no_matrix_and_no_common_trial_is_said(tmp_path: Path, second: str | None) -> None:
    folders = [run(tmp_path, "oracle", None, {"mug": WON}), run(tmp_path, "random", second, {"pan": WON})]
    hands = Hands.of([RunResults(f) for f in folders])
    if second is None:
        assert hands is None
    else:
        assert hands is not None
        assert "no trial in common" in hands.table().note
