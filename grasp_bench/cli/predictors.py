"""``grasp-bench predictors`` and ``grasp-bench serve``: list, check and serve predictors."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Annotated, Any

import typer

from grasp_bench.cli.layout import listing
from grasp_bench.system.graphics import without_gl

predictors_app = typer.Typer(help="List predictors, and check whether one keeps to the protocol.")

Name = Annotated[
    str,
    typer.Argument(
        help="A name from `grasp-bench predictors`, my_module:MyPredictor, http://127.0.0.1:PORT or "
        "'cmd: COMMAND --port {port}'."
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print as JSON.")]


@predictors_app.callback(invoke_without_command=True)
def list_predictors(context: typer.Context, as_json: AsJson = False) -> None:
    """List the shipped predictors and controls, and those of installed packages."""
    if context.invoked_subcommand is not None:
        return
    from grasp_bench.predictors.names import installed
    from grasp_bench.predictors.shipped import SHIPPED

    rows: list[dict[str, Any]] = []
    groups: list[str] = []

    def add(name: str, kind: str, summary: str, group: str = "installed packages") -> None:
        rows.append({"name": name, "kind": kind, "summary": summary})
        groups.append(group)

    for name, shipped in SHIPPED.items():
        missing = "" if shipped.available else "; weights not installed"
        add(name, shipped.kind, shipped.summary + missing, shipped.group)
    for name, offers in installed().items():
        for offer in offers:
            hidden = f"; hidden by the shipped {name}, use {offer.path}" if name in SHIPPED else ""
            home = offer.package or "an installed package"
            add(name, offer.kind, f"{offer.path} of {home}{hidden}")
    if as_json:
        for row, shipped in zip(rows, SHIPPED.values(), strict=False):  # those of packages come after
            row |= shipped.details()
        typer.echo(json.dumps(rows))
        return
    from rich.console import Console
    from rich.markup import escape

    head = ("Name", "What it does")
    table = listing(head, head)
    for group in dict.fromkeys(groups):
        table.add_section()
        table.add_row(f"[bold]{escape(group)}[/bold]", "")
        for row, other in zip(rows, groups, strict=True):
            if other == group:
                table.add_row(escape(row["name"]), escape(row["summary"]))
    console = Console()
    console.print(table)
    console.print(
        "Where weights are not installed: `grasp-bench train --predictor NAME --data DIR --out DIR` makes "
        "some, and `run --predictor NAME --weights FILE` uses them."
    )
    console.print(
        escape(
            "Your own: --predictor my_module:MyPredictor, with predict(image) -> list[Grasp]; a server at "
            "http://127.0.0.1:PORT; or a command that starts one, 'cmd: python my_server.py --port {port}'.\n"
            "See docs/predictors.md; `grasp-bench predictors check NAME` says what is wrong with one."
        )
    )


@predictors_app.command("check")
def check_predictor(name: Name, as_json: AsJson = False) -> None:
    """Show a predictor a few canned images, and say what is wrong with its answers.

    Exits with 1 when it breaks the protocol. Remarks do not fail it.
    """
    without_gl()
    from grasp_bench.doctor.conformance import check_named

    rows = check_named(name)
    failed = sum(row.failed for row in rows)
    if as_json:
        images = [
            {
                "image": r.sample,
                "grasps": r.grasps,
                "seconds": round(r.seconds, 4),
                "findings": [asdict(f) for f in r.findings],
            }
            for r in rows
        ]
        typer.echo(json.dumps({"predictor": name, "passed": not failed, "images": images}))
    else:
        from rich.console import Console
        from rich.markup import escape

        head = ("Image", "Grasps", "Time [ms]", "Verdict")
        table = listing(head, ("Image", "Verdict"), escape(name))
        for r in rows:
            colour = "red" if r.failed else "yellow" if r.findings else "green"
            words = "\n".join(f"{f.level}: {f.text}" for f in r.findings) or "sound"
            table.add_row(
                r.sample,
                "–" if r.grasps is None else str(r.grasps),
                f"{1e3 * r.seconds:.0f}",
                f"[{colour}]{escape(words)}[/{colour}]",
            )
        console = Console()
        console.print(table)
        console.print(
            f"{failed} of {len(rows)} images show a break of the protocol; see docs/predictors.md."
            if failed
            else f"All {len(rows)} images were answered as the protocol asks."
        )
    if failed:
        raise typer.Exit(1)


def serve_command(
    name: Annotated[
        str, typer.Argument(help="A name from `grasp-bench predictors`, or my_module:MyPredictor.")
    ],
    host: Annotated[
        str, typer.Option(help="Address to listen at; other machines reach it only when this is changed.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="0 takes any that is free.")] = 8000,
    max_body_mb: Annotated[
        float, typer.Option(min=0.01, help="Largest request in megabytes, packed or unpacked.")
    ] = 128.0,
) -> None:
    """Serve a predictor to `run --predictor http://…`, from another environment or machine.

    Example: grasp-bench serve htc-grasp --port 8000
    """
    without_gl()
    from grasp_bench.predictors.remote import is_loopback
    from grasp_bench.predictors.server import listen, make_app, servable, serve

    predictor, facts = servable(name)
    server = listen(host, port)
    shown = f"[{host}]" if ":" in host else host
    typer.echo(f"Serving {name} at http://{shown}:{server.getsockname()[1]} (Ctrl-C stops it).", err=True)
    if not is_loopback(host):
        typer.echo("Warning: whoever reaches this machine can use it; there is no password.", err=True)
    try:
        serve(make_app(predictor, facts, int(max_body_mb * 2**20)), server)
    except KeyboardInterrupt:  # uvicorn has shut down by then
        raise typer.Exit(0) from None
