"""``grasp-bench replay``: do a recorded trial or episode again, verify it, tell it, and show it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from grasp_bench.cli.trust import Trust, ask_for_trust
from grasp_bench.errors import GraspBenchError
from grasp_bench.system.graphics import LIBRARIES, VARIABLE, prepare, with_gl
from grasp_bench.system.machine import THREADS


def replay_command(
    run: Annotated[Path, typer.Argument(help="A run's folder.")],
    trial: Annotated[int, typer.Option(min=0, help="Number of the trial.")],
    attempt: Annotated[
        int | None, typer.Option(min=0, help="In an episode of clutter, the only attempt to tell and show.")
    ] = None,
    video: Annotated[
        Path | None, typer.Option(help="Write a film: .mp4 and .webm (extra `video`), .gif or .webp.")
    ] = None,
    viewer: Annotated[bool, typer.Option("--viewer", help="Play it in MuJoCo's viewer.")] = False,
    browser: Annotated[
        bool,
        typer.Option("--browser", help="Play it on a local web page (extra `viewer`); needs no display."),
    ] = False,
    rerun: Annotated[
        Path | None, typer.Option(help="Write a Rerun recording, FILE.rrd (extra `rerun`).")
    ] = None,
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port of the web page.")] = 8080,
    opengl: Annotated[
        bool,
        typer.Option("--opengl", help="Draw the film with OpenGL (EGL or OSMesa) instead of casting rays."),
    ] = False,
    objects: Annotated[
        Path | None, typer.Option(help="Folder of the objects' catalogue, if not the shipped one.")
    ] = None,
    trust: Trust = False,
) -> None:
    """Do a recorded trial again, verify that it ends as recorded, and show it.

    A trial of clutter is an episode: all its attempts are done again, and shown one after the other.

    Three verdicts: the same to the bit; the same within rounding, as another kind of processor gives; or
    different, which exits with 1. Whatever differs is said.

    Example: grasp-bench replay results/reference/htc-grasp --trial 2 --video trial.webp
    """
    for name in THREADS:  # before NumPy is imported: as in a run's workers
        os.environ.setdefault(name, "1")
    from grasp_bench.runs.folder import load_run

    info = load_run(run)
    trust = ask_for_trust(info.predictor, run, trust)
    _choose_graphics(info.renderer, viewer, opengl)
    if video is not None:
        from grasp_bench.replay.video import check_kind

        check_kind(video)
    if browser:
        from grasp_bench.replay.browser import import_viser

        import_viser()
    if rerun is not None:
        from grasp_bench.media.rerun_log import import_rerun

        import_rerun()
    from grasp_bench.replay.rebuild import rebuild
    from grasp_bench.replay.story import story
    from grasp_bench.replay.verdict import Verdict

    done = rebuild(run, trial, objects, attempt=attempt, trust=trust)
    for line in story(done):
        typer.echo(line)
    different = done.verdict is Verdict.DIFFERENT
    if done.identical:
        typer.echo("Verified: the record is the same to the bit.")
    else:
        words = "NOT as recorded:" if different else "Verified: the record is the same within rounding."
        typer.echo(words, err=different)
        for line in done.differs:
            typer.echo(f"  {line}", err=different)
        for cause in done.causes or ["nothing that run.json records"]:
            typer.echo(f"  differs between then and now: {cause}", err=different)
    if video is not None:
        from grasp_bench.replay.video import write_film

        count = write_film(done, video, opengl=opengl)
        typer.echo(f"{video}: {count} pictures, {video.stat().st_size / 1e6:.2f} MB.")
    if rerun is not None:
        from grasp_bench.media.rerun_log import log_take, writing

        with writing(rerun) as stream:
            for take in done.takes:
                log_take(stream, take, done.scenario)
        typer.echo(f"{rerun}: {rerun.stat().st_size / 1e6:.1f} MB; open it with `rerun {rerun}`.")
    if viewer:
        from grasp_bench.replay.viewer import show

        show(done)
    if browser:
        from grasp_bench.replay.browser import serve

        serve(done, port)
    if different:
        raise typer.Exit(1)


def _choose_graphics(renderer: str, viewer: bool, opengl: bool) -> None:
    """Choose the OpenGL that MuJoCo may load: that of the run's images, of the film, of a window, or none."""
    if viewer:
        if renderer in LIBRARIES:
            raise GraspBenchError(
                f"The run's images were made with {renderer}, which MuJoCo's viewer cannot "
                "be used together with; use --browser."
            )
        if os.environ.get(VARIABLE, "glfw").lower() == "off":
            del os.environ[VARIABLE]
        from grasp_bench.replay.viewer import check_display

        check_display()
    elif opengl and renderer not in LIBRARIES:
        with_gl()
    else:
        prepare(renderer)
