"""``grasp-bench doctor --physics``."""

from __future__ import annotations

import json
import os

import typer


def check_physics(full: bool, as_json: bool, gripper: str | None = None) -> bool:
    """Run the self-tests, print them as a table or JSON, and return whether all passed.

    ``full`` adds the oracle's trials of all objects, twice; with a ``gripper`` only what depends on it is
    tested.
    """
    from rich.console import Console
    from rich.progress import MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from grasp_bench.doctor.physics.suite import QUICK, judged, table, tests_of, trials
    from grasp_bench.objects.catalog import Catalog
    from grasp_bench.objects.fitted import graspable
    from grasp_bench.scenario.reading import load_scenario
    from grasp_bench.scenario.robots import with_gripper

    scenario, tests = load_scenario("table4"), QUICK
    names = Catalog().names
    if gripper is not None:
        scenario = with_gripper(scenario, gripper)
        tests = tests_of(scenario.robot.loaded.gripper)
        if full:
            names, _ = graspable(Catalog(), names, scenario.robot.loaded.gripper)
    checks = []
    bar = Progress(
        TextColumn("{task.description}"),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    with bar:
        task = bar.add_task("Self-tests", total=len(tests))
        for test in tests:
            bar.update(task, description=test.__name__.capitalize())
            checks += test(scenario)
            bar.advance(task)
        if full:
            task = bar.add_task("Trials of the oracle", total=2 * len(names))
            checks += judged(trials(scenario, os.cpu_count() or 1, names, progress=lambda: bar.advance(task)))
    if as_json:
        typer.echo(json.dumps([c.to_json() for c in checks], ensure_ascii=False))
    else:
        Console().print(table(checks))
    return all(c.passed for c in checks)
