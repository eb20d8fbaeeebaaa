"""Ranking: a race of real trials, resumed, the same for any number of workers."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.report.table4 import build_report
from grasp_bench.report.tables import markdown
from grasp_bench.runs.results import RunResults
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Scenario
from grasp_bench.studies.rank import BATCH, SCORES, Contest, rank, score_for
from grasp_bench.studies.ranking import in_words, to_json


@pytest.fixture
def contest(toy_catalog: Path, scenario: Scenario) -> Contest:
    catalog = Catalog(toy_catalog)
    names = ("displaced", "oracle")
    return Contest(names, scenario, catalog, tuple(catalog.names), SCORES["success"], budget=40)


def trials(folder: Path) -> dict[str, bytes]:
    return {p.parent.name: p.read_bytes() for p in sorted(folder.glob("*/trials.jsonl"))}


def test_a_ranking_stops_when_all_is_known_and_goes_on_where_it_was_stopped(
    contest: Contest, tmp_path: Path
) -> None:
    first = rank(replace(contest, budget=BATCH // 2), tmp_path / "a", 1)
    assert first.groups == [["oracle", "displaced"]], "too few to know"
    fresh: list[bool] = []
    race = rank(contest, tmp_path / "a", 1, lambda name, record, there: fresh.append(not there))
    assert race.groups == [["oracle"], ["displaced"]]
    assert BATCH // 2 < race.items < 40
    assert fresh.count(False) == 2 * BATCH // 2, "what was there is not tried again"
    whole = rank(contest, tmp_path / "b", 2)
    assert to_json(whole, "success") == to_json(race, "success")
    assert trials(tmp_path / "a") == trials(tmp_path / "b"), "whatever the workers, however often stopped"
    assert in_words(race) == "1 · 2"


def test_the_trials_are_those_of_an_ordinary_run(contest: Contest, tmp_path: Path) -> None:
    rank(replace(contest, budget=3), tmp_path, 1)
    run = RunResults(tmp_path / "oracle")
    assert len(run) == 3
    names = list(run.info.objects)
    assert all(names[r.trial % len(names)] == r.object for r in run.records)


def test_a_report_counts_the_trials_of_a_race(contest: Contest, tmp_path: Path) -> None:
    rank(replace(contest, budget=3), tmp_path, 1)
    report = build_report(sorted(tmp_path.iterdir()), tmp_path)
    (group,) = report.groups
    assert group.title == "table4, development seed 0, 3 trials"
    assert [(r.planned, r.missing) for r in report.runs] == [(3, 0), (3, 0)]
    text = markdown(report.tables())
    assert "to go" not in text
    assert not [n for n in map(int, re.findall(r"\d+", text)) if n == report.runs[0].info.trials]


def test_a_reports_runs_of_a_race_are_a_group_though_one_left_it(contest: Contest, tmp_path: Path) -> None:
    rank(replace(contest, budget=3), tmp_path, 1)
    trials = tmp_path / "displaced" / "trials.jsonl"
    trials.write_text("".join(trials.read_text().splitlines(keepends=True)[:2]))
    (group,) = build_report(sorted(tmp_path.iterdir()), tmp_path).groups
    assert group.title == "table4, development seed 0, 2 to 3 trials"


def test_bad_contests(contest: Contest, tmp_path: Path) -> None:
    for predictors, message in (
        (("oracle",), "two predictors or more"),
        (("oracle", "oracle"), "each named once"),
        (("oracle", "my_module:Mine"), "cmd: grasp-bench serve my_module:Mine"),
    ):
        with pytest.raises(GraspBenchError, match=message):
            rank(replace(contest, predictors=predictors), tmp_path, 1)
    with pytest.raises(GraspBenchError, match="one object at a time"):
        rank(replace(contest, scenario=load_scenario("clutter")), tmp_path, 1)
    with pytest.raises(GraspBenchError, match="--budget"):
        rank(replace(contest, budget=100_000), tmp_path, 1)


def test_scores() -> None:
    assert score_for(load_scenario("graded")) is SCORES["firmness"]
    assert score_for(load_scenario("table4")) is SCORES["success"]
    with pytest.raises(GraspBenchError, match="--scenario graded"):
        score_for(load_scenario("table4"), "firmness")
    with pytest.raises(UnknownNameError, match="firmness"):
        score_for(load_scenario("table4"), "firmnes")


def test_the_command(toy_catalog: Path, tmp_path: Path) -> None:
    common = ["rank", "oracle", "displaced", "--objects", str(toy_catalog), "--scenario", "table4"]
    done = CliRunner().invoke(app, [*common, "--budget", "16", "--workers", "1", "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert "Who is better: 1 · 2" in done.output
    words = [*common, "--budget", "16", "--out", str(tmp_path), "--physics", "1", "--physics-trials", "1"]
    again = json.loads(CliRunner().invoke(app, [*words, "--json"]).stdout)
    assert again["groups"] == [["oracle"], ["displaced"]]
    assert again["worlds"]["neighbours"] == [
        {"better": "oracle", "worse": "displaced", "holds": 1, "tied": 0, "turned": 0}
    ]


def test_a_scenarios_own_set_of_objects_is_tried(toy_catalog: Path, tmp_path: Path) -> None:
    scenario = tmp_path / "toys.yaml"
    scenario.write_text(
        f"extends: table4\nname: toys\nobjects: {{folder: {toy_catalog}, names: [block, pot]}}\n"
    )
    ranked = ["rank", "oracle", "displaced", "--budget", "2", "--workers", "1"]
    ranked += ["--out", str(tmp_path / "rank")]
    table = ["bench-table", "--predictors", "oracle", "--folder", str(tmp_path / "bench")]
    for words, run in ((ranked, "rank/oracle"), (table, "bench/oracle")):
        done = CliRunner().invoke(app, [*words, "--scenario", str(scenario)])
        assert done.exit_code == 0, done.output
        assert list(RunResults(tmp_path / run).info.objects) == ["block", "pot"]


def test_a_ranking_asks_of_arm_and_objects_what_a_run_does(tmp_path: Path) -> None:
    for change, message in (
        ("table: {center: [1.6, 0.0]}", "reaches only 0 of"),
        ("objects: {graded: true, names: [apple]}", "difficulty of apple was not measured"),
    ):
        scenario = tmp_path / "bad.yaml"
        scenario.write_text(f"extends: table4\nname: bad\n{change}\n")
        done = CliRunner().invoke(app, ["rank", "oracle", "displaced", "--scenario", str(scenario)])
        assert isinstance(done.exception, GraspBenchError), done.output
        assert message in str(done.exception)
