"""``grasp-bench arms``: list, show and check arms."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from grasp_bench.cli.layout import listing

arms_app = typer.Typer(no_args_is_help=True, help="List, show and check arms.")

Name = Annotated[str, typer.Argument(help="A shipped arm's name, or the folder of one with arm.yaml.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print as JSON.")]


@arms_app.command("list")
def list_arms(as_json: AsJson = False) -> None:
    """List the shipped arms with joints, length of the links and mass.

    A scenario names one by `robot: {arm: NAME}`, or anyone's by the path of its folder.
    """
    from grasp_bench.robot.arm import load_arm
    from grasp_bench.robot.facts import shipped

    found = [load_arm(n) for n in shipped("arm")]
    if as_json:
        typer.echo(json.dumps([_facts(a) for a in found]))
        return
    from rich.console import Console

    head = ("Name", "Title", "Joints", "Greatest torques [N m]", "Mass [kg]")
    table = listing(head, ("Name", "Title"))
    for a in found:
        torques = ", ".join(f"{t:g}" for t in a.torque_limits)
        table.add_row(a.name, a.title, str(len(a.joints)), torques, f"{a.shape.mass:.1f}")
    Console().print(table)


@arms_app.command()
def show(name: Name, as_json: AsJson = False) -> None:
    """Show what an arm's file says and what was measured from its model: limits, postures, torques."""
    from grasp_bench.robot.arm import load_arm

    arm = load_arm(name)
    if as_json:
        typer.echo(json.dumps(_facts(arm)))
        return
    import numpy as np
    from rich.console import Console
    from rich.markup import escape

    console, shape, facts = Console(soft_wrap=True), arm.shape, arm.facts
    told = escape(f": {arm.title}, {shape.mass:.1f} kg; {arm.path}")
    console.print(f"[bold]{escape(arm.name)}[/bold]{told}")
    if facts.source:
        console.print(f"Source: {facts.source}", markup=False)
    head = ("Joint", "Range [°]", "Speed [°/s]", "Torque [N m]", "Home [°]", "Ready [°]")
    table = listing(head, ("Joint",))
    for i, joint in enumerate(arm.joints):
        low, high = np.degrees(shape.position_limits[i])
        table.add_row(
            escape(joint),
            f"{low:.1f} to {high:.1f}",
            f"{facts.velocity_deg[i]:g}",
            f"{shape.torque_limits[i]:g}",
            f"{facts.home_deg[i]:g}",
            f"{facts.ready_deg[i]:g}",
        )
    console.print(table)


@arms_app.command()
def check(
    path: Annotated[str, typer.Argument(help="Folder with arm.yaml, or a shipped arm's name.")],
    gripper: Annotated[str, typer.Option(help="The gripper that it carries.")] = "parallel-85",
    scenario: Annotated[str, typer.Option(help="The scenario whose workspace it must reach.")] = "table4",
) -> None:
    """Check an arm of your own: files, limits and postures, that it reaches a scenario's workspace, and that
    its motors hold it stretched out with the heaviest object.

    Exits with 2 and one line where something is wrong. docs/robots.md says how such a folder is made.
    """
    from grasp_bench.objects.catalog import Catalog, folder_of
    from grasp_bench.planning.reach import check_reach
    from grasp_bench.robot.arm_trial import SECONDS, hold_out
    from grasp_bench.robot.facts import name_beside
    from grasp_bench.scenario.reading import load_scenario
    from grasp_bench.scenario.sections import Robot

    robot = Robot(arm=path, gripper=gripper)
    _ = robot.loaded.arm.shape
    chosen = load_scenario(scenario).model_copy(update={"robot": robot})
    check_reach(chosen)
    payload = chosen.objects.mass_scale * Catalog(folder_of(chosen.objects.folder)).heaviest
    held = hold_out(robot.loaded.arm, robot.loaded.gripper, payload)
    show(path)
    typer.echo(
        f"It reaches the workspace of {scenario} with {gripper}: robot: {{arm: {name_beside('arm', path)}}}."
    )
    typer.echo(
        f"Stretched out to {held.reach:.2f} m with {payload:g} kg, it sinks by {1000 * held.sag:.1f} mm in "
        f"{SECONDS:g} s."
    )


@arms_app.command("import")
def import_command(
    model: Annotated[
        Path, typer.Argument(help="MJCF or URDF of the arm alone, its base at the origin, or menagerie:NAME.")
    ],
    out: Annotated[Path, typer.Option(help="Folder to make.")],
    flange: Annotated[
        str | None,
        typer.Option(help="Site or body whose z points out of the flange; the last body by default."),
    ] = None,
    velocity: Annotated[
        str, typer.Option(help="Greatest speeds [°/s]: one number, or one for each joint, comma-separated.")
    ] = "120",
    torque: Annotated[
        str | None, typer.Option(help="Greatest torques [N m], likewise; those of the file by default.")
    ] = None,
    home: Annotated[
        str | None, typer.Option(help="Where it waits, tool down, out of view [°]; looked for by default.")
    ] = None,
    ready: Annotated[
        str | None, typer.Option(help="Ahead of the base, elbow up, tool down [°]; looked for by default.")
    ] = None,
    title: Annotated[str | None, typer.Option(help="What it is called in reports.")] = None,
    endless: Annotated[
        float | None,
        typer.Option(min=90, max=720, help="Range to either side of joints that the file gives none [°]."),
    ] = None,
) -> None:
    """Make a folder with arm.yaml of the MJCF or URDF that you have: six or more hinges.

    Motors become position servos with the gains of the shipped arms. Nothing outside of the model's folder
    is read.

    Example: grasp-bench arms import my_arm.xml --out my-arm --flange tool0 --velocity 180
    """
    from grasp_bench.workshop.own_arm import Asked, import_arm

    speeds = _numbers("--velocity", velocity)
    assert speeds is not None
    asked = Asked(
        flange,
        speeds,
        _numbers("--torque", torque),
        _numbers("--home", home),
        _numbers("--ready", ready),
        title,
        endless,
    )
    import_arm(model, out, asked)
    check(str(out), "parallel-85", "table4")


def _numbers(option: str, text: str | None) -> tuple[float, ...] | None:
    if text is None:
        return None
    try:
        return tuple(float(v) for v in text.split(","))
    except ValueError as error:
        raise typer.BadParameter(
            f"needs numbers with commas between them, not {text!r}", param_hint=option
        ) from error


def _facts(arm: Any) -> dict[str, Any]:
    return (
        {"name": arm.name, "folder": str(arm.folder)}
        | arm.facts.model_dump(mode="json")
        | {"measured": asdict(arm.shape)}
    )
