"""Foreign code that does anything: it costs its own trials, and never the run, the record or the command."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import foreign_predictors
import numpy as np
import pytest
from foreign_predictors import ENDS

import grasp_bench as gb
from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.doctor import conformance
from grasp_bench.errors import PredictorError
from grasp_bench.predictors.identity import identify
from grasp_bench.predictors.protocol import ask
from grasp_bench.report.ending import ending
from grasp_bench.runs.folder import load_records, load_run
from grasp_bench.scenario.sections import Scenario
from grasp_bench.system.interrupts import Interrupted, told_apart

TESTS = Path(__file__).parents[1] / "support"
SIZE = Intrinsics.from_fov(64, 48, 1.5)
IMAGE = RgbdImage(np.zeros((48, 64, 3), np.uint8), np.ones((48, 64), np.float32), SIZE)


class Does:
    """A predictor that does one thing."""

    def __init__(self, what: Callable[[], Any]) -> None:
        self.what = what

    def predict(self, image: RgbdImage) -> list[gb.Grasp]:
        return self.what()


@pytest.mark.parametrize("end", ENDS)
def test_whatever_a_prediction_raises_or_returns_is_one_short_legible_error(end: str) -> None:
    with told_apart(), pytest.raises(PredictorError) as caught:
        ask(Does(ENDS[end]), IMAGE, np.random.default_rng(0))
    text = str(caught.value)
    assert 10 < len(text) < 2200
    assert type(text) is str
    assert text.encode().decode() == text
    assert text.isprintable() or "\n" in text


def test_a_users_ctrl_c_is_not_taken_for_the_predictors() -> None:
    with pytest.raises(KeyboardInterrupt):
        ask(Does(ENDS["interrupt"]), IMAGE, np.random.default_rng(0))  # may be the user's
    with told_apart(), pytest.raises(Interrupted):
        ask(Does(lambda: os.kill(os.getpid(), 2)), IMAGE, np.random.default_rng(0))


def test_numpys_errors_and_the_recursion_limit_are_put_back() -> None:
    before = np.geterr(), sys.getrecursionlimit()
    here = Path.cwd()
    try:
        ask(replace_making(foreign_predictors.Moves), IMAGE, np.random.default_rng(0))
    finally:
        os.chdir(here)
    assert (np.geterr(), sys.getrecursionlimit()) == before


def replace_making(kind: Any) -> Any:
    """An instance without its ``__init__``."""
    return object.__new__(kind)


def command(cwd: Path, *words: str, seconds: float = 300) -> tuple[int, str, str]:
    """Run ``grasp-bench`` as a process of its own; its exit code, output and errors."""
    done = subprocess.run(
        [sys.executable, "-m", "grasp_bench.cli", *words],
        cwd=cwd,
        text=True,
        capture_output=True,
        timeout=seconds,
        env=os.environ | {"PYTHONPATH": f"{TESTS.parents[1]}:{TESTS}", "COLUMNS": "200"},
    )
    return done.returncode, done.stdout, done.stderr


@pytest.fixture
def quick(tmp_path: Path, scenario: Scenario) -> Path:
    path = tmp_path / "quick.yaml"
    path.write_text(scenario.model_copy(update={"trial_timeout": 20.0}).model_dump_json())
    return path


def test_a_run_of_predictions_that_end_in_all_ways_is_complete_and_readable(
    toy_catalog: Path, quick: Path, tmp_path: Path
) -> None:
    words = f"run --objects {toy_catalog} --trials {len(ENDS)} --scenario {quick} --workers 1 --out out"
    words += " --predictor foreign_predictors:Ends --max-errors 100%"
    code, out, err = command(tmp_path, *words.split())
    assert code == 0, out + err
    records = load_records(tmp_path / "out")
    assert [r.trial for r in records] == list(range(len(ENDS)))
    assert {str(r.outcome) for r in records} == {"error"}
    assert max(len(line) for line in (tmp_path / "out" / "trials.jsonl").read_bytes().splitlines()) < 10_000
    assert command(tmp_path, *words.split())[0] == 0, "and again on resume"


def test_a_process_that_leaves_with_status_0_has_died(toy_catalog: Path, quick: Path, tmp_path: Path) -> None:
    words = f"run --objects {toy_catalog} --trials 2 --scenario {quick} --workers 1 --out out --max-errors 9"
    code, out, err = command(tmp_path, *words.split(), "--predictor", "foreign_predictors:Leaves")
    assert code == 0, out + err
    found = {(str(r.outcome), r.detail) for r in load_records(tmp_path / "out")}
    assert found == {("error", "the worker process died (exit code 0)")}


@pytest.mark.parametrize("name", ["Maps", "Closes", "ClosesNever", "Thread"])
def test_maps_close_and_threads_do_not_end_or_hold_the_command(
    toy_catalog: Path, quick: Path, tmp_path: Path, name: str
) -> None:
    words = f"run --objects {toy_catalog} --trials 2 --scenario {quick} --workers 1 --out out --media all"
    code, out, err = command(
        tmp_path, *words.split(), "--predictor", f"foreign_predictors:{name}", seconds=100
    )
    assert code == 0, out + err
    records = load_records(tmp_path / "out")
    assert len(records) == 2
    assert "error" not in {str(r.outcome) for r in records}


def test_results_stay_where_the_command_was_given_and_json_stays_json(
    toy_catalog: Path, quick: Path, tmp_path: Path
) -> None:
    words = f"run --objects {toy_catalog} --trials 1 --scenario {quick} --workers 1 --out out --media all"
    code, out, err = command(tmp_path, *words.split(), "--json", "--predictor", "foreign_predictors:Moves")
    assert code == 0, err
    assert json.loads(out)["trials"] == 1
    assert "hello from a predictor" in err
    assert sorted(p.name for p in (tmp_path / "elsewhere").iterdir()) in ([], ["elsewhere"])
    assert (tmp_path / "out" / "media" / "00000.webp").is_file()
    assert len(load_records(tmp_path / "out")) == 1


def test_an_instance_that_goes_elsewhere_leaves_the_results_here(
    toy_catalog: Path, scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    made = foreign_predictors.Moves()
    os.chdir(tmp_path)
    made.predict = lambda image: os.chdir("elsewhere") or []
    run = gb.run(toy_catalog, 1, made, scenario, out="mine", progress=False)
    assert (tmp_path / "mine" / "trials.jsonl").is_file()
    assert len(run) == 1


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("LeavesWhenMade", r"ended its process while it was made \(exit code 0\)"),
        ("HangsWhenMade", r"was not ready within 5 s\..*grasp-bench serve"),
        ("Absent", "Unknown name in module"),
    ],
)
def test_the_parent_does_not_make_a_predictor_itself(
    name: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("grasp_bench.predictors.command.START_SECONDS", 5.0)
    with pytest.raises(PredictorError, match=words):
        identify(f"foreign_predictors:{name}")


def test_what_a_predictor_says_of_itself_is_written_as_text_that_can_be_read(
    toy_catalog: Path, scenario: Scenario, tmp_path: Path
) -> None:
    gb.run(toy_catalog, 1, foreign_predictors.Says(), scenario, out=tmp_path, progress=False)
    said = load_run(tmp_path).implementation
    assert said is not None
    assert said["info"] == {"weights": "caf\ufffd.pt", "\ufffd": ["\ufffd"]}


@pytest.mark.parametrize(
    ("name", "words"), [("Leaves", "ends its process (exit code 0)"), ("Ends", "foreign_predictors.py:")]
)
def test_the_check_fails_a_predictor_that_leaves_and_names_the_users_own_line(name: str, words: str) -> None:
    rows = conformance.check_named(f"foreign_predictors:{name}")
    assert rows[0].failed
    assert words in rows[0].findings[0].text


def test_the_check_ends_a_predictor_that_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conformance, "LIMIT", 4.0)
    rows = conformance.check_named("foreign_predictors:HangsWhenMade")
    assert [f.text for f in rows[0].findings] == ["hangs (no answer within 4 s)"]


# ---------------------------------------------------------------- what the user is told


class Typo:
    """A predictor with a slip in it."""

    def predict(self, image: RgbdImage) -> list[gb.Grasp]:
        return image.dept  # pyright: ignore[reportAttributeAccessIssue]


def test_tracebacks_are_kept_once_in_the_runs_folder(
    toy_catalog: Path, scenario: Scenario, tmp_path: Path
) -> None:
    run = gb.run(toy_catalog, 3, Typo(), scenario, out=tmp_path / "out", progress=False)
    log = (tmp_path / "out" / "errors.log").read_text()
    assert log.count("Traceback (most recent call last)") == 1
    assert "return image.dept" in log
    assert log.count("as in trial 0") == 2
    detail = run.records[1].detail
    assert re.search(r"raised AttributeError: .*'dept' \(test_foreign_code\.py:\d+\)", detail)
    told = "\n".join(ending(run))
    assert "Outcomes: error 3." in told
    assert "Most failures (3 of 3): error: the predictor raised AttributeError" in told
    assert "errors.log" in told
    assert "Nothing was lifted" in told


def test_an_error_is_raised_as_it_is_where_that_is_asked_for(
    toy_catalog: Path, scenario: Scenario, tmp_path: Path
) -> None:
    with pytest.raises(AttributeError, match="dept"):
        gb.run(toy_catalog, 3, Typo(), scenario, out=tmp_path / "a", progress=False, on_error="raise")
    assert load_records(tmp_path / "a") == []
    name = "foreign_predictors:Ends"
    with pytest.raises(PredictorError, match=r"Trial 0 \(.*KeyboardInterrupt"):
        gb.run(
            toy_catalog, 3, name, scenario, workers=1, out=tmp_path / "b", progress=False, on_error="raise"
        )
    with pytest.raises(gb.GraspBenchError, match="on_error"):
        gb.run(toy_catalog, 3, Typo(), scenario, out=tmp_path / "c", on_error="explode")


def test_the_last_lines_of_a_run_name_reason_and_remedy(
    toy_catalog: Path, quick: Path, tmp_path: Path
) -> None:
    words = (
        f"run --objects {toy_catalog} --trials 3 --scenario {quick} --workers 1 --out out[x] --max-errors 9"
    )
    code, out, err = command(tmp_path, *words.split(), "--predictor", "foreign_predictors:Ends")
    assert code == 0, err
    assert "Outcomes: error 3." in out
    assert "out[x]/errors.log" in out
    assert "grasp-bench predictors check foreign_predictors:Ends" in out
