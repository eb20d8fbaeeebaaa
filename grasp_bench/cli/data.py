"""``grasp-bench data``: make training data, and look at it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from grasp_bench.system.files import prepare_picture
from grasp_bench.system.progress import counting

data_app = typer.Typer(no_args_is_help=True, help="Make training data, and look at it.")


@data_app.command("synth")
def synth_command(
    scenes: Annotated[int, typer.Option(help="Number of scenes in the folder.", min=1)] = 1000,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder of the data set.")] = Path("data/synth"),
    seed: Annotated[int, typer.Option(help="Seed; the same seed gives the same scenes.", min=0)] = 1,
    workers: Annotated[int, typer.Option(help="Processes.", min=1)] = 2,
    tries: Annotated[int, typer.Option(help="Grasps tried in physics per scene.", min=0)] = 20,
    style: Annotated[
        str,
        typer.Option(
            help="plain (the reference scenario, a little varied), camera-like (cameras, walls, bins, "
            "sensors and light of all sorts), or a YAML file of what differs from camera-like."
        ),
    ] = "plain",
) -> None:
    """Generate synthetic training scenes of random shapes.

    The same command goes on where a stopped one ended; scenes already there are kept.
    """
    from rich.console import Console

    from grasp_bench.learning.data.generate import calibration, generate
    from grasp_bench.learning.data.stages.style import read_style
    from grasp_bench.learning.data.synthetic import SynthConfig

    console = Console()
    tally = {"there": 0, "made": 0, "tries": 0}
    config = SynthConfig(tries=tries, style=read_style(style))
    with counting(console) as progress:
        task = progress.add_task("scenes", total=scenes, state="")

        def report(entry: dict[str, Any] | None, fresh: bool) -> None:
            tally["there"] += entry is not None
            if fresh:
                tally["made"] += entry is not None
                tally["tries"] += entry["tried"] if entry else 0
            seconds = max(progress.tasks[task].elapsed or 0, 1e-3)
            progress.update(
                task,
                advance=1,
                state=f"{3600 * tally['made'] / seconds:.0f} scenes/h, "
                f"{tally['tries'] / seconds:.1f} tries/s",
            )
            if fresh and not console.is_terminal and tally["there"] % 50 == 0:
                console.print(f"{tally['there']} of {scenes}: {progress.tasks[task].fields['state']}")

        made = generate(out, scenes, seed, config, workers, report)
    for index, reason in made.failed.items():
        console.print(f"scene {index} failed: {reason}", style="red", markup=False)
    told = f"{len(made.entries)} scenes in {out}. Grasps that held, by quality of the analysis:"
    console.print(told, markup=False)
    for edge, count, share in calibration(out, made.entries):
        console.print(f"  up to {edge:.1f}: {100 * share:5.1f} % of {count}")


@data_app.command("show")
def show_command(
    folder: Annotated[Path, typer.Argument(help="Folder of a data set.")],
    count: Annotated[int, typer.Option(help="Scenes to show.", min=1)] = 8,
    out: Annotated[Path, typer.Option("--out", "-o", help="PNG to write.")] = Path("samples.png"),
) -> None:
    """Draw samples of a data set: grasps that held and as people draw them, height, quality, angle.

    Shows generated scenes, and Cornell or Jacquard as training sees them.
    """
    prepare_picture(out)
    from grasp_bench.learning.data.pictures import sample_sheet

    shown = sample_sheet(folder, count, out)
    typer.echo(f"{out}: scenes {', '.join(shown)}")


@data_app.command("compare")
def compare_command(
    folder: Annotated[
        Path, typer.Argument(help="Data set, Cornell or Jacquard copy, or folder of a run with --trial.")
    ],
    predictors: Annotated[
        str,
        typer.Option(
            help="Names or files of weights, comma-separated.",
            show_default="htc-grasp, gr-convnet, tf-grasp-release",
        ),
    ] = "htc-grasp,gr-convnet,tf-grasp-release",
    count: Annotated[int, typer.Option(help="Images, spread over the data set.", min=1)] = 4,
    trial: Annotated[int | None, typer.Option(help="Trial of the run whose image is shown.", min=0)] = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="PNG to write.")] = Path("compare.png"),
) -> None:
    """Draw quality, angle and width maps and the best grasp of several predictors side by side.

    That is Figures 4, 5 and, of a trial in clutter, 6 of the paper. Detectors have no maps.

    Example: grasp-bench data compare cornell --predictors htc-grasp,gr-convnet --out figure4.png
    """
    prepare_picture(out)
    from contextlib import ExitStack

    from grasp_bench.learning.data.pictures import write_picture
    from grasp_bench.learning.evaluation.compare import compare, images
    from grasp_bench.predictors.use import in_use

    with ExitStack() as opened:
        names = [name.strip() for name in predictors.split(",") if name.strip()]
        used = {name: opened.enter_context(in_use(name)) for name in names}
        shown = list(images(folder, count, trial))
        write_picture(out, compare(shown, used))
    typer.echo(f"{out}: {', '.join(one.name for one in shown)}; from above: {', '.join(names)}")


@data_app.command("export")
def export_command(
    folder: Annotated[Path, typer.Argument(help="Folder of generated scenes.")],
    out: Annotated[Path, typer.Argument(help="Folder to write.")],
    layout: Annotated[
        Literal["jacquard"],
        typer.Option("--format", help="Jacquard's files: RGB, perfect and noisy depth, mask, grasps."),
    ] = "jacquard",
    size: Annotated[int, typer.Option(help="Side of the images \\[px]; Jacquard's is 1024.", min=32)] = 1024,
    limit: Annotated[int | None, typer.Option(help="Scenes at most.", min=1)] = None,
) -> None:
    """Write generated scenes in another data set's layout, so that other trainers can read them.

    The same command goes on where a stopped one ended.
    """
    from grasp_bench.learning.data.export import export_jacquard

    written, empty = export_jacquard(folder, out, size, limit)
    typer.echo(
        f"{written} scenes in {out} in the layout of {layout}; {empty} left out, in which no grasp held."
    )


@data_app.command("info")
def info_command(
    folder: Annotated[Path, typer.Argument(help="Root of a Cornell or Jacquard copy.")],
    folds: Annotated[int, typer.Option(help="Folds to make by objects, to show how.", min=1)] = 5,
) -> None:
    """Say what a copy of Cornell or Jacquard holds, reading all of it: images, objects, labels, faults.

    Every file that cannot be read is named; the exit code is 1 then.
    """
    from grasp_bench.learning.data.folds import make_folds
    from grasp_bench.learning.data.opening import open_collection

    found = open_collection(folder)
    typer.echo(found.describe())
    labels = dropped = 0
    faults: list[str] = []
    for _, sample, fault in found.samples():
        if sample is None:
            faults.append(fault)
            continue
        labels += len(sample.rectangles)
        dropped += sample.dropped
    typer.echo(
        f"{labels} rectangles; {dropped} dropped because of NaN, no area or a middle outside of the picture."
    )
    objects = [e.object for e in found.entries]
    most = len(set(objects)) if found.knows_objects else len(objects)
    made = make_folds(objects, min(folds, most), "object")
    typer.echo(f"{made.how[0].upper()}{made.how[1:]}: {', '.join(str(len(t)) for t in made.test)} images.")
    for fault in faults:
        typer.echo(fault, err=True)
    if faults:
        typer.echo(f"{len(faults)} of {len(found.entries)} images cannot be read.", err=True)
        raise typer.Exit(1)


@data_app.command("trials")
def trials_command(
    run: Annotated[Path, typer.Argument(help="Folder of a finished run.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="File to write.")] = Path("trials.parquet"),
    objects: Annotated[
        Path | None, typer.Option(help="Folder of the run's objects; by default the scenario's.")
    ] = None,
) -> None:
    """Write a run's trials into a Parquet file to train on: image, grasp, outcome and margin of each.

    Images are made again from the run's seed. Needs the extra `parquet`.
    Example: grasp-bench data trials results/htc-grasp-graded-seed0 --out trials.parquet
    """
    from rich.console import Console

    from grasp_bench.runs.results import RunResults
    from grasp_bench.studies.trial_data import export_trials

    with counting(Console(stderr=True)) as progress:
        task = progress.add_task("trials", total=len(RunResults(run)), state="")
        count = export_trials(run, out, objects, lambda done: progress.update(task, completed=done))
    typer.echo(f"{count} trials in {out}, {out.stat().st_size / 1e6:.1f} MB.")
