"""Brackets in texts stay what they are: units in help and tables, names of folders."""

from __future__ import annotations

import itertools
import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rich.text import Text
from typer.main import get_command
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.report.tables import TextTable, as_text
from grasp_bench.system import cache

GRIPPERS = Path(__file__).parents[2] / "assets" / "grippers"
STYLES = {"[bold]", "[/bold]"}


def helps(command: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """The help of a command, of its options, and of those below it."""
    yield path, command.help or ""
    for param in command.params:
        yield f"{path} {param.name}", getattr(param, "help", None) or ""
    for name, below in getattr(command, "commands", {}).items():
        yield from helps(below, f"{path} {name}")


def test_no_help_loses_what_stands_in_brackets() -> None:
    lost = []
    for place, text in helps(get_command(app)):
        shown = Text.from_markup(text).plain
        named = set(re.findall(r"\[[^\[\]]+\]", text)) - STYLES
        lost += [(place, unit) for unit in named if unit not in shown]
    assert lost == []


@pytest.mark.parametrize(
    ("words", "units"),
    [
        ("grippers list", ["[mm]", "[kg]", "[N]"]),
        ("arms list", ["[kg]", "[N m]"]),
        ("arms show ec66", ["[°/s]", "[N m]"]),
        ("objects list", ["[g]", "[mm]"]),
        ("objects import --help", ["[m]", "[kg]", "[kg/m³]"]),
        ("grippers import --help", ["[m/s]"]),
    ],
)
def test_tables_and_help_show_units(words: str, units: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    shown = " ".join(CliRunner().invoke(app, words.split()).output.split())
    assert [u for u in units if u not in shown] == []


def commands(command: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The words of a command and of those below it."""
    yield path
    for name, below in getattr(command, "commands", {}).items():
        yield from commands(below, (*path, name))


@pytest.fixture
def _80_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("FORCE_COLOR", "GITHUB_ACTIONS", "PY_COLORS", "TERMINAL_WIDTH"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("TERM", "dumb")


@pytest.mark.usefixtures("_80_columns")
def test_no_help_is_cut_in_a_narrow_terminal() -> None:
    """Where space is short, Rich ends words with dots; names of options and defaults were lost by that."""
    for path in commands(get_command(app)):
        shown = CliRunner().invoke(app, [*path, "--help"]).output
        cut = [w for w in shown.split() if re.fullmatch(r"\w[\w,./-]*…", w)]
        assert cut == [], path


@pytest.mark.usefixtures("_80_columns")
def test_paragraphs_of_help_flow_to_the_terminals_width() -> None:
    for path in commands(get_command(app)):
        lines = CliRunner().invoke(app, [*path, "--help"]).output.splitlines()
        told = [line.strip() for line in lines[: next(i for i, x in enumerate(lines) if x.startswith("╭"))]]
        for line, below in itertools.pairwise(told):
            assert not below or not line or len(line) + 1 + len(below.split()[0]) > 76, (path, line, below)


@pytest.mark.usefixtures("_80_columns")
@pytest.mark.parametrize("words", ["objects list", "grippers list", "arms list", "scenarios", "predictors"])
def test_no_letter_of_a_list_is_lost_in_a_narrow_terminal(words: str) -> None:
    shown = CliRunner().invoke(app, words.split()).output
    told = json.loads(CliRunner().invoke(app, [*words.split(), "--json"]).output)
    lines = {line.split()[0] for line in shown.splitlines() if line.split()}
    assert [t["name"] for t in told if t["name"] not in lines] == []
    assert "…" not in shown


def test_commands_stand_in_panels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    shown = CliRunner().invoke(app, ["--help"]).output
    panels = re.findall(r"^╭─ ([\w ]+) ─", shown, re.MULTILINE)
    assert panels[1:] == [
        "Measure",
        "Look at what was measured",
        "Train",
        "Share",
        "This machine",
        "What there is to choose from",
    ]
    assert "Commands" not in panels


def test_names_in_reports_are_no_markup() -> None:
    table = TextTable("[red]title[/red]", ("[mm]",), [["[bold]x"]], note="[g]")
    shown = as_text([table])
    for part in ("[red]title[/red]", "[mm]", "[bold]x", "[g]"):
        assert part in shown


def test_a_folder_in_brackets_is_named_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "300")
    out = tmp_path / "scenes [red] [mm]"
    out.mkdir()
    shown = CliRunner().invoke(app, ["report", str(out)])
    assert shown.exit_code != 0
    assert "scenes [red] [mm]" in f"{shown.output}{shown.exception}"


def test_the_first_use_says_where_models_go_and_how_to_limit_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GRASP_BENCH_CACHE", str(tmp_path))
    monkeypatch.setenv(cache.LIMIT, "1500")
    told = cache.first_use()
    assert told is not None
    assert str(cache.folder()) in told
    assert "1 to 2 GB" in told
    assert "at most 1.5 GB" in told
    assert f"{cache.LIMIT}=500" in told
    monkeypatch.setenv(cache.LIMIT, "0")
    assert cache.first_use() is None
    monkeypatch.delenv(cache.LIMIT)
    cache.folder().mkdir(parents=True)
    (cache.folder() / "a.mjb").write_bytes(b"x")
    assert cache.first_use() is None


def test_a_gripper_in_brackets_is_shown_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "300")
    own = tmp_path / "mine [red] [mm]"
    shutil.copytree(GRIPPERS / "parallel-50", own)
    text = (own / "gripper.yaml").read_text(encoding="utf-8")
    renamed = re.sub(r"^title: .*$", 'title: "opens [mm] wide [/bold]"', text, flags=re.MULTILINE)
    (own / "gripper.yaml").write_text(renamed, encoding="utf-8")
    shown = CliRunner().invoke(app, ["grippers", "show", str(own)])
    assert shown.exit_code == 0, shown.output
    assert "opens [mm] wide [/bold]" in shown.output
    assert "mine [red] [mm]" in shown.output
