"""What a notebook shows: a line while a run goes on, a trial with its picture, failures in small."""

from __future__ import annotations

import base64
import builtins
import re
from dataclasses import dataclass
from pathlib import Path

import pytest
from html_runs import CLOSING, HOSTILE, write_clutter, write_run

from grasp_bench.errors import ResultsError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.report.notebook import MOST, failures
from grasp_bench.report.run import Run
from grasp_bench.system import progress
from grasp_bench.system.progress import Progress


@dataclass
class Tried:
    success: bool


class ZMQInteractiveShell:
    """A notebook's shell, as far as libraries look at it."""


@pytest.fixture
def notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(builtins, "get_ipython", ZMQInteractiveShell, raising=False)
    monkeypatch.setattr(progress, "EVERY", 0.0)


@pytest.mark.usefixtures("notebook")
def test_a_notebook_gets_one_line_without_widgets(
    capsys: pytest.CaptureFixture[str], recwarn: pytest.WarningsRecorder
) -> None:
    with Progress(3) as bar:
        for success in (True, False, True):
            bar.update(Tried(success))
    shown = capsys.readouterr()
    states = shown.out.split("\r")[1:]
    assert [s.split(",")[0].strip() for s in states] == ["Grasping 1/3", "Grasping 2/3", "Grasping 3/3"] + [
        "Grasping 3/3"
    ]
    assert re.search(r"lifted 1/2 = 50%, about \d+ s to go", states[1])
    assert re.search(r"lifted 2/3 = 67%, \d+ s\s*\n$", states[-1])
    assert shown.out.count("\n") == 1
    assert shown.err == ""
    assert "\x1b" not in shown.out
    assert [str(w.message) for w in recwarn] == []


@pytest.mark.usefixtures("notebook")
def test_a_refused_run_leaves_no_line(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match="refused"), Progress(3):
        raise ValueError("refused")
    assert capsys.readouterr().out == ""


def test_trials_found_done_do_not_count_for_what_is_to_go(
    notebook: None, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([0.0, 0.0, 0.0, 10.0])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))
    with Progress(5) as bar:
        bar.update(Tried(True), resumed=True)
        bar.update(Tried(True), resumed=True)
        bar.update(Tried(True))
    states = capsys.readouterr().out.split("\r")
    assert "to go" not in states[2]
    assert "about 20 s to go" in states[3]


def test_a_terminal_has_its_bar(capsys: pytest.CaptureFixture[str]) -> None:
    with Progress(1) as bar:
        bar.update(Tried(True))
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "1/1 = 100%" in shown.err


# ---------------------------------------------------------------- a trial


@pytest.fixture
def run(tmp_path: Path) -> Run:
    return Run(write_run(tmp_path / "mine", "mod:Mine", ["success", "missed", "slipped"], pictures=True))


def test_a_trial_is_shown_with_its_pictures_and_numbers(run: Run) -> None:
    view = run.show(1)
    page = view._repr_html_()
    sheet, clip = (run.folder / "media" / f"00001{kind}.webp" for kind in ("", "-clip"))
    for file in (sheet, clip):
        assert base64.b64encode(file.read_bytes()).decode() in page
    assert "missed" in page
    assert CLOSING not in page
    text = repr(view)
    assert text.splitlines()[0] == f"Trial 1 of {run.folder}"
    assert f"picture: {sheet}" in text
    assert "jaws opened: 50.0 mm" in text


def test_a_trial_without_picture_says_how_to_get_one(tmp_path: Path) -> None:
    run = Run(write_run(tmp_path / "bare", "oracle", ["missed"]))
    assert f"grasp-bench replay {run.folder} --trial 0 --video trial.gif" in repr(run.show(0))
    assert "<img" not in run.show(0)._repr_html_()


def test_an_attempt_of_an_episode_is_shown(tmp_path: Path) -> None:
    run = Run(write_clutter(tmp_path / "clutter", [["success", "missed"]]))
    assert run.show(0).picture == run.folder / "media" / "00000-01.webp"  # the last one
    first = run.show(0, attempt=0)
    assert first.picture == run.folder / "media" / "00000-00.webp"
    assert HOSTILE not in first._repr_html_()
    with pytest.raises(ResultsError, match=r"has no attempt 7; it has attempts 0 to 1\."):
        run.show(0, 7)


def test_a_trial_that_is_not_there_is_named(run: Run) -> None:
    with pytest.raises(ResultsError, match=r"holds no trial 9; it has trials 0 to 2\."):
        run.show(9)
    with pytest.raises(ResultsError, match=r"has no attempt 0; it has no attempts"):
        run.show(0, 0)


# ---------------------------------------------------------------- failures in small


def test_a_run_shows_its_failures_in_small(run: Run) -> None:
    page = run._repr_html_()
    assert page.count("<figure") == 2
    assert base64.b64encode((run.folder / "media" / "00001.webp").read_bytes()).decode() in page
    assert "run.show(1)" in page
    assert HOSTILE not in page


def test_failures_without_pictures_have_the_objects_and_there_are_not_too_many(tmp_path: Path) -> None:
    files = {"apple": Catalog().entries["apple"]["files"], "coffee_mug": {"other": "files"}}
    run = Run(write_run(tmp_path / "bare", "oracle", ["missed"] * 30, objects=files))
    page = failures(run)
    assert page.count("<figure") == MOST
    assert f"the first {MOST} of 30" in page
    assert page.count("<img") == MOST // 4  # every fourth is the apple, the others are nobody's


def test_a_run_without_failures_shows_none(tmp_path: Path) -> None:
    assert failures(Run(write_run(tmp_path / "good", "oracle", ["success"]))) == ""
