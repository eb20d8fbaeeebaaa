"""What a race tells, in tables and as plain data."""

from __future__ import annotations

from typing import Any

import numpy as np

from grasp_bench.report.tables import TextTable
from grasp_bench.runs.betting import confidence_sequence
from grasp_bench.studies.race import Race

BETWEEN = " · "
ONE_OF = "–"


def in_words(race: Race) -> str:
    """Return the groups as places, such as ``1 · 2–4 · 5``: within a group nothing is known."""
    words, first = [], 1
    for group in race.groups:
        last = first + len(group) - 1
        words.append(f"{first}" if first == last else f"{first}{ONE_OF}{last}")
        first = last + 1
    return BETWEEN.join(words)


def ranking_table(race: Race, what: str) -> TextTable:
    """Return a row a predictor, by group; ``what`` names the score."""
    rows, first = [], 1
    for group in race.groups:
        last = first + len(group) - 1
        place = f"{first}" if first == last else f"{first}{ONE_OF}{last}"
        for name in group:
            low, high = _interval(race, name)
            best, worst = race.places(name)
            sure = f"{best}" if best == worst else f"{best}{ONE_OF}{worst}"
            mean = f"{race.mean(name):.1%}"
            rows.append([place, name, sure, str(len(race.scores[name])), mean, f"{low:.1%} – {high:.1%}"])
        first = last + 1
    told, pairs = race.separated
    return TextTable(
        f"Who is better: {in_words(race)}",
        ("Group", "Predictor", "Place", "Items", f"Mean {what}", "95 % interval"),
        rows,
        note=f"{told} of {pairs} pairs told apart on {race.items} items, at a chance of {race.alpha:g} that "
        "any pair is put in a wrong order, whenever one stops. Within a group there is no order. A predictor "
        "leaves the race once it is told from all others. Intervals hold at all times, too.",
        numbers=(3, 4, 5),
    )


def unseen_table(race: Race, most: int = 12) -> TextTable | None:
    """Return the pairs that were not told apart, nearest to being so first; None where there are none."""
    found = sorted(race.unseen(), key=lambda u: u[2][1] - u[2][0])
    if not found:
        return None
    more = len(found) - most
    return TextTable(
        "What the budget could not see",
        ("Pair", "Differences that are possible", "Items"),
        [
            [f"{a} − {b}", f"{100 * low:+.1f} to {100 * high:+.1f} points", str(len(race.differences(a, b)))]
            for a, b, (low, high) in found[:most]
        ],
        note=f"And {more} more pairs." if more > 0 else "",
        numbers=(2,),
    )


def to_json(race: Race, what: str) -> dict[str, Any]:
    """Return plain data."""
    return {
        "format": 1,
        "kind": "ranking",
        "score": what,
        "alpha": race.alpha,
        "items": race.items,
        "groups": race.groups,
        "predictors": {
            name: {
                "items": len(race.scores[name]),
                "mean": race.mean(name),
                "interval": list(_interval(race, name)),
                "places": list(race.places(name)),
            }
            for name in race.names
        },
        "not_told_apart": [
            {"pair": [a, b], "difference": list(possible)} for a, b, possible in race.unseen()
        ],
    }


def _interval(race: Race, name: str) -> tuple[float, float]:
    """Return a confidence sequence of a mean score, which is in [0, 1]."""
    low, high = confidence_sequence(2 * np.array(race.scores[name], float) - 1, race.alpha)
    return (1 + low) / 2, (1 + high) / 2
