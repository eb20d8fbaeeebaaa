"""How firmly runs hold, side by side: figures, curve, and the comparison of pairs."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from made_up_runs import write_run

from grasp_bench.report.firmness import AT, GRID, Firmness, compare_firmness, firmness
from grasp_bench.report.table4 import build_report
from grasp_bench.report.tables import as_text, markdown
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate

GRADED = {"name": "graded", "version": 2, "margin": {"distance": 0.005}}
OBJECTS = {f"thing{i:02}": {"object.json": str(i)} for i in range(40)}


def graded(
    folder: Path, times: Callable[[int], float], wins: Callable[[int], bool] = lambda t: True, **run: Any
) -> Path:
    """A run in which trial t bears ``times(t)`` times the weight."""

    def margin(record: dict[str, Any]) -> dict[str, Any]:
        held = times(record["trial"]) if record["success"] else 0.0
        return record | {"margin": {"force": held, "factor": held, "direction": "+approach", "torque": 0.1}}

    settings = {"scenario": GRADED, "objects": OBJECTS, "trials": 40} | run
    return write_run(folder, wins=wins, change=margin, **settings)


def spread(trial: int) -> float:
    """From 0.5 to 100 times the weight."""
    return 0.5 * 200 ** (trial / 39)


def test_figures_of_a_run(tmp_path: Path) -> None:
    run = RunResults(graded(tmp_path / "a", spread, wins=lambda t: t != 39))
    found = firmness(run)
    assert found is not None
    factors = [spread(t) for t in range(39)] + [0.0]
    assert found.held == {at: Rate(sum(f >= at for f in factors), 40) for at in AT}
    assert found.median == pytest.approx(sorted(factors)[19] / 2 + sorted(factors)[20] / 2, rel=1e-3)
    assert [p.factor for p in found.curve] == pytest.approx(list(GRID))
    shares = [p.share.value for p in found.curve]
    assert shares == sorted(shares, reverse=True)
    assert (shares[0], shares[-1]) == (39 / 40, 0.0)
    assert all(p.share.low <= p.share.value <= p.share.high for p in found.curve)
    assert found.area.low < found.area.value < found.area.high
    # The area under the curve over the logarithm is the mean score.
    assert sum(shares[:-1] + shares[1:]) / (2 * (len(GRID) - 1)) == pytest.approx(found.area.value, abs=0.01)
    assert json.loads(json.dumps(found.to_json(), allow_nan=False)) == found.to_json()


def test_runs_without_margins_have_no_figures(tmp_path: Path) -> None:
    assert firmness(RunResults(write_run(tmp_path / "plain"))) is None


def test_the_firmer_of_two_is_found_with_its_ratio(tmp_path: Path) -> None:
    runs = [
        RunResults(graded(tmp_path / "a", lambda t: 2 * spread(t), predictor="firm")),
        RunResults(graded(tmp_path / "b", spread, predictor="soft")),
        RunResults(
            graded(tmp_path / "c", lambda t: spread(t) * (1.3 if t % 2 else 1 / 1.3), predictor="odd")
        ),
        RunResults(graded(tmp_path / "d", spread, predictor="elsewhere", seed=7)),
    ]
    pairs = compare_firmness(runs)
    assert [(p.first, p.second) for p in pairs] == [(0, 1), (0, 2), (1, 2)]
    assert pairs[0].ratio.value == pytest.approx(2, rel=1e-3)
    assert pairs[0].adjusted < 1e-4
    assert (pairs[0].trials, pairs[0].objects) == (40, 40)
    assert pairs[2].ratio.low < 1 < pairs[2].ratio.high
    assert pairs[2].adjusted > 0.5


def test_lost_trials_count_as_the_least_factor(tmp_path: Path) -> None:
    runs = [
        RunResults(graded(tmp_path / "a", lambda t: 4.0)),
        RunResults(graded(tmp_path / "b", lambda t: 4.0, wins=lambda t: t >= 20, predictor="half")),
    ]
    (pair,) = compare_firmness(runs)
    assert pair.ratio.value == pytest.approx(2**2)  # four octaves lost in half of the trials
    assert pair.p_value < 1e-4


def test_the_report_shows_columns_and_pairs(tmp_path: Path) -> None:
    graded(tmp_path / "a", lambda t: 2 * spread(t), predictor="firm")
    graded(tmp_path / "b", spread, predictor="soft")
    report = build_report(sorted(tmp_path.iterdir()), tmp_path)
    for page in (as_text(report.tables(), 80), markdown(report.tables())):
        assert "How firmly is it held?" in page
        assert "1 of 1 pairs differ" in " ".join(page.split())
    content = report.to_json()
    assert content["runs"][0]["firmness"]["held"]["2"]["trials"] == 40
    assert content["firmer"][0]["ratio"]["value"] == pytest.approx(2, rel=1e-3)
    assert "Held at 5×" in markdown(report.tables())


def test_a_graded_run_may_stop_early(tmp_path: Path) -> None:
    folder = graded(tmp_path / "a", spread, only=[0])
    found = firmness(RunResults(folder))
    assert isinstance(found, Firmness)
    assert found.trials == 1


def test_trials_are_paired_by_what_was_tried_not_by_their_numbers(tmp_path: Path) -> None:
    few = {name: OBJECTS[name] for name in reversed(OBJECTS) if int(name[-2:]) >= 30}
    runs = [
        RunResults(graded(tmp_path / "all", spread)),
        RunResults(graded(tmp_path / "few", lambda t: 2 * spread(39 - t), objects=few, trials=10)),
        RunResults(graded(tmp_path / "other files", spread, objects={n: {} for n in few}, trials=10)),
    ]
    (pair,) = compare_firmness(runs)
    assert (pair.first, pair.second, pair.trials) == (0, 1, 10)
    assert pair.ratio.value == pytest.approx(1 / 2, rel=1e-3)
