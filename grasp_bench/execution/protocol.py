"""What carries out trials: anything that takes jobs and gives answers, in any order."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from dataclasses import dataclass
from typing import Protocol

from grasp_bench.runs.jobs import Job, Settings
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.scenario.outcomes import Outcome


@dataclass(frozen=True)
class Answer:
    """A trial that ran to an end of its own.

    Attributes:
        job: what was done.
        record: line for ``trials.jsonl``.
        timings: line for ``timings.jsonl``.
    """

    job: Job
    record: TrialRecord
    timings: Timings


@dataclass(frozen=True)
class Fault:
    """A trial that took its worker with it, or that had to be stopped.

    Attributes:
        job: what was tried.
        outcome: ``timeout`` or ``error``.
        detail: the reason, in words.
    """

    job: Job
    outcome: Outcome
    detail: str


def failed(job: Job, category: str, seed: int, outcome: Outcome, why: str) -> TrialRecord:
    """The record of a trial that came to no end of its own."""
    return TrialRecord(
        trial=job.trial, object=job.object, category=category, seed=seed, outcome=outcome, detail=why
    )


class Executor(Protocol):
    """Carries out trials somewhere.

    A trial depends on its settings and its job alone, so every executor gives the same
    records; where they are made and in which order they come is its own affair.
    """

    def run(self, settings: Settings, jobs: Iterable[Job]) -> Generator[Answer | Fault, None, None]:
        """Answers as trials end. Jobs are taken as they are needed; closing the generator stops all work.

        Raises:
            GraspBenchError: when no worker can work, and why.
        """
        ...
