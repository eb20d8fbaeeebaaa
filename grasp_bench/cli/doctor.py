"""``grasp-bench doctor``: check the machine, or whether a finished run repeats on it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from grasp_bench.cli.trust import Trust, ask_for_trust
from grasp_bench.doctor.checks import healthy, show
from grasp_bench.system.graphics import prepare, without_gl


def doctor_command(
    run: Annotated[
        Path | None, typer.Argument(help="A finished run's folder; without it, the environment is checked.")
    ] = None,
    trials: Annotated[
        int, typer.Option(min=1, help="How many trials of RUN are done again, spread evenly over it.")
    ] = 5,
    objects: Annotated[
        Path | None, typer.Option(help="Folder of RUN's objects, where they are not the shipped ones.")
    ] = None,
    physics: Annotated[
        bool, typer.Option("--physics", help="Compare the physics with closed forms; takes about a minute.")
    ] = False,
    full: Annotated[
        bool,
        typer.Option("--full", help="With --physics: the oracle's trials of all objects at two time steps."),
    ] = False,
    gripper: Annotated[
        str | None,
        typer.Option(help="With --physics: test what depends on it with this gripper, by name or path."),
    ] = None,
    trust: Trust = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Check the installation, or do some trials of RUN again and compare them byte for byte.

    Where versions, objects, weights, renderer or processor are not those of RUN, it says so, and what that
    means for its numbers. Of a run of the oracle it says whether it is an upper bound: whether it lifts
    nearly everything, and no run of the same trials beside it lifts more.

    Exit codes: 0 all is well · 1 something is wrong or did not repeat · 2 bad input.

    Example: grasp-bench doctor results/htc-grasp-table4-seed0
    """
    if full and not physics:
        raise typer.BadParameter("--full goes with --physics", param_hint="--full")
    if gripper is not None and not physics:
        raise typer.BadParameter("--gripper goes with --physics", param_hint="--gripper")
    if physics:
        without_gl()
        from grasp_bench.cli.physics import check_physics

        raise typer.Exit(0 if check_physics(full, as_json, gripper) else 1)
    from rich.console import Console

    if run is None:
        without_gl()
        from grasp_bench.doctor.environment import check_environment

        title, checks = "Environment", check_environment()
    else:
        from grasp_bench.runs.folder import load_run

        info = load_run(run)
        trust = ask_for_trust(info.predictor, run, trust)
        prepare(info.renderer)
        from grasp_bench.doctor.bound import check_bound
        from grasp_bench.doctor.rerun import rerun
        from grasp_bench.execution.executors import make_executor

        found = rerun(run, trials, make_executor("process", 1), objects, trust)
        title, checks = f"{run}, then and now", [*found.checks, *check_bound(run)]
    if as_json:
        typer.echo(json.dumps([c.to_json() for c in checks], ensure_ascii=False))
    else:
        show(title, checks, Console())
    if not healthy(checks):
        raise typer.Exit(1)
