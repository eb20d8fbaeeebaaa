"""``grasp-bench check``: the CI gate."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from grasp_bench.errors import GraspBenchError


def check_command(
    new: Annotated[Path, typer.Argument(help="Folder of the new run.")],
    baseline: Annotated[Path, typer.Option(help="Folder of the old run, of the same trials.")],
    margin: Annotated[
        float, typer.Option(help="Drop of the success rate that would matter; 0.03 is three points.")
    ] = 0.03,
    alpha: Annotated[float, typer.Option(help="Level of both tests.")] = 0.05,
    exact: Annotated[
        bool,
        typer.Option(
            "--exact", help="Demand identical records, as a pinned stack on one kind of machine gives."
        ),
    ] = False,
    firmness: Annotated[
        float | None,
        typer.Option(
            help="Of graded runs: gate on the force that breaks the grip instead of the success rate; the "
            "ratio new / old to which a drop would matter, e.g. 0.8."
        ),
    ] = None,
    strict: Annotated[
        bool,
        typer.Option(
            "--strict",
            help="Exit with 1 when inconclusive, too: demand that a drop of the margin is excluded.",
        ),
    ] = False,
    junit: Annotated[Path | None, typer.Option(help="Write JUnit XML to this file.")] = None,
    markdown: Annotated[
        Path | None, typer.Option(help="Append a Markdown summary to this file, e.g. $GITHUB_STEP_SUMMARY.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Compare two runs of the same trials, pair by pair: did the success rate drop?

    [bold]no regression[/bold] (exit 0): a drop of the margin or more is excluded at level alpha, by the lower
    limit of Tango's score interval for paired rates.

    [bold]regression[/bold] (exit 1): not so, and a drop is proven at level alpha, by McNemar's exact
    one-sided test.

    [bold]underpowered[/bold] (exit 3): neither, and with so few trials a drop of the margin would rarely be
    excluded even where nothing changed. It says how many trials would do.

    [bold]inconclusive[/bold] (exit 0; 1 with --strict): neither, though there are trials enough.

    With --firmness 0.8, of runs with the scenario graded: the same verdicts on how firmly objects are held.
    No regression: a drop of the breaking force to 0.8 times is excluded, by bootstrap over objects.
    Regression: a drop is proven, by the signed-rank test.

    With --exact: [bold]identical[/bold] (exit 0) or [bold]different[/bold] (exit 1).

    Exit 2: not comparable, because scenario, objects, seed or trials are not the same, or trials are missing.

    Example: grasp-bench check results/new --baseline results/old
    """
    from grasp_bench.report.firmness_gate import check_firmness
    from grasp_bench.report.gate import Verdict, check
    from grasp_bench.report.gate_text import as_junit, as_markdown, as_text

    if firmness is not None and exact:
        raise GraspBenchError("--exact demands identical records and --firmness compares forces; give one.")
    if firmness is None:
        checked = check(new, baseline, margin, alpha, exact)
    else:
        checked = check_firmness(new, baseline, firmness, alpha)
    for path, mode, content in (
        (junit, "wb", lambda: as_junit(checked)),
        (markdown, "ab", lambda: as_markdown(checked).encode()),
    ):
        if path is not None:
            try:
                with path.open(mode) as file:
                    file.write(content())
            except OSError as error:
                raise GraspBenchError(f"{path} cannot be written ({error.strerror}).") from error
    if as_json:
        typer.echo(json.dumps(checked.to_json(), ensure_ascii=False))
    else:
        typer.echo(as_text(checked), nl=False)
    if checked.failed or (strict and checked.verdict is Verdict.INCONCLUSIVE):
        raise typer.Exit(1)
    if checked.verdict is Verdict.UNDERPOWERED:
        raise typer.Exit(3)
