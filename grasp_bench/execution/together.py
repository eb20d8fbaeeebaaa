"""Trials that several predictors do, one item at a time, each into a run of its own."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path

from grasp_bench.execution.describe import describe
from grasp_bench.execution.memory import fair_share
from grasp_bench.execution.processes import RECYCLE, WorkerPool
from grasp_bench.execution.protocol import Answer, Fault, Round, failed
from grasp_bench.execution.runner import check_inputs, owned
from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.identity import identify
from grasp_bench.predictors.names import Installed, PythonPath, parse
from grasp_bench.runs.folder import RunFolder
from grasp_bench.runs.jobs import Jobs, Settings
from grasp_bench.runs.record import Timings, TrialRecord


@dataclass(frozen=True)
class Tried:
    """How a trial of one predictor ended."""

    round: Round
    predictor: str
    record: TrialRecord
    timings: Timings


def can_share(predictor: str) -> bool:
    """Return whether a predictor may be asked in a process that has others, too.

    Other people's code inside of the process might change what the others do, by a global seed or setting.
    """
    return not isinstance(parse(predictor), (PythonPath, Installed))


def try_together(
    settings: Settings,
    predictors: Sequence[str],
    rounds: Iterable[Round | None],
    catalog: Catalog,
    workers: int,
    memory_limit: int | None = None,
) -> Generator[Tried, None, None]:
    """Yield how trials ended, as they do; rounds are taken as they are needed.

    The predictors of a round find the same world at rest and the same picture, made once. All records are
    what they are when each predictor does the trial alone: where a round does not end within the time limit
    of one trial, or kills its worker, its predictors do it again, each by itself. ``rounds`` may depend on
    what was yielded before: at most two rounds a worker are taken ahead.

    Args:
        settings: those of the run; whose predictor they name does not matter.
        predictors: names of all that any round may ask.
        rounds: trials, each with the names of those that do it; None where the next one depends on what is
            under way.
        catalog: of the objects.
        workers: number of processes.
        memory_limit: most memory of each [bytes]; by default its share of 80 % of the machine's.

    Raises:
        GraspBenchError: when workers cannot start.
    """
    source, again = iter(rounds), deque[Round]()
    limit = memory_limit or fair_share(workers)
    recycle = max(1, RECYCLE // len(predictors))
    with WorkerPool(settings, workers, limit, recycle, tuple(predictors)) as pool:
        while True:
            while pool.room and (job := again.popleft() if again else next(source, None)):
                pool.submit(job)
            if not pool.pending:
                return
            for answer in pool.wait():
                job = answer.job
                assert isinstance(job, Round)
                if isinstance(answer, Answer):
                    yield Tried(job, answer.predictor, answer.record, answer.timings)
                elif len(job.predictors) > 1:
                    again += [replace(job, predictors=(name,)) for name in job.predictors]
                else:
                    yield _failed(answer, job, catalog, settings.seed)


def _failed(fault: Fault, job: Round, catalog: Catalog, seed: int) -> Tried:
    category = catalog.entries[job.object]["category"]
    record = failed(job, category, seed, fault.outcome, fault.detail)
    return Tried(job, job.predictors[0], record, Timings(trial=job.trial))


def run_together(
    settings: Settings,
    folders: Mapping[str, Path],
    jobs: Jobs,
    workers: int,
    progress: Callable[[str, TrialRecord, bool], None] = lambda predictor, record, resumed: None,
) -> None:
    """Do all ``jobs`` with several predictors, into a run's folder each; what is there is kept.

    Args:
        settings: those of all runs; whose predictor they name does not matter.
        folders: each predictor's folder, by its name.
        jobs: the trials of each.
        workers: number of processes.
        progress: called with the predictor's name, each record, and whether it was there before.

    Raises:
        GraspBenchError: before any trial starts, for anything wrong with the inputs.
    """
    catalog = check_inputs(settings, jobs)
    facts = {name: identify(name) for name in folders}
    with ExitStack() as stack:
        opened: dict[str, RunFolder] = {}
        done: dict[str, set[int]] = {}
        for name, path in folders.items():
            folder = opened[name] = stack.enter_context(RunFolder(path))
            one = replace(settings, predictor=name)
            found = owned(path, jobs, lambda record, resumed, name=name: progress(name, record, resumed))
            done[name] = folder.start(describe(one, jobs, catalog, facts[name]), found)

        def rounds() -> Iterator[Round]:
            for job in jobs:
                if names := tuple(n for n in folders if job.trial not in done[n]):
                    yield Round(job.trial, job.object, job.attempt, names)

        if any(len(d) < len(jobs) for d in done.values()):
            ended = try_together(settings, list(folders), rounds(), catalog, min(workers, len(jobs)))
            with closing(ended):
                for tried in ended:
                    opened[tried.predictor].append(tried.record, tried.timings)
                    progress(tried.predictor, tried.record, False)
        for folder in opened.values():
            folder.finish()
