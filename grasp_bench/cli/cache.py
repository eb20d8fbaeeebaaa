"""``grasp-bench cache``: the compiled models and objects at rest that are kept, and emptying them."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from grasp_bench.system import cache

cache_app = typer.Typer()

DAY = 86400.0
AGES = (("today", DAY), ("this week", 7 * DAY), ("this month", 30 * DAY), ("longer ago", float("inf")))
"""Names of how long ago a model was used, and the seconds up to which each holds."""


@cache_app.callback(invoke_without_command=True)
def show_command(
    context: typer.Context, as_json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False
) -> None:
    """Show where compiled models and objects at rest are kept, how many, since when not used, and the limit.

    A model takes some 6 MB; how its object comes to rest in a trial and looks then, some 60 kB. Above the
    limit, 2 GB or GRASP_BENCH_CACHE_MB megabytes, those used longest ago are removed; what is not there is
    made again, to the same trial.

    Example: grasp-bench cache
    """
    if context.invoked_subcommand is not None:
        return
    entries, limit = cache.entries(), cache.limit()
    groups: dict[str, list[cache.Entry]] = {}
    above = 0.0
    for name, most in AGES:
        groups[name], above = [e for e in entries if above <= e.age < most], most
    if as_json:
        typer.echo(
            json.dumps(
                {
                    "folder": str(cache.folder()),
                    **_counted(entries),
                    "limit_bytes": limit,
                    "last_used": {name: _counted(group) for name, group in groups.items()},
                },
                ensure_ascii=False,
            )
        )
        return
    typer.echo(f"{cache.folder()}: {_many(entries)} of at most {limit / 1e6:,.0f} MB")
    for name, group in groups.items():
        if group:
            typer.echo(f"  used {name}: {_many(group)}")


@cache_app.command("clear")
def clear_command(as_json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False) -> None:
    """Remove all that is kept. Runs that go on meanwhile make theirs again.

    Example: grasp-bench cache clear
    """
    removed = cache.clear()
    if as_json:
        typer.echo(json.dumps({"folder": str(cache.folder()), **_counted(removed)}, ensure_ascii=False))
    else:
        typer.echo(f"Removed {_many(removed)} from {cache.folder()}")


def _counted(entries: list[cache.Entry]) -> dict[str, int]:
    at_rest = sum(e.path.suffix in cache.AT_REST for e in entries)
    return {"models": len(entries) - at_rest, "at_rest": at_rest, "bytes": sum(e.size for e in entries)}


def _many(entries: list[cache.Entry]) -> str:
    of = _counted(entries)
    rests = f", {of['at_rest']} of objects at rest" if of["at_rest"] else ""
    return f"{of['models']} model{'' if of['models'] == 1 else 's'}{rests}, {of['bytes'] / 1e6:,.0f} MB"
