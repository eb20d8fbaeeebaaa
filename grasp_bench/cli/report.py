"""``grasp-bench report``: the runs of a folder as tables, JSON or a page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grasp_bench.cli.output import put
from grasp_bench.cli.trust import Trust, ask_for_trust
from grasp_bench.errors import UnknownNameError


def report_command(
    folder: Annotated[Path, typer.Argument(help="A run's folder, or one that holds several.")] = Path(
        "results"
    ),
    fmt: Annotated[str, typer.Option("--format", help="table, markdown, json or html.")] = "table",
    out: Annotated[
        Path | None,
        typer.Option(help="Write to this file instead of the terminal; html: FOLDER/report.html by default."),
    ] = None,
    render: Annotated[
        str,
        typer.Option(
            help="html: make missing pictures and clips by doing trials again: none, failures or all."
        ),
    ] = "none",
    max_mb: Annotated[
        float,
        typer.Option(
            min=3, help="html: leave out pictures that would make the file larger; failures come first."
        ),
    ] = 15,
    everything: Annotated[
        bool, typer.Option("--all", help="table: all runs, and how the trials of each ended.")
    ] = False,
    objects: Annotated[
        Path | None, typer.Option(help="html: folder of the objects' catalogue, if not the shipped one.")
    ] = None,
    trust: Trust = False,
) -> None:
    """Print the run made last in FOLDER beside others of its scenario and the paper's Table 4.

    Baselines, other seeds and other scenarios take a line each. Further formats tell all of every run.

    Example: grasp-bench report results/ --format html
    """
    from grasp_bench.report.table4 import build_report
    from grasp_bench.runs.folder import find_runs

    formats = ("table", "markdown", "json", "html")
    if fmt not in formats:
        raise UnknownNameError("report format", fmt, formats)
    if fmt == "html":
        from grasp_bench.replay.missing import render_missing
        from grasp_bench.report.html.page import describe, write_html

        render_missing(
            find_runs(folder), render, objects, lambda name, where: ask_for_trust(name, where, trust)
        )
        written = write_html(
            find_runs(folder), out or folder / "report.html", folder, objects, round(1_000_000 * max_mb)
        )
        typer.echo(describe(written))
        return
    if fmt == "table" and not everything:
        from grasp_bench.report.screen import screen

        put(screen(find_runs(folder), folder), {}, fmt, out)
        return
    content = build_report(find_runs(folder), folder)
    put(content.tables(), content.to_json(), fmt, out)
