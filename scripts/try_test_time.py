"""Measures what can be done with maps at test time: ``python scripts/try_test_time.py htc-grasp``.

Each way picks one grasp a held-out scene, which is carried out in physics as predicted, and is compared with
the network as it is, scene by scene. Prints the table of docs/results.md. Openings are those of the network
itself, before any calibration.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from grasp_bench.grasps import Grasp
from grasp_bench.learning.training.held_out import held_out_from
from grasp_bench.networks.encoding import maps_from_output, to_input
from grasp_bench.networks.registry import info, input_kind
from grasp_bench.networks.store import stored_input
from grasp_bench.networks.weights import load
from grasp_bench.report.tables import TextTable, markdown
from grasp_bench.runs.statistics import mcnemar

FIRST = 20_000
"""First of the held-out scenes: neither validated nor calibrated on."""

Maps = NDArray[np.float32]
Network = Callable[[Maps], Maps]


def mirrored(network: Network, x: Maps) -> Maps:
    """Ask about the mirror image; the angle's sine changes its sign."""
    quality, sin2, cos2, width = network(x[:, :, ::-1])[:, :, ::-1]
    return np.stack([quality, -sin2, cos2, width])


def turned(network: Network, x: Maps, quarters: int) -> Maps:
    """Ask about the picture turned by quarters; twice the angle turns by halves."""
    quality, sin2, cos2, width = np.rot90(network(np.rot90(x, quarters, (1, 2))), -quarters, (1, 2))
    sign = -1 if quarters % 2 else 1
    return np.stack([quality, sign * sin2, sign * cos2, width])


def best(maps: Maps, sigma: float = 2.0, wider: float = 0.0) -> list[Grasp]:
    """Return the best grasp of maps (4, H, W), opened ``wider`` px more."""
    found = maps_from_output(torch.from_numpy(maps)).smoothed(sigma).peaks(1)
    return [replace(grasp, width=grasp.width + wider) for grasp in found]


def ways(network: Network, x: Maps) -> dict[str, list[Grasp]]:
    """Return the grasp that each way picks of an input (C, H, W)."""
    own = network(x)
    views = np.stack([own, *(turned(network, x, k) for k in (1, 2, 3))])
    mean = views.mean(0)
    agreed = np.stack([views[:, 0].min(0), *mean[1:]])
    return {
        "as it is": best(own),
        **{f"opened {wider} px wider": best(own, wider=wider) for wider in (3, 6, 9, 12)},
        **{f"maps smoothed by {sigma:g} px instead of 2": best(own, sigma) for sigma in (1.0, 3.0, 4.0)},
        "mean with the mirror image (2 passes)": best(np.stack([own, mirrored(network, x)]).mean(0)),
        "mean of four quarter turns (4 passes)": best(mean),
        "least quality of four quarter turns (4 passes)": best(agreed),
        "mean of four quarter turns, 6 px wider": best(mean, wider=6),
    }


def main() -> None:
    """Measure and print, as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("network")
    parser.add_argument("--weights", type=Path)
    parser.add_argument("--scenes", type=int, default=200)
    asked = parser.parse_args()
    torch.set_num_threads(1)
    module, metadata = load(asked.network, asked.weights)
    kind = input_kind(asked.network, stored_input(metadata))

    @torch.inference_mode()
    def network(x: Maps) -> Maps:
        return module(torch.from_numpy(np.ascontiguousarray(x))[None])[0].numpy()

    held: dict[str, list[bool]] = {}
    for scene in held_out_from(FIRST, asked.scenes, info(asked.network).crop):
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
