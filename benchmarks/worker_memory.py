"""Does a worker's memory stay flat? ``python benchmarks/worker_memory.py [--trials 2000]``.

One worker process does trials one after the other, as in a run but without being replaced, and
its resident memory is read after each. Prints it every so many trials, and the slope over the
second half, by which a run of any length can be extrapolated.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import psutil

from grasp_bench.system.graphics import LIBRARIES, with_gl, without_gl


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=2000)
    parser.add_argument("--predictor", default="oracle")
    parser.add_argument("--objects", type=int, default=6, help="how many objects take turns")
    parser.add_argument("--renderer", default="raycast")
    parser.add_argument("--image", type=int, default=0, help="width of the image [px]; 0: the scenario's")
    parser.add_argument(
        "--timestep",
        type=float,
        help="of physics [s], the scenario's by default; memory does not depend on it, time does",
    )
    parser.add_argument("--every", type=int, default=100, help="print every so many trials")
    args = parser.parse_args()
    if args.renderer in LIBRARIES:
        with_gl(args.renderer)
    without_gl()
    from grasp_bench.execution.processes import WorkerPool
    from grasp_bench.objects.catalog import Catalog
    from grasp_bench.runs.jobs import Settings, spread
    from grasp_bench.scenario.reading import load_scenario, with_value

    catalog, scenario = Catalog(), load_scenario("table4")
    if args.image:
        camera = scenario.camera.model_copy(update={"width": args.image, "height": args.image * 3 // 4})
        scenario = scenario.model_copy(update={"camera": camera})
    if args.timestep:
        scenario = with_value(scenario, "physics.timestep", args.timestep)
    settings = Settings(scenario, catalog.folder.resolve(), args.predictor, 0, args.renderer)
    names = catalog.names[:: max(1, len(catalog.names) // args.objects)][: args.objects]
    memory: list[float] = []
    start = time.perf_counter()
    with WorkerPool(settings, 1, 64 << 30, recycle=0) as pool:
        for job in spread(names, args.trials):
            pool.submit(job)
            while not pool.wait():
                pass
            memory.append(_worker_mib())
            if job.trial % args.every == 0 or job.trial == args.trials - 1:
                seconds = time.perf_counter() - start
                print(f"{job.trial:>7} trials {memory[-1]:8.1f} MiB {seconds:8.0f} s", flush=True)
    half = np.array(memory[len(memory) // 2 :])
    slope = np.polyfit(np.arange(len(half)), half, 1)[0]
    print(
        f"{args.predictor}, {args.renderer}, {len(names)} objects: {memory[0]:.0f} MiB after one trial, "
        f"{memory[-1]:.0f} MiB after {len(memory)}; {1024 * slope:+.2f} KiB a trial over the second half"
    )


def _worker_mib() -> float:
    """Resident memory of the largest child: the worker."""
    return max(c.memory_info().rss for c in psutil.Process().children()) / 2**20


if __name__ == "__main__":
    main()
