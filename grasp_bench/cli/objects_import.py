"""``grasp-bench objects import``."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grasp_bench.system.graphics import without_gl

if TYPE_CHECKING:
    from rich.console import Console

    from grasp_bench.workshop.importing.importer import Report


def import_command(
    path: Annotated[Path, typer.Argument(help="An OBJ, STL, PLY, GLB, MJCF or URDF file, or a folder.")],
    units: Annotated[str, typer.Option(help="m, cm, mm or auto.")] = "auto",
    mass: Annotated[float | None, typer.Option(help="Mass of the object [kg].")] = None,
    density: Annotated[float | None, typer.Option(help="Density instead of a mass [kg/m³].")] = None,
    masses: Annotated[Path | None, typer.Option(help="CSV with a line name,mass_kg for each object.")] = None,
    friction: Annotated[float, typer.Option(help="Friction against the finger pads.")] = 0.6,
    name: Annotated[str | None, typer.Option(help="Name of a single object.")] = None,
    category: Annotated[str | None, typer.Option(help="Category; the object's name by default.")] = None,
    source: Annotated[str, typer.Option(help="Where sizes and masses come from.")] = "",
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path("imported-objects"),
    up: Annotated[
        str, typer.Option(help="The files' upward axis: y, z or auto (y for GLB, else z).")
    ] = "auto",
    inertia: Annotated[str, typer.Option(help="How the mass is spread: solid or shell.")] = "solid",
    holes: Annotated[str, typer.Option(help="auto, fill or keep.")] = "auto",
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0 takes one for each core.")] = 0,
    timeout: Annotated[float, typer.Option(min=1, help="Seconds for one object.")] = 1800,
    as_json: Annotated[bool, typer.Option("--json", help="Print what came of each object as JSON.")] = False,
) -> None:
    """Import objects: meshes, scans and robot descriptions, for `grasp-bench run --objects FOLDER`.

    Repairs what can be, and says so; a mesh that cannot be imported fails alone, with its reason
    and exit code 1. The same command again goes on where it stopped. See docs/import.md.
    """
    without_gl()
    from rich.console import Console
    from rich.progress import Progress

    from grasp_bench.workshop.build import write_manifest
    from grasp_bench.workshop.importing.importer import import_all
    from grasp_bench.workshop.importing.jobs import plan_jobs

    jobs = plan_jobs(
        path,
        out,
        name=name,
        masses=masses,
        units=units,
        mass=mass,
        density=density,
        friction=friction,
        category=category,
        source=source,
        up=up,
        inertia=inertia,
        holes=holes,
    )
    console = Console(stderr=as_json)
    reports: list[Report] = []
    with Progress(console=console) as bar:
        task = bar.add_task("Importing", total=len(jobs))
        for report in import_all(jobs, out, workers or os.cpu_count() or 1, timeout):
            reports.append(report)
            bar.update(task, advance=1, description=f"{report.name}: {report.status}"[:60])
            _tell(report, bar.console)
    count = write_manifest(out)
    if as_json:
        told = [
            {
                "name": r.name,
                "status": r.status,
                "why": r.why,
                "notes": r.details.get("import", {}).get("notes", []),
            }
            for r in reports
        ]
        typer.echo(json.dumps(told))
    failed = sum(r.status == "failed" for r in reports)
    console.print(
        f"{len(reports) - failed} of {len(reports)} objects imported; {out} holds {count}. "
        f"Try them: grasp-bench run --objects {out} --predictor oracle",
        soft_wrap=True,
    )
    if failed:
        raise typer.Exit(1)


def _tell(report: Report, console: Console) -> None:
    """Print what came of one object."""
    if report.status == "failed":
        console.print(f"[red]{report.name}: not imported[/red]: {report.why}", soft_wrap=True)
        return
    d = report.details
    size = " × ".join(f"{1000 * x:.0f}" for x in d["extents"])
    console.print(
        f"[bold]{report.name}[/bold]: {report.status}, {size} mm, {1000 * d['mass']:.0f} g, "
        f"{d['hulls']} convex pieces",
        soft_wrap=True,
    )
    for note in d["import"]["notes"]:
        console.print(f"  {note}", soft_wrap=True)
    for pose in d["poses"]:
        if not pose["grasps"]:
            console.print(
                f"  in the resting pose of probability {pose['probability']:.2f}, centre of mass "
                f"{1000 * pose['height']:.0f} mm high, no grasp fits the gripper: not tried",
                soft_wrap=True,
            )
