"""The Python API: runs by name, class and instance, read back and compared."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import grasp_bench as gb
from grasp_bench.errors import GraspBenchError, PredictorError, ResultsError, UnknownNameError
from grasp_bench.predictors.controls import Centroid, Displaced, Oracle


class Nothing:
    """Proposes no grasp."""

    def predict(self, image: gb.RgbdImage) -> list[gb.Grasp]:
        return []


class Needy:
    """Cannot be made without an argument, so only an instance of it can be run."""

    def __init__(self, width: float) -> None:
        self.width = width

    def predict(self, image: gb.RgbdImage) -> list[gb.Grasp]:
        return [gb.Grasp(image.intrinsics.cx, image.intrinsics.cy, 0.0, self.width)]


@pytest.fixture(scope="session")
def oracle(toy_catalog: Path, scenario: gb.Scenario, tmp_path_factory: pytest.TempPathFactory) -> gb.Run:
    out = tmp_path_factory.mktemp("api") / "oracle"
    return gb.run(toy_catalog, predictor=Oracle(), scenario=scenario, out=out, progress=False)


@pytest.fixture(scope="session")
def displaced(toy_catalog: Path, scenario: gb.Scenario, tmp_path_factory: pytest.TempPathFactory) -> gb.Run:
    out = tmp_path_factory.mktemp("api") / "displaced"
    return gb.run(toy_catalog, predictor=Displaced(), scenario=scenario, out=out, progress=False)


def test_importing_the_package_imports_no_heavy_library() -> None:
    code = (
        "import sys, grasp_bench as gb; assert 'run_trial' in dir(gb)\n"
        "heavy = {'torch', 'mujoco', 'dm_control', 'mink', 'scipy', 'cv2', 'pandas', 'numpy', 'rich'}\n"
        "print('HEAVY', sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], text=True, capture_output=True, timeout=60)
    assert "HEAVY []" in done.stdout, done.stderr


def test_every_public_name_is_there_and_documented() -> None:
    for name in gb.__all__:
        assert (getattr(gb, name).__doc__ or "").strip(), name
    assert gb.__version__
    with pytest.raises(AttributeError, match=r"no attribute 'Robot'; it offers .*run_trial"):
        _ = gb.Robot


def test_a_run_holds_a_table_of_trials_rate_and_report(oracle: gb.Run) -> None:
    assert len(oracle) == len(oracle.trials) == 3  # every object once
    assert (oracle.successes, oracle.rate, oracle.faults) == (3, 1.0, 0)
    assert oracle.interval == pytest.approx((0.4385, 1.0), abs=1e-4)  # Wilson, 3 of 3
    assert oracle.outcomes == {"success": 3}
    assert set(oracle.trials["object"]) == {"block", "bar", "pot"}
    assert (oracle.trials["pose_opening"] > 0).all()
    assert (oracle.trials["tcp_error_position"] < 1e-3).all()
    assert len(oracle.trials["pose_position"].iloc[0]) == 3
    assert {"settle", "predict", "execute"} <= set(oracle.timings.columns)
    assert "| grasp-bench | grasp_bench.predictors.controls:Oracle | 3/3 |" in oracle.report()
    assert "3/3 = 100.0%" in repr(oracle)
    shown = oracle._repr_html_()
    assert "<td>success</td><td>3</td><td>100.0%</td>" in shown


def test_a_run_is_loaded_by_its_folder(oracle: gb.Run) -> None:
    again = gb.load(str(oracle.folder))
    assert again.trials.equals(oracle.trials)
    assert again.figures["wilson95"] == list(oracle.interval)
    with pytest.raises(ResultsError, match=r"holds no run\.json"):
        gb.load(oracle.folder.parent)


def test_a_run_writes_its_page(oracle: gb.Run, toy_catalog: Path, tmp_path: Path) -> None:
    page = oracle.write_report(tmp_path / "page.html", toy_catalog)
    text = page.read_text(encoding="utf-8")
    assert text.lstrip().lower().startswith("<!doctype html>")
    assert "controls:Oracle" in text


def test_nested_columns_exist_even_when_no_trial_came_that_far(
    toy_catalog: Path, scenario: gb.Scenario, tmp_path: Path
) -> None:
    run = gb.run(toy_catalog, 1, Nothing(), scenario, out=tmp_path / "out", progress=False)
    assert run.outcomes == {"no_grasp": 1}
    assert run.trials[["grasp_x", "pose_position", "tcp_error_angle"]].isna().all().all()


def test_two_runs_are_compared_pairwise(oracle: gb.Run, displaced: gb.Run) -> None:
    pair = oracle.compare(displaced)
    assert (pair.both, pair.first_only, pair.second_only, pair.neither) == (0, 3, 0, 0)
    assert pair.difference == 1.0
    assert pair.p_value == pytest.approx(0.25)  # two-sided binomial, 3 of 3: 2 / 2³
    assert pair.differing == tuple(oracle.trials["object"])
    assert "alone succeeded in 3" in str(pair)
    assert displaced.compare(oracle).difference == -1.0


def test_runs_are_compared_on_the_trials_they_share(
    oracle: gb.Run, toy_catalog: Path, scenario: gb.Scenario, tmp_path: Path
) -> None:
    shorter = gb.run(toy_catalog, 2, Nothing(), scenario, out=tmp_path / "two", progress=False)
    pair = oracle.compare(shorter)
    assert (pair.trials, pair.first_only) == (2, 2)
    other = gb.run(toy_catalog, 3, Nothing(), scenario, seed=1, out=tmp_path / "seed", progress=False)
    with pytest.raises(ResultsError, match=r"no trial in common.* same seed"):
        oracle.compare(other)


def test_an_instance_runs_here_and_gets_a_fresh_folder_each_time(
    toy_catalog: Path, scenario: gb.Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    seen: list[tuple[int, bool]] = []

    def note(record: gb.TrialRecord, resumed: bool) -> None:
        seen.append((record.trial, resumed))

    first = gb.run(toy_catalog, 2, Needy(30.0), scenario, progress=note)
    second = gb.run(toy_catalog, 2, Needy(60.0), scenario, progress=note)
    assert first.folder != second.folder
    assert second.folder.name == first.folder.name + "-2"
    assert list(first.trials["grasp_width"]) == [30.0, 30.0]
    assert list(second.trials["grasp_width"]) == [60.0, 60.0]
    resumed = gb.run(toy_catalog, 2, Needy(60.0), scenario, out=second.folder, progress=note)
    assert (resumed.summary.resumed, resumed.summary.added) == (2, 0)
    assert seen == [(0, False), (1, False)] * 2 + [(0, True), (1, True)]


def test_names_run_on_workers_even_from_a_script_without_a_main_guard(
    toy_catalog: Path, scenario: gb.Scenario, tmp_path: Path, oracle: gb.Run
) -> None:
    camera = tmp_path / "quick.yaml"
    camera.write_text(json.dumps({"camera": scenario.camera.model_dump(mode="json")}))
    script = tmp_path / "script.py"
    script.write_text(
        "import grasp_bench as gb\n"
        "print('ONCE')\n"
        f"run = gb.run({str(toy_catalog)!r}, predictor='oracle', workers=1,\n"
        f"             scenario={str(camera)!r}, out='out', progress=False)\n"
        "print(run.outcomes)\n"
    )
    done = subprocess.run([sys.executable, script], cwd=tmp_path, text=True, capture_output=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("ONCE") == 1
    assert "{'success': 3}" in done.stdout
    there = gb.load(tmp_path / "out").trials
    assert there.equals(oracle.trials)  # the same records on workers as in this process


def test_a_class_that_other_processes_can_import_is_named_for_them() -> None:
    from grasp_bench.api import named

    assert named(Centroid) == ("grasp_bench.predictors.controls:Centroid", None)
    assert named("htc-grasp") == ("htc-grasp", None)
    instance = Centroid()
    assert named(instance) == ("grasp_bench.predictors.controls:Centroid", instance)

    class Local:
        def predict(self, image: gb.RgbdImage) -> list[gb.Grasp]:
            return []

    name, made = named(Local)
    assert name.endswith("Local")
    assert isinstance(made, Local)


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"objects": "coffee_mugg"}, UnknownNameError, "Did you mean coffee_mug"),
        ({"objects": ["apple", "coffee_mugg"]}, UnknownNameError, "'coffee_mugg'"),
        ({"scenario": "tabel4"}, UnknownNameError, "Did you mean table4"),
        ({"trials": 0}, GraspBenchError, "trials must be from 1 to 100,000,000"),
        ({"workers": -1}, GraspBenchError, "workers must not be negative"),
        ({"renderer": "raycaster"}, UnknownNameError, "Did you mean raycast"),
        ({"predictor": Nothing(), "workers": 4}, PredictorError, "cannot be sent to 4 workers"),
        ({"predictor": object()}, PredictorError, "has no method predict"),
        ({"predictor": Needy}, PredictorError, "Needy could not be made: TypeError"),
    ],
)
def test_wrong_arguments_are_refused_before_anything_is_written(
    arguments: dict, error: type[Exception], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error, match=words):
        gb.run(**({"progress": False, "predictor": Nothing()} | arguments))
    assert not Path("results").exists()


def test_one_trial_by_hand(models: dict[str, gb.ObjectModel], scenario: gb.Scenario) -> None:
    cell = gb.Workcell(scenario)
    done = gb.run_trial(cell, models["block"], Oracle())
    assert done.record.outcome is gb.Outcome.SUCCESS
    assert (done.record.trial, done.record.seed) == (0, 0)
    assert done.image is not None
    assert done.image.depth.shape == (240, 320)
