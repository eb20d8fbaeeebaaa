"""``grasp-bench why``: failures of a run explained by doing them again without their causes."""

from __future__ import annotations

import json
import os
import shlex
from pathlib import Path
from typing import Annotated

import typer

from grasp_bench.cli.output import put
from grasp_bench.cli.trust import Trust, ask_for_trust
from grasp_bench.system.machine import THREADS


def why_command(
    run: Annotated[Path, typer.Argument(help="A run's folder.")],
    out: Annotated[
        Path | None, typer.Option(help="File of the replays; RUN/why.jsonl by default. It is what resumes.")
    ] = None,
    page: Annotated[
        Path | None, typer.Option(help="HTML report that examples are linked to; RUN/report.html by default.")
    ] = None,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0 takes one for each core.")] = 0,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print every failure's explanation as JSON.")
    ] = False,
    objects: Annotated[
        Path | None, typer.Option(help="Folder of the objects' catalogue, if not the shipped one.")
    ] = None,
    trust: Trust = False,
) -> None:
    """Say what the failures of RUN are due to.

    Each failed trial is done again as it was, which must come out as recorded, and then without one cause
    after another: perfect depth or colours, exact calibration, the nearest reference grasp's place, angle or
    width, true heights for the planner, more friction, less mass, thin fingers, other help; then without
    two. What saves it is what it was lost to. Takes up to 15 seconds a failure and core.

    The run's records are not touched. The same command again goes on where it stopped.

    Example: grasp-bench why results/gg-cnn2-as-predicted-seed0
    """
    for name in THREADS:  # before NumPy is imported: as in a run's workers
        os.environ.setdefault(name, "1")
    from rich.console import Console

    from grasp_bench.runs.folder import load_run
    from grasp_bench.system.graphics import prepare
    from grasp_bench.system.progress import counting

    info = load_run(run)
    trust = ask_for_trust(info.predictor, run, trust)
    prepare(info.renderer)
    from grasp_bench.studies.why.explain import explain
    from grasp_bench.studies.why.told import Pages, examples, tables, to_json

    pages = Pages(run, page)
    with counting(Console(stderr=True)) as bar:
        task = bar.add_task("Explaining failures", total=None, state="")

        def progress(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)

        study = explain(run, out=out, objects=objects, workers=workers, trust=trust, progress=progress)
    if as_json:
        typer.echo(json.dumps(to_json(study, pages), indent=1, ensure_ascii=False))
    else:
        put(tables(study), {}, "table", None)
        for line in examples(study, pages):
            typer.echo(line)
        if not pages.page.is_file():
            typer.echo(f"That page is not made yet: grasp-bench report {shlex.quote(str(run))} --format html")
