"""Sweeps over a parameter: values, resumable folders, paired figures, drawings and the command."""

from __future__ import annotations

import csv
import importlib.util
import json
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

from grasp_bench import api
from grasp_bench.cli import app
from grasp_bench.cli.sweep import as_table
from grasp_bench.errors import ScenarioError, UnknownNameError
from grasp_bench.scenario.sections import Scenario
from grasp_bench.studies.sweep import Sweep, read_values, sweep, varied
from grasp_bench.studies.sweep_chart import as_html, as_svg, save


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0,0.001,0.002", [0, 0.001, 0.002]),
        ("1e-3,2E-3,-1.5e2", [0.001, 0.002, -150.0]),
        ("run,trial", ["run", "trial"]),
        ("[0.5, 0, 0.5],[0.5, 0, 0.6]", [[0.5, 0, 0.5], [0.5, 0, 0.6]]),
        ("20", [20]),
        ("true,false", [True, False]),
    ],
)
def test_values_are_read_as_scenario_files_are(text: str, values: list[Any]) -> None:
    assert read_values(text) == values


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "at least one"), ("1,,2", "must be like"), ("1,1", "twice"), ("[1", "must be like")],
)
def test_lists_that_are_none_are_refused(text: str, words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        read_values(text)


def test_all_values_are_validated_and_the_own_one_is_the_reference(table4: Scenario) -> None:
    made = varied(table4, "gripper.force", [20, 60, 120])
    assert list(made) == ["gripper.force=20", "reference", "gripper.force=120"]
    assert made["reference"][1] == table4
    assert list(varied(table4, "camera.position", [[0.5, 0, 0.6]])) == ["camera.position=_0.5_0_0.6_"]
    with pytest.raises(ScenarioError, match=r"gripper\.force"):
        varied(table4, "gripper.force", [20, 6000])


@pytest.fixture
def simulated(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Runs that write records instead of simulating: a trial is lost when force · (trial + 1) < 60."""
    folders: list[Path] = []

    def run(objects: Any, trials: int, predictor: str, scenario: Scenario, *, out: Path, **_: Any) -> None:
        out.mkdir(parents=True, exist_ok=True)
        folders.append(out)
        lines = [
            {
                "trial": i,
                "object": "egg",
                "category": "egg",
                "seed": 0,
                "detail": "",
                "outcome": "success" if won else "slipped",
                "success": won,
            }
            for i in range(trials)
            for won in [scenario.gripper.force * (i + 1) >= 60]
        ]
        (out / "trials.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))

    monkeypatch.setattr(api, "run", run)
    return folders


def swept(table4: Scenario, out: Path) -> Sweep:
    return sweep("gripper.force", [20, 30, 60], table4, out, predictors=["oracle", "my:Own"], trials=10)


def test_points_hold_counts_intervals_and_what_changed_trial_by_trial(
    table4: Scenario, tmp_path: Path, simulated: list[Path]
) -> None:
    done = swept(table4, tmp_path)
    assert [(p.predictor, p.value, p.successes, p.lost, p.gained) for p in done.points[:3]] == [
        ("oracle", 20, 8, 2, 0),
        ("oracle", 30, 9, 1, 0),
        ("oracle", 60, 10, 0, 0),
    ]
    assert done.points[0].p == pytest.approx(0.5)
    assert (done.points[0].low, done.points[0].high) == pytest.approx((0.490, 0.943), abs=1e-3)
    assert (done.own, done.scenario, done.predictors) == (60.0, "table4", ["oracle", "my:Own"])
    assert simulated[3] == tmp_path / "my-Own" / "gripper.force=20"


def test_without_the_own_value_nothing_is_compared(
    table4: Scenario, tmp_path: Path, simulated: list[Path]
) -> None:
    done = sweep("gripper.force", [20], table4, tmp_path, predictors=["oracle"], trials=4)
    assert (done.points[0].lost, done.points[0].p) == (None, None)
    assert as_table(done).caption is None


def test_figures_are_written_and_say_what_the_points_do(
    table4: Scenario, tmp_path: Path, simulated: list[Path]
) -> None:
    done = swept(table4, tmp_path)
    paths = {p.suffix: p for p in save(done, tmp_path)}
    assert {p.stem for p in paths.values()} == {"sweep-gripper.force"}
    assert json.loads(paths[".json"].read_text())["points"][0]["successes"] == 8
    rows = list(csv.DictReader(paths[".csv"].open()))
    assert (len(rows), rows[0]["rate"], rows[0]["lost"]) == (6, "0.8000", "2")
    drawing = ElementTree.parse(paths[".svg"]).getroot()
    space = "{http://www.w3.org/2000/svg}"
    circles = drawing.findall(f"{space}circle")
    points = [c for c in circles if c.find(f"{space}title") is not None]
    assert len(points) == 6
    assert "oracle, 20: 8/10 = 80.0%" in (points[0].findtext(f"{space}title") or "")
    heights = [float(c.get("cy", "")) for c in points[:3]]
    assert heights == sorted(heights, reverse=True)  # up is better
    page = paths[".html"].read_text()
    assert "plotly" in page
    assert 'src="http' not in page


def test_names_in_drawings_are_escaped(table4: Scenario, tmp_path: Path, simulated: list[Path]) -> None:
    done = sweep("gripper.force", [60], table4, tmp_path, predictors=["m:<b>&"], trials=2)
    assert ElementTree.fromstring(as_svg(done)) is not None
    assert "m:<b>&" not in as_svg(done)
    assert "</script><b>" not in as_html(done)


def test_the_sensitivity_study_says_which_values_differ(
    table4: Scenario, tmp_path: Path, simulated: list[Path]
) -> None:
    script = Path(__file__).parents[2] / "benchmarks" / "sensitivity.py"
    spec = importlib.util.spec_from_file_location("sensitivity", script)
    assert spec is not None
    assert spec.loader is not None
    study = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(study)
    for parameter, values in study.STUDY.items():
        assert "reference" in varied(table4, parameter, values)
        assert parameter in study.MEANING
    done = sweep("gripper.force", [20, 60], table4, tmp_path, predictors=["oracle"], trials=10)
    assert study.conclusion(done) == "`oracle` 10/10 at 60: no value can be told from it."
    apart = replace(done, points=(replace(done.points[0], p=0.01), done.points[1]))
    assert study.conclusion(apart) == (
        "`oracle` 10/10 at 60: 20 differs (8/10, −2/+0, p = 0.01); no value is like it."
    )
    text = study.as_markdown([done])
    assert "| oracle | 60 (reference) | 10/10 = 100.0% | 72.2% – 100.0% |  |  |" in text
    assert "n = 10 a point" in text


def test_the_command_names_what_is_wrong_before_the_first_trial(tmp_path: Path) -> None:
    call = ["sweep", "--values", "1", "--out", str(tmp_path / "x"), "--parameter"]
    result = CliRunner().invoke(app, [*call, "gripper.forse"])
    assert isinstance(result.exception, UnknownNameError)
    assert "Did you mean gripper.force" in str(result.exception)
    assert isinstance(CliRunner().invoke(app, [*call, "gripper.force"]).exception, ScenarioError)
    assert not (tmp_path / "x").exists()


def test_the_command_sweeps_and_resumes(toy_catalog: Path, tmp_path: Path) -> None:
    call = [
        "sweep",
        "--parameter",
        "sensor.axial_sigma",
        "--values",
        "0,0.0005",
        "--predictor",
        "centroid",
        "--objects",
        str(toy_catalog),
        "--trials",
        "1",
        "--workers",
        "1",
        "--json",
        "--out",
        str(tmp_path),
    ]
    first = CliRunner().invoke(app, call)
    assert first.exit_code == 0, first.output
    done = json.loads(first.stdout)
    assert [(p["value"], p["trials"]) for p in done["points"]] == [(0, 1), (0.0005, 1)]
    trials = tmp_path / "centroid" / "reference" / "trials.jsonl"
    before = trials.stat().st_mtime_ns
    assert json.loads(CliRunner().invoke(app, call).stdout) == done
    assert trials.stat().st_mtime_ns == before
