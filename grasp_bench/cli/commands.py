"""The command line. Commands are thin: parse, call, print.

They import what brings NumPy only when they run, so that help and completion stay quick.

Exit codes: 0 success · 1 the run finished, but with more harness errors than allowed ·
2 bad input, nothing was measured or lost · 130 interrupted; the same command goes on.
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from importlib.metadata import version as installed
from typing import Annotated

import typer

from grasp_bench.cli.agree import agree_command
from grasp_bench.cli.arms import arms_app
from grasp_bench.cli.cache import cache_app
from grasp_bench.cli.calibrate import calibrate_command
from grasp_bench.cli.check import check_command
from grasp_bench.cli.data import data_app
from grasp_bench.cli.doctor import doctor_command
from grasp_bench.cli.evaluate import bench_table_command, evaluate_command
from grasp_bench.cli.grippers import grippers_app
from grasp_bench.cli.layout import lay_out
from grasp_bench.cli.leaderboard import leaderboard_app
from grasp_bench.cli.merge import merge_command
from grasp_bench.cli.objects import objects_app
from grasp_bench.cli.predictors import predictors_app, serve_command
from grasp_bench.cli.rank import rank_command
from grasp_bench.cli.replay import replay_command
from grasp_bench.cli.report import report_command
from grasp_bench.cli.run import run_command
from grasp_bench.cli.scenarios import scenarios_app
from grasp_bench.cli.sweep import sweep_command
from grasp_bench.cli.train import train_command
from grasp_bench.cli.why import why_command
from grasp_bench.errors import GraspBenchError
from grasp_bench.system.texts import LONGEST, legible

app = typer.Typer(
    name="grasp-bench",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    help="How often does a grasp predictor really lift the object, on an EC66 arm, seen by a depth "
    "camera?\n\n"
    "Start with [bold]grasp-bench run --objects all --trials 180[/bold], then "
    "[bold]grasp-bench report results/[/bold].",
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"grasp-bench {installed('grasp-bench')}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    """Take the options of the command itself."""


MEASURE, LOOK, TRAIN, SHARE = "Measure", "Look at what was measured", "Train", "Share"
CHOOSE, MACHINE = "What there is to choose from", "This machine"

app.command("run", rich_help_panel=MEASURE)(run_command)
app.command("rank", rich_help_panel=MEASURE)(rank_command)
app.command("agree", rich_help_panel=LOOK)(agree_command)
app.command("sweep", rich_help_panel=MEASURE)(sweep_command)
app.command("bench-table", rich_help_panel=MEASURE)(bench_table_command)
app.command("report", rich_help_panel=LOOK)(report_command)
app.command("why", rich_help_panel=LOOK)(why_command)
app.command("replay", rich_help_panel=LOOK)(replay_command)
app.command("check", rich_help_panel=LOOK)(check_command)
app.command("train", rich_help_panel=TRAIN)(train_command)
app.command("calibrate", rich_help_panel=TRAIN)(calibrate_command)
app.command("evaluate", rich_help_panel=TRAIN)(evaluate_command)
app.command("serve", rich_help_panel=SHARE)(serve_command)
app.command("merge", rich_help_panel=SHARE)(merge_command)
app.command("doctor", rich_help_panel=MACHINE)(doctor_command)
app.add_typer(data_app, name="data", rich_help_panel=TRAIN)
app.add_typer(leaderboard_app, name="leaderboard", rich_help_panel=SHARE)
app.add_typer(predictors_app, name="predictors", rich_help_panel=CHOOSE)
app.add_typer(objects_app, name="objects", rich_help_panel=CHOOSE)
app.add_typer(scenarios_app, name="scenarios", rich_help_panel=CHOOSE)
app.add_typer(grippers_app, name="grippers", rich_help_panel=CHOOSE)
app.add_typer(arms_app, name="arms", rich_help_panel=CHOOSE)
app.add_typer(cache_app, name="cache", rich_help_panel=MACHINE)
lay_out(app)


def main() -> None:
    """Run the command line: one clear line for what is wrong, never a traceback for bad input."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError, ValueError, OSError):  # a notebook's, or one that is closed
            stream.reconfigure(errors="replace")  # pyright: ignore[reportAttributeAccessIssue]
    try:
        app(prog_name="grasp-bench")
    except GraspBenchError as error:
        typer.echo(f"Error: {legible(str(error), LONGEST)}", err=True)
        sys.exit(2)
    except OSError as error:
        if error.strerror is None:
            raise
        where = f"{os.fsdecode(error.filename)}: " if error.filename else ""
        typer.echo(f"Error: {where}{error.strerror}.", err=True)
        sys.exit(2)
    except (KeyboardInterrupt, SystemExit) as end:
        if isinstance(end, SystemExit) and end.code != 130:  # Typer turns Ctrl-C into an exit with 130
            raise
        typer.echo("Stopped. What was measured is kept; the same command goes on from here.", err=True)
        sys.exit(130)
