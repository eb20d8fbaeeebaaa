"""Random streams depend on seed, object, attempt and purpose, and on nothing else."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from grasp_bench.scenario.seeding import Purpose, stream


def draw(*key) -> np.ndarray:
    return stream(*key).random(8)


KEY = (7, "mug", 3, Purpose.POSE)


def test_the_same_key_gives_the_same_numbers() -> None:
    np.testing.assert_array_equal(draw(*KEY), draw(*KEY))


@pytest.mark.parametrize(
    "other",
    [
        (8, "mug", 3, Purpose.POSE),
        (7, "cup", 3, Purpose.POSE),
        (7, "mug", 4, Purpose.POSE),
        (7, "mug", 3, Purpose.SENSOR),
    ],
)
def test_every_part_of_the_key_matters(other) -> None:
    assert not np.array_equal(draw(*KEY), draw(*other))


def test_drawing_from_one_stream_leaves_another_as_it_is() -> None:
    expected = draw(7, "mug", 3, Purpose.SENSOR)
    stream(*KEY).random(1000)
    np.testing.assert_array_equal(draw(7, "mug", 3, Purpose.SENSOR), expected)


def test_streams_are_the_same_in_every_version() -> None:
    # Published results can be repeated only as long as this number stays.
    assert stream(0, "mug", 0, Purpose.POSE).integers(2**32) == 3621708398


def test_streams_of_successive_trials_are_not_correlated() -> None:
    draws = np.array([stream(0, "mug", i, Purpose.POSE).random(50) for i in range(200)])
    neighbours = [np.corrcoef(a, b)[0, 1] for a, b in pairwise(draws)]
    assert abs(np.mean(neighbours)) < 0.05
