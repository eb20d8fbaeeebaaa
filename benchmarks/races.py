"""How many items `rank` needs to tell two predictors apart, without a simulation.

``python benchmarks/races.py htc-grasp gg-cnn2``: races on items drawn again, with replacement, from the
committed runs of both (180 trials each), with each score that they have. docs/better.md has three pairs.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from grasp_bench.report.tables import TextTable, markdown
from grasp_bench.runs.comparison import scenes
from grasp_bench.runs.results import RunResults
from grasp_bench.studies.race import Race
from grasp_bench.studies.rank import SCORES, Score

RESULTS = Path(__file__).parents[1] / "results"
WAYS = (
    ("firmness, as predicted (default)", "graded", "firmness"),
    ("success, as predicted", "as-predicted", "success"),
    ("success, assisted", "reference", "success"),
)
LONGEST = 2000
"""Items after which a race is given up."""


def length(first: np.ndarray, second: np.ndarray, rng: np.random.Generator) -> float:
    """Return after how many items a race ends; infinity for more than :data:`LONGEST`."""
    race = Race(("first", "second"))
    for item in rng.integers(len(first), size=LONGEST):
        race.observe({"first": float(first[item]), "second": float(second[item])})
        if not race.in_doubt:
            return race.items
    return np.inf


def scores(names: tuple[str, str], kind: str, score: Score) -> tuple[np.ndarray, np.ndarray]:
    """Return the scores (n,) of two predictors on the trials of both."""
    first, second = (scenes(RunResults(RESULTS / kind / name)) for name in names)
    both = [key for key in first if key in second]
    return np.array([score.of(first[k]) for k in both]), np.array([score.of(second[k]) for k in both])


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("first")
    parser.add_argument("second")
    parser.add_argument("--races", type=int, default=200)
    parser.add_argument("--within", type=int, default=120)
    asked = parser.parse_args()
    rows = []
    for told, kind, score in WAYS:
        rng = np.random.default_rng(0)
        first, second = scores((asked.first, asked.second), kind, SCORES[score])
        lengths = np.array([length(first, second, rng) for _ in range(asked.races)])
        half = np.median(lengths)
        rows.append(
            [
                told,
                f"{half:.0f} items" if np.isfinite(half) else f"more than {LONGEST} items",
                f"{np.mean(lengths <= asked.within):.0%}",
            ]
        )
    head = (
        f"`{asked.first}` against `{asked.second}`",
        "half of the races end by",
        f"within {asked.within} items",
    )
    print(markdown([TextTable("Races", head, rows, numbers=(1, 2))]))


if __name__ == "__main__":
    main()
