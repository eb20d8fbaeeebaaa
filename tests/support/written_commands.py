"""Commands as texts name them, held against the command line as it is."""

from __future__ import annotations

import re
import shlex
from functools import cache
from pathlib import Path
from typing import Any

import typer
from typer.main import get_command

from grasp_bench.cli import app

ROOT = Path(__file__).parents[2]
PLACEHOLDER = re.compile(r"…|\.\.\.|<[a-z]+>|[*{}$]|\b[A-Z][A-Z_]{2,}\b|\bN\b")


@cache
def _whole() -> Any:
    return get_command(app)


def fault(command: str) -> str | None:
    """Say what is wrong with a command; None where nothing is, or where it is a pattern of one."""
    try:
        words = shlex.split(command)
    except ValueError as error:
        return str(error)
    if words[0] == "make":
        targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
        return None if len(words) < 2 or words[1] in targets else f"no target {words[1]}"
    if words[0] == "python":
        return None if (ROOT / words[1]).is_file() else f"no file {words[1]}"
    return refused(_whole(), words[1:])


def refused(command: Any, words: list[str]) -> str | None:
    """Say what a command's parser refuses; words in capitals stand for anything."""
    if below := getattr(command, "commands", None):
        if not words or words[0].startswith("-") or PLACEHOLDER.search(words[0]):
            return None
        return refused(below[words[0]], words[1:]) if words[0] in below else f"no command {words[0]}"
    try:
        command.make_context("x", list(words))
    except typer.Exit:
        return None
    except Exception as error:  # Typer brings its own Click, whose names differ between versions
        kind = type(error).__name__
        half = kind in ("MissingParameter", "BadOptionUsage") and len(words) < 2  # as named in a sentence
        pattern = kind != "NoSuchOption" and PLACEHOLDER.search(" ".join(words))
        return None if half or pattern else f"{kind}: {error}"
    return None


def options(command: Any = None) -> set[str]:
    """Return all options of a command and those below it; of the whole command line by default."""
    command = _whole() if command is None else command
    own = {name for p in command.params for name in (*p.opts, *p.secondary_opts) if name.startswith("--")}
    return own.union(*map(options, getattr(command, "commands", {}).values()))
