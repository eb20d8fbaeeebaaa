"""Latency of every network on a CPU: batch 1, one thread, eager PyTorch.

    python benchmarks/network_latency.py [--repeats 20]

Networks take turns, so that load from elsewhere meets all of them; medians are printed, and
how many times faster than GR-ConvNet each network is. float32 as built is the comparison (HTC-Grasp
builds itself with channels last, the others do not; the second column gives it to all); bfloat16 beside it
shows what the processor's matrix unit makes of it (it favours wide convolutions).
"""

from __future__ import annotations

import time
from statistics import median
from typing import Annotated

import torch
import typer
from rich.console import Console
from rich.table import Table
from torch import Tensor, nn

from grasp_bench.networks import NETWORKS, build, info, parameter_count

REFERENCE = "gr-convnet"
MODES = ("fp32", "fp32 channels_last", "bf16 channels_last")


def _case(name: str, mode: str) -> tuple[nn.Module, Tensor]:
    x = torch.randn(1, info(name).channels, info(name).crop, info(name).crop)
    network = build(name).eval()
    if "channels_last" not in mode:
        return network, x
    network.to(memory_format=torch.channels_last)  # pyright: ignore[reportCallIssue]
    return network, x.to(memory_format=torch.channels_last)


@torch.inference_mode()
def _seconds(network: nn.Module, x: Tensor, bf16: bool) -> float:
    with torch.autocast("cpu", torch.bfloat16, enabled=bf16):
        began = time.perf_counter()
        network(x)
        return time.perf_counter() - began


def measure(repeats: int, names: list[str] | None = None) -> dict[str, dict[str, float]]:
    """Median milliseconds by mode and network."""
    figures: dict[str, dict[str, float]] = {}
    for mode in MODES:
        cases = {name: _case(name, mode) for name in names or NETWORKS}
        times: dict[str, list[float]] = {name: [] for name in cases}
        for turn in range(repeats + 2):
            for name, (network, x) in cases.items():
                seconds = _seconds(network, x, mode.startswith("bf16"))
                if turn >= 2:  # the first turns allocate memory and choose kernels
                    times[name].append(seconds)
        figures[mode] = {name: 1000 * median(values) for name, values in times.items()}
    return figures


def main(
    repeats: Annotated[int, typer.Option(help="Timed forward passes of each network.", min=1)] = 20,
) -> None:
    """Print a table of latencies."""
    torch.set_num_threads(1)
    figures = measure(repeats)
    table = Table(title=f"Batch 1, 224×224, 1 thread, median of {repeats}, torch {torch.__version__}")
    table.add_column("network")
    table.add_column("parameters", justify="right")
    for mode in MODES:
        table.add_column(f"{mode}\nms", justify="right")
        table.add_column(f"× {REFERENCE}", justify="right")
    for name in NETWORKS:
        cells = [name, f"{parameter_count(build(name)):,}"]
        for mode in MODES:
            ms = figures[mode][name]
            cells += [f"{ms:.1f}", f"{figures[mode][REFERENCE] / ms:.1f}"]
        table.add_row(*cells)
    Console(width=120).print(table)


if __name__ == "__main__":
    typer.run(main)
