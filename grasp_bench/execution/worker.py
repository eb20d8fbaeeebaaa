"""The inside of a worker process: what all its trials share, and one trial after the other."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from grasp_bench.execution.protocol import Answer, failed
from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors import load_predictor
from grasp_bench.predictors.guard import catching
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.runs.jobs import Job, Settings
from grasp_bench.runs.record import Timings
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.system import interrupts
from grasp_bench.system.machine import THREADS
from grasp_bench.system.spawning import die_with_parent, print_to_stderr
from grasp_bench.system.texts import raised, whole_traceback

if TYPE_CHECKING:
    from grasp_bench.trials.workcell import Workcell

_worker: dict[str, Any] = {}


class NotStarted(Exception):  # noqa: N818 - it is a worker's state that travels to the parent
    """A worker could not load what its trials share."""


def start(settings: Settings) -> None:
    """Load once what all trials of a worker share; the first trial tells what is wrong."""
    for name in THREADS:
        os.environ[name] = "1"
    die_with_parent()
    print_to_stderr()
    try:
        load(settings)
    except BaseException as error:  # an initializer that raises would only be started again, for ever
        _worker["broken"] = raised(error)


def load(settings: Settings) -> None:
    """Load catalog, workcell and predictor."""
    import cv2

    from grasp_bench.trials.workcell import Workcell

    cv2.setNumThreads(1)
    _worker.clear()
    _worker.update(
        settings=settings,
        catalog=Catalog(settings.objects),
        cell=Workcell(settings.scenario, settings.renderer),
        predictor=load_predictor(settings.predictor),
    )


def do(job: Job, how: Callable[..., Answer] | None = None) -> Answer:
    """Do one trial; NotStarted when this worker could not start.

    Args:
        how: does it, given what :func:`attempt` is given, which does by default.
    """
    if "broken" in _worker:
        raise NotStarted(_worker["broken"])
    return (how or attempt)(job, **_worker)


def attempt(job: Job, settings: Settings, catalog: Catalog, cell: Workcell, predictor: Predictor) -> Answer:
    """Do one trial, whose record is an error where anything raises."""
    from grasp_bench.media.recorders import recorders_for
    from grasp_bench.trials.job import do_job

    with catching() as faults:
        try:
            done = do_job(cell, catalog, predictor, job, settings.seed, partial(recorders_for, settings))
            record, timings = done.record, done.clock.timings(job.trial)
        except BaseException as error:  # whatever goes wrong belongs to this trial alone
            if interrupts.by_user(error):
                raise
            faults.append(error)
            category = catalog.entries[job.object]["category"]
            record = failed(job, category, settings.seed, Outcome.ERROR, raised(error))
            timings = Timings(trial=job.trial)
    return Answer(job, record, timings, tuple(map(whole_traceback, faults)))
