"""Latency of every network on a CPU and on a GPU, in one run.

    python benchmarks/latency.py [--repeats 20] [--threads 1 --threads 2] [--engine openvino] [--markdown]

All cases (network, precision, engine, threads) take turns, so that load from elsewhere meets all of
them alike; medians are printed, and how many times faster than GR-ConvNet and than TF-Grasp each network
is, fastest first, beside what the HTC-Grasp paper's Table 1 says of its own, on other hardware.

On the CPU, batch 1: ``fp32`` is eager PyTorch with each network as it is built (HTC-Grasp builds itself with
channels last, the others do not), ``fp32 cl`` gives channels last to all, ``bf16 cl`` is autocast to bfloat16
besides, and ``folded cl`` is float32 as trials use it, without batch norms.
Engines are optional: ``pip install 'grasp-bench[engines]'``.

On the GPU, batches of 1 and 32, as trials use them: ``fp32`` (with PyTorch's defaults, which let convolutions
round to TF32) and ``bf16``, called from Python, and replayed as a CUDA graph. A batch's time is
that of all its images, until the GPU has finished.
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

from grasp_bench.errors import GraspBenchError
from grasp_bench.networks.folding import folded
from grasp_bench.networks.registry import NETWORKS, build, info, parameter_count, standing_for
from grasp_bench.report.paper import TABLE_1
from grasp_bench.report.tables import TextTable, markdown, show

PRINTED = {n: row.milliseconds for row in TABLE_1 if row.milliseconds for n in standing_for(1, row.method)}
"""Milliseconds in the HTC-Grasp paper's Table 1."""
REFERENCES = ("gr-convnet", "tf-grasp")
"""Networks compared with."""
PLAIN = "fp32 cl"
"""Mode in which networks are compared, where it is measured: all have channels last."""
EAGER = ("fp32", PLAIN, "folded cl", "bf16 cl")
BATCHES = (1, 32)
"""Images at a time on a GPU."""
ENGINE_MODES = ("f32", "bf16")
Case = tuple[int, str, str]
"""Threads or images at a time, mode, network."""
Run = Callable[[], object]


class Engine(StrEnum):
    """What runs the networks besides PyTorch."""

    OPENVINO = "openvino"


def eager(name: str, mode: str) -> Run:
    """One forward pass in PyTorch."""
    x = torch.randn(1, info(name).channels, info(name).crop, info(name).crop)
    network = build(name).eval()
    if mode.startswith("folded"):
        network = folded(network)
    if mode != "fp32":
        network.to(memory_format=torch.channels_last)  # pyright: ignore[reportCallIssue]
        x = x.to(memory_format=torch.channels_last)

    @torch.inference_mode()
    def run() -> object:
        with torch.autocast("cpu", torch.bfloat16, enabled=mode.startswith("bf16")):
            return network(x)

    return run


def modes_of(device: torch.device) -> list[str]:
    """What can be measured on a device: graphs are CUDA's."""
    return ["fp32", "bf16"] + ["fp32 graph", "bf16 graph"] * (device.type == "cuda")


def on_device(name: str, mode: str, batch: int, device: torch.device) -> Run:
    """One forward pass of ``batch`` images on any device; it has ended when the call returns."""
    network = folded(build(name).eval()).to(device).to(memory_format=torch.channels_last)  # pyright: ignore[reportCallIssue]
    x = torch.randn(batch, info(name).channels, info(name).crop, info(name).crop, device=device)
    x = x.to(memory_format=torch.channels_last)
    graphed = mode.endswith("graph")

    @torch.inference_mode()
    def run() -> object:
        # A graph that used cached casts of the weights would outlive them.
        low = mode.startswith("bf16")
        with torch.autocast(device.type, torch.bfloat16, enabled=low, cache_enabled=not graphed):
            return network(x)

    once = _captured(run) if graphed else run

    def finished() -> object:
        output = once()
        if device.type == "cuda":
            torch.cuda.synchronize(device)
        return output

    return finished


def _captured(run: Run) -> Run:
    """The same work as a CUDA graph."""
    aside = torch.cuda.Stream()
    aside.wait_stream(torch.cuda.current_stream())
    with torch.cuda.stream(aside):  # kernels are chosen before anything is captured
        for _ in range(3):
            run()
    torch.cuda.current_stream().wait_stream(aside)
    graph = torch.cuda.CUDAGraph()
    with torch.cuda.graph(graph):
        output = run()

    def replay() -> object:
        graph.replay()
        return output

    return replay


def missing_cuda() -> str | None:
    """What the GPU's part needs and does not find here; None where it can be measured."""
    if torch.cuda.is_available():
        return None
    if torch.version.cuda is None:
        return f"a PyTorch built for CUDA (this is {torch.__version__}; see pytorch.org) and an NVIDIA GPU"
    return f"an NVIDIA GPU with a driver for CUDA {torch.version.cuda}; PyTorch sees none"


def measure_on(
    device: torch.device, names: list[str], repeats: int, batches: tuple[int, ...] = BATCHES
) -> dict[Case, float]:
    """Median milliseconds of each case on one device; networks and modes take turns."""
    figures: dict[Case, float] = {}
    for batch in batches:
        cases = {(batch, m, n): on_device(n, m, batch, device) for n in names for m in modes_of(device)}
        figures |= take_turns(cases, repeats)
    return figures


def take_turns(
    cases: dict[Case, Run], repeats: int, before: Callable[[Case], None] = lambda case: None
) -> dict[Case, float]:
    """Median milliseconds of each case; ``before`` is called before every run."""
    times: dict[Case, list[float]] = {case: [] for case in cases}
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for turn in progress.track(range(repeats + 2), description="timing"):
            for case, run in cases.items():
                before(case)
                began = time.perf_counter()
                run()
                if turn >= 2:  # the first turns allocate memory and choose kernels
                    times[case].append(time.perf_counter() - began)
    return {case: 1000 * median(values) for case, values in times.items()}


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
    return take_turns(cases, repeats, lambda case: torch.set_num_threads(case[0]))


def table(figures: dict[Case, float], group: int, what: str, repeats: int) -> TextTable:
    """Milliseconds of each network in each mode, fastest first, and how many times faster than the references
    it is, as measured and as printed.

    Args:
        figures: of all groups.
        group: threads or images at a time.
        what: the group in words.
        repeats: behind each median.
    """
    modes = list(dict.fromkeys(mode for of, mode, _ in figures if of == group))
    compared = PLAIN if PLAIN in modes else modes[0]
    names = {name for of, _, name in figures if of == group}
    rows = []
    for name in sorted(names, key=lambda name: figures[group, compared, name]):
        ms = figures[group, compared, name]
        measured = [f"{figures[group, compared, r] / ms:.1f}" if r in names else "" for r in REFERENCES]
        paper = PRINTED.get(name)
        printed = [f"{PRINTED[r] / paper:.2g}" if paper else "" for r in REFERENCES]
        rows.append(
            [
                name,
                f"{parameter_count(build(name)):,}",
                *(f"{figures[group, mode, name]:.1f}" for mode in modes),
                *measured,
                f"{paper:g}" if paper else "",
                *printed,
            ]
        )
    times = [f"× {name}" for name in REFERENCES]
    head = ("network", "parameters", *modes, *times, "printed", *(f"{t}, printed" for t in times))
    return TextTable(
        f"{what}, milliseconds",
        head,
        rows,
        note=f"Median of {repeats}, torch {torch.__version__}. ×: how many times faster, in {compared}. "
        "Printed: the HTC-Grasp paper's Table 1, each author's milliseconds on hardware of their own.",
        numbers=range(1, len(head)),
        level=4,
    )


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
    as_markdown: Annotated[bool, typer.Option("--markdown", help="For benchmarks/README.md.")] = False,
) -> None:
    """Print a table of latencies for each number of threads, and for each batch on a GPU."""
    counts = threads or [1, 2]
    try:
        names = [name for name in predictor or NETWORKS if info(name)]
        figures = measure(names, counts, repeats, engine)
        on_gpu = {} if missing_cuda() else measure_on(torch.device("cuda"), names, repeats)
    except GraspBenchError as error:
        Console(stderr=True).print(f"[red]{error}")
        raise typer.Exit(2) from None
    tables = [table(figures, count, f"CPU, {count} thread{'s' * (count > 1)}", repeats) for count in counts]
    for batch in dict.fromkeys(case[0] for case in on_gpu):
        what = f"{torch.cuda.get_device_name()}, {batch} image{'s' * (batch > 1)}"
        tables.append(table(on_gpu, batch, what, repeats))
    if as_markdown:
        print(markdown(tables))
    else:
        show(tables, Console(width=170))
    if missing := missing_cuda():
        Console(stderr=True).print(f"Nothing of a GPU: that part needs {missing}.")


if __name__ == "__main__":
    typer.run(main)
