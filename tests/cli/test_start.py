"""Workers that are begun before the command line is imported."""

from __future__ import annotations

import inspect

import pytest
from typer.models import OptionInfo

from grasp_bench.cli.run import run_command
from grasp_bench.cli.start import GUESSED, UNLIKE, begun_ahead, guess


def test_guessed_defaults_are_those_of_the_command() -> None:
    parameters = inspect.signature(run_command).parameters
    defaults = {name: str(parameters[name].default) for name in GUESSED}
    assert parameters["predictor"].default is None, "or that of the weights, with which none are begun here"
    assert defaults | {"predictor": "htc-grasp"} == GUESSED
    assert "--weights" in UNLIKE
    assert not any(isinstance(parameters[name].default, OptionInfo) for name in GUESSED)


@pytest.mark.parametrize(
    ("words", "asked"),
    [
        ("run", {}),
        ("run --predictor oracle --trials 6", {"predictor": "oracle", "trials": "6"}),
        ("run --workers=1 --objects mug -q", {"workers": "1"}),
    ],
)
def test_options_of_a_run_are_seen_before_they_are_checked(words: str, asked: dict[str, str]) -> None:
    assert guess(words.split()) == GUESSED | asked


@pytest.mark.parametrize(
    "words",
    [
        "",
        "report results",
        "--help",
        "run --help",
        "run --predictor",
        "run --predictor my_module:MyPredictor",
        "run --trials many",
        "run --workers -1",
        "run --renderer egl",
        "run --executor ray",
        "run --executor=ray",
        "run --weights mine.safetensors",
    ],
)
def test_no_workers_are_begun_where_they_would_not_serve(words: str) -> None:
    assert guess(words.split()) is None
    with begun_ahead(words.split()):
        pass
