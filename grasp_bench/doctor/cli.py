"""``grasp-bench doctor``: is this machine fit to measure, and does a finished run repeat on it?"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from grasp_bench.graphics import without_gl


def doctor_command(
    run: Annotated[Path | None, typer.Argument(
        help="A finished run's folder; without it, the environment is checked.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Check the installation, or rerun some trials of RUN and compare them byte for byte.

    Exit codes: 0 all is well · 1 something is wrong or did not repeat · 2 bad input.

    Example: grasp-bench doctor
    """
    without_gl()
    from rich.console import Console

    from grasp_bench.doctor.checks import healthy, show
    from grasp_bench.doctor.environment import check_environment

    title, checks = "Environment", check_environment()
    if as_json:
        typer.echo(json.dumps([c.to_json() for c in checks], ensure_ascii=False))
    else:
        show(title, checks, Console())
    if not healthy(checks):
        raise typer.Exit(1)
