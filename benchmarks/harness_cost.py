"""What the harness itself costs a trial, physics apart: ``python benchmarks/harness_cost.py``.

Made-up records of the usual length are written, read back, put in order and merged from shards;
and jobs that do nothing go through a pool of one worker. Prints processor time of this process a
trial, and what that makes for a million: these parts are done by one process, whatever the
number of workers.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from grasp_bench.execution.processes import WorkerPool
from grasp_bench.execution.protocol import Answer
from grasp_bench.runs.folder import RunFolder, join, write_run
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.jobs import WHOLE, Job, Settings, Shard, spread
from grasp_bench.runs.merge import merge
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.scenario.reading import load_scenario

OBJECTS = [f"object_{i:03}" for i in range(180)]
RUN = {
    "format": 1,
    "predictor": "none",
    "scenario": {"name": "none"},
    "seed": 0,
    "weights": None,
    "objects": {o: {} for o in OBJECTS},
    "versions": {},
    "renderer": "raycast",
}


def record(job: Job) -> TrialRecord:
    """A made-up record as long as a real one."""
    made = {
        "trial": job.trial,
        "object": job.object,
        "category": "thing",
        "seed": 0,
        "outcome": "success",
        "success": True,
        "detail": "",
        "grasp": {"x": 285.061, "y": 236.951, "angle": -1.300328, "width": 53.748, "quality": 0.991},
        "pose": {
            "position": [0.504588, 0.052574, 0.040483],
            "opening": 0.080876,
            "rotation": [[-0.963646, -0.267183, 0.0], [-0.267183, 0.963646, 0.0], [0.0, 0.0, -1.0]],
        },
        "rank": 0,
        "tcp_error": {"position": 0.000137, "angle": 0.000269},
        "lift_height": 0.19993,
        "contact_force": 59.427,
        "sim_steps": 3222,
    }
    return TrialRecord.read(made)


def info(trials: int, shard: Shard = WHOLE) -> RunInfo:
    """What a made-up run says of itself."""
    return RunInfo.read(RUN | {"trials": trials, "shard": None if shard == WHOLE else str(shard)})


def timings(job: Job) -> Timings:
    """Made-up timings."""
    return Timings.read({"trial": job.trial, "plan": 0.1})


class IdlePool(WorkerPool):
    """Workers that load nothing and do nothing."""

    @staticmethod
    def _begin(predictors: tuple[str, ...], early: bool) -> None:
        return

    @staticmethod
    def _do(settings: Settings, job: Job) -> tuple[Answer, ...]:
        return (Answer(job, record(job), Timings(trial=job.trial)),)


def measure(name: str, trials: int, work: Callable[[], object]) -> None:
    """Print what some work costs a trial."""
    processor, wall = time.process_time(), time.perf_counter()
    work()
    processor, wall = time.process_time() - processor, time.perf_counter() - wall
    print(
        f"{name:<44} {1e6 * processor / trials:8.1f} µs {1e6 * wall / trials:8.1f} µs of wall time"
        f" {processor / trials * 1e6 / 60:8.1f} min a million",
        flush=True,
    )


def write_part(folder: Path, trials: int, shard: Shard) -> None:
    """A finished shard, written at once."""
    folder.mkdir()
    write_run(folder / "run.json", info(trials, shard))
    with (folder / "trials.jsonl").open("w") as file:
        for job in spread(OBJECTS, trials, shard):
            file.write(record(job).line() + "\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=100_000, help="records that are read and merged")
    parser.add_argument("--live", type=int, default=2000, help="records that are synced, jobs that are sent")
    args = parser.parse_args()
    settings = Settings(load_scenario("table4"), Path(), "none", 0, "raycast")
    print(f"{'':<44} {'processor':>11}")
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        with RunFolder(home / "live") as folder:
            folder.start(info(args.live))
            jobs = list(spread(OBJECTS, args.live))
            measure(
                "append and sync to disk",
                args.live,
                lambda: [folder.append(record(j), timings(j)) for j in jobs],
            )

        def through_the_pool() -> None:
            source = iter(spread(OBJECTS, args.live))
            with IdlePool(settings, 1, 64 << 30) as pool:
                while True:
                    while pool.room and (job := next(source, None)):
                        pool.submit(job)
                    if not pool.pending:
                        return
                    pool.wait()

        measure("send a job to a worker and take its answer", args.live, through_the_pool)
        for i in range(4):
            write_part(home / f"part{i}", args.trials, Shard(i + 1, 4))
        parts = [home / f"part{i}" for i in range(4)]
        measure("check and merge 4 shards", args.trials, lambda: merge(home / "merged", parts))
        lines = (home / "merged" / "trials.jsonl").read_text().splitlines(keepends=True)
        (home / "merged" / "trials.jsonl").write_text("".join(lines[::-1]))
        target = home / "merged" / "trials.jsonl"
        measure("put in order at the end", args.trials, lambda: join([target], target))
        with RunFolder(home / "merged") as folder:
            run = info(args.trials)
            measure("read and check to resume", args.trials, lambda: folder.start(run))


if __name__ == "__main__":
    import harness_cost  # workers find what they call by its module's name

    harness_cost.main()
