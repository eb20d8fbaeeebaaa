"""Intervals and tests of success counts, against published and hand-made values."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest

from grasp_bench.runs.statistics import (
    Pairs,
    Rate,
    holm,
    mcnemar,
    mcnemar_worse,
    non_inferiority,
    paired_interval,
    power_of_drop,
    trials_to_exclude,
    visible_drop,
    wilson,
)


@pytest.mark.parametrize(
    ("successes", "trials", "interval"),
    [
        (168, 180, (0.887, 0.961)),
        (110, 120, (0.853, 0.954)),
        (0, 10, (0.0, 0.278)),
        (10, 10, (0.722, 1.0)),
        (81, 263, (0.255, 0.366)),  # Newcombe, Statistics in Medicine 17 (1998), table I
        (15, 148, (0.062, 0.160)),
        (0, 20, (0.0, 0.161)),
        (1, 29, (0.006, 0.172)),
    ],
)
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


def test_wilson_is_scipys() -> None:
    for n in (1, 2, 7, 180, 900):
        for k in {0, 1, n // 3, n - 1, n}:
            expected = binomtest(k, n).proportion_ci(0.95, method="wilson")
            assert wilson(k, n) == pytest.approx((expected.low, expected.high), abs=1e-12)


@pytest.mark.parametrize(("successes", "trials"), [(1, 0), (0, 0), (-1, 5), (6, 5)])
def test_wilson_refuses_impossible_counts(successes: int, trials: int) -> None:
    with pytest.raises(ValueError, match=f"{successes}/{trials}"):
        wilson(successes, trials)


@pytest.mark.parametrize(
    ("first", "second", "p"),
    [
        (0, 0, 1.0),
        (5, 0, 2 / 2**5),
        (0, 5, 2 / 2**5),
        (9, 1, 2 * (1 + 10) / 2**10),
        (4, 4, 1.0),
        (12, 3, 2 * (1 + 15 + 105 + 455) / 2**15),
    ],
)
def test_mcnemar_agrees_with_binomial_sums_by_hand(first: int, second: int, p: float) -> None:
    assert mcnemar(first, second) == pytest.approx(p)


@given(st.integers(0, 60), st.integers(0, 60))
def test_mcnemar_is_symmetric_and_a_probability(first: int, second: int) -> None:
    p = mcnemar(first, second)
    assert 0 < p <= 1
    assert p == pytest.approx(mcnemar(second, first))


# ---------------------------------------------------------------- two runs on the same trials


@pytest.mark.parametrize(
    ("lost", "gained", "p"),
    [(0, 0, 1.0), (5, 0, 1 / 2**5), (0, 5, 1.0), (9, 1, 11 / 2**10), (4, 4, 163 / 2**8)],
)
def test_the_one_sided_test_agrees_with_binomial_sums_by_hand(lost: int, gained: int, p: float) -> None:
    assert mcnemar_worse(lost, gained) == pytest.approx(p)


@pytest.mark.parametrize(
    ("lost", "gained", "trials", "confidence", "interval"),
    [
        # Airway hyper-responsiveness of 21 children before and after stem cell transplantation (Bentur et
        # al. 2009) with Tango's interval as in Fagerland, Lydersen & Laake, Stat. in Medicine 33 (2014) 2850.
        (7, 1, 21, 0.95, (-0.517, -0.026)),
        # R's PropCIs 0.3-0, scoreci.mp(b, c, n), which gives (c − b)/n.
        (25, 28, 618, 0.90, (-0.0148, 0.0247)),
        (60, 20, 1000, 0.95, (-0.0584, -0.0231)),
        (41, 48, 549, 0.90, (-0.0157, 0.0414)),
    ],
)
def test_paired_intervals_agree_with_published_values(
    lost: int, gained: int, trials: int, confidence: float, interval
) -> None:
    assert paired_interval(Pairs(lost, gained, trials), confidence) == pytest.approx(interval, abs=6e-4)


@pytest.mark.parametrize("n", [1, 10, 180, 5000])
def test_without_any_change_the_paired_interval_has_a_closed_form(n: int) -> None:
    """Without a discordant pair the score equation is n² d² = z² n |d| (1 − |d|), so |d| = z²/(n + z²)."""
    z2 = 1.6448536269514722**2
    limit = z2 / (n + z2)
    assert paired_interval(Pairs(0, 0, n), 0.9) == pytest.approx((-limit, limit), rel=1e-6)


counts = st.integers(1, 300).flatmap(
    lambda n: st.integers(0, n).flatmap(
        lambda lost: st.tuples(st.just(lost), st.integers(0, n - lost), st.just(n))
    )
)


@given(counts)
def test_paired_intervals_hold_the_estimate_and_mirror(found: tuple[int, int, int]) -> None:
    lost, gained, n = found
    low, high = paired_interval(Pairs(lost, gained, n))
    assert -1 <= low <= (gained - lost) / n + 1e-9
    assert (gained - lost) / n - 1e-9 <= high <= 1
    mirrored = paired_interval(Pairs(gained, lost, n))
    assert mirrored == pytest.approx((-high, -low), abs=1e-6)


@given(counts, st.floats(0.005, 0.5))
def test_the_interval_and_the_test_of_non_inferiority_agree(
    found: tuple[int, int, int], margin: float
) -> None:
    pairs = Pairs(*found)
    low, _ = paired_interval(pairs, 0.9)
    p = non_inferiority(pairs, margin)
    if abs(low + margin) > 1e-6:
        assert (low > -margin) == (p < 0.05)


@pytest.mark.parametrize("pairs", [(0, 0, 0), (-1, 0, 5), (3, 3, 5)])
def test_paired_intervals_refuse_impossible_counts(pairs: tuple[int, int, int]) -> None:
    with pytest.raises(ValueError, match="lost"):
        paired_interval(Pairs(*pairs))


def shares_of(lost: float, gained: float, n: int) -> np.ndarray:
    """Probability of each (lost, gained) count of ``n`` pairs, (n + 1, n + 1)."""
    both = np.arange(n + 1)
    discordant = binom.pmf(both, n, lost + gained)
    table = np.zeros((n + 1, n + 1))
    for m in both:
        losses = np.arange(m + 1)
        table[losses, m - losses] = discordant[m] * binom.pmf(losses, m, lost / (lost + gained))
    return table


@pytest.mark.parametrize("gained", [0.0, 0.005, 0.02, 0.08])
@pytest.mark.parametrize("n", [90, 180])
def test_a_drop_of_the_margin_is_seldom_declared_harmless(n: int, gained: float) -> None:
    """Type-I error of the non-inferiority test, by enumerating all tables: near the nominal 5 %."""
    margin = 0.05
    table = shares_of(margin + gained, gained, n)
    assert table.sum() == pytest.approx(1)
    rejected = np.array(
        [
            [i + j <= n and non_inferiority(Pairs(i, j, n), margin) <= 0.05 for j in range(n + 1)]
            for i in range(n + 1)
            if i < 60
        ]
    )
    assert float((table[:60] * rejected).sum()) < 0.058


@pytest.mark.parametrize(("gained", "n"), [(0.01, 24), (0.02, 180), (0.1, 180), (0.3, 40)])
def test_where_nothing_changed_a_drop_is_proven_in_at_most_5_of_100_cases(gained: float, n: int) -> None:
    """Type-I error of McNemar's exact one-sided test, by enumerating all tables."""
    most = min(n, 45)  # nothing of weight lies beyond
    table = shares_of(gained, gained, n)[:most, :most]
    assert table.sum() == pytest.approx(1, abs=1e-7)
    rejected = np.array([[mcnemar_worse(i, j) <= 0.05 for j in range(most)] for i in range(most)])
    assert float((table * rejected).sum()) <= 0.05
    assert float((table * rejected).sum()) == pytest.approx(power_of_drop(n, 0.0, gained), abs=1e-6)


def test_power_is_what_simulated_runs_show() -> None:
    rng = np.random.default_rng(1)
    n, lost, gained, repeats = 180, 0.08, 0.02, 4000
    drawn = rng.multinomial(n, [lost, gained, 1 - lost - gained], size=repeats)
    seen = np.mean([mcnemar_worse(int(i), int(j)) <= 0.05 for i, j, _ in drawn])
    assert power_of_drop(n, lost - gained, gained) == pytest.approx(seen, abs=3 * math.sqrt(0.25 / repeats))


def test_power_of_the_smallest_visible_drop_is_the_power_asked_for() -> None:
    drop = visible_drop(180, 0.933, 0.01)
    assert drop is not None
    assert power_of_drop(180, drop, 0.01) == pytest.approx(0.8, abs=2e-3)
    assert power_of_drop(180, drop / 2, 0.01) < 0.8 < power_of_drop(180, 1.5 * drop, 0.01)


def test_more_trials_see_smaller_drops_and_few_see_none() -> None:
    drops = [visible_drop(n, 0.95) for n in (24, 180, 1800, 100_000)]
    assert all(d is not None for d in drops)
    assert drops == sorted(drops, reverse=True)  # type: ignore[type-var]
    assert visible_drop(4, 0.95) is None
    assert visible_drop(180, 0.0) is None
    # Five losses without a win are the fewest that prove anything at 5 %.
    assert visible_drop(5, 1.0, 0.0) == pytest.approx(0.8 ** (1 / 5), abs=1e-3)


@pytest.mark.parametrize(("new", "power"), [(0.90, 0.44), (0.88, 0.76), (0.85, 0.97)])
def test_a_single_rate_against_a_fixed_one_has_the_power_of_the_binomial_test(
    new: float, power: float
) -> None:
    """180 trials against 93.3 %: fewer than 162 successes are a drop at 5 %."""
    assert int(binom.ppf(0.05, 180, 168 / 180)) == 162
    assert float(binom.cdf(161, 180, new)) == pytest.approx(power, abs=0.01)


@pytest.mark.parametrize(("lost", "gained"), [(0.01, 0.01), (0.02, 0.01), (0.0, 0.0)])
def test_so_many_trials_do_exclude_the_margin_in_80_of_100_cases(lost: float, gained: float) -> None:
    margin = 0.05
    n = trials_to_exclude(margin, lost, gained)
    assert n is not None
    rng = np.random.default_rng(2)
    drawn = rng.multinomial(n, [lost, gained, 1 - lost - gained], size=2000)
    share = np.mean([non_inferiority(Pairs(int(i), int(j), n), margin) <= 0.05 for i, j, _ in drawn])
    assert 0.72 < share <= 1.0


def test_no_number_of_trials_excludes_a_margin_that_is_passed() -> None:
    assert trials_to_exclude(0.03, 0.05, 0.01) is None


# ---------------------------------------------------------------- several tests at once, and rates


def test_holms_correction_is_the_textbooks() -> None:
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.5, 0.9]) == [1.0, 1.0]
    assert holm([]) == []
    assert holm([0.02]) == [0.02]


def test_a_rate_is_written_with_counts_and_interval() -> None:
    rate = Rate(168, 180)
    assert str(rate) == "168/180 = 93.3% (95 % interval 88.7% – 96.1%)"
    low, high = wilson(168, 180)
    assert rate.to_json() == {"successes": 168, "trials": 180, "rate": 168 / 180, "wilson95": [low, high]}


def test_of_no_trials_nothing_is_known() -> None:
    assert (Rate(0, 0).rate, Rate(0, 0).interval) == (0.0, (0.0, 1.0))
