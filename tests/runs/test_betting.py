"""Tests by betting: sound at any time, and as sharp as they should be."""

from __future__ import annotations

import numpy as np
import pytest

from grasp_bench.runs.betting import Wagers, confidence_sequence


def test_the_capital_is_a_fair_game() -> None:
    """Of fair coins 5 % at most ever look biased, at 2.5 % for each side, however long one looks."""
    rng = np.random.default_rng(1)
    wagers = Wagers(2000)
    for _ in range(200):
        wagers.observe(np.arange(2000), rng.choice([-1.0, 0.0, 1.0], 2000, p=[0.15, 0.7, 0.15]))
    reached = (wagers.p_values() <= 0.025).any(axis=1).mean()
    assert 0.003 < reached <= 0.05, "valid, and not for being blind"


def test_a_bias_is_found_on_its_own_side() -> None:
    rng = np.random.default_rng(2)
    wagers = Wagers(200)
    for _ in range(150):
        wagers.observe(np.arange(200), rng.choice([-1.0, 0.0, 1.0], 200, p=[0.05, 0.7, 0.25]))
    positive, negative = wagers.p_values().T
    assert (positive <= 0.025).mean() > 0.95
    assert (negative > 0.025).mean() > 0.99


def test_larger_stakes_count_for_more() -> None:
    """Of gaps that some hundred numbers tell, a uniform mixture of stakes sees fewer so soon."""
    rng, stakes = np.random.default_rng(6), np.linspace(0.0005, 0.9995, 1000)
    wagers, even, most = Wagers(300), np.zeros((300, 1000)), np.ones(300)
    for _ in range(60):
        d = np.clip(rng.normal(0.12, 0.3, 300), -1, 1)
        wagers.observe(np.arange(300), d)
        even += np.log1p(stakes * d[:, None])
        most = np.maximum(most, np.exp(even).mean(1))
    soon = (wagers.p_values()[:, 0] <= 0.025).mean()
    assert soon > (most >= 40).mean() + 0.03


def test_the_order_of_the_numbers_does_not_matter() -> None:
    d = np.random.default_rng(3).uniform(-0.5, 1, 40)
    forth, back = Wagers(1), Wagers(1)
    for a, b in zip(d, d[::-1], strict=True):
        forth.observe(np.array([0]), np.array([a]))
        back.observe(np.array([0]), np.array([b]))
    np.testing.assert_allclose(forth._log, back._log)


def test_numbers_outside_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\[−1, 1\]"):
        Wagers(1).observe(np.array([0]), np.array([1.5]))


def test_confidence_sequence_covers_at_all_times() -> None:
    rng, missed = np.random.default_rng(4), 0
    for _ in range(150):
        p = rng.random(2)
        d = (rng.random(40) < p[0]).astype(float) - (rng.random(40) < p[1])
        low, high = confidence_sequence(d, 0.1)  # of all looks so far, so that it misses if one of them did
        missed += not low <= p[0] - p[1] <= high
    assert missed <= 0.1 * 150


def test_confidence_sequence_narrows() -> None:
    d = np.tile([1.0, 0.0, 0.0, -1.0], 100)
    widths = [np.ptp(confidence_sequence(d[:n])) for n in (0, 40, 400)]
    assert widths[0] == 2
    assert widths[2] < 0.25 < widths[1] < 0.8
    assert confidence_sequence(np.ones(100))[0] > 0.85
    assert confidence_sequence(-np.ones(100))[1] < -0.85
