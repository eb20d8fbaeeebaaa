"""``grasp-bench rank``: which predictor is better, and when that is known."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from grasp_bench.cli.output import left_out


def rank_command(
    predictors: Annotated[
        list[str], typer.Argument(help="Two or more, as for `grasp-bench run --predictor`; or 'all'.")
    ],
    scenario: Annotated[
        str, typer.Option(help="A scenario's name or file; the default tells most apart.")
    ] = "graded-as-predicted",
    score: Annotated[
        str | None,
        typer.Option(
            help="firmness, success, or difficulty of what is lifted (objects grid); by default firmness "
            "where the scenario measures it."
        ),
    ] = None,
    budget: Annotated[int, typer.Option(min=1, help="Most items, each a trial of all still in doubt.")] = 180,
    alpha: Annotated[
        float, typer.Option(help="Chance at most that any pair is put in a wrong order.")
    ] = 0.05,
    objects: Annotated[str | None, typer.Option(help="As for `grasp-bench run`.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the items and of their trials.")] = 0,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0 takes one for each core.")] = 0,
    physics: Annotated[
        int, typer.Option(min=0, help="Other plausible worlds in which the order is tried as well, e.g. 30.")
    ] = 0,
    physics_trials: Annotated[
        int, typer.Option(min=1, help="Trials of each predictor in each of these worlds.")
    ] = 60,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Folder; by default rankings/SCENARIO-seedN.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Race predictors on the same trials until it is known who is better, or the budget is used up.

    Each item is an object in a place, both drawn at random, and tried by all predictors still in doubt. After
    every item all pairs are tested, by tests that stay valid however often one looks; who is told from all
    others leaves the race. What comes out are [bold]groups[/bold], such as 1 · 2–4 · 5: within one nothing is
    known.

    The same command again goes on, also with a larger budget. Each predictor's trials are an ordinary run
    below OUT for `grasp-bench report`.

    [bold]--physics 30[/bold] asks afterwards whether the order would survive: all predictors try the same
    trials in 30 other worlds, drawn about the scenario (friction, masses, time step, sensor, calibration …).

    Example: grasp-bench rank htc-grasp gr-convnet gg-cnn2 --budget 120
    """
    from rich.console import Console

    from grasp_bench import api
    from grasp_bench.errors import GraspBenchError
    from grasp_bench.predictors.shipped import SHIPPED
    from grasp_bench.report.tables import show
    from grasp_bench.runs.record import TrialRecord
    from grasp_bench.scenario.reading import load_scenario
    from grasp_bench.studies.rank import Contest, rank, score_for
    from grasp_bench.studies.ranking import ranking_table, to_json, unseen_table
    from grasp_bench.studies.worlds import in_worlds, worlds_table
    from grasp_bench.system.graphics import prepare
    from grasp_bench.system.machine import usable_cores
    from grasp_bench.system.progress import counting

    if not 0 < alpha < 0.5:
        raise GraspBenchError(f"--alpha must be between 0 and 0.5, e.g. 0.05, not {alpha:g}.")
    prepare("raycast")
    read = load_scenario(scenario)
    catalog, chosen, without = api.objects_for(read, objects)
    names = [n for n, e in SHIPPED.items() if e.available] if predictors == ["all"] else predictors
    counted = score_for(read, score, catalog, chosen)
    contest = Contest(tuple(names), read, catalog, tuple(chosen), counted, budget, alpha, seed)
    folder = out or Path("rankings") / f"{read.name}-seed{seed}"
    console = Console(quiet=as_json)
    if without:
        console.print(left_out(without), soft_wrap=True)
    with counting(Console(stderr=True, quiet=as_json)) as bar:
        tasks = {}

        def count(name: str, record: TrialRecord, there: bool) -> None:
            if not tasks:  # not before: what is wrong with the inputs is told without any bar
                tasks.update((n, bar.add_task(n, total=budget, state="")) for n in names)
            bar.update(tasks[name], advance=1)

        race = rank(contest, folder, workers or usable_cores(), count)
        worlds = None
        if physics:
            task = bar.add_task("other worlds", total=(physics + 1) * physics_trials * len(names), state="")

            def count_world(name: str, world: int, record: TrialRecord, there: bool) -> None:
                bar.update(task, advance=1, state=f"world {world}")

            worlds = in_worlds(
                contest, physics, physics_trials, folder, workers or usable_cores(), count_world
            )
    if as_json:
        told = to_json(race, counted.what) | ({"worlds": worlds.to_json()} if worlds else {})
        typer.echo(json.dumps(told, ensure_ascii=False))
        return
    unseen = unseen_table(race)
    show([ranking_table(race, counted.what), *([unseen] if unseen else [])], console)
    if worlds:
        show([worlds_table(worlds)], console)
    console.print(f"Trials are in {folder}; see `grasp-bench report {folder}`.", soft_wrap=True, markup=False)
