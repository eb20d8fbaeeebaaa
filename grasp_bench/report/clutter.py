"""Figures of runs that cleared cluttered tables: success over attempts, and how much was cleared."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from grasp_bench.runs.record import AttemptRecord, EpisodeRecord
from grasp_bench.runs.statistics import Rate


@dataclass(frozen=True)
class Clearing:
    """Figures over episodes.

    Attempts of one episode depend on each other, so the interval of their rate is too narrow where failures
    cluster; tables are independent.

    Attributes:
        episodes: number of episodes.
        attempts: attempts that lifted an object.
        cleared: objects that were taken away.
        emptied: tables on which nothing was left.
        by_attempt: first attempts that lifted an object, second ones, and so on.
        outcomes: number of attempts by outcome, most frequent first.
    """

    episodes: int
    attempts: Rate
    cleared: Rate
    emptied: Rate
    by_attempt: tuple[Rate, ...]
    outcomes: dict[str, int]

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "episodes": self.episodes,
            "attempts": self.attempts.to_json(),
            "cleared": self.cleared.to_json(),
            "emptied": self.emptied.to_json(),
            "by_attempt": [turn.to_json() for turn in self.by_attempt],
            "outcomes": self.outcomes,
        }


def summarise_clutter(episodes: Sequence[EpisodeRecord], trials: int) -> Clearing:
    """Return figures over episodes.

    Args:
        episodes: the ``clutter`` of each trial's record that has one.
        trials: number of all trials; those without an episode (timeouts, errors) emptied no table.
    """

    def lifted(attempts: Sequence[AttemptRecord]) -> Rate:
        return Rate(sum(a.success for a in attempts), len(attempts))

    attempts = [a for e in episodes for a in e.attempts]
    turns = range(max((len(e.attempts) for e in episodes), default=0))
    return Clearing(
        trials,
        lifted(attempts),
        Rate(sum(e.cleared for e in episodes), sum(len(e.objects) for e in episodes)),
        Rate(sum(e.cleared == len(e.objects) for e in episodes), trials),
        tuple(lifted([e.attempts[i] for e in episodes if len(e.attempts) > i]) for i in turns),
        by_frequency(a.outcome for a in attempts),
    )


def by_frequency(names: Iterable[str]) -> dict[str, int]:
    """Return how often each name occurs, the most frequent first."""
    return dict(sorted(Counter(map(str, names)).items(), key=lambda o: (-o[1], o[0])))


def attempts_in_words(figures: Clearing) -> str:
    """Tell the successes of first attempts, second attempts, and so on, over the tables that saw them."""
    turns = enumerate(figures.by_attempt, 1)
    return ", ".join(f"{i}: {turn.successes}/{turn.trials}" for i, turn in turns) or "none"


def in_words(figures: Clearing) -> str:
    """Tell :func:`summarise_clutter`'s figures in one sentence."""

    def part(rate: Rate, verb: str) -> str:
        low, high = rate.interval
        return f"{verb} {rate.successes}/{rate.trials} = {rate.rate:.1%} ({low:.1%} – {high:.1%})"

    return (
        f"{part(figures.attempts, 'attempts that lifted')}, {part(figures.cleared, 'objects cleared')}, "
        f"{part(figures.emptied, 'tables emptied')}"
    )
