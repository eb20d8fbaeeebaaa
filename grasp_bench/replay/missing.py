"""Pictures that are missing for ``grasp-bench report --format html``, made by replay."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import typer

from grasp_bench.media.modes import check_mode
from grasp_bench.runs.folder import load_run
from grasp_bench.system.graphics import prepare
from grasp_bench.system.machine import usable_cores
from grasp_bench.system.progress import Progress


def untrusted(name: str, folder: Path) -> bool:
    """Trust no predictor that is not shipped."""
    return False


def render_missing(
    folders: list[Path], mode: str, objects: Path | None, trusted: Callable[[str, Path], bool] = untrusted
) -> None:
    """Make the pictures and clips of trials that have none, and say what could not be made.

    Args:
        folders: folders of the runs.
        mode: ``none``, ``failures`` or ``all``.
        objects: folder of the objects' catalogue; the shipped ones by default.
        trusted: says of a predictor's name and the folder that names it whether it may be started.

    Raises:
        GraspBenchError: for an unknown mode, or a run that cannot be done again here.
    """
    for renderer in sorted({load_run(f).renderer for f in folders}):
        prepare(renderer)
    if check_mode(mode) == "none":
        return
    from grasp_bench.replay.rerender import missing, rerender

    for folder in folders:
        count = len(missing(folder, mode))
        if count == 0:
            continue
        trust = trusted(load_run(folder).predictor, folder)
        typer.echo(f"{folder}: {count} trials again for their pictures", err=True)
        with Progress(count) as bar:
            done = rerender(folder, mode, objects, usable_cores(), bar.update, trust)
        if done.differing:
            typer.echo(
                f"{folder}: {len(done.differing)} trials did not end as recorded and got no pictures "
                f"(trial {done.differing[0]} first); `grasp-bench replay {folder} --trial "
                f"{done.differing[0]}` says what differs.",
                err=True,
            )
        for number, why in list(done.failed.items())[:1]:
            typer.echo(f"{folder}: no pictures of {len(done.failed)} trials; trial {number}: {why}", err=True)
