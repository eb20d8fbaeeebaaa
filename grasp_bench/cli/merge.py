"""``grasp-bench merge``: several shards' folders made into one."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer


def merge_command(
    out: Annotated[Path, typer.Argument(help="New folder for the whole run.")],
    shards: Annotated[list[Path], typer.Argument(help="Folders of the shards, in any order.")],
    partial: Annotated[
        bool,
        typer.Option(
            "--partial", help="Accept that trials are missing; `grasp-bench run --out OUT` does them later."
        ),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Put the shards of a run together: OUT becomes what one machine would have written, byte for byte.

    Refuses, naming them: shards of different settings, missing trials, and trials of which two
    shards hold different records.

    Example: grasp-bench merge results/whole results/part1 results/part2
    """
    from grasp_bench.runs.merge import merge

    merged = merge(out, shards, partial)
    if as_json:
        typer.echo(json.dumps(asdict(merged) | {"folder": str(out)}, ensure_ascii=False))
        return
    typer.echo(f"Merged {len(shards)} folders: {merged.trials} of {merged.planned} trials in {out}.")
    if merged.repeated:
        typer.echo(f"{merged.repeated} trials were in more than one of them, each time the same record.")
    for note in merged.notes:
        typer.echo(note)
