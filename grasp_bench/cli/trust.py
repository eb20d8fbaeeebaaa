"""The question whether a predictor that a stranger's record names may be started here."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

Trust = Annotated[
    bool,
    typer.Option(
        "--trust",
        help="Start the predictor that the run names also where it is a module, a command or a server, "
        "without asking.",
    ),
]


def ask_for_trust(name: str, folder: Path, trusted: bool) -> bool:
    """Return whether the predictor of a run may be started: asked of who sits at a terminal.

    Raises:
        UntrustedError: where nobody can be asked, or the answer is no.
    """
    from grasp_bench.predictors.trust import require, what_it_does

    does = what_it_does(name)
    if does is not None and not trusted and sys.stdin.isatty() and sys.stderr.isatty():
        trusted = typer.confirm(f"Doing trials of {folder} again {does} on this machine. Go on?", err=True)
    require(name, folder, trusted)
    return trusted or does is None
