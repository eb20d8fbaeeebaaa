"""Margins as numbers: scores, intervals that go by object, and the clustered signed-rank test."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.stats import wilcoxon

from grasp_bench.errors import ResultsError
from grasp_bench.runs.margins import EXACT, estimate, factor, resampled, score, score_of, signed_rank
from grasp_bench.runs.record import TrialRecord


def record(margin: dict[str, Any] | None, outcome: str = "success") -> TrialRecord:
    content = {"trial": 0, "object": "mug", "category": "mug", "outcome": outcome}
    return TrialRecord.read(content | ({} if margin is None else {"margin": margin}))


@pytest.mark.parametrize(
    ("times", "expected"), [(0, 0), (0.1, 0), (0.25, 0), (0.5, 0.1), (1, 0.2), (16, 0.6), (256, 1), (900, 1)]
)
def test_a_score_is_a_tenth_for_every_doubling(times: float, expected: float) -> None:
    assert score_of(times) == pytest.approx(expected)
    assert score(record({"factor": times})) == pytest.approx(expected)


def test_a_failure_scores_nothing_and_a_success_without_a_margin_is_an_error() -> None:
    assert score(record(None, "missed")) == 0
    assert score(record({"factor": 0.0}, "missed")) == 0
    assert factor(record({"factor": 3.5})) == 3.5
    with pytest.raises(ResultsError, match="mug has no margin; run with the scenario graded"):
        score(record(None))


def test_intervals_go_by_object() -> None:
    rng = np.random.default_rng(3)
    level = rng.normal(size=30)
    values = np.repeat(level, 10) + 0.01 * rng.normal(size=300)
    names = [f"o{i // 10}" for i in range(300)]
    clustered = estimate(values, names)
    alone = estimate(values, [str(i) for i in range(300)])
    assert clustered.value == alone.value == pytest.approx(values.mean())
    assert clustered.high - clustered.low > 2.5 * (alone.high - alone.low)  # ten trials say what one does
    half = 1.96 * level.std() / math.sqrt(30)
    assert clustered.high - clustered.low == pytest.approx(2 * half, rel=0.2)
    assert estimate(values, names) == clustered
    assert resampled(np.stack([values, values], 1), names).shape == (2000, 2)


def test_intervals_cover_the_truth() -> None:
    rng = np.random.default_rng(0)
    covered = 0
    for _ in range(200):
        values = rng.normal(size=60)
        found = estimate(values, [f"o{i // 2}" for i in range(60)])
        covered += found.low <= 0 <= found.high
    assert 183 <= covered <= 198


def test_with_one_trial_an_object_it_is_wilcoxons_test() -> None:
    rng = np.random.default_rng(1)
    for n in (8, 40):
        d = rng.normal(0.4, 1, n)
        ours = signed_rank(d.tolist(), [str(i) for i in range(n)])
        theirs = wilcoxon(d, method="exact" if n <= EXACT else "approx", correction=False).pvalue
        assert ours == pytest.approx(theirs, rel=1e-6)
        one = signed_rank(d.tolist(), [str(i) for i in range(n)], worse=True)
        assert one == pytest.approx(
            wilcoxon(d, alternative="less", method="exact" if n <= EXACT else "approx").pvalue, rel=1e-6
        )


def test_equal_pairs_say_nothing() -> None:
    assert signed_rank([0.0, 0.0], ["a", "b"]) == 1
    some = [0.3, 0.2, -0.1, 0.5]
    assert signed_rank([*some, 0.0], list("abcde")) == signed_rank(some, list("abcd"))


def test_copies_of_a_trial_are_no_evidence() -> None:
    d, names = [0.3, 0.2, -0.1, 0.5, 0.4], list("abcde")
    assert signed_rank(d * 20, names * 20) == pytest.approx(signed_rank(d, names), abs=0.02)


def test_false_alarms_are_as_frequent_as_the_level_says() -> None:
    rng = np.random.default_rng(2)
    names = [f"o{i // 4}" for i in range(120)]
    alarms = 0
    for _ in range(400):
        d = np.repeat(rng.standard_cauchy(30), 4) + 0.1 * rng.normal(size=120)
        alarms += signed_rank(d.tolist(), names) <= 0.05
    assert 8 <= alarms <= 34
