"""Many trials: spread over objects, given to an executor, written as they end, resumed when killed."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from grasp_bench.errors import GraspBenchError, PredictorError, ResultsError
from grasp_bench.execution.describe import describe, objects_of
from grasp_bench.execution.executors import make_executor
from grasp_bench.execution.here import Here
from grasp_bench.execution.protocol import Executor, Fault, failed
from grasp_bench.objects.catalog import Catalog
from grasp_bench.objects.difficulty import check_graded
from grasp_bench.objects.fitted import fitted
from grasp_bench.predictors.identity import identify
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.runs.folder import ERRORS, RunFolder
from grasp_bench.runs.jobs import Job, Jobs, Settings
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import check_current
from grasp_bench.system import cache


@dataclass(frozen=True)
class RunSummary:
    """What a call of :func:`run` did.

    Attributes:
        folder: the results.
        resumed, added: number of trials that were found done, and that were done now.
        repaired: whether a torn last line was cut off.
    """

    folder: Path
    resumed: int
    added: int
    repaired: bool


def run(
    settings: Settings,
    jobs: Jobs,
    out: Path,
    workers: int,
    progress: Callable[[TrialRecord, bool], None] = lambda record, resumed: None,
    predictor: Predictor | None = None,
    executor: Executor | None = None,
    raises: bool = False,
) -> RunSummary:
    """Do all ``jobs`` that ``out`` does not hold yet.

    Args:
        settings: settings of the run.
        jobs: all trials of the run.
        out: results folder.
        workers: number of worker processes.
        progress: called with each record, and whether it was there before.
        predictor: used in this process, trial after trial, instead of loading ``settings.predictor``
            on workers; for one that no other process can make.
        executor: carries the trials out; worker processes of this machine by default.
        raises: end with the first trial that is an error; it is done again on resume.

    Raises:
        GraspBenchError: before any trial starts, for anything wrong with the inputs.
        PredictorError: for an error of a trial, where ``raises``; what a ``predictor`` of this process raised
            is raised as it is.
    """
    catalog = check_inputs(settings, jobs)
    implementation = identify(settings.predictor, predictor)
    with RunFolder(out) as folder:
        done = folder.start(describe(settings, jobs, catalog, implementation), owned(out, jobs, progress))
        todo = len(jobs) - len(done)
        if todo:
            chosen = executor or (
                make_executor("process", min(workers, todo)) if predictor is None else Here(predictor, raises)
            )
            left = (j for j in jobs if j.trial not in done)
            with closing(carry_out(settings, left, catalog, chosen, folder.note)) as ended:
                for record, timings in ended:
                    if raises and record.outcome is Outcome.ERROR:
                        raise PredictorError(
                            f"Trial {record.trial} ({record.object}): {record.detail}; "
                            f"see {folder.path / ERRORS}."
                        )
                    folder.append(record, timings)
                    progress(record, False)
        folder.finish()  # also where a run was killed after its last trial, before this
        return RunSummary(out, len(done), todo, folder.repaired)


def check_inputs(settings: Settings, jobs: Jobs) -> Catalog:
    """Return the catalog of a run's objects, every file of which was checked.

    Raises:
        GraspBenchError: for anything wrong with scenario, cache or objects.
    """
    check_current(settings.scenario)
    cache.limit()  # a wrong one is told now
    catalog = Catalog(settings.objects)
    gripper = settings.scenario.robot.loaded.gripper
    names = objects_of(settings, jobs, catalog)
    if settings.scenario.objects.graded:
        check_graded(settings.scenario, catalog, names)
    for name in names:
        model = fitted(catalog.load(name), gripper)  # every mesh is checked before the first trial
        if not model.graspable_poses:
            raise GraspBenchError(f"{name} has no resting pose in which a grasp fits the gripper")
    return catalog


def owned(
    out: Path, jobs: Jobs, progress: Callable[[TrialRecord, bool], None]
) -> Callable[[TrialRecord], None]:
    """Return what is called with each record found in ``out``: ResultsError where it is none of the jobs'."""

    def found(record: TrialRecord) -> None:
        trial = record.trial
        if not jobs.holds(trial) or jobs.job(trial).object != record.object:
            raise ResultsError(
                f"{out} holds trial {trial} on {record.object}, which is none of this run; "
                "its files were mixed up. Restore them, or choose another --out."
            )
        progress(record, True)

    return found


def carry_out(
    settings: Settings,
    jobs: Iterable[Job],
    catalog: Catalog,
    executor: Executor,
    told: Callable[[TrialRecord, tuple[str, ...]], None] = lambda record, tracebacks: None,
) -> Generator[tuple[TrialRecord, Timings], None, None]:
    """Yield records and timings of ``jobs`` as they end; faults become records of their kind.

    ``told`` is called before with each record and the tracebacks of what foreign code raised, if it did.
    """
    with closing(executor.run(settings, jobs)) as answers:
        for answer in answers:
            if isinstance(answer, Fault):
                category = catalog.entries[answer.job.object]["category"]
                record = failed(answer.job, category, settings.seed, answer.outcome, answer.detail)
                yield record, Timings(trial=answer.job.trial)
            else:
                if answer.tracebacks:
                    told(answer.record, answer.tracebacks)
                yield answer.record, answer.timings
