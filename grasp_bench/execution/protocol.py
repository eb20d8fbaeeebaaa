"""The protocol of what carries out trials: jobs in, answers out, in any order."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from dataclasses import dataclass
from typing import Protocol

from grasp_bench.runs.jobs import Job, Settings
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.scenario.outcomes import Outcome


@dataclass(frozen=True)
class Round(Job):
    """A trial that several predictors do, by their names, one after the other on the same worker."""

    predictors: tuple[str, ...] = ()


@dataclass(frozen=True)
class Answer:
    """A trial that ended by itself, with its lines for ``trials.jsonl`` and ``timings.jsonl``.

    Attributes:
        tracebacks: those of what foreign code raised meanwhile, as text.
        predictor: name of the one that was asked.
    """

    job: Job
    record: TrialRecord
    timings: Timings
    tracebacks: tuple[str, ...] = ()
    predictor: str = ""


@dataclass(frozen=True)
class Fault:
    """A trial that killed its worker (``error``) or had to be stopped (``timeout``), and why in words."""

    job: Job
    outcome: Outcome
    detail: str


def failed(job: Job, category: str, seed: int, outcome: Outcome, why: str) -> TrialRecord:
    """Return the record of a trial that did not end by itself."""
    return TrialRecord(
        trial=job.trial, object=job.object, category=category, seed=seed, outcome=outcome, detail=why
    )


class Executor(Protocol):
    """Something that carries out trials.

    A trial depends on its settings and its job alone, so every executor gives the same
    records, wherever they are made and in whatever order they come.
    """

    def run(self, settings: Settings, jobs: Iterable[Job]) -> Generator[Answer | Fault, None, None]:
        """Yield answers as trials end. Jobs are taken as needed; closing the generator stops all work.

        Raises:
            GraspBenchError: when no worker can work, and why.
        """
        ...
