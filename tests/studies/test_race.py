"""Races: no false order, known gaps found, fewer trials than a design fixed beforehand."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from scipy.stats import binom

from grasp_bench.runs.statistics import holm
from grasp_bench.studies.race import Race

Rng = np.random.Generator


def finished(rates: list[float], items: int, rng: Rng) -> Race:
    """Race coins of such rates until all are told apart or the items are used up."""
    names = [f"p{i}" for i in range(len(rates))]
    race = Race(names)
    for scores in rng.random((items, len(rates))) < rates:
        if not race.in_doubt:
            break
        race.observe(dict(zip(names, map(float, scores), strict=True)))
    return race


def test_two_thousand_races_of_equals() -> None:
    rng = np.random.default_rng(0)
    false = sum(finished([0.9] * 3, 60, rng).separated[0] > 0 for _ in range(2000))
    assert false <= 0.05 * 2000


def test_few_races_of_equals_but_one_go_wrong() -> None:
    """Where some differ, an order of those that do not is as wrong, and as rare."""
    rng, false = np.random.default_rng(1), 0
    for _ in range(300):
        race = finished([0.9, 0.9, 0.3], 120, rng)
        false += race.better("p0", "p1") or race.better("p1", "p0")
        assert race.better("p0", "p2")
    assert false <= 0.05 * 300


RATES = [0.97, 0.85, 0.7, 0.35]


def test_known_gaps_are_found_with_few_trials() -> None:
    rng = np.random.default_rng(2)
    races = [finished(RATES, 900, rng) for _ in range(60)]
    found = sum(r.groups == [["p0"], ["p1"], ["p2"], ["p3"]] for r in races)
    assert found >= 0.95 * 60
    trials = np.mean([sum(map(len, r.scores.values())) for r in races])
    # A design fixed beforehand that is as sure to find all: exact McNemar tests, corrected by Holm.
    items = int(trials / 0.6 / len(RATES))
    fixed = sum(all_told(rng.random((items, len(RATES))) < RATES) for _ in range(200))
    assert fixed < 0.95 * 200, "with 1/0.6 of the race's trials it finds them less often"


def all_told(won: np.ndarray) -> bool:
    counts = [
        ((won[:, a] & ~won[:, b]).sum(), (~won[:, a] & won[:, b]).sum())
        for a, b in combinations(range(won.shape[1]), 2)
    ]
    return max(holm([min(1.0, 2 * binom.cdf(min(c), sum(c), 0.5)) for c in counts])) <= 0.05


def test_what_follows_needs_no_test() -> None:
    """a over b and b over c make a over c, though a and c were never compared."""
    race = Race(["a", "b", "c"])
    race._place(0, 1)
    race._place(1, 2)
    assert race.better("a", "c")
    assert race.places("a") == (1, 1)
    assert race.in_doubt == []


def test_who_is_placed_leaves_the_race() -> None:
    race = finished([0.9, 0.9, 0.05], 200, np.random.default_rng(5))
    assert len(race.scores["p2"]) < len(race.scores["p0"]) == 200
    assert race.groups == [["p0", "p1"], ["p2"]] or race.groups == [["p1", "p0"], ["p2"]]
    assert race.places("p0") == (1, 2)
    ((a, b, (low, high)),) = race.unseen()
    assert {a, b} == {"p0", "p1"}
    assert low < 0 < high


def test_groups_are_cut_only_where_all_above_beat_all_below() -> None:
    race = Race("abcd")
    for better, worse in ((0, 2), (0, 3), (1, 3)):
        race._place(better, worse)
    assert race.groups == [["a", "b", "c", "d"]], "b and c are not told apart, nor a and b"
    race._place(1, 2)
    assert [sorted(g) for g in race.groups] == [["a", "b"], ["c", "d"]]


def test_bad_input() -> None:
    with pytest.raises(ValueError, match="two different names"):
        Race(["a", "a"])
    with pytest.raises(ValueError, match="alpha"):
        Race(["a", "b"], alpha=1)
    with pytest.raises(ValueError, match="b needs a score"):
        Race(["a", "b"]).observe({"a": 1.0})
    with pytest.raises(ValueError, match="a needs a score"):
        Race(["a", "b"]).observe({"a": 1.5, "b": 0.0})
