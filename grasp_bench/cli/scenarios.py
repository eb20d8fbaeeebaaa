"""``grasp-bench scenarios``: list the shipped ones, and show every value of one."""

from __future__ import annotations

import json
from typing import Annotated

import typer
import yaml

from grasp_bench.cli.layout import listing

scenarios_app = typer.Typer(invoke_without_command=True, help="List scenarios, and show what they hold.")


@scenarios_app.callback()
def list_command(
    context: typer.Context, as_json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False
) -> None:
    """List the shipped scenarios; `show NAME` prints all values of one."""
    if context.invoked_subcommand is not None:
        return
    from grasp_bench.scenario.reading import load_scenario, scenario_names

    found = [(n, load_scenario(n).description) for n in scenario_names()]
    if as_json:
        typer.echo(json.dumps([{"name": n, "description": d} for n, d in found], ensure_ascii=False))
        return
    from rich.console import Console
    from rich.markup import escape

    head = ("Name", "What it is")
    table = listing(head, head)
    for row in found:
        table.add_row(*map(escape, row))
    console = Console()
    console.print(table)
    console.print(
        "`grasp-bench run --scenario NAME`; your own: a YAML file with `extends: table4` and what differs."
    )


@scenarios_app.command("show")
def show_command(
    name: Annotated[str, typer.Argument(help="A shipped scenario, or the path of a YAML file.")],
    changed: Annotated[bool, typer.Option("--changed", help="Only what differs from table4.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Print all values of a scenario, inherited ones and presets resolved."""
    from grasp_bench.scenario.reading import load_scenario

    values = load_scenario(name).model_dump(mode="json")
    if changed:
        values = _difference(values, load_scenario("table4").model_dump(mode="json"))
    if as_json:
        typer.echo(json.dumps(values, indent=1, ensure_ascii=False))
    else:
        typer.echo(yaml.safe_dump(values, sort_keys=False, allow_unicode=True, width=110), nl=False)


def _difference(values: dict, reference: dict) -> dict:
    """Return what differs from the reference, section by section."""
    different = {}
    for key, value in values.items():
        other = reference.get(key)
        if isinstance(value, dict) and isinstance(other, dict) and key != "names":
            value = _difference(value, other)
            if value:
                different[key] = value
        elif value != other:
            different[key] = value
    return different
