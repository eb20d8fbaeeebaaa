"""The same ranking in other plausible worlds: counts, Kendall's τ, and what is tried."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grasp_bench.errors import GraspBenchError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.runs.results import RunResults
from grasp_bench.scenario.sections import Scenario
from grasp_bench.studies.rank import SCORES, Contest
from grasp_bench.studies.worlds import AGAIN, Pair, Worlds, in_worlds, worlds_table


@pytest.fixture
def contest(toy_catalog: Path, scenario: Scenario) -> Contest:
    catalog = Catalog(toy_catalog)
    return Contest(("displaced", "oracle"), scenario, catalog, tuple(catalog.names), SCORES["success"])


def test_orders_by_hand() -> None:
    means = {"a": [0.9, 0.9, 0.1], "b": [0.5, 0.5, 0.5], "c": [0.2, 0.5, 0.9]}
    found = Worlds({n: np.tile(np.array([m]).T, 60) for n, m in means.items()}, "success")
    assert found.trials == 60
    assert found.order == ["a", "b", "c"]
    assert found.pairs == [Pair("a", "b", 1, 0, 1), Pair("b", "c", 0, 1, 1)]
    # World 1: two of three pairs as before and one level, τ-b = 2 / √(3 · 2); world 2: all turned.
    assert found.taus == pytest.approx([2 / np.sqrt(6), -1])
    assert "from -1.00 to 0.82" in worlds_table(found).note
    assert found.chance == pytest.approx(1), "all trials are alike"
    assert "agree by 1.00 in the mean, one time in twenty by less than 1.00" in worlds_table(found).note
    level = Worlds({"a": np.array([[0.5], [0.5]]), "b": np.array([[0.4], [0.5]])}, "success")
    assert level.to_json()["kendall_tau"] == [None]
    assert "undefined" in worlds_table(level).note


def test_what_chance_does_to_an_order() -> None:
    rng = np.random.default_rng(0)
    coins = {n: (rng.random((2, 40)) < p).astype(float) for n, p in (("a", 0.9), ("b", 0.5), ("c", 0.5))}
    found = Worlds(coins, "success")
    assert len(found.chance) == AGAIN
    assert 0.4 < found.chance.mean() < 0.95, "b and c turn half of the time"
    apart = Worlds({n: np.full((2, 40), p) for n, p in (("a", 0.9), ("b", 0.5), ("c", 0.1))}, "success")
    assert apart.to_json()["kendall_tau_of_other_trials"] == {"mean": 1.0, "p5": 1.0}


def test_worlds_differ_and_trials_are_the_same(contest: Contest, tmp_path: Path) -> None:
    fresh: list[bool] = []
    found = in_worlds(
        contest, 1, 2, tmp_path / "a", 2, lambda name, world, record, there: fresh.append(not there)
    )
    assert fresh == 8 * [True]
    assert found.means["displaced"].tolist() == [0, 0]
    assert found.means["oracle"].tolist() == [1, 1]
    own, other = (RunResults(tmp_path / "a" / f"world{i}" / "oracle") for i in (0, 1))
    assert [r.object for r in own.records] == [r.object for r in other.records]
    assert own.info.scenario_name == contest.scenario.name
    assert other.info.scenario_name == f"{contest.scenario.name}-w1"
    assert own.records != other.records
    fresh.clear()
    again = in_worlds(
        contest, 1, 2, tmp_path / "a", 1, lambda name, world, record, there: fresh.append(not there)
    )
    assert fresh == 8 * [False], "what is there is not tried again"
    assert again.to_json() == found.to_json()


def test_more_trials_than_objects(contest: Contest, tmp_path: Path) -> None:
    with pytest.raises(GraspBenchError, match="--physics-trials 99 is more than there are objects"):
        in_worlds(contest, 1, 99, tmp_path, 1)
