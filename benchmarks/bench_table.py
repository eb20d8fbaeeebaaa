"""What many predictors on the same trials cost: ``python benchmarks/bench_table.py TREE [TREE …]``.

Runs ``grasp-bench bench-table`` of each checkout in turn, into fresh folders, and prints seconds on the clock
and of the processors, and the ratio to the first tree.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def run(tree: Path, predictors: str, trials: int) -> tuple[float, float]:
    """Seconds of wall and of processor time of one comparison."""
    with tempfile.TemporaryDirectory() as name:
        command = [
            sys.executable,
            "-m",
            "grasp_bench.cli",
            "bench-table",
            "--folder",
            str(Path(name) / "bench"),
        ]
        command += ["--predictors", predictors, "--trials", str(trials), "--format", "json"]
        before, start = os.times(), time.perf_counter()
        environment = os.environ | {"PYTHONPATH": str(tree)}
        quiet = subprocess.DEVNULL
        subprocess.run(command, cwd=tree, env=environment, check=True, stdout=quiet, stderr=quiet)
        wall, after = time.perf_counter() - start, os.times()
    busy = after.children_user + after.children_system - before.children_user - before.children_system
    return wall, busy


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trees", nargs="+", type=Path)
    parser.add_argument("--predictors", default="htc-grasp,gg-cnn,htc-grasp-no-ca,antipodal,oracle")
    parser.add_argument("--trials", type=int, default=20)
    args = parser.parse_args()
    first: tuple[float, float] | None = None
    for tree in args.trees:
        wall, busy = run(tree.resolve(), args.predictors, args.trials)
        first = first or (wall, busy)
        shares = f"{wall / first[0]:.2f} and {busy / first[1]:.2f} of the first"
        print(f"{tree}: {wall:.1f} s, {busy:.1f} s of processors; {shares}", flush=True)


if __name__ == "__main__":
    main()
