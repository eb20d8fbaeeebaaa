"""Seconds until a run's first trial is recorded: ``python benchmarks/start_up.py TREE [TREE …]``.

Each tree is a checkout whose package is run, in turn and once before, so that ratios hold on a busy machine,
too. Unset ``PYTHONDONTWRITEBYTECODE``, or every process compiles the package's source.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def first_trial(tree: Path, predictor: str, workers: int) -> float:
    """Seconds from the start of the command until its first trial is on disk."""
    with tempfile.TemporaryDirectory() as name:
        out = Path(name) / "run"
        command = [sys.executable, "-m", "grasp_bench.cli", "run", "--quiet", "--trials", str(2 * workers)]
        command += ["--predictor", predictor, "--workers", str(workers), "--out", str(out)]
        start = time.perf_counter()
        run = subprocess.Popen(command, cwd=tree, env=os.environ | {"PYTHONPATH": str(tree)})
        path = out / "trials.jsonl"
        while run.poll() is None and not (path.is_file() and path.stat().st_size):
            time.sleep(0.005)
        seconds = time.perf_counter() - start
        if run.wait():
            raise SystemExit(f"the run in {tree} failed")
        return seconds


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trees", nargs="+", type=Path)
    parser.add_argument("--predictor", default="htc-grasp")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--repeats", type=int, default=5)
    args = parser.parse_args()
    trees = [t.resolve() for t in args.trees]
    taken: dict[Path, list[float]] = {t: [] for t in trees}
    for tree in trees:  # byte code and compiled models
        first_trial(tree, args.predictor, args.workers)
    for _ in range(args.repeats):
        for tree in trees:
            taken[tree].append(first_trial(tree, args.predictor, args.workers))
    first = statistics.median(taken[trees[0]])
    for tree, seconds in taken.items():
        middle = statistics.median(seconds)
        print(f"{tree}: {middle:.2f} s (least {min(seconds):.2f}), {middle / first:.2f} of the first")


if __name__ == "__main__":
    main()
