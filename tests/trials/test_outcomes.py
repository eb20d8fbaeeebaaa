"""Every outcome of a trial, each caused by a scene that can only end so."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grasp_bench.camera import RgbdImage
from grasp_bench.grasps import Grasp
from grasp_bench.objects.catalog import ObjectModel, ReferenceGrasp, RestingPose
from grasp_bench.predictors.controls import Displaced, Oracle, project_grasp
from grasp_bench.predictors.protocol import GroundTruth, PrivilegedPredictor
from grasp_bench.scenario.outcomes import HARNESS_FAULTS, Outcome
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.touch import Touch
from grasp_bench.scene.world import UnstableError, World
from grasp_bench.trials.attempt import Trial
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell
from grasp_bench.workshop.build import build_shape
from grasp_bench.workshop.model import ObjectSpec, Part
from grasp_bench.workshop.shapes import box, move


class Says:
    """Predictor that answers with what it was given."""

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def predict(self, image: RgbdImage) -> Any:
        return self.answer


class Raises:
    """Predictor that fails."""

    def predict(self, image: RgbdImage) -> list[Grasp]:
        raise ZeroDivisionError("by nought")


class Seen(Oracle):
    """The reference grasps as a predictor would propose them: planned through the picture, not tried out."""

    foresight = False

    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        return [
            Grasp(g.x, g.y, g.angle, g.width, g.quality) for g in super().predict_from_truth(image, truth)
        ]


class At(PrivilegedPredictor):
    """Grasps at a place of the object, given in its own frame [m]."""

    def __init__(
        self, place: tuple[float, float, float], axis: tuple[float, float, float], width: float, top: float
    ) -> None:
        self.place, self.axis, self.width, self.top = np.array(place), np.array(axis), width, top

    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        return [
            project_grasp(
                truth,
                truth.rotation @ self.place + truth.position,
                truth.rotation @ self.axis,
                self.top,
                self.width,
                1.0,
            )
        ]


def changed(scenario: Scenario, **sections: dict[str, Any]) -> Scenario:
    """The scenario with some values of its sections replaced."""
    return scenario.model_copy(
        update={name: getattr(scenario, name).model_copy(update=values) for name, values in sections.items()}
    )


def attempt(scenario: Scenario, model: ObjectModel, predictor: Any, **more: Any) -> Trial:
    return run_trial(Workcell(scenario), model, predictor, trial=5, attempt=1, seed=2, **more)


@pytest.fixture(scope="module")
def lying(models: dict[str, ObjectModel]) -> ObjectModel:
    """The block lying flat: 80 x 40 mm, 30 mm high."""
    flat = [p for p in models["block"].poses if p.height < 0.016]
    return replace(models["block"], poses=tuple(flat[:1]))


# ---------------------------------------------------------------- physics


def test_success_lifts_carries_and_holds(scenario: Scenario, lying: ObjectModel) -> None:
    trial = attempt(scenario, lying, Seen())
    record = trial.record
    assert (record.outcome, record.success, record.detail) == (Outcome.SUCCESS, True, "")
    assert record.lift_height == pytest.approx(scenario.motion.lift_height, abs=0.003)
    assert record.contact_force == pytest.approx(scenario.gripper.force, rel=0.05)
    assert record.tcp_error is not None
    assert record.tcp_error[0] < 0.001
    assert record.tcp_error[1] < math.radians(0.1)
    assert trial.world is not None
    place = trial.world.object_pose[0]
    np.testing.assert_allclose(place[:2], scenario.motion.carry_to[:2], atol=0.02)
    assert trial.world.touch().elsewhere == ()
    assert record.sim_steps == trial.world.steps > 1000
    assert trial.plan is not None
    assert record.widening_mm == 1000 * trial.plan.widening
    assert record.shortfall_mm == 1000 * trial.plan.shortfall
    assert set(trial.clock.seconds) == {"build", "settle", "render", "sense", "predict", "plan", "execute"}


def test_no_grasp_when_nothing_is_proposed(scenario: Scenario, lying: ObjectModel) -> None:
    record = attempt(scenario, lying, Says([])).record
    assert record.outcome is Outcome.NO_GRASP
    assert record.grasp is None


def test_ik_failed_when_the_object_lies_beyond_the_arm(scenario: Scenario, lying: ObjectModel) -> None:
    far = changed(
        scenario,
        table={"center": (1.3, 0.0)},
        camera={"position": (1.3, 0.0, 0.55), "target": (1.3, 0.0, 0.0)},
    )
    record = attempt(far, lying, Seen()).record
    assert record.outcome is Outcome.IK_FAILED
    assert "no joint angles" in record.detail
    assert record.grasp is not None
    assert record.pose is None


def test_missed_when_the_grasp_holds_bare_table(scenario: Scenario, lying: ObjectModel) -> None:
    record = attempt(scenario, lying, Displaced()).record
    assert record.outcome is Outcome.MISSED
    assert record.tcp_error is not None
    assert record.tcp_error[0] < 0.001


@pytest.fixture(scope="module")
def tower(tmp_path_factory: pytest.TempPathFactory) -> ObjectModel:
    """A low block with a tower at one end, higher than the fingers are long."""
    folder = tmp_path_factory.mktemp("tower")
    parts = [
        Part(box(100, 40, 25), "#00aa00", "wood", "convex"),
        Part(move(box(30, 40, 110), x=35), "#00aa00", "wood", "convex"),
    ]
    build_shape(ObjectSpec("tower", "tower", "toys", 0.4, "wood", "made up", lambda: parts), folder)
    details = json.loads((folder / "tower" / "shape.json").read_text())
    inertia = np.array(details["inertia"])
    model = ObjectModel("tower", "tower", folder / "tower", 0.4, inertia, 0.7, (), details["fingerprint"])
    cloud = np.vstack(model.hulls)
    low, middle = cloud[:, 2].min(), (cloud[:, 0].min() + cloud[:, 0].max()) / 2
    grasp = ReferenceGrasp(np.array([middle, 0, low + 0.002]), np.array([0, 1.0, 0]), 0.06, 0.025, 1.0)
    return replace(model, poses=(RestingPose(np.array([1.0, 0, 0, 0]), -low, 1.0, (grasp,)),))


def test_a_tower_that_the_hand_would_meet_is_seen(scenario: Scenario, tower: ObjectModel) -> None:
    trial = attempt(scenario, tower, Seen())
    assert trial.record.outcome is Outcome.BLOCKED
    assert (trial.record.widening_mm, trial.record.shortfall_mm) == (None, None)
    assert "above its top, as something is under the hand; the arm did not move" in trial.record.detail
    assert "-" not in trial.record.detail
    assert trial.plan is None


def test_approach_collision_where_the_camera_is_not_where_it_is_thought(
    scenario: Scenario, lying: ObjectModel
) -> None:
    trial = attempt(changed(scenario, calibration={"position_mm": 25.0}), lying, Seen())
    assert trial.record.outcome is Outcome.APPROACH_COLLISION
    assert trial.record.detail.startswith("the gripper met the object with ")
    assert trial.plan is not None  # it was planned, and physics stopped it


def test_missed_when_the_jaws_squeeze_a_slippery_corner(scenario: Scenario, lying: ObjectModel) -> None:
    slippery = changed(scenario, gripper={"friction_scale": 0.05}, table={"friction": 0.05})
    c = math.sqrt(0.5)
    corner = At((0.0125, 0.0325, 0), (c, -c, 0), 0.05, 0.03)
    record = attempt(slippery, lying, corner).record
    assert record.outcome is Outcome.MISSED
    assert record.lift_height == 0


def test_slipped_when_friction_cannot_carry_the_weight(scenario: Scenario, lying: ObjectModel) -> None:
    # 2 · 60 N · 0.7 · 0.004 = 0.34 N of friction against a weight of 0.78 N.
    record = attempt(changed(scenario, gripper={"friction_scale": 0.004}), lying, Seen()).record
    assert record.outcome is Outcome.SLIPPED
    assert record.lift_height < 0.01


def test_dropped_when_friction_carries_the_weight_but_no_rush(scenario: Scenario, lying: ObjectModel) -> None:
    # 2 · 20 N · 0.7 · 0.034 = 0.95 N against 0.78 N at rest; carried steeply upwards it weighs twice that.
    hasty = changed(
        scenario,
        gripper={"friction_scale": 0.034, "force": 20.0},
        motion={"carry_to": (0.5, 0.0, 0.25), "carry_speed": 3.0, "speed_fraction": 1.0},
    )
    record = attempt(hasty, lying, Seen()).record
    assert record.outcome is Outcome.DROPPED
    assert record.lift_height == pytest.approx(0.2, abs=0.003)  # the lift went well
    assert record.contact_force == 0
    gentle = changed(hasty, motion={"carry_speed": 0.2})
    assert attempt(gentle, lying, Seen()).record.outcome is Outcome.SUCCESS


def test_dropped_when_it_is_put_down_instead_of_held(scenario: Scenario, lying: ObjectModel) -> None:
    low = changed(scenario, motion={"carry_to": (0.4, 0.25, -0.2)})
    record = attempt(low, lying, Seen()).record
    assert record.outcome is Outcome.DROPPED
    assert "0 mm above its place" in record.detail


def test_dropped_when_something_else_supports_it_at_the_end(
    scenario: Scenario, lying: ObjectModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(World, "touch", lambda self: Touch(10.0, 10.0, ("table",)))
    record = attempt(scenario, lying, Seen()).record
    assert record.outcome is Outcome.DROPPED
    assert record.detail == "still touching table at the end"


def test_unstable_when_the_object_still_falls_at_the_timeout(scenario: Scenario, lying: ObjectModel) -> None:
    falling = changed(scenario, settling={"clearance": 0.2, "timeout": 0.1})
    record = attempt(falling, lying, Seen()).record
    assert record.outcome is Outcome.UNSTABLE
    assert "not at rest" in record.detail


def test_unstable_when_the_simulation_diverges(scenario: Scenario, lying: ObjectModel) -> None:
    def push(world: World) -> None:
        world.data.qvel[:] = 1e12

    record = attempt(scenario, lying, Seen(), observer=push).record
    assert record.outcome is Outcome.UNSTABLE
    assert record.detail == "MuJoCo warning badqvel"
    assert record.grasp is not None  # what was known until then is kept


def test_a_diverged_world_is_not_stepped_on(scenario: Scenario, lying: ObjectModel) -> None:
    world = World(attempt(scenario, lying, Says([])).world.model, scenario)  # type: ignore[union-attr]
    world.data.qvel[:] = np.nan
    with pytest.raises(UnstableError, match="badqvel"):
        world.step(1)


# ---------------------------------------------------------------- predictors that answer nonsense


@pytest.mark.parametrize(
    ("predictor", "words"),
    [
        (Raises(), "the predictor raised ZeroDivisionError: by nought"),
        (Says(None), "must return a list of Grasp or GraspPose, got NoneType"),
        (Says(np.zeros((3, 5))), "must return a list of Grasp or GraspPose, got ndarray"),
        (Says([(1, 2, 3, 4, 5)]), "grasp 0 is a tuple"),
        (Says([Grasp(160, 120, math.nan, 40)]), "holds NaN"),
        (Says([Grasp(160, 120, 0, 40), Grasp(160, 120, 0, math.inf)]), "grasp 1 holds NaN or infinity"),
        (Says([Grasp("a", 120, 0, 40)]), "not a number"),  # type: ignore[arg-type]
        (Says([Grasp(321, 120, 0, 40)]), "outside the 320×240 image"),
        (Says([Grasp(160, -0.5, 0, 40)]), "outside the 320×240 image"),
        (Says([Grasp(160, 120, 0, 0)]), "width of 0.000 px"),
    ],
)
def test_error_names_what_is_wrong_with_an_answer(
    scenario: Scenario, lying: ObjectModel, predictor: Any, words: str
) -> None:
    record = attempt(scenario, lying, predictor).record
    assert record.outcome is Outcome.ERROR
    assert words in record.detail


def test_a_control_that_needs_the_truth_refuses_without(scenario: Scenario, lying: ObjectModel) -> None:
    class Cheat:
        def predict(self, image: RgbdImage) -> list[Grasp]:
            return Oracle().predict(image)

    record = attempt(scenario, lying, Cheat()).record
    assert record.outcome is Outcome.ERROR
    assert "needs the simulator's truth" in record.detail


# ---------------------------------------------------------------- ranking, records, repetition


@pytest.fixture
def afar(scenario: Scenario) -> Scenario:
    """Objects within the arm's reach, the upper corners of the picture beyond it."""
    return changed(
        scenario,
        table={"center": (0.72, 0.0)},
        camera={"position": (0.72, 0.0, 0.55), "target": (0.72, 0.0, 0.0)},
    )


def test_the_best_grasp_that_can_be_carried_out_is_taken(afar: Scenario, lying: ObjectModel) -> None:
    class Second(Oracle):
        def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
            return [Grasp(2, 2, 0, 40), *super().predict_from_truth(image, truth)]

    record = attempt(afar, lying, Second()).record
    assert record.outcome is Outcome.SUCCESS
    assert record.rank == 1


def test_where_no_grasp_can_be_done_the_best_one_tells_why(afar: Scenario, lying: ObjectModel) -> None:
    record = attempt(afar, lying, Says([Grasp(2, 2, 0, 40), Grasp(318, 2, 0, 40)])).record
    assert record.outcome is Outcome.IK_FAILED
    assert record.rank == 0
    assert record.grasp == Grasp(2, 2, 0, 40)


def test_angles_and_qualities_are_brought_into_range(scenario: Scenario, lying: ObjectModel) -> None:
    record = attempt(scenario, lying, Says([Grasp(20, 20, 4.0, 40, 7.0)])).record
    assert record.grasp is not None
    assert record.grasp.angle == pytest.approx(4.0 - math.pi)
    assert record.grasp.quality == 1.0


def test_a_trial_repeats_exactly_whatever_its_cell_did_before(
    scenario: Scenario, models: dict[str, ObjectModel]
) -> None:
    cell = Workcell(scenario)
    first = run_trial(cell, models["bar"], Seen(), trial=0, attempt=3, seed=9)
    run_trial(cell, models["pot"], Seen(), trial=1, attempt=0, seed=9)
    again = run_trial(cell, models["bar"], Seen(), trial=0, attempt=3, seed=9)
    assert first.record.to_json() == again.record.to_json()
    assert first.image is not None
    assert again.image is not None
    np.testing.assert_array_equal(first.image.depth, again.image.depth)
    other = run_trial(cell, models["bar"], Seen(), trial=0, attempt=4, seed=9)
    assert other.image is not None
    assert (other.image.depth != first.image.depth).any()


def test_records_are_plain_json_with_every_field(scenario: Scenario, lying: ObjectModel) -> None:
    for predictor in (Seen(), Says([])):
        record = attempt(scenario, lying, predictor).record.to_json()
        assert json.loads(json.dumps(record, allow_nan=False)) == record
        planned = {"widening_mm", "shortfall_mm"} if record["pose"] else set()
        assert set(record) == planned | {
            "trial",
            "object",
            "category",
            "seed",
            "outcome",
            "success",
            "detail",
            "grasp",
            "pose",
            "rank",
            "tcp_error",
            "lift_height",
            "contact_force",
            "sim_steps",
        }
        assert [record[k] for k in ("trial", "object", "category", "seed")] == [5, "block", "box", 2]


def test_faults_of_the_harness_are_told_from_those_of_the_predictor() -> None:
    assert set(HARNESS_FAULTS) == {Outcome.UNSTABLE, Outcome.TIMEOUT, Outcome.ERROR}
    assert len(Outcome) == 11


def test_without_a_cache_folder_a_trial_still_runs(
    scenario: Scenario, lying: ObjectModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setenv("GRASP_BENCH_CACHE", str(blocked))
    assert attempt(scenario, lying, Says([])).record.outcome is Outcome.NO_GRASP
