"""``grasp-bench agree``: does the order in physics hold on real images?"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer


def agree_command(
    runs: Annotated[Path, typer.Argument(help="Folder of runs, one a predictor, all of one scenario.")],
    evaluations: Annotated[
        Path, typer.Option("--evaluations", help="Folder of results of `grasp-bench evaluate --out`.")
    ],
    dataset: Annotated[str, typer.Option(help="cornell or jacquard.")] = "cornell",
    protocol: Annotated[str, typer.Option(help="strict or legacy.")] = "strict",
    out: Annotated[Path | None, typer.Option("--out", "-o", help="SVG to draw.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Compare success in physics with accuracy on real images, over predictors.

    Prints Pearson's correlation and the mean maximum rank violation (SIMPLER's measures) with intervals.
    Results of networks that were trained for a fold of the images are left out.

    Example: grasp-bench agree results/reference --evaluations results/evaluation --out agreement.svg
    """
    from rich.console import Console

    from grasp_bench.errors import UnknownNameError
    from grasp_bench.report.agreement import agreement, agreement_table
    from grasp_bench.report.agreement_chart import as_svg
    from grasp_bench.report.tables import show
    from grasp_bench.runs.folder import find_runs
    from grasp_bench.runs.results import RunResults
    from grasp_bench.studies.bench_table import read_evaluations
    from grasp_bench.system.integrity import write_whole

    valid = {"data set": (dataset, ("cornell", "jacquard")), "protocol": (protocol, ("strict", "legacy"))}
    for what, (given, names) in valid.items():
        if given not in names:
            raise UnknownNameError(what, given, names)
    wanted = [
        e
        for e in read_evaluations(evaluations)
        if e.dataset == dataset and e.protocol == protocol and not e.trained
    ]
    found = agreement([RunResults(folder) for folder in find_runs(runs)], wanted)
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_whole(out, as_svg(found).encode())
    if as_json:
        typer.echo(json.dumps(found.to_json(), ensure_ascii=False))
        return
    show([agreement_table(found)], Console())
    if out is not None:
        typer.echo(f"Drawn: {out}")
