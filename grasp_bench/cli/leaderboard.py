"""``grasp-bench leaderboard``: check a run for the leaderboard, and print the table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

leaderboard_app = typer.Typer(
    no_args_is_help=True, help="Check a run for the leaderboard, and print the table."
)


@leaderboard_app.command("check")
def check_command(
    folder: Annotated[Path, typer.Argument(help="A run's folder, with about.yaml beside run.json.")],
) -> None:
    """Check that a run can be a row: scenario, objects, trials and records. Exits with 1 if not.

    Whether it was measured as it says is for `grasp-bench doctor FOLDER`, which reruns trials of it.
    """
    from grasp_bench.report.leaderboard import check, load_row

    conditions = check(folder)
    for condition in conditions:
        typer.echo(
            f"{'ok   ' if condition.passed else 'FAULT'}  {condition.what}"
            + ("" if condition.passed else f": {condition.fault}")
        )
    if not all(c.passed for c in conditions):
        raise typer.Exit(1)
    row = load_row(folder)
    typer.echo(f"{row.about.name}: {row.lifted} can be a row.")


@leaderboard_app.command("table")
def table_command(
    root: Annotated[Path, typer.Argument(help="Folder of runs; all of them must be fit for a row.")] = Path(
        "results/reference"
    ),
) -> None:
    """Print the leaderboard of all runs below ROOT as Markdown."""
    from grasp_bench.report.leaderboard import as_markdown, load_row
    from grasp_bench.runs.folder import find_runs

    typer.echo(as_markdown([load_row(folder) for folder in find_runs(root)]))
