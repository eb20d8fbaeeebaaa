"""How much of a run is physics: ``python benchmarks/physics_share.py [--trials 18] [--predictor NAME]``.

Runs trials in this process with one thread, recording every command; then repeats the same
steps with bare ``mj_step``. Prints seconds by phase, and bare stepping over busy time.
"""

from __future__ import annotations

import argparse
import os
import time
from itertools import pairwise
from typing import Any

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"

from grasp_bench.system.graphics import without_gl  # noqa: E402

without_gl()

import cv2  # noqa: E402
import mujoco  # noqa: E402
import numpy as np  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.table import Table  # noqa: E402

from grasp_bench.objects.catalog import Catalog  # noqa: E402
from grasp_bench.predictors import load_predictor  # noqa: E402
from grasp_bench.runs.jobs import spread  # noqa: E402
from grasp_bench.scenario.reading import load_scenario  # noqa: E402
from grasp_bench.scene import world as world_module  # noqa: E402
from grasp_bench.scene.world import ROLLOUT  # noqa: E402
from grasp_bench.trials.trial import run_trial  # noqa: E402
from grasp_bench.trials.workcell import Workcell  # noqa: E402


class Recorder:
    """Stands in for the ``mujoco`` module and for ``ROLLOUT`` in ``world``, and remembers every command."""

    def __init__(self) -> None:
        self.tape: list[tuple[Any, int, tuple[int, int]]] = []
        self.start: Any = None

    def __getattr__(self, name: str) -> Any:
        return getattr(mujoco, name)

    def mj_step(self, model: mujoco.MjModel, data: mujoco.MjData, count: int) -> None:
        """Step, and remember."""
        if self.start is None:
            self.start = (model, data.qpos.copy(), data.qvel.copy())
        self.tape.append((data.ctrl.copy(), count, _options(model)))
        mujoco.mj_step(model, data, count)

    def rollout(self, models: Any, datas: Any, state: Any, controls: Any, **options: Any) -> None:
        """Roll out, and remember."""
        (model,), (data,), (ctrls,) = models, datas, controls
        if self.start is None:
            self.start = (model, data.qpos.copy(), data.qvel.copy())
        starts = [0, *(np.flatnonzero((ctrls[1:] != ctrls[:-1]).any(1)) + 1), len(ctrls)]
        self.tape += [(ctrls[a], int(b - a), _options(model)) for a, b in pairwise(starts)]
        ROLLOUT.rollout(models, datas, state, controls, **options)

    def replay(self) -> tuple[float, int]:
        """Seconds and steps of the same commands without anything else; forgets them."""
        model, qpos, qvel = self.start
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = qpos, qvel
        start = time.perf_counter()
        for ctrl, count, (model.opt.noslip_iterations, model.opt.enableflags) in self.tape:
            data.ctrl[:] = ctrl
            mujoco.mj_step(model, data, count)
        seconds = time.perf_counter() - start
        steps = sum(count for _, count, _ in self.tape)
        self.tape, self.start = [], None
        return seconds, steps


def _options(model: mujoco.MjModel) -> tuple[int, int]:
    """What a trial changes of a model between steps: no-slip iterations, and whether resting things sleep."""
    return model.opt.noslip_iterations, model.opt.enableflags


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=18)
    parser.add_argument("--predictor", default="htc-grasp")
    args = parser.parse_args()
    cv2.setNumThreads(1)
    scenario, catalog = load_scenario("table4"), Catalog()
    every = max(1, len(catalog.names) // args.trials)
    predictor, cell = load_predictor(args.predictor), Workcell(scenario)
    recorder = Recorder()
    phases: dict[str, float] = {}
    busy = bare = 0.0
    steps = 0
    names = catalog.names[::every]
    for warm, jobs in ((True, spread(names, 2)), (False, spread(names, args.trials))):
        for job in jobs:
            model = catalog.load(job.object)
            world_module.mujoco = recorder if not warm else mujoco
            world_module.ROLLOUT = recorder if not warm else ROLLOUT
            start = time.perf_counter()
            done = run_trial(cell, model, predictor, trial=job.trial, attempt=job.attempt, seed=0)
            if warm:
                continue
            busy += time.perf_counter() - start
            for name, seconds in done.clock.seconds.items():
                phases[name] = phases.get(name, 0.0) + seconds
            seconds, count = recorder.replay()
            bare += seconds
            steps += count
    table = Table(title=f"{args.trials} trials with {args.predictor}, one thread", header_style="bold")
    for name in ("Phase", "ms a trial", "Share"):
        table.add_column(name, justify="left" if name == "Phase" else "right")
    for name, seconds in phases.items():
        table.add_row(name, f"{1000 * seconds / args.trials:.1f}", f"{seconds / busy:.1%}")
    table.add_section()
    table.add_row("all (busy)", f"{1000 * busy / args.trials:.1f}", "100 %")
    table.add_row("bare mj_step, same steps", f"{1000 * bare / args.trials:.1f}", f"{bare / busy:.1%}")
    Console().print(table)
    print(f"{steps} steps, {1e6 * bare / steps:.1f} µs a bare step; physics share {bare / busy:.1%}")


if __name__ == "__main__":
    main()
