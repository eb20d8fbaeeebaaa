"""The command line. Commands are thin: parse, call, print; heavy imports wait until needed.

Exit codes: 0 success · 1 the run finished, but with more harness errors than allowed ·
2 bad input, nothing was measured or lost · 130 interrupted; the same command goes on.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grasp_bench import completion
from grasp_bench.errors import GraspBenchError

if TYPE_CHECKING:
    from rich.console import Console

app = typer.Typer(
    name="grasp-bench", no_args_is_help=True, rich_markup_mode="rich", pretty_exceptions_enable=False,
    help="How often does a grasp predictor really lift the object, on an EC66 arm, seen by a depth "
         "camera?\n\n"
         "Start with [bold]grasp-bench run --objects all --trials 180[/bold], then "
         "[bold]grasp-bench report results/[/bold].")


def _print_version(wanted: bool) -> None:
    if wanted:
        from grasp_bench import __version__

        typer.echo(f"grasp-bench {__version__}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[bool, typer.Option(
        "--version", callback=_print_version, is_eager=True, help="Print the version and exit.")] = False,
) -> None:
    """Options of the command itself."""


def _console(quiet: bool = False) -> Console:
    from rich.console import Console

    return Console(quiet=quiet)


@app.command()
def run(
    objects: Annotated[str | None, typer.Option(
        autocompletion=completion.objects,
        help="all, object names, categories (comma-separated), or a folder with a manifest.json; by default "
             "the scenario's objects, which are all unless it names some.")] = None,
    trials: Annotated[int, typer.Option(
        min=1, help="How many trials, spread evenly over the objects; of clutter, how many episodes.")] = 180,
    predictor: Annotated[str, typer.Option(
        autocompletion=completion.predictors,
        help="A name from `grasp-bench predictors`, my_module:MyPredictor, http://127.0.0.1:PORT, or "
             "'cmd: python my_server.py --port {port}'.")] = "htc-grasp",
    scenario: Annotated[str, typer.Option(
        autocompletion=completion.scenarios,
        help="A shipped scenario, or the path of a YAML file.")] = "table4",
    seed: Annotated[int, typer.Option(min=0, help="Seed of all that is random.")] = 0,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0 takes one for each core.")] = 0,
    out: Annotated[Path | None, typer.Option(
        help="Results folder; by default results/PREDICTOR-SCENARIO-seedN.")] = None,
    renderer: Annotated[str, typer.Option(
        help="auto, raycast (needs no graphics library), egl or osmesa.")] = "auto",
    max_errors: Annotated[str, typer.Option(
        help="Exit with 1 when more trials than this end unstable, timeout or error: a number, or a share "
             "such as 2%.")] = "0",
    media: Annotated[str, typer.Option(
        help="Pictures of all trials (in clutter: attempts), and clips of: none (no pictures either), "
             "failures or all.")] = "none",
    rerun: Annotated[Path | None, typer.Option(
        help="Log all trials into a Rerun recording, FILE.rrd (extra `rerun`).")] = None,
    shard: Annotated[str, typer.Option(
        help="i/N: do only every N-th trial, from the i-th on; `grasp-bench merge` joins the N folders.",
    )] = "1/1",
    executor: Annotated[str, typer.Option(help="process (this machine) or ray.")] = "process",
    ray_address: Annotated[str | None, typer.Option(
        help="A running Ray cluster, auto or HOST:PORT; without it, --executor ray starts Ray here.")] = None,
    memory_limit: Annotated[float | None, typer.Option(
        min=0.1, help="GiB a worker may take before its trial is an error; by default its share of 80 % of "
                      "the machine's memory.")] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the run's figures as JSON.")] = False,
) -> None:
    """Try to pick up objects, and record every trial. The same command again resumes.

    Example: grasp-bench run --objects mug,pliers --trials 20 --predictor oracle
    """
    from grasp_bench import api
    from grasp_bench.interrupts import terminate_as_interrupt
    from grasp_bench.jobs import Shard, spread
    from grasp_bench.limits import ErrorLimit
    from grasp_bench.progress import Progress

    console = _console(quiet or as_json)
    allowed = ErrorLimit.parse(max_errors)
    with terminate_as_interrupt(), Progress(len(spread(["any"], trials, Shard.parse(shard))), console) as bar:
        done = api.run(objects, trials, predictor, scenario, seed=seed, workers=workers, out=out,
                       renderer=renderer, media=media, rerun=rerun, progress=bar.update, shard=shard,
                       executor=executor, ray_address=ray_address, memory_limit=memory_limit)
    folder, summary, figures = done.folder, done.summary, done.figures
    if summary.repaired:
        console.print("[yellow]A torn last line, left by a kill, was cut off; "
                      "that trial was done again.[/yellow]")
    if summary.added == 0:
        console.print(f"{folder} is finished already: nothing was left to do.")
    elif summary.resumed:
        console.print(f"Resumed {folder}: {summary.resumed} trials were done, {summary.added} added.")
    if as_json:
        typer.echo(json.dumps(figures))
    if figures["clutter"] is not None:
        from grasp_bench.report.clutter import in_words

        said = f": {in_words(figures['clutter'])}"
    else:
        low, high = figures["wilson95"]
        said = (f" lifted {figures['successes']}/{figures['trials']} = {figures['rate']:.1%} "
                f"(95 % interval {low:.1%} – {high:.1%})")
    console.print(f"[bold]{predictor}[/bold]{said}. "
                  f"Results in {folder}; see `grasp-bench report {folder}`.", soft_wrap=True)
    if rerun is not None:
        console.print(f"{rerun}: {rerun.stat().st_size / 1e6:.1f} MB; open it with `rerun {rerun}`."
                      if rerun.is_file() else "No trial was done now, so there is nothing for Rerun; "
                      "`grasp-bench replay` logs trials of a finished run.", soft_wrap=True)
    if media != "none":
        from grasp_bench.media.cost import describe_cost

        console.print(describe_cost(folder), soft_wrap=True)
    if allowed.exceeded(done.faults, len(done)):
        typer.echo(f"{done.faults} trials ended unstable, in a timeout or an error (allowed: {allowed}); "
                   f"see `detail` in {folder / 'trials.jsonl'}.", err=True)
        raise typer.Exit(1)


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(
        help="A run's folder, or one that holds several.")] = Path("results"),
    fmt: Annotated[str, typer.Option("--format", help="table, markdown, json or html.")] = "table",
    out: Annotated[Path | None, typer.Option(
        help="Write to this file instead of the terminal; html: FOLDER/report.html by default.")] = None,
    render: Annotated[str, typer.Option(
        help="html: make missing pictures and clips by doing trials again: none, failures or all.")] = "none",
    max_mb: Annotated[float, typer.Option(
        min=3, help="html: leave out pictures that would make the file larger; failures come first.")] = 15,
    objects: Annotated[Path | None, typer.Option(
        help="html: folder of the objects' catalogue, if not the shipped one.")] = None,
) -> None:
    """Print Table 4 of the paper with the runs of FOLDER beside it, and how their trials ended."""
    from grasp_bench.errors import UnknownNameError
    from grasp_bench.report.table4 import build_report
    from grasp_bench.results import find_runs

    formats = ("table", "markdown", "json", "html")
    if fmt not in formats:
        raise UnknownNameError("report format", fmt, formats)
    if fmt == "html":
        from grasp_bench.report.html.cli import render_missing
        from grasp_bench.report.html.page import describe, write_html

        render_missing(find_runs(folder), render, objects)
        written = write_html(find_runs(folder), out or folder / "report.html", folder, objects,
                             round(1_000_000 * max_mb))
        typer.echo(describe(written))
        return
    content = build_report(find_runs(folder), folder)
    if fmt == "table" and out is None:
        from grasp_bench.report.text import show

        show(content, _console())
        return
    if fmt == "json":
        text = json.dumps(content, indent=1, ensure_ascii=False) + "\n"
    elif fmt == "markdown":
        from grasp_bench.report.text import as_markdown

        text = as_markdown(content)
    else:
        from rich.console import Console

        from grasp_bench.report.text import show

        console = Console(record=True, width=120, quiet=True)
        console.quiet = False
        with console.capture() as capture:
            show(content, console)
        text = capture.get()
    if out is None:
        typer.echo(text, nl=False)
    else:
        try:
            out.write_text(text, encoding="utf-8")
        except OSError as error:
            raise GraspBenchError(f"{out} cannot be written ({error.strerror}).") from error


def _register() -> None:
    from grasp_bench.datasets.cli import export_command, info_command, show_command, synth_command
    from grasp_bench.doctor.cli import doctor_command
    from grasp_bench.evaluation.cli import bench_table_command, evaluate_command
    from grasp_bench.gate.cli import check_command
    from grasp_bench.leaderboard.cli import leaderboard_app
    from grasp_bench.objects.cli import objects_app
    from grasp_bench.predictors.cli import predictors_app, serve_command
    from grasp_bench.replay.cli import replay_command
    from grasp_bench.scenarios_cli import scenarios_app
    from grasp_bench.shards.cli import merge_command
    from grasp_bench.sweeps.cli import sweep_command
    from grasp_bench.training.cli import train_command

    app.add_typer(objects_app, name="objects")
    app.add_typer(scenarios_app, name="scenarios")
    app.add_typer(leaderboard_app, name="leaderboard")
    app.add_typer(predictors_app, name="predictors")
    app.command("serve")(serve_command)
    data = typer.Typer(no_args_is_help=True, help="Make training data, and look at it.")
    data.command("synth")(synth_command)
    data.command("show")(show_command)
    data.command("export")(export_command)
    data.command("info")(info_command)
    app.add_typer(data, name="data")
    app.command("sweep")(sweep_command)
    app.command("train")(train_command)
    app.command("evaluate")(evaluate_command)
    app.command("bench-table")(bench_table_command)
    app.command("replay")(replay_command)
    app.command("doctor")(doctor_command)
    app.command("merge")(merge_command)
    app.command("check")(check_command)


_register()


def main() -> None:
    """Entry point: one clear line for what is wrong, never a traceback for bad input."""
    try:
        app(prog_name="grasp-bench")
    except GraspBenchError as error:
        typer.echo(f"Error: {error}", err=True)
        sys.exit(2)
    except (KeyboardInterrupt, SystemExit) as end:
        if isinstance(end, SystemExit) and end.code != 130:  # Typer turns Ctrl-C into an exit with 130
            raise
        typer.echo("Stopped. What was measured is kept; the same command goes on from here.", err=True)
        sys.exit(130)


if __name__ == "__main__":
    main()
