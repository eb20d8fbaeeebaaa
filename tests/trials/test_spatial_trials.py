"""Trials of grasps in six degrees of freedom: as planar where they are, and refused with a reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from grasp_bench.camera import RgbdImage
from grasp_bench.grasps import GraspPose
from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors import load_predictor
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell

SAME = ("outcome", "detail", "sim_steps", "pose", "seed", "object")


@pytest.fixture(scope="module")
def cell() -> Workcell:
    return Workcell(load_scenario("table4"))


class Says:
    """Proposes poses, given in the world."""

    def __init__(self, cell: Workcell, *poses: GraspPose) -> None:
        camera = cell.camera.pose
        turn = camera.rotation.T
        self.poses = [p.moved(turn, -turn @ camera.position) for p in poses]

    def predict(self, image: RgbdImage) -> list[GraspPose]:
        return self.poses


@pytest.mark.parametrize("name", ["flat_screwdriver", "egg", "coffee_mug", "cereal_bowl", "tea_box"])
@pytest.mark.parametrize("predictor", ["antipodal", "random"])
def test_a_planar_trial_through_this_door_has_the_same_record(
    cell: Workcell, name: str, predictor: str
) -> None:
    model = Catalog().load(name)
    done = run_trial(cell, model, load_predictor(predictor))
    planar = done.record
    if done.plan is None:
        pytest.skip("nothing was planned")
    spatial = run_trial(cell, model, Says(cell, done.plan.pose)).record
    a, b = (r.model_dump(mode="json") for r in (planar, spatial))
    assert {k: a[k] for k in SAME} == {k: b[k] for k in SAME}
    # What is measured in physics: turning a pose into the camera's frame and back moves it by 1e-17 m, which
    # contacts make more of.
    assert planar.tcp_error is not None
    assert spatial.tcp_error is not None
    np.testing.assert_allclose(spatial.tcp_error, planar.tcp_error, atol=2e-6)
    assert spatial.lift_height == pytest.approx(planar.lift_height, abs=1e-5)
    assert spatial.contact_force == pytest.approx(planar.contact_force, abs=1e-2)
    assert spatial.widening_mm == 0
    assert spatial.grasp is not None


def down(x: float, y: float, z: float, opening: float = 0.06) -> GraspPose:
    return GraspPose.top_down([x, y, z], 0.3, opening)


@pytest.mark.parametrize(
    ("pose", "outcome", "why"),
    [
        (down(0.5, 0, -0.02), Outcome.BLOCKED, "the table, 20 mm under whose top"),
        (down(1.4, 0.1, 0.02), Outcome.IK_FAILED, "no joint angles"),
        (down(0.5, 0, 0.02), Outcome.MISSED, "without holding"),
        (
            replace(down(0.5, 0, 0.05), rotation=Rotation.from_euler("y", 90, degrees=True).as_matrix()),
            Outcome.BLOCKED,
            "the table",
        ),
    ],
)
def test_what_cannot_be_done_says_why(cell: Workcell, pose: GraspPose, outcome: Outcome, why: str) -> None:
    model = Catalog().load("egg")
    record = run_trial(cell, model, Says(cell, pose), seed=3).record
    assert (record.outcome, why in record.detail) == (outcome, True), record.detail


def test_a_rotation_that_is_none_is_one_clear_error(cell: Workcell) -> None:
    bad = replace(down(0.5, 0, 0.02), rotation=np.ones((3, 3)))
    record = run_trial(cell, Catalog().load("egg"), Says(cell, bad)).record
    assert record.outcome is Outcome.ERROR
    assert "rotation is none" in record.detail


def test_the_first_that_can_be_planned_is_carried_out(cell: Workcell) -> None:
    model = Catalog().load("egg")
    planar = run_trial(cell, model, load_predictor("antipodal")).record
    assert planar.pose is not None
    record = run_trial(cell, model, Says(cell, down(0.5, 0, -0.02), planar.pose)).record
    assert (record.rank, record.outcome) == (1, planar.outcome)
