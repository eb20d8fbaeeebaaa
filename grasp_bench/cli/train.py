"""``grasp-bench train``: train a network, resume, and export weights with a model card."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

import typer
from annotated_types import Ge
from pydantic import ValidationError

from grasp_bench.learning.training.config import RECIPES, TrainConfig
from grasp_bench.networks.registry import info, input_kind
from grasp_bench.networks.store import WeightsFile, shipped_file
from grasp_bench.system.graphics import without_gl
from grasp_bench.system.integrity import write_whole
from grasp_bench.system.progress import counting

if TYPE_CHECKING:
    from grasp_bench.learning.data.scenes import SceneSet
    from grasp_bench.learning.training.loop import Trained
    from grasp_bench.learning.training.sources import Source

TRAINING = "training.json"
"""What a training was and how it went, as in the weights' own metadata: steps, time, seed, data, curve."""

NO_CONTEXT = cast(typer.Context, None)
"""Of a command that is called as a function: all that is given was typed."""


def _with_settings(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command with ``**settings`` an option for each field of :class:`TrainConfig`."""
    options = []
    for name, field in TrainConfig.model_fields.items():
        option = TrainConfig.option(name)
        least: Any = next((m.ge for m in field.metadata if isinstance(m, Ge)), None)
        typed = Annotated[field.annotation, typer.Option(option.names, help=field.description, min=least)]
        default = not field.default if option.off else field.default
        options.append(
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=typed)
        )
    signature = inspect.signature(command, eval_str=True)
    *first, last, _settings = signature.parameters.values()
    command.__signature__ = signature.replace(parameters=[*first, *options, last])
    return command


@_with_settings
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
    *,
    context: typer.Context = NO_CONTEXT,
    recipe: Annotated[
        Literal["own", "paper"],
        typer.Option(
            help="own: the defaults below. paper: 100 epochs of 200 batches of 32, AdamW at 1e-4, unmasked "
            "loss; options that are given count all the same."
        ),
    ] = "own",
    export: Annotated[
        bool,
        typer.Option(
            "--export",
            help="Install the weights and a model card into assets/weights when done, or into "
            "rivals where they have more than 6 MB.",
        ),
    ] = False,
    **settings: Any,
) -> None:
    """Train a grasp network on generated scenes, Cornell, Jacquard, or a mixture.

    Figures go to OUT/log.jsonl, the state to OUT/checkpoint.safetensors; killed at any time,
    the run ends with the same weights as if it had not been, once the command is repeated.
    OUT/training.json has steps, time, seed, data and the learning curve in the end.
    """
    from rich.console import Console

    from grasp_bench.learning.data.folds import parse_holdout
    from grasp_bench.learning.training.process import prepare_process
    from grasp_bench.learning.training.sources import Source, gather

    prepare_process()
    without_gl()  # tries in physics need no graphics, and no display
    console = Console()
    config, begin = read_settings(with_recipe(recipe, settings, context))
    sources = [Source.parse(str(d)) for d in data]
    with console.status("Reading scenes …"):
        holdout = parse_holdout(config.holdout) if config.holdout else None
        scenes = gather(
            sources,
            info(config.network).crop,
            holdout,
            config.split,
            kind=input_kind(config.network, config.input),
        )
    for note in scenes.notes:
        console.print(note, style="yellow", markup=False, highlight=False)
    console.print(f"{len(scenes.train)} scenes to train on, {len(scenes.val)} to validate on")
    trained = _train_with_progress(config, scenes, out, console, begin)
    weights = _store(trained, config, scenes, sources, out, export)
    console.print(f"{trained.accuracy}\n{trained.course.told()}\n{weights}", markup=False)


def with_recipe(recipe: str, typed: dict[str, Any], context: typer.Context | None) -> dict[str, Any]:
    """Lay what was typed over a recipe: an option that was left out is the recipe's.

    Args:
        recipe: a key of :data:`RECIPES`.
        typed: options by the names of their fields.
        context: tells which of them are defaults; None where none are.
    """

    def left_out(name: str) -> bool:
        source = context and context.get_parameter_source(name)
        return source.name != "COMMANDLINE" if source else name not in typed

    # A switch that turns a setting off is typed the other way round.
    of_recipe = {k: not v if TrainConfig.option(k).off else v for k, v in RECIPES[recipe].items()}
    return typed | {name: value for name, value in of_recipe.items() if left_out(name)}


def read_settings(typed: dict[str, Any]) -> tuple[TrainConfig, Path | None]:
    """Return the settings of a run and the file with its first weights.

    Args:
        typed: options by the names of their fields; ``init`` is a file or 'shipped'.

    Raises:
        typer.BadParameter: naming the option that is out of its range.
        UnknownNameError, AssetError: for networks and weights that are not there.
    """
    usual = TrainConfig()
    network, init = typed.get("network", usual.network), typed.get("init")
    input_kind(network, typed.get("input"))
    begin, begun = _initial(network, init)
    try:
        return TrainConfig.from_options(typed | {"init": begun}), begin
    except ValidationError as error:
        first = error.errors()[0]
        raise typer.BadParameter(
            first["msg"], param_hint=TrainConfig.option(str(first["loc"][0])).names
        ) from None


def _initial(predictor: str, init: str | None) -> tuple[Path | None, str | None]:
    """Return the file that ``--init`` names, and what the settings say of it."""
    if init is None:
        return None, None
    file = shipped_file(predictor) if init == "shipped" else WeightsFile(Path(init))
    return file.path, file.described()


def _train_with_progress(
    config: TrainConfig, scenes: SceneSet, out: Path, console, init: Path | None
) -> Trained:
    from grasp_bench.learning.training.loop import train

    with counting(console) as progress:
        # Steps of a run that ends by something else are a bound that tells nothing of the time that is left.
        total = None if config.open_ended else config.steps
        task = progress.add_task(config.network, total=total, state="")

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
    """Write weights and card into ``out``; with ``export`` to the shipped ones, too, and the manifest."""
    from grasp_bench.learning.training.card import provenance
    from grasp_bench.learning.training.kept import keep, ship

    facts = provenance(trained, config, scenes, data)
    write_whole(out / TRAINING, (json.dumps(facts, indent=1, ensure_ascii=False) + "\n").encode())
    made = WeightsFile(out / f"{config.network}.safetensors", config.network)
    keep(trained.network, made, facts)
    return (ship(made) if export else made).path
