"""``grasp-bench cache``: the compiled models that are kept, and emptying them."""

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
    """Show where compiled models are kept, how many, since when they were not used, and the limit.

    A model takes some 6 MB. Above the limit, 2 GB or GRASP_BENCH_CACHE_MB megabytes, those used longest ago
    are removed; a model that is not there is compiled again, to the same trial.

    Example: grasp-bench cache
    """
    if context.invoked_subcommand is not None:
        return
    entries, limit = cache.entries(), cache.limit()
    groups, above = {}, 0.0
    for name, most in AGES:
        sizes = [e.size for e in entries if above <= e.age < most]
        groups[name], above = {"models": len(sizes), "bytes": sum(sizes)}, most
    total = sum(e.size for e in entries)
    if as_json:
        typer.echo(
            json.dumps(
                {
                    "folder": str(cache.folder()),
                    "models": len(entries),
                    "bytes": total,
                    "limit_bytes": limit,
                    "last_used": groups,
                },
                ensure_ascii=False,
            )
        )
        return
    typer.echo(f"{cache.folder()}: {_many(len(entries), total)} of at most {limit / 1e6:,.0f} MB")
    for name, group in groups.items():
        if group["models"]:
            typer.echo(f"  used {name}: {_many(group['models'], group['bytes'])}")


@cache_app.command("clear")
def clear_command(as_json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False) -> None:
    """Remove all compiled models. Runs that go on meanwhile compile theirs again.

    Example: grasp-bench cache clear
    """
    removed = cache.clear()
    size = sum(e.size for e in removed)
    if as_json:
        found = {"folder": str(cache.folder()), "models": len(removed), "bytes": size}
        typer.echo(json.dumps(found, ensure_ascii=False))
    else:
        typer.echo(f"Removed {_many(len(removed), size)} from {cache.folder()}")


def _many(count: int, size: int) -> str:
    return f"{count} model{'' if count == 1 else 's'}, {size / 1e6:,.0f} MB"
