"""``grasp-bench calibrate``: how much wider a network's grasps should open, and how likely they hold."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def calibrate_command(
    predictor: Annotated[str, typer.Argument(help="A network: htc-grasp, gr-convnet, gg-cnn …")],
    weights: Annotated[
        Path | None,
        typer.Option("--weights", help="Its .safetensors file, e.g. of `train`; by default the shipped one."),
    ] = None,
    scenes: Annotated[
        int, typer.Option(min=1, help="Held-out synthetic scenes whose two best grasps are carried out.")
    ] = 200,
) -> None:
    """Calibrate trained weights in physics, once, after the training; the result is stored in the file.

    Openings: networks learn them by their mean error, and too narrow costs more than too wide. Qualities:
    what `run` records is then the probability that the grasp holds as predicted. Neither looks at a
    benchmark object or a real image. A second call begins from the network's own answers again.

    Example: grasp-bench calibrate htc-grasp --weights runs/htc-grasp/htc-grasp.safetensors
    """
    from rich.console import Console

    from grasp_bench.learning.training.calibrate import FIRST, calibrate
    from grasp_bench.learning.training.held_out import held_out_from
    from grasp_bench.learning.training.kept import keep_facts
    from grasp_bench.networks.calibration import KEY
    from grasp_bench.networks.registry import info, input_kind
    from grasp_bench.networks.store import WeightsFile, shipped_file, stored_input
    from grasp_bench.networks.weights import load
    from grasp_bench.system.progress import counting

    console = Console()
    network, metadata = load(predictor, weights)
    file = shipped_file(predictor) if weights is None else WeightsFile(weights, predictor)
    kind, crop = input_kind(predictor, stored_input(metadata)), info(predictor).crop
    with counting(console) as progress:
        task = progress.add_task(predictor, total=scenes, state="held-out scenes")

        def counted():
            for scene in held_out_from(FIRST, scenes, crop):
                yield scene
                progress.advance(task)

        found = calibrate(network, kind, counted())
    keep_facts(file, metadata | {KEY: found.facts()})
    told = found.calibration
    console.print(f"{found}", markup=False)
    console.print(f"Opens {told.widening:g} px wider from now on; {_in_words(told.intercept, told.slope)}.")
    console.print(f"{file.path}", markup=False)


def _in_words(intercept: float | None, slope: float | None) -> str:
    from grasp_bench.grasps import Grasp
    from grasp_bench.networks.calibration import Calibration

    if slope is None:
        return "its qualities say nothing of success and stay as they are"
    judged = Calibration(0.0, intercept, slope).judged
    low, high = (judged(Grasp(0, 0, 0, 1, quality)).quality for quality in (0.2, 0.8))
    return f"a grasp of quality 0.2 holds with probability {low:.2f}, of 0.8 with {high:.2f}"
