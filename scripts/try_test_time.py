"""Measures what can be done with maps at test time: ``python scripts/try_test_time.py htc-grasp``.

Each way picks one grasp a held-out scene, which is carried out in physics as predicted, and is compared with
the network as it is, scene by scene. Prints the table of docs/results.md. Openings are those of the network
itself, before any calibration.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from grasp_bench.grasps import Grasp
from grasp_bench.learning.training.held_out import held_out_from
from grasp_bench.networks.encoding import maps_from_output, to_input
from grasp_bench.networks.registry import info, input_kind
from grasp_bench.networks.store import stored_input
from grasp_bench.networks.symmetries import SYMMETRIES, answers
from grasp_bench.networks.weights import load
from grasp_bench.report.tables import TextTable, markdown
from grasp_bench.runs.statistics import mcnemar

FIRST = 20_000
"""First of the held-out scenes: neither validated nor calibrated on."""

Maps = NDArray[np.float32]


def best(maps: Maps, sigma: float = 2.0, wider: float = 0.0) -> list[Grasp]:
    """Return the best grasp of maps (4, H, W), opened ``wider`` px more."""
    found = maps_from_output(torch.from_numpy(maps)).smoothed(sigma).peaks(1)
    return [replace(grasp, width=grasp.width + wider) for grasp in found]


def ways(network: nn.Module, x: Maps) -> dict[str, list[Grasp]]:
    """Return the grasp that each way picks of an input (C, S, S)."""
    with torch.inference_mode():
        views = torch.cat(answers(network, torch.from_numpy(x)[None], SYMMETRIES)).numpy()
    own, turned = views[0], views[:4]
    mean = turned.mean(0)
    agreed = np.stack([turned[:, 0].min(0), *mean[1:]])
    return {
        "as it is": best(own),
        **{f"opened {wider} px wider": best(own, wider=wider) for wider in (3, 6, 9, 12)},
        **{f"maps smoothed by {sigma:g} px instead of 2": best(own, sigma) for sigma in (1.0, 3.0, 4.0)},
        "mean with the mirror image (2 passes)": best(views[[0, 4]].mean(0)),
        "mean of half turn and mirror images (4 passes)": best(views[[0, 2, 4, 6]].mean(0)),
        "mean of four quarter turns (4 passes)": best(mean),
        "least quality of four quarter turns (4 passes)": best(agreed),
        "mean of all eight symmetries (8 passes)": best(views.mean(0)),
        "mean of four quarter turns, 6 px wider": best(mean, wider=6),
    }


def main() -> None:
    """Measure and print, as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("network")
    parser.add_argument("--weights", type=Path)
    parser.add_argument("--scenes", type=int, default=200)
    options = parser.parse_args()
    torch.set_num_threads(1)
    network, metadata = load(options.network, options.weights)
    kind = input_kind(options.network, stored_input(metadata))

    held: dict[str, list[bool]] = {}
    for scene in held_out_from(FIRST, options.scenes, info(options.network).crop):
        x = to_input(scene.image.rgb, scene.image.depth, kind)
        for way, grasps in ways(network, x).items():
            held.setdefault(way, []).append(bool(grasps) and scene.holds(grasps[0]))
    own = np.array(held["as it is"])
    rows = []
    for way, outcomes in held.items():
        won = np.array(outcomes)
        gained, lost = int((won & ~own).sum()), int((own & ~won).sum())
        rows.append([way, f"{won.sum()}/{len(won)}", str(gained), str(lost), f"{mcnemar(gained, lost):.2g}"])
    print(
        markdown(
            [
                TextTable(
                    "What the maps give at test time", ["way", "held", "gained", "lost", "p"], rows, level=4
                )
            ]
        )
    )


if __name__ == "__main__":
    main()
