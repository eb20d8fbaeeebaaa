"""Success over difficulty: the fit, what it tells of planted predictors, and where it is shown."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_runs import write_run

from grasp_bench.objects.catalog import Catalog
from grasp_bench.objects.difficulty import check_graded, difficulty_of
from grasp_bench.report import difficulty
from grasp_bench.report.difficulty import Managed, crossing, difficulty_table, logistic, managed
from grasp_bench.report.table4 import build_report
from grasp_bench.report.tables import as_text
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate

GRID = Catalog().select("grid")
FILES = {name: Catalog().entries[name]["files"] for name in GRID}
DIFFICULTY = {n: d.failing for n in GRID if (d := difficulty_of(Catalog().entries[n]))}
SCENARIO = {"name": "grid", "version": 2, "robot": {"gripper": "parallel-85"}}


def graded(folder: Path, wins: Callable[[float, int], bool], rounds: int = 4, **run: Any) -> RunResults:
    """A run on the grid in which an attempt at an object of a difficulty ends as ``wins`` says."""
    settings: dict[str, Any] = {"scenario": SCENARIO, "objects": FILES, "predictor": "mine"} | run
    names = list(settings["objects"])

    def won(trial: int) -> bool:
        return wins(DIFFICULTY.get(names[trial % len(names)], 0.5), trial)

    return RunResults(write_run(folder, rounds * len(names), wins=won, **settings))


def logistic_of(half: float, slope: float) -> Callable[[float, int], bool]:
    """Wins with a probability that falls with difficulty and is one half at ``half``."""
    return lambda d, t: bool(np.random.default_rng([7, t]).random() < 1 / (1 + np.exp(slope * (d - half))))


def test_the_fit_is_the_maximum_of_the_penalised_likelihood() -> None:
    rng = np.random.default_rng(3)
    x, trials = rng.uniform(size=30), rng.integers(1, 6, size=30).astype(float)
    wins = rng.binomial(trials.astype(int), 1 / (1 + np.exp(8 * (x - 0.6)))).astype(float)
    ((a, b),) = logistic(x, wins, trials, np.ones((1, 30)))

    def penalised(a: float, b: float) -> float:
        p = 1 / (1 + np.exp(-(a + b * x)))
        w, design = trials * p * (1 - p), np.column_stack([np.ones(30), x])
        fit = (wins * np.log(p) + (trials - wins) * np.log(1 - p)).sum()
        return float(fit + 0.5 * np.linalg.slogdet((design * w[:, None]).T @ design)[1])

    best = penalised(a, b)
    for da, db in ((0.05, 0), (-0.05, 0), (0, 0.05), (0, -0.05), (0.05, -0.1), (-0.05, 0.1)):
        assert penalised(a + da, b + db) < best


def test_weights_count_an_object_as_often() -> None:
    x, wins, trials = np.array([0.1, 0.4, 0.9]), np.array([3.0, 2, 0]), np.array([3.0, 3, 3])
    (weighted,) = logistic(x, wins, trials, np.array([[1.0, 2, 1]]))
    repeated = np.array([0.1, 0.4, 0.4, 0.9])
    (listed,) = logistic(repeated, np.array([3.0, 2, 2, 0]), np.full(4, 3.0), np.ones((1, 4)))
    np.testing.assert_allclose(weighted, listed, rtol=0.06)


def test_where_curves_cross_one_half() -> None:
    fits = np.array([[4.0, -8.0], [5.0, 1.0], [-5.0, 1.0]])
    assert crossing(fits).tolist() == [0.5, np.inf, -np.inf]


@pytest.mark.parametrize("half", [0.25, 0.5])
def test_a_planted_difficulty_is_found(tmp_path: Path, half: float) -> None:
    found = managed(graded(tmp_path / "run", logistic_of(half, 12), rounds=6))
    assert found is not None
    assert found.half.low < half < found.half.high
    assert abs(found.half.value - half) < 0.08
    values = [c.value for c in found.curve]
    assert values == sorted(values, reverse=True)
    assert all(c.low - 1e-6 <= c.value <= c.high + 1e-6 for c in found.curve)
    assert sum(b.trials for b in found.bands) == 6 * len(GRID)
    assert json.loads(json.dumps(found.to_json(), allow_nan=False)) == found.to_json()


def test_what_is_always_or_never_lifted_is_told_as_beyond(tmp_path: Path) -> None:
    every = managed(graded(tmp_path / "every", lambda d, t: True))
    none = managed(graded(tmp_path / "none", lambda d, t: False))
    assert every is not None
    assert none is not None
    assert every.half.value == max(DIFFICULTY.values())
    assert none.half.value == min(DIFFICULTY.values())
    assert (every.in_words[0], none.in_words[0]) == ("≥", "≤")
    rows = difficulty_table([("none", none), ("every", every)]).rows
    assert [row[0] for row in rows] == ["every", "none"], "the best first"


def test_objects_without_a_difficulty_have_no_curve(tmp_path: Path) -> None:
    household = {n: Catalog().entries[n]["files"] for n in Catalog().names[:20]}
    assert managed(graded(tmp_path / "a", lambda d, t: True, objects=household)) is None
    mixed = FILES | {"apple": Catalog().entries["apple"]["files"]}
    assert managed(graded(tmp_path / "b", lambda d, t: True, objects=mixed)) is None
    changed = {n: f | {"object.json": "0" * 64} for n, f in FILES.items()}
    assert managed(graded(tmp_path / "c", lambda d, t: True, objects=changed)) is None
    other = SCENARIO | {"robot": {"gripper": "parallel-140"}}
    assert managed(graded(tmp_path / "d", lambda d, t: True, scenario=other)) is None


def test_it_stands_in_the_report(tmp_path: Path) -> None:
    graded(tmp_path / "good", logistic_of(0.6, 12), predictor="good")
    graded(tmp_path / "bad", logistic_of(0.2, 12), predictor="bad")
    report = build_report([tmp_path / "good", tmp_path / "bad"], tmp_path)
    text = as_text(report.tables())
    assert difficulty.DRAWS
    assert "How difficult an object is lifted?" in text
    halves = {r["run"]: r["difficulty"]["half"]["value"] for r in report.to_json()["runs"]}
    assert halves["good"] > halves["bad"]
    assert isinstance(report.runs[0].managed, Managed)
    assert sum(r.trials for r in report.runs[0].managed.bands) == report.runs[0].lifted.trials
    assert all(isinstance(r, Rate) for _, r in report.runs[0].managed.objects.values())


def test_it_has_a_section_of_the_page(tmp_path: Path) -> None:
    from grasp_bench.report.html.page import write_html

    graded(tmp_path / "good", logistic_of(0.6, 12), predictor="good")
    page = write_html([tmp_path / "good"], tmp_path / "report.html", tmp_path).path.read_text()
    assert 'id="difficulty"' in page
    assert 'data-chart="difficulty"' in page
    write_run(tmp_path / "plain")
    plain = write_html([tmp_path / "plain"], tmp_path / "plain.html", tmp_path).path.read_text()
    assert 'id="difficulty"' not in plain


def test_difficulties_are_those_of_the_manifest() -> None:
    from grasp_bench.scenario.reading import load_scenario

    assert check_graded(load_scenario("grid"), Catalog(), GRID) == DIFFICULTY
