"""The scenario side-grasps: what it holds cannot be held from above, and can from the side."""

from __future__ import annotations

import pytest

from grasp_bench.errors import AssetError
from grasp_bench.objects.catalog import Catalog, folder_of
from grasp_bench.predictors import load_predictor
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.system.paths import scenarios_dir
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell

if not (scenarios_dir() / "side-grasps.yaml").is_file():
    pytest.skip("scripts/make_side_objects.py was not run here", allow_module_level=True)
SCENARIO = load_scenario("side-grasps")
CATALOG = Catalog(folder_of(SCENARIO.objects.folder))


def test_at_least_twenty_things_stand_in_poses_without_a_grasp_from_above() -> None:
    assert len(SCENARIO.objects.names) >= 20
    assert set(SCENARIO.objects.names) == set(SCENARIO.objects.poses) <= set(CATALOG.names)
    for name, chosen in SCENARIO.objects.poses.items():
        model = CATALOG.load(name)
        for i in chosen:
            assert not model.poses[i].grasps, name
            assert model.poses[i].rotation[2, 2] > 0.95, "upright"


def test_from_above_they_are_wider_than_the_jaws() -> None:
    for name in SCENARIO.objects.names:
        assert min(CATALOG.entries[name]["extents"][:2]) > PARALLEL_85.opening


@pytest.mark.parametrize("name", ["cake_stand", "toy_bar_stool"])
def test_the_oracle_from_above_has_nothing_and_that_from_any_direction_lifts(name: str) -> None:
    cell, model = Workcell(SCENARIO), CATALOG.load(name)
    assert run_trial(cell, model, load_predictor("oracle")).record.outcome is Outcome.NO_GRASP
    record = run_trial(cell, model, load_predictor("oracle-6dof")).record
    assert record.outcome is Outcome.SUCCESS
    assert record.pose is not None
    assert record.pose.approach[2] > -0.9, "not from above"


def test_a_pose_that_is_not_there_is_one_clear_error() -> None:
    objects = SCENARIO.objects.model_copy(update={"poses": {"cake_stand": (99,)}})
    cell = Workcell(SCENARIO.model_copy(update={"objects": objects}))
    with pytest.raises(AssetError, match="asks for pose 99 of cake_stand"):
        run_trial(cell, CATALOG.load("cake_stand"), load_predictor("random"))
