"""Two runs compared on the trials that they have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from grasp_bench.errors import ResultsError
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import mcnemar


class Scene(NamedTuple):
    """What a trial's random numbers follow from: equal ones mean the same pose and the same noise.

    Attributes:
        seed: the run's seed.
        object: name of what is tried; of an episode, of what leads it.
        attempt: the number of times that the run tried it before.
    """

    seed: int
    object: str
    attempt: int


def scenes(run: RunResults) -> dict[Scene, TrialRecord]:
    """Return a run's records by their scenes, in trial order."""
    names, found = run.info.tried, {}
    met: dict[str, int] = {}
    for record in run.records:
        before = met.get(record.object, 0)
        met[record.object] = before + 1
        if names and names[record.trial % len(names)] == record.object:
            before = record.trial // len(names)  # also where a shard lacks the trials before
        seed = run.info.seed if record.seed is None else record.seed
        found[Scene(seed, record.object, before)] = record
    return found


@dataclass(frozen=True)
class Comparison:
    """Two runs on the same trials, counted pairwise.

    Attributes:
        first, second: names of the predictors.
        both, first_only, second_only, neither: number of trials in which they succeeded.
        p_value: McNemar's exact two-sided p-value: how often two equally good predictors would
            differ this much on these trials.
        discordant: the trials in which exactly one succeeded, as records of the first and of the second
            run, in the first's trial order.
    """

    first: str
    second: str
    both: int
    first_only: int
    second_only: int
    neither: int
    p_value: float
    discordant: tuple[tuple[TrialRecord, TrialRecord], ...]

    @classmethod
    def of(cls, first: RunResults, second: RunResults) -> Comparison:
        """Compare two runs on the trials that have the same seed, object and attempt in both.

        Raises:
            ResultsError: when there is no such trial.
        """
        for run in (first, second):
            run.check_not_empty()
        others = scenes(second)
        pairs = [(record, others[key]) for key, record in scenes(first).items() if key in others]
        if not pairs:
            raise ResultsError(
                f"{first.folder} and {second.folder} have no trial in common. Run both with the same seed "
                "and some of the same objects."
            )
        return cls.counted(first.predictor, second.predictor, pairs)

    @classmethod
    def counted(cls, first: str, second: str, pairs: list[tuple[TrialRecord, TrialRecord]]) -> Comparison:
        """Count pairs of records of the same trials."""
        won = [(a.success, b.success) for a, b in pairs]
        only, other = won.count((True, False)), won.count((False, True))
        return cls(
            first,
            second,
            won.count((True, True)),
            only,
            other,
            won.count((False, False)),
            mcnemar(only, other),
            tuple((a, b) for a, b in pairs if a.success is not b.success),
        )

    @property
    def trials(self) -> int:
        """Number of pairs."""
        return self.both + self.first_only + self.second_only + self.neither

    @property
    def difference(self) -> float:
        """Rate of the first minus rate of the second."""
        return (self.first_only - self.second_only) / self.trials

    @property
    def differing(self) -> tuple[str, ...]:
        """Names of the objects on which exactly one succeeded, in trial order."""
        return tuple(record.object for record, _ in self.discordant)

    def __str__(self) -> str:
        return (
            f"On {self.trials} common trials {self.first} alone succeeded in {self.first_only} and "
            f"{self.second} alone in {self.second_only} ({self.difference:+.1%}, McNemar's exact "
            f"p = {self.p_value:.2g})."
        )
