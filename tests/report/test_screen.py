"""The last screen of ``make bench``: the run made last beside others, its failures, what to do next."""

from __future__ import annotations

import json
import os
import shutil
import time
from pathlib import Path

import pytest
from committed import RESULTS, committed_runs
from html_runs import write_run
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.report.groups import DEVELOPED_ON, grouped, made_last, newest
from grasp_bench.report.screen import LINES, screen
from grasp_bench.report.summary import Summary
from grasp_bench.report.table4 import build_report
from grasp_bench.report.tables import as_text, markdown
from grasp_bench.runs.folder import TRIALS, find_runs
from grasp_bench.runs.results import RunResults
from grasp_bench.scenario.reading import load_scenario

MINE = "my_module:MyPredictor"


def aged(folder: Path, seconds: float) -> Path:
    """A run as if it had been made some time ago."""
    then = time.time() - seconds
    os.utime(folder / TRIALS, (then, then))
    return folder


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The committed runs with one that was made last."""
    root = tmp_path_factory.mktemp("screen") / "results"
    for folder in committed_runs():
        shutil.copytree(folder, root / folder.relative_to(RESULTS))
        aged(root / folder.relative_to(RESULTS), 3600)
    mine = shutil.copytree(root / "reference" / "gg-cnn", root / "mine")
    info = json.loads((mine / "run.json").read_text())
    (mine / "run.json").write_text(json.dumps(info | {"predictor": MINE}))
    aged(mine, 0)
    return root


@pytest.fixture
def lines(results: Path) -> list[str]:
    return as_text(screen(find_runs(results), results), 80).splitlines()


def test_the_table_takes_at_most_25_lines_of_80_columns(lines: list[str]) -> None:
    end = max(i for i, line in enumerate(lines) if "(control)" in line and "/180" in line)
    assert end <= LINES
    assert max(map(len, lines[: end + 1])) <= 80
    assert len(lines) < 60


def test_my_run_is_marked_among_the_rows_of_its_scenario(lines: list[str]) -> None:
    marked = [line for line in lines if "▶" in line]
    assert len(marked) == 1
    assert MINE in marked[0]
    assert "172/180" in marked[0]
    assert "yours" in marked[0]
    rows = [line.split()[0] for line in lines if "/180" in line and "%" in line and "trials" not in line]
    assert len(rows) == 14 + 1  # and one of the paper
    assert rows.index("oracle") > rows.index("htc-grasp-plain")
    assert f"development seed {DEVELOPED_ON}" in lines[0]


def test_other_groups_are_a_line_each(lines: list[str]) -> None:
    at = lines.index("Also here")
    assert lines[at + 1 : at + 7] == [
        "21 more of these trials: tf-grasp 173/180, gg-cnn 172/180, gq-cnn 172/180 and 18",
        "  more",
        "table4, development seed 0, 24 trials: htc-grasp 24/24, oracle 24/24",
        "table4, seeds 5 to 9, 180 trials each: htc-grasp-tta 870/900 = 96.7% (95.3% –",
        "  97.7%), htc-grasp 869/900 = 96.6% (95.2% – 97.6%)",
        "11 scenarios, seed 0, 180 trials each: htc-grasp 93.9% (office) to 99.4% (ideal)",
    ]


def test_failures_are_told_with_reasons_and_what_to_do(lines: list[str]) -> None:
    text = " ".join(" ".join(lines).split())
    assert f"{MINE} failed in 8 of 180 trials" in text
    assert "slipped 4 lost while lifting, 0 mm above its place: french_press, hatchet" in text
    assert "--trial 63 --video trial.gif" in text
    assert "--format html" in text
    assert max(len(line) for line in lines if not line.startswith("  grasp-bench")) <= 80


def test_a_fresh_copy_has_no_run_of_mine(tmp_path: Path) -> None:
    shutil.copytree(RESULTS / "reference", tmp_path / "results" / "reference")
    text = as_text(screen(find_runs(tmp_path), tmp_path), 80)
    assert "▶" not in text
    assert "grasp-bench run --objects all" in text


def test_a_run_alone_in_its_scenario_stands_beside_others_of_that_scenario(
    results: Path, tmp_path: Path
) -> None:
    root = tmp_path / "results"
    shutil.copytree(results / "reference", root / "reference")
    for folder in find_runs(root):
        aged(folder, 3600)
    write_run(root / "mine", MINE, ["success", "missed"], seed=3)
    text = as_text(screen(find_runs(root), root), 80)
    assert "▶ my_module:MyPredictor" in text
    assert "htc-grasp" in text
    assert "Others tried 180 trials with seed 0." in " ".join(text.split())


def test_many_runs_are_cut_and_mine_stays(tmp_path: Path) -> None:
    for i in range(40):
        aged(write_run(tmp_path / f"run{i:02}", f"m:P{i}", ["success"] * 3), 3600)
    write_run(tmp_path / "worst", MINE, ["missed"] * 3)
    text = as_text(screen(find_runs(tmp_path), tmp_path), 80)
    assert sum("3/3" in line and "%" in line for line in text.splitlines()) <= LINES
    assert "▶ my_module:MyPredictor" in text
    assert "27 more of these trials: m:P" in text


def test_other_scenarios_are_no_rows_of_table_4(tmp_path: Path) -> None:
    heavy = load_scenario("heavy").model_dump(mode="json")
    write_run(tmp_path / "a", "one", ["success"])
    write_run(tmp_path / "b", "two", ["success"], scenario=heavy)
    write_run(tmp_path / "c", "three", ["missed"], scenario=heavy)
    report = build_report(find_runs(tmp_path), tmp_path)
    assert [row.run for row in report.rows if row.run] == ["a"]
    heads = [line for line in markdown(report.tables()).splitlines() if line.startswith("## ")]
    assert heads == [
        "## heavy, seed 0, 1 trial",
        "## Table 4, re-measured: table4, development seed 0, 1 trial",
        "## Is its quality a probability?",
    ]


def test_the_newest_few_are_chosen_before_the_best(tmp_path: Path) -> None:
    for i, outcome in enumerate(["missed", "success", "success", "missed", "success", "success"]):
        aged(write_run(tmp_path / f"r{i}", f"m:P{i}", [outcome]), 100 * i)
    runs = [RunResults(f) for f in find_runs(tmp_path)]
    names = [r.folder.name for r in runs]
    summaries = [Summary.of(r, tmp_path) for r in runs]
    assert made_last(runs, names) == 0
    assert newest(runs, names, grouped(summaries, 0)) == [0, 1, 2, 3]
    for run in runs:
        aged(run.folder, 500)
    assert made_last(runs, names) is None
    assert newest(runs, names, grouped(summaries)) == [1, 2, 4, 5]


def test_a_run_alone_is_shown_with_others_of_its_scenario(tmp_path: Path) -> None:
    """A few trials to begin with are a group of their own; on the page it would stand beside no reference."""
    for i in range(3):
        aged(write_run(tmp_path / "reference" / f"r{i}", f"m:P{i}", ["success"] * 4), 500)
    mine = aged(write_run(tmp_path / "mine", "m:Mine", ["missed"]), 0)
    runs = [RunResults(f) for f in find_runs(tmp_path)]
    names = [r.folder.relative_to(tmp_path).as_posix() for r in runs]
    groups = grouped([Summary.of(r, tmp_path) for r in runs], made_last(runs, names))
    assert [len(g.runs) for g in groups] == [1, 3]
    first, *others = newest(runs, names, groups)
    assert runs[first].folder == mine
    assert len(others) == 3


def test_predictors_with_the_same_seeds_stand_together_each_with_its_sum(tmp_path: Path) -> None:
    told = {"m:A": ["missed", "success"], "m:B": ["success", "success"]}
    for seed in (5, 6, 7):
        for name, outcomes in told.items():
            aged(write_run(tmp_path / f"{name[-1]}{seed}", name, outcomes, seed=seed), 500)
    aged(write_run(tmp_path / "C8", "m:C", ["success", "success"], seed=8), 500)
    report = build_report(find_runs(tmp_path), tmp_path)
    alone, both = report.groups
    assert both.title == "table4, seeds 5 to 7, 2 trials each"
    assert [report.runs[i].run for i in both.runs] == ["B5", "B6", "B7", "A5", "A6", "A7"]
    assert {p: (r.successes, r.trials) for p, r in both.pooled.items()} == {"m:B": (6, 6), "m:A": (3, 6)}
    assert list(both.pooled) == ["m:B", "m:A"]
    assert [report.runs[i].run for i in alone.runs] == ["C8"]
    assert not alone.pooled
    text = as_text(screen(find_runs(tmp_path), tmp_path), 200)
    assert "m:B, together" in markdown(report.tables())
    assert "m:A, together" in markdown(report.tables())
    assert "seeds 5 to 7" in text
    # The run made last keeps a table of its own seed.
    aged(tmp_path / "A6", 0)
    runs = [RunResults(f) for f in find_runs(tmp_path)]
    names = [r.folder.name for r in runs]
    lead, *_ = grouped([Summary.of(r, tmp_path) for r in runs], made_last(runs, names))
    assert [names[i] for i in lead.runs] == ["B6", "A6"]


def test_the_command_prints_the_screen_and_all_on_request(results: Path) -> None:
    short = CliRunner().invoke(app, ["report", str(results)])
    long = CliRunner().invoke(app, ["report", str(results), "--all"])
    assert short.exit_code == long.exit_code == 0
    assert "Hardest objects" not in short.output
    assert long.output.count("Hardest objects") == len(committed_runs()) + 1


def test_two_controls_stand_beside_the_best_and_mine_is_there_however_low(results: Path) -> None:
    lines = as_text(screen(find_runs(results), results), 80).splitlines()
    table = [line for line in lines if "/180" in line and "%" in line and "trials" not in line]
    assert sum("(control)" in line for line in table) == 2
    low = results.parent / "low"
    shutil.copytree(results / "reference", low / "reference")
    for folder in find_runs(low):
        aged(folder, 3600)
    shutil.copytree(results / "mine", low / "mine")
    for file in (TRIALS, "timings.jsonl"):
        shutil.copyfile(low / "reference" / "kumra-resnet50x2" / file, low / "mine" / file)
    aged(low / "mine", 0)
    text = as_text(screen(find_runs(low), low), 80).splitlines()
    table = [line for line in text if "/180" in line and "%" in line and "trials" not in line]
    assert sum("(control)" in line for line in table) == 2
    assert ["6/180" in line for line in table if "▶" in line] == [True]
