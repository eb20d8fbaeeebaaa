"""``grasp-bench sweep``: success against any parameter of a scenario."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from grasp_bench.studies.sweep import Sweep


def sweep_command(
    parameter: Annotated[
        str,
        typer.Option(
            help="Dotted name of a scenario's value, e.g. gripper.force; see `grasp-bench scenarios show`."
        ),
    ],
    values: Annotated[str, typer.Option(help="Comma-separated, e.g. 0,0.001,0.002.")],
    predictor: Annotated[str, typer.Option(help="One or several, comma-separated.")] = "htc-grasp",
    objects: Annotated[str | None, typer.Option(help="As for `grasp-bench run`.")] = None,
    trials: Annotated[
        int | None, typer.Option(min=1, help="Trials for each value; by default every object once.")
    ] = None,
    scenario: Annotated[str, typer.Option(help="Scenario that all other values come from.")] = "table4",
    seed: Annotated[int, typer.Option(min=0, help="Seed of all that is random.")] = 0,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0 takes one for each core.")] = 0,
    out: Annotated[
        Path | None, typer.Option(help="Folder; by default sweeps/SCENARIO-seedN, shared by all parameters.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Run several values of one scenario parameter, and plot success with intervals against it.

    Every value sees the same objects in the same places. The same command again resumes.

    Example: grasp-bench sweep --parameter gripper.force --values 20,40,60,120 --predictor oracle,htc-grasp
    """
    from rich.console import Console

    from grasp_bench.scenario.reading import load_scenario
    from grasp_bench.studies.sweep import read_values, sweep
    from grasp_bench.studies.sweep_chart import save

    base = load_scenario(scenario)
    folder = out or Path("sweeps") / f"{base.name}-seed{seed}"
    console = Console(quiet=as_json)
    with console.status("Starting …") as status:
        names = [p.strip() for p in predictor.split(",") if p.strip()]
        done = sweep(
            parameter,
            read_values(values),
            base,
            folder,
            predictors=names,
            objects=objects,
            trials=trials,
            seed=seed,
            workers=workers or None,
            progress=lambda words, record, _: status.update(f"{words}: trial {record.trial}"),
        )
    written = save(done, folder)
    if as_json:
        typer.echo(done.as_json(), nl=False)
        return
    console.print(as_table(done))
    told = f"Figures: {', '.join(p.name for p in written)} in {folder}."
    console.print(told, soft_wrap=True, markup=False)


def as_table(done: Sweep) -> Table:
    """Return the points as a table for the terminal."""
    from rich.markup import escape
    from rich.table import Table

    from grasp_bench.studies.sweep_chart import words

    table = Table(
        title=escape(f"{done.parameter} on {done.scenario}, seed {done.seed}"),
        title_style="bold",
        header_style="bold",
    )
    for name in ("Predictor", "Value", "Lifted", "Rate", "95 % interval", "−/+", "p"):
        table.add_column(name, justify="left" if name == "Predictor" else "right", no_wrap=True)
    for p in done.points:
        own = words(p.value) == words(done.own)
        paired = ("", "") if own or p.p is None else (f"{p.lost}/{p.gained}", f"{p.p:.2g}")
        table.add_row(
            escape(p.predictor),
            escape(words(p.value) + (" (own)" if own else "")),
            f"{p.successes}/{p.trials}",
            f"{p.rate:.1%}",
            f"{p.low:.1%} – {p.high:.1%}",
            *paired,
        )
    if any(p.p is not None for p in done.points):
        table.caption = (
            "−/+: trials lost and gained against the scenario's own value; p: two-sided exact McNemar test"
        )
    return table
