"""The gate on how firmly objects are held: verdicts, what is not comparable, and what it writes."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from made_up_runs import write_run
from test_firmness import GRADED, graded, spread

from grasp_bench.errors import GraspBenchError
from grasp_bench.report.firmness_gate import CheckedFirmness, check_firmness
from grasp_bench.report.gate import NotComparableError, Verdict
from grasp_bench.report.gate_text import as_junit, as_markdown, as_text

NOISE = np.random.default_rng(5).normal(size=40)
NOISE -= NOISE.mean()


def compared(folder: Path, drift: float, noise: float, **options: Any) -> CheckedFirmness:
    """A new run that bears ``drift`` times as much, give or take ``noise`` octaves."""
    old = graded(folder / "old", spread)
    new = graded(folder / "new", lambda t: drift * spread(t) * 2 ** (noise * float(NOISE[t])))
    return check_firmness(new, old, **options)


@pytest.mark.parametrize(
    ("drift", "noise", "verdict"),
    [
        (1.0, 0.0, Verdict.NO_REGRESSION),
        (1.0, 0.3, Verdict.NO_REGRESSION),
        (1.4, 0.3, Verdict.NO_REGRESSION),
        (0.95, 0.05, Verdict.NO_REGRESSION),
        (0.7, 0.1, Verdict.REGRESSION),
        (0.7, 0.5, Verdict.REGRESSION),
        (0.95, 2.0, Verdict.INCONCLUSIVE),
    ],
)
def test_verdicts(tmp_path: Path, drift: float, noise: float, verdict: Verdict) -> None:
    found = compared(tmp_path, drift, noise)
    assert found.verdict is verdict
    assert found.failed is (verdict is Verdict.REGRESSION)
    assert found.ratio.low <= found.ratio.value <= found.ratio.high
    assert (found.trials, found.objects) == (40, 40)


def test_a_small_drop_that_is_proven_passes_with_a_word(tmp_path: Path) -> None:
    found = compared(tmp_path, 0.95, 0.05)
    assert found.p_worse < 0.01
    assert found.notes == ("A drop is proven, but it is smaller than the margin.",)


def test_the_most_changed_trials_come_first(tmp_path: Path) -> None:
    old = graded(tmp_path / "old", lambda t: 8.0)
    new = graded(tmp_path / "new", lambda t: {3: 1.0, 5: 3.0, 7: 5.0}.get(t, 8.0), wins=lambda t: t != 9)
    found = check_firmness(new, old)
    assert [c.trial for c in found.changed] == [9, 3, 5]
    assert (found.changed[1].before, found.changed[1].after) == ("8×", "1×")


def test_it_is_told_in_words_markdown_junit_and_json(tmp_path: Path) -> None:
    found = compared(tmp_path, 0.5, 0.1)
    text = as_text(found)
    assert text.startswith("REGRESSION: Objects are held less firmly: 0.")
    assert "signed-rank" in text
    assert "❌ grasp-bench: regression" in as_markdown(found)
    assert Xml.fromstring(as_junit(found)).find(".//failure") is not None
    content = json.loads(json.dumps(found.to_json(), allow_nan=False))
    assert content["verdict"] == "regression"
    assert content["ratio"]["value"] == pytest.approx(0.5, rel=0.05)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ({"scenario": {"name": "table4", "version": 2}}, {}, "did not measure how firmly"),
        ({}, {"seed": 9}, "not of the same trials"),
        ({}, {"scenario": GRADED | {"execution": "as-predicted"}}, "not of the same trials"),
        ({}, {"only": [0, 1]}, "lacks 38 of 40 trials"),
    ],
)
def test_what_cannot_be_compared_is_refused(
    tmp_path: Path, old: dict[str, Any], new: dict[str, Any], words: str
) -> None:
    first, second = graded(tmp_path / "old", spread, **old), graded(tmp_path / "new", spread, **new)
    with pytest.raises(NotComparableError, match=words):
        check_firmness(second, first)


@pytest.mark.parametrize(("option", "value"), [("least", 0.0), ("least", 1.0), ("alpha", 0.7)])
def test_impossible_options_are_refused(tmp_path: Path, option: str, value: float) -> None:
    with pytest.raises(GraspBenchError, match="must be between"):
        check_firmness(tmp_path, tmp_path, **{option: value})


def test_the_command_gates_on_it(tmp_path: Path, cli: Callable[[str], Any]) -> None:
    old, new = graded(tmp_path / "old", spread), graded(tmp_path / "new", lambda t: 0.5 * spread(t))
    plain = write_run(tmp_path / "plain")
    assert cli(f"check {new} --baseline {old}").code == 3  # as many succeed
    worse = cli(f"check {new} --baseline {old} --firmness 0.8")
    assert (worse.code, worse.out.split(":")[0]) == (1, "REGRESSION")
    assert cli(f"check {new} --baseline {old} --firmness 0.4").code == 0
    assert cli(f"check {plain} --baseline {plain} --firmness 0.8").code == 2
    assert cli(f"check {new} --baseline {old} --firmness 0.8 --exact").code == 2
