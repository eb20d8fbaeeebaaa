"""Walls, floors and their feet are told from what stands on the table, also beside them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from grasp_bench.predictors.surroundings import surroundings

SIDE, TABLE = 224, 0.7


def table() -> NDArray[np.float32]:
    rng = np.random.default_rng(0)
    return (TABLE + rng.normal(0, 0.002, (SIDE, SIDE))).astype(np.float32)


def with_wall() -> NDArray[np.float32]:
    """A wall that rises over the upper quarter of the picture."""
    depth = table()
    depth[:60] -= np.linspace(0.3, 0, 60, dtype=np.float32)[:, None]
    return depth


def test_a_plain_table_and_things_on_it_have_none() -> None:
    depth = table()
    depth[80:120, 90:130] = 0.55
    depth[:40, 100:140] = 0.5  # tall, and cut off by the rim
    depth[150:160] = 0  # holes
    assert not surroundings(depth).any()
    assert not surroundings(np.zeros((SIDE, SIDE), np.float32)).any()


def test_a_wall_is_marked_with_its_foot() -> None:
    marked = surroundings(with_wall())
    assert marked[:50].all()
    assert marked[:56].mean() > 0.99, "the foot rises by 5 mm a pixel"
    assert not marked[75:].any()


def test_a_floor_beside_the_table_is_marked() -> None:
    depth = table()
    depth[:, 180:] = 1.4
    marked = surroundings(depth)
    assert marked[:, 183:].all()
    assert not marked[:, :165].any()


@pytest.mark.parametrize("top", [0.50, 0.40])
def test_a_tall_thing_in_front_of_a_wall_survives(top: float) -> None:
    depth = with_wall()
    depth[30:110, 90:130] = top
    marked = surroundings(depth)
    assert not marked[62:108, 92:128].any()
    assert marked[35:105, 92:128].mean() < 0.1, "where the wall is behind it, too"
    assert marked[:25].all()


def test_a_pile_in_the_middle_of_a_bin_survives_and_the_bins_wall_does_not() -> None:
    depth = table()
    depth[:20] = depth[-20:] = depth[:, :20] = depth[:, -20:] = 0.55
    depth[80:140, 80:140] = 0.6
    marked = surroundings(depth)
    assert marked[:17].all()
    assert not marked[78:142, 78:142].any()
