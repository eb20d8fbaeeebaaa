"""What people read in a terminal: help and errors, word for word.

After an intended change: ``GRASP_BENCH_UPDATE_SNAPSHOTS=1 pytest tests/cli/test_snapshots.py``, then read
the difference.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from grasp_bench.cli import main

SNAPSHOTS = Path(__file__).with_name("snapshots")
HELP = [
    "",
    "run",
    "report",
    "predictors",
    "train",
    "doctor",
    "objects",
    "objects list",
    "objects show",
    "data",
    "data synth",
    "leaderboard",
    "leaderboard check",
    "check",
    "merge",
    "sweep",
    "why",
    "evaluate",
    "scenarios",
    "grippers",
    "grippers check",
    "grippers prepare",
    "grippers import",
    "arms",
    "arms check",
    "arms import",
    "objects import",
    "predictors check",
    "cache",
    "cache clear",
]
ERRORS = {
    "unknown-command": "rnu",
    "unknown-option": "run --object mug",
    "unknown-object": "run --objects cofee_mug",
    "unknown-predictor": "run --predictor orcale",
    "unknown-predictor-module": "run --predictor nowhere:Thing",
    "unknown-scenario": "run --scenario tabel4",
    "missing-scenario-file": "run --scenario missing.yaml",
    "unknown-scenario-key": "run --scenario wrong-key.yaml",
    "impossible-scenario-value": "run --scenario wrong-value.yaml",
    "unknown-renderer": "run --renderer raycaster",
    "no-trials": "run --trials 0",
    "folder-without-objects": "run --objects empty",
    "report-of-nothing": "report empty",
    "report-of-no-folder": "report nowhere",
    "unknown-report-format": "report empty --format markdwon",
    "row-of-nothing": "leaderboard check empty",
}


@pytest.fixture(autouse=True)
def _terminal(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A plain terminal of 96 columns in a folder with a few wrong files."""
    for name in ("FORCE_COLOR", "GITHUB_ACTIONS", "PY_COLORS", "TERMINAL_WIDTH"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("COLUMNS", "96")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.chdir(tmp_path)
    Path("empty").mkdir()
    Path("wrong-key.yaml").write_text("gripper: {forse: 30}")
    Path("wrong-value.yaml").write_text("gripper: {force: 1000}")


def compare(
    name: str, words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> int:
    """Run a command and compare all it printed with its snapshot; its exit code."""
    monkeypatch.setattr("sys.argv", ["grasp-bench", *words.split()])
    with pytest.raises(SystemExit) as ended:
        main()
    printed = capsys.readouterr()
    both = (printed.out + printed.err).replace(str(tmp_path), "FOLDER")
    text = re.sub(" +\n", "\n", both).strip() + "\n"
    path = SNAPSHOTS / f"{name}.txt"
    if os.environ.get("GRASP_BENCH_UPDATE_SNAPSHOTS"):
        SNAPSHOTS.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    assert text == path.read_text(encoding="utf-8")
    return ended.value.code if isinstance(ended.value.code, int) else 0


@pytest.mark.parametrize("words", HELP)
def test_help(
    words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    name = "-".join(["help", *words.split()])
    assert compare(name, f"{words} --help", monkeypatch, capsys, tmp_path) == 0


@pytest.mark.parametrize("name", ERRORS)
def test_errors(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert compare(f"error-{name}", ERRORS[name], monkeypatch, capsys, tmp_path) == 2


def test_no_snapshot_is_left_over() -> None:
    wanted = {"-".join(["help", *words.split()]) for words in HELP} | {f"error-{name}" for name in ERRORS}
    assert {p.stem for p in SNAPSHOTS.glob("*.txt")} == wanted
