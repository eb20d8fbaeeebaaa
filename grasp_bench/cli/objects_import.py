"""``grasp-bench objects import``."""

from __future__ import annotations

import json
import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grasp_bench.system.graphics import without_gl

if TYPE_CHECKING:
    from rich.console import Console

    from grasp_bench.workshop.importing.importer import Report


def import_command(
    path: Annotated[Path, typer.Argument(help="An OBJ, STL, PLY, GLB, DAE, MJCF or URDF file, or a folder.")],
    units: Annotated[str, typer.Option(help="The files' unit: m, cm, mm, in (inches) or auto.")] = "auto",
    length: Annotated[
        float | None,
        typer.Option(help="Scale one object to this longest side \\[m]; for meshes without a unit."),
    ] = None,
    scale: Annotated[
        float | None, typer.Option(help="Metres that the files' unit is, such as 0.001; instead of --units.")
    ] = None,
    mass: Annotated[float | None, typer.Option(help="Mass of the object \\[kg].")] = None,
    density: Annotated[float | None, typer.Option(help="Density instead of a mass \\[kg/m³].")] = None,
    masses: Annotated[Path | None, typer.Option(help="CSV with a line name,mass_kg for each object.")] = None,
    friction: Annotated[float, typer.Option(help="Friction against the finger pads.")] = 0.6,
    name: Annotated[str | None, typer.Option(help="Name of a single object.")] = None,
    category: Annotated[str | None, typer.Option(help="Category; the object's name by default.")] = None,
    source: Annotated[str, typer.Option(help="Where sizes and masses come from.")] = "",
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path("imported-objects"),
    up: Annotated[
        str, typer.Option(help="The files' upward axis: y, z or auto (y for GLB, DAE as it says, else z).")
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
    from rich.markup import escape
    from rich.progress import Progress

    from grasp_bench.workshop.build import Listing
    from grasp_bench.workshop.importing.importer import import_all
    from grasp_bench.workshop.importing.jobs import plan_jobs

    plan = plan_jobs(
        path,
        out,
        name=name,
        masses=masses,
        units=units,
        length=length,
        scale=scale,
        mass=mass,
        density=density,
        friction=friction,
        category=category,
        source=source,
        up=up,
        inertia=inertia,
        holes=holes,
    )
    jobs = plan.jobs
    console = Console(stderr=as_json)
    for note in plan.notes:
        console.print(f"[yellow]{escape(note)}[/yellow]", soft_wrap=True, highlight=False)
    reports: list[Report] = []
    listed = Listing(out)
    with Progress(console=console) as bar:
        task = bar.add_task("Importing", total=len(jobs))
        for report in import_all(jobs, out, workers or os.cpu_count() or 1, timeout):
            reports.append(report)
            bar.update(task, advance=1, description=escape(f"{report.name}: {report.status}"[:60]))
            count = listed.write()  # now: a kill leaves what is finished ready to run
            _tell(report, bar.console)
    count = listed.write()
    if as_json:
        told = [
            {
                "name": r.name,
                "status": r.status,
                "why": r.why,
                "graspable": r.graspable,
                "notes": r.details.get("import", {}).get("notes", []),
            }
            for r in reports
        ]
        typer.echo(json.dumps(told))
    failed = sum(r.status == "failed" for r in reports)
    done = f"{len(reports) - failed} of {len(reports)} objects imported; {out} holds {count}."
    ready = listed.graspable
    if ready:
        without = f" ({count - ready} without any grasp are left out)" if ready < count else ""
        done += f" Try them: grasp-bench run --objects {shlex.quote(str(out))} --predictor oracle{without}"
    elif count:
        done += " None can be grasped by this gripper, so there is nothing to run."
    else:
        done += " There is nothing to run: see the reasons above."
    console.print(escape(done), soft_wrap=True, highlight=False)
    if failed:
        raise typer.Exit(1)


def _tell(report: Report, console: Console) -> None:
    """Print what came of one object."""
    from rich.markup import escape

    if report.status == "failed":
        console.print(f"[red]{escape(report.name)}: not imported[/red]: {escape(report.why)}", soft_wrap=True)
        return
    d = report.details
    size = " × ".join(f"{1000 * x:.0f}" for x in d["extents"])
    console.print(
        f"[bold]{escape(report.name)}[/bold]: {report.status}, {size} mm, {1000 * d['mass']:.0f} g, "
        f"{d['hulls']} convex pieces",
        soft_wrap=True,
    )
    if report.replaced:
        console.print(
            f"  replaces the {escape(report.name)} that was imported from {escape(report.replaced)}; "
            "--name keeps both",
            soft_wrap=True,
        )
    for note in d["import"]["notes"]:
        console.print(f"  {escape(note)}", soft_wrap=True)
    if not report.graspable:
        console.print(
            f"  [yellow]no grasp fits the gripper in any of its {len(d['poses'])} resting poses: kept and "
            "marked, left out of runs[/yellow]",
            soft_wrap=True,
        )
        return
    for pose in d["poses"]:
        if not pose["grasps"]:
            console.print(
                f"  in the resting pose of probability {pose['probability']:.2f}, centre of mass "
                f"{1000 * pose['height']:.0f} mm high, no grasp fits the gripper: not tried",
                soft_wrap=True,
            )
