"""Ray: the same bytes as without it, also when a node of the cluster dies on the way."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import grasp_bench as gb
from grasp_bench.errors import GraspBenchError
from grasp_bench.execution.ray_cluster import RayCluster, _open_pool, _task
from grasp_bench.execution.runner import run
from grasp_bench.predictors.controls import Antipodal
from grasp_bench.runs.jobs import Settings, spread
from grasp_bench.runs.record import TrialRecord
from grasp_bench.scenario.sections import Scenario

ray = pytest.importorskip("ray", reason="Ray is not installed")

TRIALS = 12


@pytest.fixture
def settings(scenario: Scenario, toy_catalog: Path) -> Settings:
    return Settings(scenario, toy_catalog, "antipodal", 5, "raycast")


@pytest.fixture
def cluster(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Two nodes of one core each."""
    from ray.cluster_utils import Cluster

    root = str(Path(__file__).parents[2])
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [root, os.environ.get("PYTHONPATH")])))
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    made: Any = Cluster(initialize_head=False)
    try:
        made.add_node(num_cpus=1, include_dashboard=False)
        made.second = made.add_node(num_cpus=1)
    except Exception as error:
        made.shutdown()
        if "timed out" in str(error):
            pytest.skip(f"Ray's nodes do not start within its own time limit here: {error}")
        raise
    yield made
    ray.shutdown()
    made.shutdown()


def test_a_cluster_of_which_a_node_dies_writes_the_bytes_of_one_machine(
    cluster: Any, settings: Settings, toy_catalog: Path, scenario: Scenario, tmp_path: Path
) -> None:
    alone = gb.run(toy_catalog, TRIALS, Antipodal(), scenario, seed=5, out=tmp_path / "alone", progress=False)
    seen = []

    def watch(record: TrialRecord, resumed: bool) -> None:
        seen.append(record.trial)
        if len(seen) == 3:
            cluster.remove_node(cluster.second, allow_graceful=False)

    executor = RayCluster(address=cluster.address)
    run(settings, spread(["bar", "block", "pot"], TRIALS), tmp_path / "ray", 1, watch, executor=executor)
    assert sorted(seen) == list(range(TRIALS))
    assert (tmp_path / "ray" / "trials.jsonl").read_bytes() == (alone.folder / "trials.jsonl").read_bytes()
    assert not ray.is_initialized()


def test_a_node_with_other_objects_or_versions_refuses_to_work(settings: Settings) -> None:
    task = _task(settings, None)
    task.stack.versions["mujoco"] = "3.99.0"
    with pytest.raises(GraspBenchError, match=r"mujoco: 3\.99\.0 where the run was started, .* on this node"):
        _open_pool(task)


def test_a_cluster_that_is_not_there_is_a_clear_error(
    settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unreachable(**_: object) -> None:
        raise ConnectionError("nobody answers\nfor many lines")

    monkeypatch.setattr(ray, "init", unreachable)
    with pytest.raises(GraspBenchError, match=r"reached at 10\.0\.0\.1:6379 \(nobody answers\)"):
        list(RayCluster(address="10.0.0.1:6379").run(settings, spread(["bar"], 1)))
