"""Figures of runs that cleared cluttered tables: success over attempts, and how much was cleared."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grasp_bench.report.tables import TextTable
from grasp_bench.runs.margins import bounds
from grasp_bench.runs.record import AttemptRecord, EpisodeRecord
from grasp_bench.runs.statistics import Rate


@dataclass(frozen=True)
class Clearing:
    """Figures over episodes.

    Attempts of one episode depend on each other, tables do not: intervals of attempts and objects are by
    bootstrap over episodes, and never narrower than Wilson's.

    Attributes:
        episodes: number of episodes.
        attempts, attempts_interval: attempts that lifted an object, and the 95 % interval of their rate.
        cleared, cleared_interval: objects that were taken away, likewise.
        emptied: tables on which nothing was left.
        by_attempt: first attempts that lifted an object, second ones, and so on.
        outcomes: number of attempts by outcome, most frequent first.
    """

    episodes: int
    attempts: Rate
    attempts_interval: tuple[float, float]
    cleared: Rate
    cleared_interval: tuple[float, float]
    emptied: Rate
    by_attempt: tuple[Rate, ...]
    outcomes: dict[str, int]

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "episodes": self.episodes,
            "attempts": self.attempts.to_json() | {"clustered95": list(self.attempts_interval)},
            "cleared": self.cleared.to_json() | {"clustered95": list(self.cleared_interval)},
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
    tried = lifted(attempts)
    cleared = Rate(sum(e.cleared for e in episodes), sum(len(e.objects) for e in episodes))
    turns = range(max((len(e.attempts) for e in episodes), default=0))
    return Clearing(
        trials,
        tried,
        clustered(tried, [[a.success for a in e.attempts] for e in episodes]),
        cleared,
        clustered(cleared, [[i < e.cleared for i in range(len(e.objects))] for e in episodes]),
        Rate(sum(e.cleared == len(e.objects) for e in episodes), trials),
        tuple(lifted([e.attempts[i] for e in episodes if len(e.attempts) > i]) for i in turns),
        by_frequency(a.outcome for a in attempts),
    )


def clustered(rate: Rate, episodes: Sequence[Sequence[bool]]) -> tuple[float, float]:
    """Return the 95 % interval of a rate over what each episode counts, clustered by episode."""
    low, high = rate.interval
    if len(episodes) < 2 or not rate.trials:
        return 0.0, 1.0
    values = np.array([v for e in episodes for v in e], float)
    least, most = bounds(values, [str(i) for i, e in enumerate(episodes) for _ in e])
    return min(low, float(least)), max(high, float(most))


def by_frequency(names: Iterable[str]) -> dict[str, int]:
    """Return how often each name occurs, the most frequent first."""
    return dict(sorted(Counter(map(str, names)).items(), key=lambda o: (-o[1], o[0])))


def attempts_in_words(figures: Clearing) -> str:
    """Tell the successes of first attempts, second attempts, and so on, over the tables that saw them."""
    turns = enumerate(figures.by_attempt, 1)
    return ", ".join(f"{i}: {turn.successes}/{turn.trials}" for i, turn in turns) or "none"


def in_words(figures: Clearing) -> str:
    """Tell :func:`summarise_clutter`'s figures in one sentence."""

    def part(rate: Rate, interval: tuple[float, float], verb: str) -> str:
        low, high = interval
        return f"{verb} {rate.successes}/{rate.trials} = {rate.rate:.1%} ({low:.1%} – {high:.1%})"

    return (
        f"{part(figures.attempts, figures.attempts_interval, 'attempts that lifted')}, "
        f"{part(figures.cleared, figures.cleared_interval, 'objects cleared')}, "
        f"{part(figures.emptied, figures.emptied.interval, 'tables emptied')}"
    )


def clutter_table(rows: Sequence[tuple[str, Clearing]]) -> TextTable:
    """Return the table of named runs that cleared tables, by share cleared."""

    def cells(rate: Rate, interval: tuple[float, float]) -> list[str]:
        low, high = interval
        return [f"{rate.successes}/{rate.trials}", f"{rate.rate:.1%}", f"{low:.1%} – {high:.1%}"]

    head = ("Attempts", "Lifted", "95 % interval", "Objects", "Cleared", "95 % interval", "Emptied")
    order = sorted(rows, key=lambda r: -r[1].cleared.rate)
    return TextTable(
        "Tables cleared",
        ("Run", *head),
        [
            [
                name,
                *cells(c.attempts, c.attempts_interval),
                *cells(c.cleared, c.cleared_interval),
                f"{c.emptied.successes}/{c.emptied.trials}",
            ]
            for name, c in order
        ],
        note="Lifted: attempts that took an object away. Cleared: share of all objects. Intervals are by "
        "bootstrap over tables, whose attempts depend on each other, and never narrower than Wilson's.",
        numbers=range(1, len(head) + 1),
    )
