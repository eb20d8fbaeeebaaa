"""What workers, Ray and large runs cost: ``python benchmarks/scaling.py [--trials 120]``.

The same run with one worker process, with as many as there are cores, with two and four times as many, and by
Ray where that is installed: seconds on the clock and of the processors, in turn. Then the bytes that a trial
leaves on disk, and what ``grasp-bench report`` takes for made-up runs. ``docs/scaling.md`` is from it.
"""

from __future__ import annotations

import argparse
import importlib.util
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from harness_cost import write_part
from rich.console import Console
from rich.table import Table
from wall_time import run

from grasp_bench.runs.jobs import WHOLE
from grasp_bench.system.machine import usable_cores

FORMATS = ("json", "html")


def report_seconds(folder: Path, fmt: str) -> float:
    """Seconds of ``grasp-bench report`` on a run, as a user would call it."""
    out = folder.parent / f"report.{fmt}"
    command = [sys.executable, "-m", "grasp_bench.cli", "report", str(folder), "--format", fmt]
    command += ["--out", str(out)]
    start = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=120)
    parser.add_argument("--predictor", default="htc-grasp")
    parser.add_argument("--records", type=int, nargs="*", default=[1_000, 10_000, 100_000])
    args = parser.parse_args()
    console, cores = Console(), usable_cores()
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        run(
            args.predictor, args.trials, cores, home / "warm"
        )  # compiles scenes that are not in the cache yet
        table = Table(title=f"{args.trials} trials of {args.predictor}, start-up included, {cores} cores")
        for column in ("How", "Workers", "Wall s", "Processor s", "Wall against processes"):
            table.add_column(column, justify="left" if column == "How" else "right")
        ways = [("process", n) for n in (1, cores, 2 * cores, 4 * cores)]
        if importlib.util.find_spec("ray"):
            ways.append(("ray", cores))
        taken = {(how, n): run(args.predictor, args.trials, n, home / f"{how}-{n}", how) for how, n in ways}
        usual = taken["process", cores][0]
        for (how, n), (wall, busy) in taken.items():
            table.add_row(how, str(n), f"{wall:.1f}", f"{busy:.1f}", f"{wall / usual:.2f}")
        console.print(table)
        left = sum(p.stat().st_size for p in (home / "warm").rglob("*") if p.is_file())
        console.print(f"On disk: {left / args.trials / 1000:.2f} kB a trial.")
        table = Table(title="grasp-bench report on a run of made-up records")
        for column in ("Records", *(f"{f} s" for f in FORMATS)):
            table.add_column(column, justify="right")
        for count in args.records:
            folder = home / f"records-{count}"
            write_part(folder, count, WHOLE)
            table.add_row(f"{count:,}", *(f"{report_seconds(folder, f):.1f}" for f in FORMATS))
        console.print(table)


if __name__ == "__main__":
    main()
