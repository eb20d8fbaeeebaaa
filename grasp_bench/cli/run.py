"""``grasp-bench run``: try to pick up objects, and record every trial."""

from __future__ import annotations

import json
import os
import signal
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from grasp_bench.cli import completion
from grasp_bench.cli.output import left_out
from grasp_bench.runs.limits import MOST_TRIALS, ErrorLimit
from grasp_bench.system.interrupts import told_apart
from grasp_bench.system.machine import usable_cores
from grasp_bench.system.progress import Progress


def run_command(
    objects: Annotated[
        str | None,
        typer.Option(
            autocompletion=completion.objects,
            help="all, object names, categories or grid (comma-separated), or a folder with a manifest.json; "
            "by default the scenario's objects, which are all unless it names some.",
        ),
    ] = None,
    trials: Annotated[
        int,
        typer.Option(
            min=1,
            max=MOST_TRIALS,
            help="How many trials, spread evenly over the objects; of clutter, how many episodes.",
        ),
    ] = 180,
    predictor: Annotated[
        str | None,
        typer.Option(
            autocompletion=completion.predictors,
            show_default="htc-grasp",
            help="A name from `grasp-bench predictors`, my_module:MyPredictor, http://127.0.0.1:PORT, or "
            "'cmd: python my_server.py --port {port}'.",
        ),
    ] = None,
    weights: Annotated[
        Path | None,
        typer.Option(
            help="Weights that `train` wrote, instead of shipped ones; they say of which network they are."
        ),
    ] = None,
    scenario: Annotated[
        str,
        typer.Option(
            autocompletion=completion.scenarios, help="A shipped scenario, or the path of a YAML file."
        ),
    ] = "table4",
    seed: Annotated[int, typer.Option(min=0, help="Seed of all that is random.")] = 0,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0 takes one for each core.")] = 0,
    out: Annotated[
        Path | None, typer.Option(help="Results folder; by default PREDICTOR-SCENARIO-seedN in results/.")
    ] = None,
    renderer: Annotated[
        str, typer.Option(help="auto, raycast (needs no graphics library), egl or osmesa.")
    ] = "auto",
    max_errors: Annotated[
        str,
        typer.Option(
            help="Exit with 1 when more trials than this end unstable, timeout or error: a number, or a "
            "share such as 2%."
        ),
    ] = "0",
    media: Annotated[
        str,
        typer.Option(
            help="Pictures of all trials (in clutter: attempts), and clips of: none (no pictures either), "
            "failures or all."
        ),
    ] = "none",
    rerun: Annotated[
        Path | None, typer.Option(help="Log all trials into a Rerun recording, FILE.rrd (extra `rerun`).")
    ] = None,
    shard: Annotated[
        str,
        typer.Option(
            help="i/N: do only every N-th trial, from the i-th on; `grasp-bench merge` joins the N folders."
        ),
    ] = "1/1",
    executor: Annotated[str, typer.Option(help="process (this machine) or ray.")] = "process",
    ray_address: Annotated[
        str | None,
        typer.Option(
            help="A running Ray cluster, auto or HOST:PORT; without it, --executor ray starts Ray here."
        ),
    ] = None,
    memory_limit: Annotated[
        float | None,
        typer.Option(
            min=0.1,
            help="GiB a worker may take before its trial is an error; by default its share of 80 % of "
            "the machine's memory.",
        ),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the run's figures as JSON.")] = False,
) -> None:
    """Try to pick up objects, and record every trial. The same command again resumes.

    Example: grasp-bench run --objects mug,pliers --trials 20 --predictor oracle
    """
    from grasp_bench.execution.crew import early_crew

    if weights is not None:
        from grasp_bench.predictors.names import with_weights

        predictor = str(weights) if predictor is None else with_weights(predictor, weights)
    predictor = predictor or "htc-grasp"
    asked, most = workers, max(2, usable_cores())
    if executor == "process":
        workers = min(workers, most)
    early = executor == "process"
    with early_crew((predictor,), workers, trials, renderer) if early else nullcontext():
        from rich.console import Console
        from rich.markup import escape

        from grasp_bench import api
        from grasp_bench.objects.catalog import Catalog
        from grasp_bench.objects.fitted import is_reference
        from grasp_bench.report.clutter import in_words
        from grasp_bench.report.ending import ending
        from grasp_bench.report.summary import Summary
        from grasp_bench.runs.jobs import Shard, spread
        from grasp_bench.scenario.reading import load_scenario
        from grasp_bench.system import cache

        console = Console(quiet=quiet or as_json)
        if workers < asked:
            console.print(f"{asked} workers would only wait for each other here; {workers} are used.")
        of_the_cache = cache.first_use()
        allowed = ErrorLimit.parse(max_errors)
        if objects is not None and objects != "all" and os.path.isdir(objects):
            catalog = Catalog(Path(objects))
            reference = is_reference(load_scenario(scenario).robot.loaded.gripper)
            if reference and (without := catalog.ungraspable(catalog.names)):
                console.print(
                    f"Left out, since no grasp fits the gripper in any resting pose: {', '.join(without)}.",
                    soft_wrap=True,
                    markup=False,
                )
        total = len(spread(["any"], trials, Shard.parse(shard)))
        with told_apart(signal.SIGINT, signal.SIGTERM), Progress(total, console) as bar:
            done = api.run(
                objects,
                trials,
                predictor,
                scenario,
                seed=seed,
                workers=workers,
                out=out,
                renderer=renderer,
                media=media,
                rerun=rerun,
                progress=bar.update,
                shard=shard,
                executor=executor,
                ray_address=ray_address,
                memory_limit=memory_limit,
            )
    folder, summary, told = done.folder, done.summary, Summary.of(done)
    if summary.repaired:
        console.print(
            "[yellow]A torn last line, left by a kill, was cut off; that trial was done again.[/yellow]"
        )
    if summary.added == 0:
        console.print(f"{folder} is finished already: nothing was left to do.", markup=False)
    elif summary.resumed:
        told_of = f"Resumed {folder}: {summary.resumed} trials were done, {summary.added} added."
        console.print(told_of, markup=False)
    if done.left_out:
        console.print(left_out(done.left_out), soft_wrap=True)
    if as_json:
        typer.echo(json.dumps(told.to_json()))
    said = f" lifted {told.lifted}" if told.clutter is None else f": {in_words(told.clutter)}"
    console.print(
        f"[bold]{escape(done.predictor)}[/bold]{said}. Results in {escape(str(folder))}; "
        f"see `grasp-bench report {escape(str(folder))}`.",
        soft_wrap=True,
    )
    for line in ending(done):
        console.print(escape(line), soft_wrap=True, highlight=False)
    if of_the_cache is not None:
        console.print(of_the_cache, soft_wrap=True, markup=False, highlight=False)
    if rerun is not None:
        console.print(
            f"{rerun}: {rerun.stat().st_size / 1e6:.1f} MB; open it with `rerun {rerun}`."
            if rerun.is_file()
            else "No trial was done now, so there is nothing for Rerun; "
            "`grasp-bench replay` logs trials of a finished run.",
            soft_wrap=True,
            markup=False,
        )
    if media != "none":
        from grasp_bench.media.cost import describe_cost

        console.print(describe_cost(folder), soft_wrap=True, markup=False)
    if allowed.exceeded(done.faults, len(done)):
        typer.echo(
            f"{done.faults} trials ended unstable, in a timeout or an error (allowed: {allowed}); "
            f"see `detail` in {folder / 'trials.jsonl'}.",
            err=True,
        )
        raise typer.Exit(1)
