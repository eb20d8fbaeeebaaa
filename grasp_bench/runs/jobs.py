"""The trials of a run as a list that takes no memory, and the share of it that one machine does."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import overload

from grasp_bench.errors import GraspBenchError
from grasp_bench.scenario.sections import Scenario

LONGEST_TIME = 30 * 86400.0
"""No trial takes longer [s], whatever its scenario allows: clocks of the system hold no more."""
MEDIA_TIME = 60.0
"""Seconds that a worker may take for a trial's pictures, in clutter for each of its objects."""


@dataclass(frozen=True)
class Job:
    """One trial to do: its number, object, and how many tries that object had before."""

    trial: int
    object: str
    attempt: int


@dataclass(frozen=True)
class Settings:
    """What a worker needs to know of a run.

    Pictures of trials (``media``, one of :data:`grasp_bench.media.modes.MODES`) and parts of a Rerun
    recording are stored in ``folder``. No record depends on them.
    """

    scenario: Scenario
    objects: Path
    predictor: str
    seed: int
    renderer: str
    media: str = "none"
    rerun: bool = False
    folder: Path | None = None

    @property
    def keeps(self) -> bool:
        """Whether something is kept of trials beside their records."""
        return self.media != "none" or self.rerun

    @property
    def time_limit(self) -> float:
        """Seconds after which a worker is stopped: making pictures must not turn a trial into a timeout."""
        clutter = self.scenario.clutter
        tries = 1 if clutter is None else clutter.most
        wanted = self.scenario.trial_timeout + (MEDIA_TIME * tries if self.keeps else 0.0)
        return min(wanted, LONGEST_TIME)


@dataclass(frozen=True)
class Shard:
    """Every ``count``-th trial of a run, from the ``index``-th (counted from 1) on."""

    index: int = 1
    count: int = 1

    def __str__(self) -> str:
        return f"{self.index}/{self.count}"

    @classmethod
    def parse(cls, text: str) -> Shard:
        """Read a shard from ``i/N``; GraspBenchError unless 1 ≤ i ≤ N."""
        match = re.fullmatch(r"(\d{1,7})/(\d{1,7})", text.strip())
        if match is None or not 1 <= int(match[1]) <= int(match[2]):
            raise GraspBenchError(f"--shard must be i/N with i from 1 to N, e.g. 1/4, not {text!r}.")
        return cls(int(match[1]), int(match[2]))


WHOLE = Shard()


@dataclass(frozen=True)
class Jobs(Sequence[Job]):
    """The trials of one shard of a run.

    Attributes:
        objects: names for the whole run, in the order in which they are tried.
        total: trials of the whole run.
        shard: the share of them that these are.
    """

    objects: tuple[str, ...]
    total: int
    shard: Shard = WHOLE

    def __len__(self) -> int:
        return len(self._trials)

    @property
    def _trials(self) -> range:
        return range(self.shard.index - 1, self.total, self.shard.count)

    @overload
    def __getitem__(self, index: int) -> Job: ...
    @overload
    def __getitem__(self, index: slice) -> list[Job]: ...
    def __getitem__(self, index: int | slice) -> Job | list[Job]:
        if isinstance(index, slice):
            return [self.job(t) for t in self._trials[index]]
        return self.job(self._trials[index])

    def __iter__(self) -> Iterator[Job]:
        return map(self.job, self._trials)

    def job(self, trial: int) -> Job:
        """Return the job of a trial, by its number in the whole run."""
        return Job(trial, self.objects[trial % len(self.objects)], trial // len(self.objects))

    def holds(self, trial: int) -> bool:
        """Return whether a trial is one of these."""
        return trial in self._trials

    @property
    def used(self) -> list[str]:
        """Objects that the whole run tries at least once."""
        return list(self.objects[: self.total])


def spread(objects: Sequence[str], trials: int, shard: Shard = WHOLE) -> Jobs:
    """Spread trials evenly over objects: every object once, then every object again."""
    return Jobs(tuple(objects), trials, shard)
