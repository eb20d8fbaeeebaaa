"""Figures of runs that cleared cluttered tables: success over attempts, and how much was cleared."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from grasp_bench.runs.statistics import wilson


def summarise_clutter(episodes: Sequence[dict[str, Any]], trials: int) -> dict[str, Any]:
    """Figures over episodes.

    Attempts of one episode depend on each other, so the interval of their rate is too narrow where failures
    cluster; tables are independent.

    Args:
        episodes: the ``clutter`` of each trial's record that has one.
        trials: all trials; those without an episode (timeouts, errors) emptied no table.
    """
    attempts = [a for e in episodes for a in e["attempts"]]
    turns = [
        [e["attempts"][i] for e in episodes if len(e["attempts"]) > i]
        for i in range(max((len(e["attempts"]) for e in episodes), default=0))
    ]
    ended = Counter(a["outcome"] for a in attempts)

    def share(successes: int, trials: int) -> dict[str, Any]:
        if trials == 0:  # no layout came to rest, or no episode ended
            return {"successes": 0, "trials": 0, "rate": 0.0, "wilson95": [0.0, 1.0]}
        return {
            "successes": successes,
            "trials": trials,
            "rate": successes / trials,
            "wilson95": list(wilson(successes, trials)),
        }

    return {
        "episodes": trials,
        "attempts": share(sum(a["success"] for a in attempts), len(attempts)),
        "cleared": share(sum(e["cleared"] for e in episodes), sum(len(e["objects"]) for e in episodes)),
        "emptied": share(sum(e["cleared"] == len(e["objects"]) for e in episodes), trials),
        "by_attempt": [share(sum(a["success"] for a in turn), len(turn)) for turn in turns],
        "outcomes": dict(sorted(ended.items(), key=lambda o: (-o[1], o[0]))),
    }


def attempts_in_words(figures: dict[str, Any]) -> str:
    """Successes of first attempts, second attempts, and so on, over the tables that saw them."""
    return (
        ", ".join(
            f"{i}: {turn['successes']}/{turn['trials']}" for i, turn in enumerate(figures["by_attempt"], 1)
        )
        or "none"
    )


def in_words(figures: dict[str, Any]) -> str:
    """One sentence of :func:`summarise_clutter`'s figures."""

    def part(key: str, verb: str) -> str:
        row = figures[key]
        low, high = row["wilson95"]
        return f"{verb} {row['successes']}/{row['trials']} = {row['rate']:.1%} ({low:.1%} – {high:.1%})"

    return (
        f"{part('attempts', 'attempts that lifted')}, {part('cleared', 'objects cleared')}, "
        f"{part('emptied', 'tables emptied')}"
    )
