"""A trial of a run, as its scenario says: an attempt at one object, or an episode of clutter."""

from __future__ import annotations

from dataclasses import dataclass

from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.runs.jobs import Job
from grasp_bench.runs.record import TrialRecord
from grasp_bench.trials.attempt import Table
from grasp_bench.trials.clock import Clock
from grasp_bench.trials.episode import run_episode
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.watching import Watch, unwatched, watched
from grasp_bench.trials.workcell import Workcell


@dataclass(frozen=True)
class Finished:
    """A finished trial: its record, and the seconds of each phase."""

    record: TrialRecord
    clock: Clock


def do_job(
    cell: Workcell,
    catalog: Catalog,
    predictor: Predictor,
    job: Job,
    seed: int,
    watch: Watch = unwatched,
    table: Table | None = None,
) -> Finished:
    """Do a trial of a run.

    Args:
        job: the trial's number, object and attempt.
        seed: the run's seed.
        watch: gives watchers for pictures, films and logs.
        table: what the trial on one object finds, where others find it, too; by default its own.
    """
    if cell.scenario.clutter is not None:
        clock = Clock()
        record = run_episode(cell, catalog, predictor, job, seed, clock, watch)
        return Finished(record, clock)
    model = catalog.load(job.object)
    done = watched(
        watch(None),
        predictor,
        lambda watcher: run_trial(
            cell,
            model,
            predictor,
            trial=job.trial,
            attempt=job.attempt,
            seed=seed,
            observer=watcher,
            table=table,
        ),
    )
    return Finished(done.record, done.clock)
