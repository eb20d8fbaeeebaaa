"""``grasp-bench objects``: list, show, verify, picture, build and import objects."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Annotated, Any

import typer

from grasp_bench.cli.layout import listing
from grasp_bench.cli.objects_grasps import grasps_command
from grasp_bench.cli.objects_import import import_command
from grasp_bench.errors import AssetError, UnknownNameError
from grasp_bench.system.files import prepare_picture
from grasp_bench.system.graphics import with_gl, without_gl

objects_app = typer.Typer(no_args_is_help=True, help="List, show, verify, picture, build and import objects.")
objects_app.command("import")(import_command)
objects_app.command("grasps")(grasps_command)

Folder = Annotated[
    Path | None, typer.Option("--folder", help="A folder of objects; the shipped 180 by default.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print as JSON.")]


@objects_app.command("list")
def list_objects(
    what: Annotated[str, typer.Argument(help="all, names or categories, comma-separated.")] = "all",
    folder: Folder = None,
    as_json: AsJson = False,
) -> None:
    """List objects with category (where it is not the name), mass, size and number of convex pieces."""
    from grasp_bench.objects.catalog import Catalog

    catalog = Catalog(folder)
    entries = [catalog.entries[n] for n in catalog.select(what)]
    if as_json:
        typer.echo(json.dumps(entries))
        return
    from rich.console import Console
    from rich.markup import escape

    kinds = len({e["category"] for e in entries})
    title = (
        f"{len(entries)} object{'s' * (len(entries) != 1)} in {kinds} categor{'y' if kinds == 1 else 'ies'}"
    )
    table = listing(("Name", "Category", "Mass [g]", "Size [mm]", "Hulls"), ("Name", "Category"), title)
    for e in entries:
        size = " × ".join(f"{1000 * x:.0f}" for x in e["extents"])
        table.add_row(
            escape(e["name"]),
            "" if e["category"] == e["name"] else escape(e["category"]),
            f"{1000 * e['mass']:.0f}",
            size,
            str(e["hulls"]),
        )
    Console().print(table)


@objects_app.command()
def show(
    name: Annotated[str, typer.Argument(help="An object's name.")],
    folder: Folder = None,
    as_json: AsJson = False,
    picture: Annotated[Path | None, typer.Option(help="Write a picture (PNG) to this file.")] = None,
) -> None:
    """Show all that is known of one object."""
    if picture is not None:
        prepare_picture(picture)
        with_gl()
    from grasp_bench.objects.catalog import Catalog
    from grasp_bench.objects.difficulty import difficulty_of

    catalog = Catalog(folder)
    model = catalog.load(name)
    entry: dict[str, Any] = catalog.entries[name] | {
        "poses": [
            {"probability": p.probability, "height": p.height, "grasps": len(p.grasps)} for p in model.poses
        ]
    }
    if picture is not None:
        from grasp_bench.workshop.pictures import object_picture

        object_picture(model).save(picture)
    if as_json:
        typer.echo(json.dumps(entry))
        return
    from rich.console import Console
    from rich.markup import escape

    console = Console()
    console.print(
        f"[bold]{escape(name)}[/bold] ({escape(entry['category'])}): {1000 * entry['mass']:.0f} g, "
        f"{escape(entry['material'])}, friction {entry['friction']:g} against the pads"
    )
    size, off = " × ".join(f"{1000 * x:.1f}" for x in entry["extents"]), entry["decomposition"]
    console.print(
        f"Size {size} mm; {entry['faces']} faces, "
        f"{entry['hulls']} convex pieces, volume {off['volume_ratio']:.3f} of the mesh's, "
        f"surface at most {1000 * off['max_distance']:.1f} mm off"
    )
    console.print(f"Source: {entry['source']}", markup=False)
    if told := difficulty_of(entry):
        console.print(
            f"Difficulty {told.failing:.0%}: with gripper {told.gripper}, {told.tried - told.held} of "
            f"{told.tried} random antipodal tries failed"
        )
    for pose in model.poses:
        console.print(
            f"Rests with probability {pose.probability:.2f}, centre of mass "
            f"{1000 * pose.height:.0f} mm high: {len(pose.grasps)} reference grasps"
        )


@objects_app.command()
def verify(folder: Folder = None) -> None:
    """Check every file against the manifest's SHA-256, and that every mesh loads."""
    from grasp_bench.objects.catalog import Catalog

    catalog = Catalog(folder)
    bad = []
    for name in catalog.entries:
        try:
            model = catalog.load(name)
            if not (model.visual and model.hulls):
                bad.append(f"{name}: a mesh is empty")
        except AssetError as error:
            bad.append(f"{name}: {error}")
    for line in bad:
        typer.echo(line, err=True)
    typer.echo(
        f"{len(catalog.entries) - len(bad)} of {len(catalog.entries)} objects are as the manifest says."
    )
    if bad:
        raise typer.Exit(2)


@objects_app.command()
def sheet(
    out: Annotated[Path, typer.Argument(help="PNG file to write.")],
    what: Annotated[str, typer.Option(help="all, names or categories.")] = "all",
    columns: Annotated[int, typer.Option(min=1)] = 12,
    folder: Folder = None,
    names: Annotated[bool, typer.Option(help="Write names under the pictures.")] = True,
) -> None:
    """Render a contact sheet of objects."""
    prepare_picture(out)
    with_gl()
    from grasp_bench.objects.catalog import Catalog
    from grasp_bench.workshop.pictures import contact_sheet

    catalog = Catalog(folder)
    contact_sheet([catalog.load(n) for n in catalog.select(what)], columns, names).save(out)


@objects_app.command()
def build(
    out: Annotated[Path, typer.Option(help="Target folder.")] = Path("assets/objects"),
    only: Annotated[str | None, typer.Option(help="Names or families, e.g. grid, comma-separated.")] = None,
    stage: Annotated[str, typer.Option(help="shape, rest or all.")] = "all",
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0 takes one for each core.")] = 0,
) -> None:
    """Build objects from code: meshes, convex pieces, resting poses, reference grasps, manifest.

    Takes minutes to hours; objects that have not changed are skipped, a killed build goes on.
    """
    without_gl()
    from grasp_bench.workshop.build import build_all, known, write_manifest

    if stage not in ("shape", "rest", "all"):
        raise UnknownNameError("stage", stage, ("shape", "rest", "all"))
    specs = known()
    wanted = list(specs) if only is None else [n.strip() for n in only.split(",")]
    names = [n for word in wanted for n, s in specs.items() if word in (n, s.family)]
    for word in wanted:
        if not any(word in (n, s.family) for n, s in specs.items()):
            raise UnknownNameError("object", word, specs)
    from rich.progress import Progress

    failed = []
    with Progress() as bar:
        task = bar.add_task("Building", total=len(names))
        for name, outcome in build_all(out, names, workers or os.cpu_count() or 1, stage):
            bar.update(task, advance=1, description=f"{name}: {outcome}"[:60])
            if outcome.startswith("failed"):
                failed.append(f"{name}: {outcome}")
    for line in failed:
        typer.echo(line, err=True)
    typer.echo(f"The manifest lists {write_manifest(out)} objects.")
    if failed:
        raise typer.Exit(1)
