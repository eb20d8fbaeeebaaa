"""How long a run takes, start-up included: ``python benchmarks/wall_time.py [--trials 180]``.

Runs the command as a user would, in fresh processes and folders with a warm model cache: one worker and two
in turn, and two trials only, which is mostly start-up. Prints seconds on the clock and of the processors, the
speed-up of the second worker, and the shares of the phases. The table in ``benchmarks/README.md`` is from it.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table


def run(
    predictor: str, trials: int, workers: int, folder: Path, executor: str = "process"
) -> tuple[float, float]:
    """Seconds of wall and of processor time of one run."""
    command = [
        sys.executable,
        "-m",
        "grasp_bench.cli",
        "run",
        "--quiet",
        "--predictor",
        predictor,
        "--trials",
        str(trials),
        "--workers",
        str(workers),
        "--executor",
        executor,
        "--out",
        str(folder),
    ]
    busy, start = _of_children(), time.perf_counter()
    subprocess.run(command, check=True)
    return time.perf_counter() - start, _of_children() - busy


def _of_children() -> float:
    """Processor seconds of all processes that this one started and that have ended."""
    times = os.times()
    return times.children_user + times.children_system


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=180)
    parser.add_argument("--predictor", default="htc-grasp")
    parser.add_argument("--repeats", type=int, default=1)
    args = parser.parse_args()
    console = Console()
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        run(args.predictor, args.trials, 2, home / "warm")  # compiles scenes that are not in the cache yet
        table = Table(title=f"{args.predictor}, load {os.getloadavg()[0]:.1f} at the end")
        for column in ("Trials", "Workers", "Wall s", "Processor s"):
            table.add_column(column, justify="right")
        best: dict[tuple[int, int], float] = {}
        for i in range(args.repeats):
            for trials, workers in ((2, 1), (args.trials, 1), (args.trials, 2)):
                wall, busy = run(args.predictor, trials, workers, home / f"{trials}-{workers}-{i}")
                table.add_row(str(trials), str(workers), f"{wall:.1f}", f"{busy:.1f}")
                best[trials, workers] = min(wall, best.get((trials, workers), wall))
        console.print(table)
        console.print(
            f"two workers are {best[args.trials, 1] / best[args.trials, 2]:.2f}× one; without the "
            f"start-up, {_per_trial(best, args.trials, 1) / _per_trial(best, args.trials, 2):.2f}×"
        )
        phases: dict[str, float] = {}
        for line in (home / f"{args.trials}-1-0" / "timings.jsonl").read_text().splitlines():
            for phase, seconds in json.loads(line).items():
                phases[phase] = phases.get(phase, 0.0) + seconds
        phases.pop("trial")
        total = sum(phases.values())
        console.print(
            "phases with one worker: "
            + ", ".join(
                f"{phase} {1000 * s / args.trials:.0f} ms ({s / total:.0%})" for phase, s in phases.items()
            )
        )


def _per_trial(best: dict[tuple[int, int], float], trials: int, workers: int) -> float:
    return (best[trials, workers] - best[2, 1]) / (trials - 2)


if __name__ == "__main__":
    main()
