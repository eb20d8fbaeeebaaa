"""Latency of every network on a CPU, batch 1, in one run.

    python benchmarks/latency.py [--repeats 20] [--threads 1 --threads 2] [--engine openvino]

All cases (network, precision, engine, threads) take turns, so that load from elsewhere meets all of
them alike; medians are printed, and how many times faster than GR-ConvNet and than TF-Grasp each network
is in the same mode, beside what the HTC-Grasp paper's Table 1 says of its own, on other hardware.

``fp32`` is eager PyTorch with each network as it is built (HTC-Grasp builds itself with channels last,
the others do not), ``fp32 cl`` gives channels last to all, ``bf16 cl`` is autocast to bfloat16 besides.
Engines are optional: ``pip install 'grasp-bench[engines]'``.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable
from enum import StrEnum
from statistics import median
from typing import Annotated, Any

import numpy as np
import torch
import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from grasp_bench.errors import GraspBenchError
from grasp_bench.networks.registry import NETWORKS, build, info, parameter_count, standing_for
from grasp_bench.report.paper import TABLE_1

PRINTED = {n: row.milliseconds for row in TABLE_1 if row.milliseconds for n in standing_for(1, row.method)}
"""Milliseconds in the HTC-Grasp paper's Table 1."""
REFERENCES = {name: PRINTED[name] / PRINTED["htc-grasp"] for name in ("gr-convnet", "tf-grasp")}
"""Networks compared with, and how many times faster than each the paper's HTC-Grasp is (its Table 1)."""
EAGER = ("fp32", "fp32 cl", "bf16 cl")
ENGINE_MODES = ("f32", "bf16")
Case = tuple[int, str, str]
"""Threads, mode, network."""
Run = Callable[[], object]


class Engine(StrEnum):
    """What runs the networks besides PyTorch."""

    OPENVINO = "openvino"


def eager(name: str, mode: str) -> Run:
    """One forward pass in PyTorch."""
    x = torch.randn(1, info(name).channels, info(name).crop, info(name).crop)
    network = build(name).eval()
    if mode != "fp32":
        network.to(memory_format=torch.channels_last)  # pyright: ignore[reportCallIssue]
        x = x.to(memory_format=torch.channels_last)

    @torch.inference_mode()
    def run() -> object:
        with torch.autocast("cpu", torch.bfloat16, enabled=mode.startswith("bf16")):
            return network(x)

    return run


def openvino(name: str, precision: str, threads: int) -> Run:
    """One inference by OpenVINO, whose own default would be bfloat16 where the processor has it.

    Raises:
        GraspBenchError: when OpenVINO is not installed.
    """
    try:
        ov: Any = importlib.import_module("openvino")
    except ImportError:
        raise GraspBenchError("--engine openvino needs it: pip install 'grasp-bench[engines]'.") from None
    x = torch.randn(1, info(name).channels, info(name).crop, info(name).crop)
    converted = ov.convert_model(torch.export.export(build(name).eval(), (x,)))
    compiled = ov.Core().compile_model(
        converted,
        "CPU",
        {
            "INFERENCE_PRECISION_HINT": precision,
            "INFERENCE_NUM_THREADS": threads,
            "PERFORMANCE_HINT": "LATENCY",
        },
    )
    request, values = compiled.create_infer_request(), np.ascontiguousarray(x.numpy())
    return lambda: request.infer([values])


def measure(names: list[str], threads: list[int], repeats: int, engine: Engine | None) -> dict[Case, float]:
    """Median milliseconds of each case."""
    cases: dict[Case, Run] = {}
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("preparing", total=len(names))
        for name in names:
            passes = {mode: eager(name, mode) for mode in EAGER}
            for count in threads:
                cases |= {(count, mode, name): run for mode, run in passes.items()}
                if engine:
                    cases |= {
                        (count, f"{engine.value} {p}", name): openvino(name, p, count) for p in ENGINE_MODES
                    }
            progress.advance(task)
        task = progress.add_task("timing", total=repeats + 2)
        times: dict[Case, list[float]] = {case: [] for case in cases}
        for turn in range(repeats + 2):
            for case, run in cases.items():
                torch.set_num_threads(case[0])
                began = time.perf_counter()
                run()
                if turn >= 2:  # the first turns allocate memory and choose kernels
                    times[case].append(time.perf_counter() - began)
            progress.advance(task)
    return {case: 1000 * median(values) for case, values in times.items()}


def table(figures: dict[Case, float], threads: int, repeats: int) -> Table:
    """Milliseconds of each network in each mode, and how many times faster than the references it is."""
    modes = list(dict.fromkeys(mode for count, mode, _ in figures if count == threads))
    names = list(dict.fromkeys(name for _, _, name in figures))
    shown = Table(
        title=f"{threads} thread{'s' * (threads > 1)}: ms, then × {' and × '.join(REFERENCES)}; "
        f"median of {repeats}, torch {torch.__version__}"
    )
    shown.add_column("network")
    shown.add_column("parameters", justify="right")
    for mode in modes:
        shown.add_column(mode, justify="right")
    for name in names:
        cells = [name, f"{parameter_count(build(name)):,}"]
        for mode in modes:
            ms = figures[threads, mode, name]
            ratios = [figures[threads, mode, r] / ms for r in REFERENCES if r in names]
            cells.append(f"{ms:.1f}" + "".join(f" {ratio:5.1f}×" for ratio in ratios))
        shown.add_row(*cells)
    return shown


def main(
    repeats: Annotated[int, typer.Option(help="Timed forward passes of each case.", min=1)] = 20,
    threads: Annotated[
        list[int] | None, typer.Option(help="Threads, repeatable.", show_default="1 and 2")
    ] = None,
    engine: Annotated[Engine | None, typer.Option(help="Measure this engine besides eager PyTorch.")] = None,
    predictor: Annotated[
        list[str] | None,
        typer.Option(help=f"Network, repeatable: {', '.join(NETWORKS)}.", show_default="all"),
    ] = None,
) -> None:
    """Print a table of latencies for each number of threads."""
    counts = threads or [1, 2]
    try:
        names = [name for name in predictor or NETWORKS if info(name)]
        figures = measure(names, counts, repeats, engine)
    except GraspBenchError as error:
        Console(stderr=True).print(f"[red]{error}")
        raise typer.Exit(2) from None
    console = Console(width=170)
    for count in counts:
        console.print(table(figures, count, repeats))
    paper = ", ".join(f"{ratio:.1f}× {name}" for name, ratio in REFERENCES.items())
    console.print(
        f"HTC-Grasp in its paper: {paper} ({PRINTED['htc-grasp']:g} ms, Table 1; other hardware, other code)."
    )


if __name__ == "__main__":
    typer.run(main)
