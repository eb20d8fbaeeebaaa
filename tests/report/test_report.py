"""The report: Table 4 with intervals, what the runs add to it, and the note that goes with it."""

from __future__ import annotations

import json
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from grasp_bench.report.paper import TABLE_4
from grasp_bench.report.summary import worst_objects
from grasp_bench.report.table4 import NOTE, PAPER, Report, build_report
from grasp_bench.report.tables import markdown, show
from grasp_bench.runs.folder import RunFolder
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.runs.statistics import Rate, wilson

RUN: dict[str, Any] = {
    "predictor": "oracle",
    "scenario": {"name": "table4", "version": 2},
    "seed": 4,
    "trials": 5,
    "objects": {},
    "weights": None,
    "versions": {},
    "renderer": "raycast",
}
TRIALS = [
    ("mug", "mug", "success"),
    ("pan", "cookware", "missed"),
    ("pot", "cookware", "success"),
    ("mug", "mug", "slipped"),
    ("pan", "cookware", "missed"),
]


def write(folder: Path, trials: list[tuple[str, str, str]], run: dict[str, Any] = RUN) -> Path:
    with RunFolder(folder) as results:
        results.start(RunInfo.read(run))
        for i, (name, category, outcome) in enumerate(trials):
            content = {"trial": i, "object": name, "category": category, "outcome": outcome}
            results.append(
                TrialRecord.read(content), Timings.read({"trial": i, "plan": 0.1 * i, "render": 0.5})
            )
    return folder


@pytest.fixture
def told(tmp_path: Path) -> Report:
    started = write(tmp_path / "two", TRIALS[:1], RUN | {"trials": 9})
    return build_report([write(tmp_path / "one", TRIALS), started])


@pytest.fixture
def report(told: Report) -> dict[str, Any]:
    return told.to_json()


def test_the_report_is_runs_and_a_table_as_plain_json(report: dict[str, Any]) -> None:
    assert set(report) == {"firmer", "groups", "merit", "note", "robots", "runs", "table4"}
    assert json.loads(json.dumps(report, allow_nan=False)) == report


def test_the_papers_rows_have_counts_intervals_and_the_printed_rate(report: dict[str, Any]) -> None:
    rows = [r for r in report["table4"] if r["source"] == "paper"]
    assert [(r["authors"], r["system"], r["successes"], r["trials"], r["printed_rate"]) for r in rows] == [
        ("Lenz", "SAE", 89, 100, 89.0),
        ("Morrison", "GG-CNN", 110, 120, 92.0),
        ("Chu", "ResNet-50", 89, 100, 89.0),
        ("Wang", "TF-Grasp", 152, 165, 92.1),
        ("HTC-Grasp authors", "HTC-Grasp", 168, 180, 93.3),
    ]
    for row in rows:
        assert row["rate"] == row["successes"] / row["trials"]
        assert row["wilson95"] == list(wilson(row["successes"], row["trials"]))
        assert row["run"] is None


def test_printed_rates_differ_from_their_counts_only_where_the_paper_does() -> None:
    wrong = [p.system for p in TABLE_4 if abs(100 * p.successes / p.trials - p.printed_rate) > 0.06]
    assert wrong == ["GG-CNN"]


def test_the_note_holds_no_claim_that_the_intervals_contradict() -> None:
    intervals = [p.lifted.interval for p in PAPER]
    assert "all overlap" in NOTE
    assert max(low for low, _ in intervals) < min(high for _, high in intervals)


def test_every_run_has_a_row_below_the_papers(report: dict[str, Any]) -> None:
    own = report["table4"][len(PAPER) :]
    assert [(r["run"], r["system"], r["successes"], r["trials"]) for r in own] == [
        ("one", "oracle", 2, 5),
        ("two", "oracle", 1, 1),
    ]
    assert all(r["source"] == "simulation" and r["printed_rate"] is None for r in own)
    assert set(own[0]) == set(report["table4"][0])


def test_a_run_is_broken_down_by_outcome_category_object_and_phase(report: dict[str, Any]) -> None:
    one = report["runs"][0]
    assert one["outcomes"] == {"missed": 2, "success": 2, "slipped": 1}
    assert one["by_category"] == {
        "cookware": {"successes": 1, "trials": 3},
        "mug": {"successes": 1, "trials": 2},
    }
    assert one["by_object"]["pan"] == {"successes": 0, "trials": 2}
    assert one["timings"] == {"plan": pytest.approx(0.2), "render": pytest.approx(0.5)}
    assert (one["run"], one["predictor"], one["scenario"], one["seed"]) == ("one", "oracle", "table4", 4)
    assert (one["rate"], one["planned_trials"]) == (0.4, 5)


def test_a_run_without_a_trial_has_no_row(tmp_path: Path) -> None:
    empty = write(tmp_path / "empty", [])
    report = build_report([empty])
    assert report.runs == ()
    assert report.rows == list(PAPER)


def test_the_hardest_objects_come_first_and_the_easy_not_at_all() -> None:
    rates = {"a": Rate(1, 2), "b": Rate(0, 2), "c": Rate(3, 3), "d": Rate(0, 5)}
    assert worst_objects(rates) == [("d", Rate(0, 5)), ("b", Rate(0, 2)), ("a", Rate(1, 2))]
    assert worst_objects(rates, 1) == [("d", Rate(0, 5))]


def test_markdown_holds_rates_intervals_and_the_note(told: Report) -> None:
    text = markdown(told.tables())
    assert "| HTC-Grasp | 168/180 | 93.3% | 88.7% – 96.1% | 93.3 % | paper, real robot |" in text
    assert "| Morrison | GG-CNN | 110/120 | 91.7% | 85.3% – 95.4% | 92.0 % |" in text
    assert "| grasp-bench | oracle (control) | 2/5 | 40.0% | 11.8% – 76.9% |  | one: table4, seed 4 |" in text
    assert NOTE in text
    assert "| missed | 2 | 40.0% |" in text
    assert "Hardest objects: pan 0/2, mug 1/2" in text
    assert "two: oracle on table4, seed 4, raycast, 8 to go" in text


def test_markdown_tables_have_as_many_cells_in_every_row(told: Report) -> None:
    rows = [line for line in markdown(told.tables()).splitlines() if line.startswith("|")]
    widths = {line.count("|") for line in rows}
    assert widths == {8, 10, 4}


def test_bars_in_names_do_not_break_markdown_tables(tmp_path: Path) -> None:
    report = build_report([write(tmp_path / "a|b", TRIALS)])
    assert "a\\|b |" in markdown(report.tables())


@pytest.mark.parametrize("width", [80, 120, 200])
def test_the_terminal_holds_rates_intervals_and_the_note(told: Report, width: int) -> None:
    stream = StringIO()
    show(told.tables(), Console(file=stream, width=width))
    text = stream.getvalue()
    words = " ".join(text.split())
    assert "Table 4, re-measured" in text
    assert "168/180" in text
    assert "not directly comparable" in words
    assert "slipped" in text
    assert "Hardest objects: pan 0/2, mug 1/2" in words
    assert max(map(len, text.splitlines())) <= width
    if width >= 120:
        assert "88.7% – 96.1%" in text
        assert "92.0 %" in text
