"""The oracle as an upper bound: what it knows, what it tries, and what becomes of its trial."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_outcomes import Seen, attempt, changed

from grasp_bench.camera import RgbdImage
from grasp_bench.grasps import Grasp, KnownGrasp
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.planning.planner import Plan
from grasp_bench.predictors.controls import Oracle, Random, Random10
from grasp_bench.predictors.protocol import GroundTruth
from grasp_bench.runs.record import TrialRecord
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.sections import Execution, Scenario


class Misled(Oracle):
    """Its best grasp lies 20 cm beside the object, in the world and in the picture; the second is right."""

    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        right = super().predict_from_truth(image, truth)
        assert isinstance(right[0], KnownGrasp)
        pose = replace(right[0].pose, position=right[0].pose.position + [0.0, 0.2, 0.0])
        return [replace(right[0], pose=pose, x=right[0].x - 120), *right]


def test_the_first_grasp_that_succeeds_is_carried_out(
    scenario: Scenario, models: dict[str, ObjectModel]
) -> None:
    trial = attempt(scenario, models["block"], Misled())
    assert (trial.record.outcome, trial.record.rank) == (Outcome.SUCCESS, 1)
    assert trial.record.widening_mm == 0
    told = trial.grasps[1]
    assert isinstance(told, KnownGrasp)
    assert isinstance(trial.plan, Plan)
    np.testing.assert_allclose(trial.plan.pose.position, told.pose.position)


def test_a_miscalibrated_camera_costs_it_nothing(scenario: Scenario, models: dict[str, ObjectModel]) -> None:
    wrong = changed(scenario, calibration={"position_mm": 25.0})
    assert attempt(wrong, models["block"], Oracle()).record.success
    assert not attempt(wrong, models["block"], Seen()).record.success


def test_no_help_is_needed_as_predicted(scenario: Scenario, models: dict[str, ObjectModel]) -> None:
    alone = scenario.model_copy(update={"execution": Execution(protocol="as-predicted")})
    assert attempt(alone, models["pot"], Misled()).record.success


class Lost(Oracle):
    """Knows no grasp that is right: all lie 20 cm beside the object, in the world and in the picture."""

    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        found = []
        for g in super().predict_from_truth(image, truth):
            assert isinstance(g, KnownGrasp)
            found.append(
                replace(g, pose=replace(g.pose, position=g.pose.position + [0.0, 0.2, 0.0]), x=g.x - 120)
            )
        return found


@pytest.mark.parametrize("name", ["block", "pot", "bar"])
def test_where_no_known_grasp_succeeds_analysis_finds_one(
    scenario: Scenario, models: dict[str, ObjectModel], name: str
) -> None:
    assert not attempt(scenario, models[name], Lost()).record.success, "table4 is as it was"
    trial = attempt(changed(scenario, objects={"graded": True}), models[name], Lost())
    assert trial.record.success
    assert trial.record.rank is not None
    told = trial.grasps[trial.record.rank]
    assert isinstance(told, KnownGrasp)
    assert isinstance(trial.plan, Plan)
    np.testing.assert_allclose(trial.plan.pose.position, told.pose.position)
    assert trial.record.grasp is not None
    assert (trial.record.grasp.x, trial.record.grasp.y) == pytest.approx((told.x, told.y), abs=0.01)


def test_where_none_succeeds_the_first_is_the_trials(
    scenario: Scenario, models: dict[str, ObjectModel]
) -> None:
    slippery = changed(scenario, gripper={"friction_scale": 0.004})
    record = attempt(slippery, models["block"], Oracle()).record
    assert record.outcome is Outcome.SLIPPED
    assert record.rank == 0


def test_watched_or_not_it_is_the_same_trial(scenario: Scenario, models: dict[str, ObjectModel]) -> None:
    seen: list[int] = []
    watched = attempt(
        scenario, models["block"], Misled(), observer=lambda world: seen.append(world.steps)
    ).record
    assert watched.line() == attempt(scenario, models["block"], Misled()).record.line()
    assert seen == sorted(seen), "one execution only is watched"
    assert seen[-1] == watched.sim_steps


def test_a_contestant_cannot_say_where_its_grasp_is(
    scenario: Scenario, models: dict[str, ObjectModel]
) -> None:
    known = attempt(scenario, models["block"], Oracle()).grasps

    class Cheat:
        def predict(self, image: RgbdImage) -> list[Grasp]:
            return list(known)

    trial = attempt(scenario, models["block"], Cheat())
    assert not any(isinstance(g, KnownGrasp) for g in trial.grasps)


@pytest.mark.parametrize("seed", [1, 2])
def test_the_first_of_ten_random_grasps_is_that_of_one(
    scenario: Scenario, models: dict[str, ObjectModel], seed: int
) -> None:
    image = attempt(scenario, models["pot"], Oracle()).image
    assert image is not None
    told = []
    for control in (Random(), Random10()):
        control.begin(np.random.default_rng(seed))
        told.append(control.predict(image))
    assert [len(t) for t in told] == [1, 10]
    assert told[0][0] == told[1][0]
    assert len({(g.x, g.y) for g in told[1]}) > 5


def test_records_of_the_oracle_read_back(scenario: Scenario, models: dict[str, ObjectModel]) -> None:
    record = attempt(scenario, models["block"], Oracle()).record
    assert TrialRecord.read(record.to_json()).line() == record.line()
