"""Items of a race."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import pytest
from scipy.stats import chisquare

from grasp_bench.studies.draw import draw, whole

OBJECTS = tuple(f"object{i}" for i in range(9))


def test_items_are_trials_of_one_run_and_none_comes_twice() -> None:
    items = draw(OBJECTS, 200, seed=3)
    assert len({j.trial for j in items}) == 200
    assert all(whole(OBJECTS).job(j.trial) == j for j in items)
    assert max(j.attempt for j in items) + 1 == max(Counter(j.object for j in items).values())


def test_the_first_items_do_not_depend_on_their_number() -> None:
    assert draw(OBJECTS, 200, seed=3)[:50] == draw(OBJECTS, 50, seed=3)
    assert draw(OBJECTS, 50, seed=3) != draw(OBJECTS, 50, seed=4)


def test_every_object_is_as_likely_every_time() -> None:
    """Drawn with replacement: what was drawn before says nothing of what is drawn next."""
    items = [j.object for j in draw(OBJECTS, 700, seed=0)]
    assert chisquare(list(Counter(items).values())).pvalue > 0.01
    again = sum(a == b for a, b in pairwise(items))
    assert 0.5 / 9 < again / 699 < 2 / 9


def test_too_many_items() -> None:
    with pytest.raises(ValueError, match="too many"):
        draw(OBJECTS[:1], 101, seed=0)
