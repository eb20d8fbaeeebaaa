"""``grasp-bench grippers``: list, show and check grippers, and prepare objects for them."""

from __future__ import annotations

import json
import math
import os
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from grasp_bench.cli.layout import listing
from grasp_bench.system.graphics import without_gl

grippers_app = typer.Typer(
    no_args_is_help=True, help="List, show and check grippers, and prepare objects for them."
)

Name = Annotated[
    str, typer.Argument(help="A shipped gripper's name, or the folder of one with gripper.yaml.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print as JSON.")]


@grippers_app.command("list")
def list_grippers(as_json: AsJson = False) -> None:
    """List the shipped grippers with opening, force, finger and mass.

    A scenario names one by `robot: {gripper: NAME}`, or anyone's by the path of its folder.
    """
    from grasp_bench.robot.cup import SuctionCup
    from grasp_bench.robot.facts import shipped
    from grasp_bench.robot.grippers import load_gripper

    found = [load_gripper(n) for n in shipped("gripper")]
    if as_json:
        typer.echo(json.dumps([_facts(g) for g in found]))
        return
    from rich.console import Console

    head = ("Name", "Opening [mm]", "Force [N]", "Finger [mm]", "Pad [mm]", "Mass [kg]")
    table = listing(head, ("Name",))
    for g in found:
        finger = (g.finger_thickness, g.finger_width, g.finger_length)
        cup = isinstance(g, SuctionCup)
        table.add_row(
            g.name,
            "–" if cup else f"{1000 * g.opening:.0f}",
            f"{g.force[0]:.3g} to {g.force[1]:.3g}",
            "suction cup" if cup else _mm(finger),
            f"⌀ {2000 * g.radius:g}" if isinstance(g, SuctionCup) else _mm(g.pad[1:]),
            f"{g.shape.mass:.2f}",
        )
    Console().print(table)


@grippers_app.command()
def show(name: Name, as_json: AsJson = False) -> None:
    """Show what a gripper's file says and what was measured from its model."""
    from grasp_bench.robot.grippers import load_gripper

    gripper = load_gripper(name)
    if as_json:
        typer.echo(json.dumps(_facts(gripper)))
        return
    from rich.console import Console
    from rich.markup import escape

    from grasp_bench.robot.cup import SuctionCup

    console, shape = Console(soft_wrap=True), gripper.shape
    told = escape(f": {gripper.title}, {shape.mass:.2f} kg; {gripper.path}")
    console.print(f"[bold]{escape(gripper.name)}[/bold]{told}")
    if gripper.facts.source:
        console.print(f"Source: {gripper.facts.source}", markup=False)
    least, most = gripper.force
    if isinstance(gripper, SuctionCup):
        cup = gripper.cup
        console.print(
            f"Stated: vacuum of {cup.vacuum[0] / 1000:g} to {cup.vacuum[1] / 1000:g} kPa; the rim tilts by "
            f"{cup.tilt_deg:g}° and follows {1000 * cup.compliance:g} mm; up to {1000 * cup.hollow:g} mm may "
            f"stand out into it; pressed in by {1000 * cup.press:g} mm",
            markup=False,
        )
        console.print(
            f"Measured: rim ⌀ {2000 * gripper.radius:g} mm, so {least:.1f} to {most:.1f} N pull it off; hand "
            f"{_mm(shape.palm)} mm; flange to TCP {1000 * shape.flange_to_tcp:.1f} mm",
            markup=False,
        )
        return
    ends = gripper.jaws.commands
    console.print(
        f"Stated: {least:g} to {most:g} N a pad, up to {gripper.speed:g} m/s a finger; actuator "
        f"{gripper.actuator!r}, {ends.open:g} open, {ends.closed:g} closed",
        markup=False,
    )
    console.print(
        f"Measured: opens {1000 * gripper.opening:.1f} mm; fingers "
        f"{_mm((shape.finger_thickness, shape.finger_width, shape.finger_length))} mm (thickness, width, "
        f"length); pads {_mm(shape.pad)} mm; palm {_mm(shape.palm)} mm; flange to TCP "
        f"{1000 * shape.flange_to_tcp:.1f} mm; the actuator presses each pad with 1/{shape.force_ratio:g} of "
        "its force, "
        f"{shape.strongest:.0f} N at most"
    )


@grippers_app.command()
def check(
    path: Annotated[str, typer.Argument(help="Folder with gripper.yaml, or a shipped gripper's name.")],
) -> None:
    """Check a gripper of your own: its files, its parts, its measures, and that it opens and closes.

    Exits with 2 and one line where something is wrong. docs/robots.md says how such a folder is made.
    """
    from grasp_bench.robot.cup import SuctionCup
    from grasp_bench.robot.facts import name_beside
    from grasp_bench.robot.gripper_trial import try_out
    from grasp_bench.robot.grippers import load_gripper

    gripper = load_gripper(path)
    moved = try_out(gripper)
    show(path)
    if isinstance(gripper, SuctionCup):
        done = "The vacuum holds a plate of half the force, and lets it go."
    else:
        wide, narrow = 1000 * moved.opened, 1000 * moved.closed
        done = f"The actuator opens it to {wide:.1f} mm, closes it to {narrow:.1f} mm."
    typer.echo(f"{done} It can be used, after `grasp-bench grippers prepare {path}`, by a scenario such as")
    named = name_beside("gripper", path)
    typer.echo(f"\nextends: table4\nname: my-scenario\nrobot: {{gripper: {named}}}{_within(path)}")


@grippers_app.command("import")
def import_command(
    model: Annotated[
        Path, typer.Argument(help="MJCF or URDF of the gripper alone, z its approach, or menagerie:NAME.")
    ],
    out: Annotated[Path, typer.Option(help="Folder to make.")],
    fingers: Annotated[
        str | None,
        typer.Option(help="Bodies of the two fingers, comma-separated; those on slides by default."),
    ] = None,
    pads: Annotated[
        str | None, typer.Option(help="Geoms that touch what is held, one of each finger, comma-separated.")
    ] = None,
    force: Annotated[str, typer.Option(help="Least and greatest force of each pad [N].")] = "5,100",
    speed: Annotated[float, typer.Option(min=0.001, help="Greatest speed of each finger \\[m/s].")] = 0.1,
    title: Annotated[str | None, typer.Option(help="What it is called in reports.")] = None,
    radian: Annotated[
        bool, typer.Option("--radian", help="The file's angles are radians, though it does not say so.")
    ] = False,
) -> None:
    """Make a folder with gripper.yaml of the MJCF or URDF that you have: fingers on slides or linkages.

    The jaws are turned to open along x, the fingers coupled and moved by one position servo, and the pads
    get the contacts of the shipped grippers. Of linkages the pads are kept parallel. Nothing outside of the
    model's folder is read.

    Example: grasp-bench grippers import my_hand.xml --out my-hand --force 20,70
    """
    from grasp_bench.workshop.own_gripper import Asked, import_gripper

    least, most = (float(v) for v in _two("--force", force))
    asked = Asked(
        None if fingers is None else _two("--fingers", fingers),
        None if pads is None else _two("--pads", pads),
        (least, most),
        speed,
        title,
        radian,
    )
    import_gripper(model, out, asked)
    check(str(out))


def _within(path: str) -> str:
    """Return the line of a scenario that brings `table4`'s use of a gripper within this one's limits."""
    from grasp_bench.scenario.reading import load_scenario
    from grasp_bench.scenario.robots import with_gripper

    table4 = load_scenario("table4")
    before, after = (s.gripper.model_dump(mode="json") for s in (table4, with_gripper(table4, path)))
    inwards = {k: math.floor if after[k] < before[k] else math.ceil for k in after if after[k] != before[k]}
    changed = ", ".join(f"{k}: {round_(1e4 * after[k]) / 1e4:g}" for k, round_ in inwards.items())
    return f"\ngripper: {{{changed}}}" if changed else ""


def _two(option: str, text: str) -> tuple[str, str]:
    parts = [p.strip() for p in text.split(",")]
    if len(parts) != 2 or not all(parts):
        raise typer.BadParameter(
            f"needs two values with a comma between them, not {text!r}", param_hint=option
        )
    if option == "--force" and not all(p.replace(".", "", 1).isdecimal() for p in parts):
        raise typer.BadParameter(f"needs two numbers, such as 20,70, not {text!r}", param_hint=option)
    return parts[0], parts[1]


@grippers_app.command()
def prepare(
    name: Name,
    objects: Annotated[
        str, typer.Option(help="all, names or categories (comma-separated), or a folder of objects.")
    ] = "all",
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0 takes one for each core.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Work out where a gripper can grasp the objects: grasps for each resting pose, tried in physics.

    Needed once before a run with another gripper than parallel-85; takes minutes for all objects. What is
    done is kept under the digests of gripper and object: the same command again resumes.

    Example: grasp-bench grippers prepare panda-hand --objects mug,pliers
    """
    without_gl()
    from rich.console import Console

    from grasp_bench.api import select_objects
    from grasp_bench.objects.fitted import is_reference
    from grasp_bench.robot.grippers import load_gripper
    from grasp_bench.system.progress import counting
    from grasp_bench.workshop.fitting import prepare as fit_all

    gripper = load_gripper(name)
    catalog, names = select_objects(objects, gripper)
    if is_reference(gripper):
        typer.echo(f"{name} is the reference gripper: the objects come with its grasps.")
        return
    outcomes: dict[str, str] = {}
    console = Console(stderr=True)
    with counting(console) as bar:
        task = bar.add_task(f"Grasps of {name}", total=len(names), state="")
        for done, outcome in fit_all(gripper, catalog.folder, names, workers or os.cpu_count() or 1):
            outcomes[done] = outcome
            bar.update(task, advance=1, state=f"{done}: {outcome}"[:60])
    failed = [f"{n}: {o}" for n, o in outcomes.items() if o.startswith("failed")]
    cannot = sorted(n for n, o in outcomes.items() if o == "cannot be grasped")
    for line in failed:
        typer.echo(line, err=True)
    if as_json:
        typer.echo(json.dumps({"gripper": name, "objects": outcomes}))
    else:
        can = len(outcomes) - len(cannot) - len(failed)
        typer.echo(f"{name} can grasp {can} of {len(names)} objects.")
        if cannot:
            typer.echo(f"In no resting pose: {', '.join(cannot)}. Runs leave them out.")
    if failed:
        raise typer.Exit(1)


def _facts(gripper: Any) -> dict[str, Any]:
    facts = gripper.facts.model_dump(mode="json")
    folder = {"name": gripper.name, "folder": str(Path(gripper.folder))}
    return folder | facts | {"measured": asdict(gripper.shape)}


def _mm(lengths: Any) -> str:
    return " × ".join(f"{round(1000 * v, 1):g}" for v in lengths)
