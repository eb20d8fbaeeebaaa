"""``grasp-bench train``: trains a network, resumes, and exports weights with a model card."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from grasp_bench.learning.training.config import TrainConfig
    from grasp_bench.learning.training.dataset import SceneSet
    from grasp_bench.learning.training.loop import Trained
    from grasp_bench.learning.training.sources import Source


def train_command(
    data: Annotated[
        list[Path],
        typer.Option(
            "--data",
            "-d",
            help="Folder of generated scenes, or root of a Cornell or Jacquard copy; may be "
            "given several times. DIR:WEIGHT sets its share of what is seen; without, "
            "every scene is seen equally often.",
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            "--out", "-o", help="Folder of the run. The same command continues an interrupted run there."
        ),
    ],
    predictor: Annotated[
        str,
        typer.Option(
            help="Network to train: htc-grasp, gr-convnet, gg-cnn, tf-grasp …; a wrong name lists all."
        ),
    ] = "htc-grasp",
    steps: Annotated[int, typer.Option(help="Optimiser steps in all.", min=1)] = 5000,
    batch: Annotated[int, typer.Option(help="Scenes a step.", min=1)] = 16,
    lr: Annotated[float, typer.Option(help="Highest learning rate (warm-up, then cosine to 0).")] = 1e-3,
    seed: Annotated[int, typer.Option(help="Seed of weights, order and augmentation.", min=0)] = 0,
    warmup: Annotated[int, typer.Option(help="Steps of linear warm-up.", min=0)] = 50,
    constant: Annotated[
        bool,
        typer.Option("--constant-lr", help="Keep the learning rate after the warm-up, as the paper does."),
    ] = False,
    masked: Annotated[
        bool,
        typer.Option(
            "--masked/--unmasked",
            help="Angle and width errors only where there is a grasp; unmasked is the paper's equation 7.",
        ),
    ] = True,
    geometry_weight: Annotated[
        float, typer.Option(help="Weight of the masked angle and width errors.")
    ] = 0.1,
    positive_weight: Annotated[
        float, typer.Option(help="Extra weight of quality errors where there is a grasp.", min=0)
    ] = 0.0,
    ema: Annotated[float, typer.Option(help="Decay of averaged weights, e.g. 0.999; 0 = off.", min=0)] = 0.0,
    augment: Annotated[bool, typer.Option(help="Random rotation, mirror, scale, shift and colour.")] = True,
    precision: Annotated[
        Literal["auto", "fp32", "bf16"],
        typer.Option(help="fp32, bf16, or auto: bf16 where the processor or GPU multiplies in it."),
    ] = "auto",
    workers: Annotated[int, typer.Option(help="Threads that prepare batches.", min=1)] = 1,
    threads: Annotated[
        int,
        typer.Option(
            help="Threads of the network; 0 = all cores but one. Use 1 where others share the machine.", min=0
        ),
    ] = 0,
    checkpoint_every: Annotated[int, typer.Option(help="Steps between checkpoints.", min=1)] = 500,
    validate_every: Annotated[int, typer.Option(help="Steps between validations.", min=1)] = 500,
    init: Annotated[
        str | None,
        typer.Option(help="Weights to begin with: a .safetensors file, or 'shipped' for the installed ones."),
    ] = None,
    input_kind: Annotated[
        Literal["rgbd", "rgb", "depth"] | None,
        typer.Option("--input", help="What the network is shown, where it was published with several."),
    ] = None,
    holdout: Annotated[
        str | None,
        typer.Option(
            help="FOLD/FOLDS of the real images to leave out, e.g. 2/5; they are validated on only."
        ),
    ] = None,
    split: Annotated[
        Literal["image", "object"], typer.Option(help="How --holdout parts images: at random, or by objects.")
    ] = "object",
    export: Annotated[
        bool,
        typer.Option("--export", help="Install the weights and a model card into assets/weights when done."),
    ] = False,
) -> None:
    """Train a grasp network on generated scenes, Cornell, Jacquard, or a mixture.

    Figures go to OUT/log.jsonl, the state to OUT/checkpoint.safetensors; killed at any time,
    the run ends with the same weights as if it had not been, once the command is repeated.
    """
    from pydantic import ValidationError
    from rich.console import Console

    from grasp_bench.learning.data.folds import parse_holdout
    from grasp_bench.learning.training.config import TrainConfig
    from grasp_bench.learning.training.sources import Source, gather
    from grasp_bench.networks.registry import info
    from grasp_bench.networks.registry import input_kind as checked_input

    console = Console()
    crop = info(predictor).crop
    checked_input(predictor, input_kind)
    begin, begun = _initial(predictor, init)
    sources = [Source.parse(str(d)) for d in data]
    try:
        config = TrainConfig(
            network=predictor,
            input=input_kind,
            init=begun,
            steps=steps,
            batch=batch,
            lr=lr,
            seed=seed,
            warmup=warmup,
            cosine=not constant,
            masked=masked,
            geometry_weight=geometry_weight,
            positive_weight=positive_weight,
            ema=ema,
            augment=augment,
            precision=precision,
            workers=workers,
            threads=threads,
            checkpoint_every=checkpoint_every,
            validate_every=validate_every,
        )
    except ValidationError as error:
        first = error.errors()[0]
        raise typer.BadParameter(first["msg"], param_hint=f"--{first['loc'][0]}".replace("_", "-")) from None
    with console.status("Reading scenes …"):
        scenes = gather(sources, crop, parse_holdout(holdout) if holdout else None, split)
    console.print(f"{len(scenes.train)} scenes to train on, {len(scenes.val)} to validate on")
    trained = _train_with_progress(config, scenes, out, console, begin)
    weights = _store(trained, config, scenes, sources, out, export)
    console.print(f"{trained.accuracy}\n[bold]{weights}[/bold]")


def _initial(predictor: str, init: str | None) -> tuple[Path | None, str | None]:
    """File that ``--init`` names, and what the run's settings say of it."""
    from grasp_bench.networks.store import WeightsFile, shipped_file

    if init is None:
        return None, None
    file = shipped_file(predictor) if init == "shipped" else WeightsFile(Path(init))
    return file.path, file.described()


def _train_with_progress(
    config: TrainConfig, scenes: SceneSet, out: Path, console, init: Path | None
) -> Trained:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from grasp_bench.learning.training.loop import train

    columns = (
        TextColumn("{task.fields[name]}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[state]}"),
    )
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("", total=config.steps, name=config.network, state="")

        def report(done, figures, accuracy) -> None:
            progress.update(
                task,
                completed=done,
                state=f"loss {figures['loss']:.4f}  {figures['samples_per_second']:.1f}/s",
            )
            if accuracy is not None:
                progress.console.print(f"step {done}: {accuracy}")

        return train(config, scenes, out, report, init)


def _store(
    trained: Trained, config: TrainConfig, scenes: SceneSet, data: list[Source], out: Path, export: bool
) -> Path:
    """Write weights and card into ``out``; with ``export`` into the assets too, listed in the manifest."""
    from grasp_bench.learning.training.card import model_card, provenance
    from grasp_bench.learning.training.log import training_seconds
    from grasp_bench.networks.store import shipped_file
    from grasp_bench.networks.weights import save

    seconds = training_seconds(out / "log.jsonl", config.batch)
    facts = provenance(trained, config, scenes, data) | ({"seconds": round(seconds)} if seconds else {})
    installed = shipped_file(config.network)
    places = [out / installed.name, *([installed.path] if export else [])]
    for path in places:
        save(trained.network, path, facts)
        path.with_suffix(".md").write_text(model_card(facts), encoding="utf-8")
    if export:
        installed.enter_in_manifest()
    return places[-1]
