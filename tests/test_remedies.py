"""Every command, option, extra and page that a message of the package offers is one that works."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner
from written_commands import ROOT, fault, options

from grasp_bench.cli import app
from grasp_bench.errors import GraspBenchError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.names import parse
from grasp_bench.scenario.reading import load_scenario

PACKAGE = ROOT / "grasp_bench"
UNKNOWN = "\0"
STANDINS = ("1", "gripper")
"""What a message's changing parts may be: a number or a name."""
NAMED = re.compile(r"`(grasp-bench [^`]+)`|(?:^ *|cmd: |: )(grasp-bench [a-z\0][^\n'\";]*)", re.MULTILINE)
OTHERS = re.compile(r"`?(?:ray start|python -m mujoco\.viewer|python my_server\.py)[^`']*")
"""Commands of others, with their options."""
FOREIGN = {"describe.py": {"--always", "--dirty", "--abbrev"}}
"""Options of git, which a module calls."""


def _text(node: ast.AST) -> str | None:
    if isinstance(node, ast.JoinedStr):
        return "".join(str(v.value) if isinstance(v, ast.Constant) else UNKNOWN for v in node.values)
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


@cache
def messages() -> tuple[tuple[str, str], ...]:
    """All texts of the package but its docstrings, with the place of each."""
    return tuple(_messages())


def _messages() -> Iterator[tuple[str, str]]:
    for path in sorted(PACKAGE.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        inner = {id(v) for n in ast.walk(tree) if isinstance(n, ast.JoinedStr) for v in n.values}
        inner |= {id(n.value) for n in ast.walk(tree) if isinstance(n, ast.Expr)}
        for node in ast.walk(tree):
            if id(node) not in inner and (text := _text(node)):
                yield f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 0)}", text


def offered(text: str) -> list[str]:
    """The commands of grasp-bench that a text names."""
    found = (a or b for a, b in NAMED.findall(text))
    return [re.split(r"[,)](?: |$)|\.(?: |$)", command)[0].strip().rstrip(".") for command in found]


def wrong_with(command: str) -> str | None:
    """What is wrong with a command, whatever its changing parts stand for; None if nothing is."""
    if command.split()[1] in (UNKNOWN, f"{UNKNOWN}{UNKNOWN}"):  # all of it is put together elsewhere
        return None
    faults = [fault(command.replace(UNKNOWN, word)) for word in STANDINS]
    return None if None in faults else faults[0]


def test_every_command_that_is_offered_is_understood() -> None:
    commands = {(place, c) for place, text in messages() for c in offered(text)}
    assert len(commands) > 40
    assert {(p, c): why for p, c in commands if (why := wrong_with(c))} == {}


def test_every_option_that_is_named_exists() -> None:
    known = options() | {"--help"}
    wrong = []
    for place, text in messages():
        own = known | FOREIGN.get(Path(place.split(":")[0]).name, set())
        named = re.findall(r"(?<![\w-])--[a-z][\w-]*[a-z0-9](?![\w-]*\0)", OTHERS.sub("", text))
        wrong += [(place, name) for name in named if name not in own]
    assert wrong == []


def test_every_extra_that_is_to_be_installed_exists() -> None:
    with (ROOT / "pyproject.toml").open("rb") as file:
        extras = tomllib.load(file)["project"]["optional-dependencies"]
    named = {e for _, text in messages() for e in re.findall(r"grasp-bench\[([\w,-]+)\]", text)}
    assert {"rerun", "viewer", "video", "ray"} <= named <= set(extras)


def test_every_page_that_is_named_exists() -> None:
    named = {p for _, text in messages() for p in re.findall(r"docs/[\w/-]+\.md", text)}
    assert "docs/predictors.md" in named
    assert [p for p in named if not (ROOT / p).is_file()] == []


def test_faults_are_found() -> None:
    assert offered("Do it by `grasp-bench report X --format html`.") == ["grasp-bench report X --format html"]
    assert offered("Try: grasp-bench run --objects \0, then look.") == ["grasp-bench run --objects \0"]
    assert wrong_with("grasp-bench replay \0 --trail \0")
    assert wrong_with("grasp-bench replay --trial 1")
    assert wrong_with("grasp-bench objects rebuild")
    assert wrong_with("grasp-bench replay \0 --trial \0") is None


# ---------------------------------------------------------------- run as errors offer them


def told(*words: str) -> str:
    done = CliRunner().invoke(app, list(words))
    assert done.exit_code != 0
    return " ".join(
        str(done.exception if isinstance(done.exception, GraspBenchError) else done.output).split()
    )


@pytest.mark.parametrize(
    ("words", "offers"),
    [
        (("report", "OUT"), ["run"]),
        (("replay", "OUT", "--trial", "0"), ["run"]),
        (("run", "--predictor", "roi-gd", "--out", "OUT/run"), ["data synth", "train"]),
        (("objects", "list", "--folder", "OUT"), ["objects build"]),
        (("grippers", "show", "OUT"), ["grippers import"]),
        (("arms", "show", "OUT"), ["arms import"]),
    ],
    ids=lambda v: " ".join(v),
)
def test_what_an_error_offers_works(words: tuple[str, ...], offers: list[str], tmp_path: Path) -> None:
    message = told(*(w.replace("OUT", str(tmp_path)) for w in words))
    commands = offered(message)
    assert len(commands) == len(offers), message
    for command, offer in zip(commands, offers, strict=True):
        assert command.startswith(f"grasp-bench {offer}")
        assert fault(command) is None
        assert CliRunner().invoke(app, [*offer.split(), "--help"]).exit_code == 0


@pytest.mark.parametrize(
    ("words", "accepted"),
    [
        (("run", "--predictor", "htc-grap"), lambda name: parse(name).kind == "network"),
        (("run", "--predictor", "orcale"), lambda name: parse(name).kind == "control"),
        (("run", "--scenario", "tabel4"), lambda name: load_scenario(name).name == name),
        (("run", "--objects", "cofee_mug"), lambda name: bool(Catalog().select(name))),
    ],
    ids=lambda v: v[-1] if isinstance(v, tuple) else "",
)
def test_what_an_error_takes_to_be_meant_is_accepted(words: tuple[str, ...], accepted: Any) -> None:
    message = told(*words)
    meant = re.search(r"Did you mean ([^?]+)\?", message)
    assert meant is not None, message
    assert all(accepted(name) for name in meant[1].split(" or "))
