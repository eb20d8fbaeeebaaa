"""Intervals and tests of success counts, against published and hand-made values."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grasp_bench.stats import mcnemar, wilson


@pytest.mark.parametrize(("successes", "trials", "interval"), [
    (168, 180, (0.887, 0.961)),
    (110, 120, (0.853, 0.954)),
    (0, 10, (0.0, 0.278)),
    (10, 10, (0.722, 1.0)),
    (81, 263, (0.255, 0.366)),  # Newcombe, Statistics in Medicine 17 (1998), table I
    (15, 148, (0.062, 0.160)),
    (0, 20, (0.0, 0.161)),
    (1, 29, (0.006, 0.172)),
])
def test_wilson_intervals_agree_with_published_values(successes: int, trials: int, interval) -> None:
    assert wilson(successes, trials) == pytest.approx(interval, abs=6e-4)


@given(st.integers(1, 400).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_wilson_solves_its_own_equation(counts: tuple[int, int]) -> None:
    k, n = counts
    low, high = wilson(k, n)
    assert -1e-12 <= low <= k / n + 1e-12
    assert k / n - 1e-12 <= high <= 1 + 1e-12
    for limit in (low, high):
        z = 1.959964
        assert abs(k / n - limit) == pytest.approx(z * math.sqrt(max(limit * (1 - limit), 0) / n), abs=1e-6)


def test_more_confidence_is_a_wider_interval() -> None:
    low, high = wilson(50, 100)
    wider = wilson(50, 100, 0.99)
    assert wider[0] < low < high < wider[1]


@pytest.mark.parametrize(("successes", "trials"), [(1, 0), (0, 0), (-1, 5), (6, 5)])
def test_wilson_refuses_impossible_counts(successes: int, trials: int) -> None:
    with pytest.raises(ValueError, match=f"{successes}/{trials}"):
        wilson(successes, trials)


@pytest.mark.parametrize(("first", "second", "p"), [
    (0, 0, 1.0),
    (5, 0, 2 / 2**5),
    (0, 5, 2 / 2**5),
    (9, 1, 2 * (1 + 10) / 2**10),
    (4, 4, 1.0),
    (12, 3, 2 * (1 + 15 + 105 + 455) / 2**15),
])
def test_mcnemar_agrees_with_binomial_sums_by_hand(first: int, second: int, p: float) -> None:
    assert mcnemar(first, second) == pytest.approx(p)


@given(st.integers(0, 60), st.integers(0, 60))
def test_mcnemar_is_symmetric_and_a_probability(first: int, second: int) -> None:
    p = mcnemar(first, second)
    assert 0 < p <= 1
    assert p == pytest.approx(mcnemar(second, first))
