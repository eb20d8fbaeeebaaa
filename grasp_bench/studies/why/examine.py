"""One failed trial examined, on a worker process or in this one: all its replays, level by level."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from dataclasses import dataclass, field, replace

from grasp_bench.errors import GraspBenchError
from grasp_bench.execution import worker
from grasp_bench.execution.processes import Processes, WorkerPool
from grasp_bench.execution.protocol import Answer, Fault
from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.replay.verdict import Verdict, verdict
from grasp_bench.runs.jobs import Job, Settings
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.sections import Scenario
from grasp_bench.studies.why.attribution import first_success
from grasp_bench.studies.why.causes import UNCHANGED, Removed, applying, ordered
from grasp_bench.studies.why.counterfactual import Counterfactuals
from grasp_bench.studies.why.journal import Replayed, digest_of
from grasp_bench.system.texts import raised
from grasp_bench.trials.workcell import Workcell

MOST_REPLAYS = 100
"""No trial is done again more often: this bounds the time of a worker."""


@dataclass(frozen=True)
class Question(Job):
    """A failed trial to be examined: its record, and the replays that are known already."""

    stored: TrialRecord
    known: dict[Removed, Replayed] = field(default_factory=dict)


@dataclass(frozen=True)
class Examined(Answer):
    """What replays of a trial gave.

    Attributes:
        new: replays that were done now.
        verdict: how the trial done again as it was compares with its record.
        sets: first sets of causes without which it succeeds.
        tried: number of sets that were tried.
        broken: number of replays that could not be done; they count as not saved.
    """

    new: tuple[Replayed, ...] = ()
    verdict: Verdict = Verdict.DIFFERENT
    sets: tuple[Removed, ...] = ()
    tried: int = 0
    broken: int = 0


def examine(
    job: Question, settings: Settings, catalog: Catalog, cell: Workcell, predictor: Predictor
) -> Examined:
    """Do a failed trial again as it was, and, where it ends as recorded, without causes of its failure."""
    replays = Counterfactuals(cell, catalog.load(job.object), predictor, job, settings.seed)
    known, new = dict(job.known), list[Replayed]()
    job = replace(job, known=known)
    digest = digest_of(job.stored)

    def keep(removed: Removed, outcome: Outcome, seen: Verdict | None = None) -> Replayed:
        done = Replayed(trial=job.trial, without=ordered(removed), outcome=outcome, verdict=seen, of=digest)
        known[removed] = done
        new.append(done)
        return done

    def succeeds(removed: Removed) -> bool:
        done = known.get(removed) or keep(removed, _outcome(replays, removed))
        return done.success

    again = known.get(UNCHANGED)
    if again is None or again.verdict is None:
        record = replays.unchanged()
        again = keep(UNCHANGED, record.outcome, verdict(job.stored, record))
    seen = again.verdict or Verdict.DIFFERENT
    sets, tried = ((), 0)
    if seen is not Verdict.DIFFERENT:
        sets, tried = first_success(applying(settings.scenario), succeeds)
    return _examined(job, seen, sets, tried, tuple(new))


def recalled(job: Question, scenario: Scenario) -> Examined | None:
    """Return what replays of a trial gave where all that are needed are known already, else None."""
    again = job.known.get(UNCHANGED)
    if again is None or again.verdict is None:
        return None
    sets, tried = ((), 0)
    if again.verdict is not Verdict.DIFFERENT:
        try:
            sets, tried = first_success(applying(scenario), lambda removed: job.known[removed].success)
        except KeyError:
            return None
    return _examined(job, again.verdict, sets, tried)


def _examined(
    job: Question, seen: Verdict, sets: tuple[Removed, ...], tried: int, new: tuple[Replayed, ...] = ()
) -> Examined:
    broken = sum(done.outcome is Outcome.ERROR for done in job.known.values())
    timings = Timings(trial=job.trial)
    return Examined(job, job.stored, timings, new=new, verdict=seen, sets=sets, tried=tried, broken=broken)


def _outcome(replays: Counterfactuals, removed: Removed) -> Outcome:
    try:
        return replays.without(removed).outcome
    except Exception:  # one replay that cannot be done saves no trial, and costs no other
        return Outcome.ERROR


def _do(settings: Settings, job: Question) -> tuple[Answer, ...]:
    return worker.do(settings, job, examine)


class _Pool(WorkerPool):
    _do = staticmethod(_do)


class Examiners(Processes):
    """Worker processes that examine failed trials."""

    _pool = _Pool


class ExaminerHere:
    """Examines failed trials in this process, with a predictor that no other can make."""

    def __init__(self, predictor: Predictor) -> None:
        self._predictor = predictor

    def run(self, settings: Settings, jobs: Iterable[Job]) -> Generator[Answer | Fault, None, None]:
        """See :class:`~grasp_bench.execution.protocol.Executor`."""
        catalog, cell = Catalog(settings.objects), Workcell(settings.scenario, settings.renderer)
        for job in jobs:
            assert isinstance(job, Question)
            try:
                yield examine(job, settings, catalog, cell, self._predictor)
            except GraspBenchError as error:
                yield Fault(job, Outcome.ERROR, raised(error))
