"""What is told of a run's circumstances: a process of its own, and variables that change last digits."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from made_up_runs import write_run

from grasp_bench.doctor.checks import State
from grasp_bench.doctor.rerun import _isolation
from grasp_bench.execution.describe import NUMERIC, _environment
from grasp_bench.runs.folder import load_run


@pytest.mark.parametrize(
    ("predictor", "recorded", "state", "words"),
    [
        ("cmd: serve --port {port}", True, State.OK, "in a process of its own"),
        ("http://127.0.0.1:8000", True, State.OK, "in a process of its own"),
        ("cmd: serve --port {port}", None, State.NOTE, "does not say"),
        ("mine:Mine", None, State.NOTE, "caller's frame holds the truth.* no row of the leaderboard"),
        ("mine:Mine", True, State.NOTE, "caller's frame holds the truth"),
    ],
)
def test_it_says_whether_a_predictor_could_read_the_truth(
    predictor: str, recorded: bool | None, state: State, words: str, tmp_path: Path
) -> None:
    check = _isolation(load_run(write_run(tmp_path, predictor=predictor, apart=recorded)))
    assert check is not None
    assert check.state is state
    assert re.search(words, check.detail)


def test_of_a_shipped_predictor_nothing_is_to_be_feared(tmp_path: Path) -> None:
    assert _isolation(load_run(write_run(tmp_path, predictor="oracle"))) is None


def test_variables_that_choose_instructions_are_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in NUMERIC:
        monkeypatch.delenv(name, raising=False)
    assert _environment() is None
    chosen = {"ONEDNN_MAX_CPU_ISA": "AVX2", "OPENBLAS_CORETYPE": "Haswell"}
    for name, value in chosen.items():
        monkeypatch.setenv(name, value)
    assert _environment() == chosen
