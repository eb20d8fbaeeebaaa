"""What a try of a grasp and a training scene cost: ``python benchmarks/synth.py --before OLDER_CHECKOUT``.

Every grasp of some scenes is tried briefly, as ``data synth`` does, and to its end: processor time of both,
and how often they agree. Where they do not, it is tried to its end again at half the time step. With
``--before``, ``data synth`` of that checkout and of this one run in turn, start-up included.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import ClassVar

import cv2
import numpy as np

from grasp_bench.learning.data import synthetic
from grasp_bench.scene.brief import BriefTries
from grasp_bench.scene.floating import QUICK
from grasp_bench.system.arrays import Floats

HERE = Path(__file__).resolve().parents[1]
SYNTH = "from grasp_bench.cli import main; main()"


class Both(BriefTries):
    """Tries each grasp twice, and notes processor time and (M, 3) verdicts: briefly, to the end, and at half
    the time step or, where the first two agree, what they say."""

    said: ClassVar[list[tuple[bool, bool, bool]]] = []
    spent: ClassVar[Floats] = np.zeros(2)

    def holds(self, tip: Floats, yaw: float, opening: float) -> bool:
        """Return what the full try says, with which scenes go on."""
        start = time.process_time()
        brief = super().holds(tip, yaw, opening)
        middle = time.process_time()
        full = self._to_the_end(tip, yaw, opening)
        self.spent[:] += middle - start, time.process_time() - middle
        finer = full
        if brief != full:
            option = self._gripper.model.opt
            option.timestep /= 2
            finer = self._to_the_end(tip, yaw, opening)
            option.timestep *= 2
        self.said.append((brief, full, finer))
        return full

    def _to_the_end(self, tip: Floats, yaw: float, opening: float) -> bool:
        return self._gripper.attempt(self._state, tip, yaw, opening, QUICK).held


def tries(seed: int, scenes: int) -> None:
    """Compare brief tries with full ones."""
    cv2.setNumThreads(1)
    synthetic.BriefTries = Both
    synthetic.make_scene(seed, scenes, synthetic.SynthConfig())  # imports and caches
    Both.said.clear()
    Both.spent[:] = 0
    start = time.process_time()
    for index in range(scenes):
        synthetic.make_scene(seed, index, synthetic.SynthConfig())
    total = time.process_time() - start
    brief, full, finer = np.array(Both.said).T
    count = len(full)
    cost = 1000 * Both.spent / count
    print(f"{count} tries of {scenes} scenes, {np.mean(full):.1%} of them held to the end")
    print(f"agree: {np.sum(brief == full)} = {np.mean(brief == full):.2%}")
    for name, which in (("briefly", brief & ~full), ("to the end", ~brief & full)):
        print(
            f"hold only when tried {name}: {which.sum()}; at half the time step {finer[which].sum()} of these"
        )
    print(f"a try: {cost[0]:.2f} ms briefly, {cost[1]:.2f} ms to the end, ratio {cost[1] / cost[0]:.2f}")
    print(f"a scene besides tries: {1000 * (total - Both.spent.sum()) / scenes:.0f} ms (nothing written)")


def synth(checkout: Path, seed: int, scenes: int, workers: int) -> tuple[float, float]:
    """Run ``data synth`` of a checkout; return wall and processor time a scene [s]."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["data", "synth", "--out", f"{folder}/made", "--scenes", str(scenes), "--seed", str(seed)]
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run(
            [sys.executable, "-c", SYNTH, *command, "--workers", str(workers)],
            env=os.environ | {"PYTHONPATH": str(checkout)},
            cwd=folder,
            check=True,
            stdout=subprocess.DEVNULL,
        )
        wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return wall / scenes, spent / scenes


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=50)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--before", type=Path, help="checkout of an older state to compare with")
    parser.add_argument("--rounds", type=int, default=3, help="runs of each checkout, in turn")
    parser.add_argument("--workers", type=int, default=1, help="of data synth")
    args = parser.parse_args()
    tries(args.seed, args.scenes)
    trees = {"after": HERE} if args.before is None else {"before": args.before.resolve(), "after": HERE}
    figures = np.array(
        [
            [synth(tree, args.seed, args.scenes, args.workers) for tree in trees.values()]
            for _ in range(args.rounds)
        ]
    )
    wall, spent = np.median(figures, axis=0).T
    for name, seconds, processor in zip(trees, wall, spent, strict=True):
        print(
            f"{name:<7}{3600 / seconds:>8.0f} scenes an hour, --workers {args.workers}, "
            f"{1000 * processor:.0f} ms of processor time a scene"
        )
    if args.before is not None:
        print(f"ratio of processor time {spent[0] / spent[1]:.2f}, of wall time {wall[0] / wall[1]:.2f}")


if __name__ == "__main__":
    main()
