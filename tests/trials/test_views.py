"""Several pictures of a trial: other fixed cameras, and a camera on the wrist."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from grasp_bench.camera import RgbdImage, View, fused
from grasp_bench.errors import ScenarioError
from grasp_bench.grasps import GraspPose
from grasp_bench.objects.catalog import Catalog
from grasp_bench.planning.planner import Planner
from grasp_bench.planning.viewing import view_motions
from grasp_bench.predictors.controls import Centroid
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import load_scenario, parse_scenario
from grasp_bench.scenario.sections import Scenario
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell


def scenario(camera: dict[str, Any], **more: Any) -> Scenario:
    content = load_scenario("table4").model_dump(mode="json")
    content["camera"] |= camera
    return parse_scenario(content | more | {"name": "views"}, "views")


class Sees:
    """Keeps all pictures, and grasps as the centroid does in the first."""

    def predict_views(self, views: list[View]) -> Any:
        self.views = views
        return Centroid().predict(views[0].image)

    def predict(self, image: RgbdImage) -> list[GraspPose]:
        raise AssertionError("not asked where there are views")


ASIDE = {"more": [{"position": [0.5, -0.45, 0.35]}, {"position": [0.85, 0.2, 0.4]}]}
MODEL = Catalog().load("tea_box")


def agrees(views: list[View], millimetres: float) -> bool:
    """Whether all pictures show the table in one plane, that of the first."""
    points, colours = fused(views)
    assert points.shape == colours.shape
    own = len(views[0].image.cloud()[0])
    assert len(points) > own
    level = np.median(points[:own, 2])  # the first looks straight down
    other = points[own:]
    on_table = other[np.abs(other[:, 2] - level) < 0.02]
    return bool(abs(np.median(on_table[:, 2]) - level) < millimetres / 1000) and len(on_table) > 10_000


def test_other_fixed_cameras_show_the_same_scene() -> None:
    sees = Sees()
    record = run_trial(Workcell(scenario(ASIDE)), MODEL, sees).record
    assert record.outcome is Outcome.SUCCESS
    assert len(sees.views) == 3
    np.testing.assert_allclose(sees.views[0].rotation, np.eye(3), atol=1e-12)
    assert agrees(sees.views, 1.0)


def test_who_does_not_ask_gets_the_first_and_the_same_trial() -> None:
    plain = run_trial(Workcell(load_scenario("table4")), MODEL, Centroid()).record
    several = run_trial(Workcell(scenario(ASIDE)), MODEL, Centroid()).record
    assert several.line() == plain.line()


def test_a_wrist_camera_sees_from_where_the_arm_brings_it() -> None:
    sees = Sees()
    cell = Workcell(scenario({"mount": "wrist", "views": 3, "position": [0.5, 0.0, 0.5]}))
    trial = run_trial(cell, MODEL, sees)
    assert len(sees.views) == 3
    assert agrees(sees.views, 2.0)
    assert trial.record.outcome is Outcome.SUCCESS, trial.record.detail
    tilts = [float(np.degrees(np.arccos(v.rotation[2, 2]))) for v in sees.views[1:]]
    assert tilts == pytest.approx([20.0, 20.0], abs=0.5)


def test_an_error_of_hand_and_eye_moves_what_is_believed() -> None:
    wrong = {"position_mm": 15.0, "rotation_deg": 0.0, "drawn": "trial"}
    sees = Sees()
    cell = Workcell(scenario({"mount": "wrist", "views": 2, "position": [0.5, 0.0, 0.5]}, calibration=wrong))
    trial = run_trial(cell, MODEL, sees)
    exact = Sees()
    run_trial(Workcell(scenario({"mount": "wrist", "views": 2, "position": [0.5, 0.0, 0.5]})), MODEL, exact)
    np.testing.assert_allclose(sees.views[1].position, exact.views[1].position, atol=1e-9)
    assert not np.array_equal(sees.views[0].image.depth, exact.views[0].image.depth)
    assert trial.image is not None


def test_a_view_that_the_arm_does_not_reach_is_one_clear_error() -> None:
    with pytest.raises(ScenarioError, match="cannot bring its wrist camera to view 0") as error:
        view_motions(Planner(scenario({"mount": "wrist", "position": [0.5, 0.0, 1.6]})))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("camera", [{"views": 3}, {"mount": "wrist"} | ASIDE, {"mount": "ceiling"}])
def test_what_does_not_go_together_is_refused(camera: dict[str, Any]) -> None:
    with pytest.raises((ScenarioError, ValidationError)):
        scenario(camera)
