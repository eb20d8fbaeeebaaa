"""The inside of a worker process: what all its trials share, and one trial after the other."""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from grasp_bench.execution.protocol import Answer, Round, failed
from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors import load_predictor
from grasp_bench.predictors.guard import catching
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.predictors.shipped import SHIPPED
from grasp_bench.runs.jobs import Job, Settings
from grasp_bench.runs.record import Timings
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.system import interrupts
from grasp_bench.system.texts import raised, whole_traceback

if TYPE_CHECKING:
    from grasp_bench.trials.attempt import Table
    from grasp_bench.trials.watching import Watch
    from grasp_bench.trials.workcell import Workcell

_predictors: dict[str, Predictor] = {}
_broken: dict[str, str] = {}
"""Why a predictor could not be loaded, by its name."""
_loading: list[threading.Thread] = []
"""The thread that loads predictors, until somebody has waited for it."""
_run: dict[str, Any] = {}
"""What the trials of one run share, and its settings."""


class NotStarted(Exception):  # noqa: N818 - it is a worker's state that travels to the parent
    """A worker could not load what its trials share."""


def import_all() -> None:
    """Import what every trial needs."""
    import cv2

    import grasp_bench.trials.job
    import grasp_bench.trials.shared  # noqa: F401

    cv2.setNumThreads(1)


def load(predictors: Sequence[str], early: bool = False) -> None:
    """Load predictors by name; what is wrong with one is told by its first trial.

    Shipped ones are loaded beside the first trial, which does not need them before its picture is taken.
    Other people's may take long, and the time of no trial counts it.
    """
    shipped = [n for n in predictors if n in SHIPPED]
    if not early:
        for name in predictors:
            if name not in shipped:
                _load(name)

    def load_shipped() -> None:
        for name in shipped:
            _load(name)
        gc.freeze()  # modules, and what all trials share, are no garbage
        gc.enable()

    _loading.append(threading.Thread(target=load_shipped, daemon=True, name="load-predictors"))
    _loading[0].start()


def _load(name: str) -> None:
    try:
        _predictors[name] = load_predictor(name)
    except BaseException as error:  # an initializer that raises would only be started again, for ever
        _broken[name] = raised(error)


def do(settings: Settings, job: Job, how: Callable[..., Answer] | None = None) -> tuple[Answer, ...]:
    """Do one trial with each predictor of ``job``; NotStarted when this worker could not start.

    Args:
        how: does it, given job, settings, catalog, workcell and predictor; by default :func:`attempt`.
    """
    if settings != _run.get("settings"):
        try:
            _enter(settings)
        except Exception as error:
            raise NotStarted(raised(error)) from error
    catalog, cell = _run["catalog"], _run["cell"]
    names = job.predictors if isinstance(job, Round) else (settings.predictor,)
    table = None
    if how is None and (len(names) > 1 or _loading) and settings.scenario.clutter is None:
        table = _shared(cell, catalog, job, settings.seed, ahead=bool(_loading))
    while _loading:
        _loading.pop().join()
    for name in names:
        if name not in _predictors:
            raise NotStarted(_broken.get(name, f"{name} was not loaded"))
    do_one = how or partial(attempt, table=table)
    return tuple(do_one(job, replace(settings, predictor=n), catalog, cell, _predictors[n]) for n in names)


def _shared(cell: Workcell, catalog: Catalog, job: Job, seed: int, ahead: bool) -> Table | None:
    """Return what all who try a trial find, for ``ahead`` with its picture taken; None where that fails.

    Then each finds out by itself what is wrong, and records it.
    """
    from grasp_bench.trials.shared import SharedTable

    try:
        shared = SharedTable(cell, catalog.load(job.object), job.attempt, seed)
        return shared.prepared() if ahead else shared.table
    except Exception:
        return None


def _enter(settings: Settings) -> None:
    from grasp_bench.trials.workcell import Workcell

    _run.clear()
    _run.update(
        settings=settings,
        catalog=Catalog(settings.objects),
        cell=Workcell(settings.scenario, settings.renderer),
    )


def attempt(
    job: Job,
    settings: Settings,
    catalog: Catalog,
    cell: Workcell,
    predictor: Predictor,
    table: Table | None = None,
    raises: bool = False,
) -> Answer:
    """Do one trial, whose record is an error where anything raises; with ``raises`` that is raised again.

    ``table`` is as in :func:`~grasp_bench.trials.job.do_job`.
    """
    from grasp_bench.trials.job import do_job

    with catching() as faults:
        try:
            done = do_job(cell, catalog, predictor, job, settings.seed, _watch(settings), table)
            record, timings = done.record, done.clock.timings(job.trial)
        except BaseException as error:  # whatever goes wrong belongs to this trial alone
            if interrupts.by_user(error):
                raise
            faults.append(error)
            category = catalog.entries[job.object]["category"]
            record = failed(job, category, settings.seed, Outcome.ERROR, raised(error))
            timings = Timings(trial=job.trial)
    if raises and faults and record.outcome is Outcome.ERROR:
        raise faults[0]
    return Answer(job, record, timings, tuple(map(whole_traceback, faults)), settings.predictor)


def _watch(settings: Settings) -> Watch:
    from grasp_bench.trials.watching import unwatched

    if not settings.keeps:
        return unwatched
    from grasp_bench.media.recorders import recorders_for

    return partial(recorders_for, settings)
