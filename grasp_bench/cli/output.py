"""Output of tables, to the terminal or into a file, and what several commands say."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from grasp_bench.errors import GraspBenchError

if TYPE_CHECKING:
    from grasp_bench.report.tables import TextTable


def put(tables: Sequence[TextTable], data: dict[str, Any], fmt: str, out: Path | None) -> None:
    """Print or write tables as ``fmt``: ``table``, ``markdown``, or the ``data`` behind them as ``json``.

    Raises:
        GraspBenchError: when ``out`` cannot be written.
    """
    from rich.console import Console

    from grasp_bench.report.tables import as_text, markdown, show

    if fmt == "table" and out is None:
        show(tables, Console())
        return
    if fmt == "json":
        text = json.dumps(data, indent=1, ensure_ascii=False) + "\n"
    else:
        text = markdown(tables) if fmt == "markdown" else as_text(tables)
    if out is None:
        typer.echo(text, nl=False)
        return
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise GraspBenchError(f"{out} cannot be written ({error.strerror}).") from error


def left_out(names: Sequence[str]) -> str:
    """Return what is said of objects that no grasp fits, as Rich's markup."""
    why = f"[yellow]Left out, as the gripper cannot grasp them in any resting pose ({len(names)}):[/yellow]"
    return f"{why} {', '.join(names)}."
