"""The shake test: its motion by its own definition, and what it shakes loose."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grasp_bench.grasps import GraspPose
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.planning.planner import Planner
from grasp_bench.planning.shake import AXES, SWELL, amplitude, burst
from grasp_bench.predictors.controls import Oracle
from grasp_bench.robot.ec66 import EC66
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Scenario, Shake
from grasp_bench.scene.world import World
from grasp_bench.trials.attempt import Trial
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell

HARD = Shake(acceleration=5.0)


@pytest.fixture(scope="module")
def lying(models: dict[str, ObjectModel]) -> ObjectModel:
    """The block lying flat: 80 x 40 mm, 30 mm high."""
    return replace(models["block"], poses=tuple(p for p in models["block"].poses if p.height < 0.016)[:1])


def shaking(scenario: Scenario, shake: Shake = HARD, **gripper: float) -> Scenario:
    return scenario.model_copy(
        update={
            "motion": scenario.motion.model_copy(update={"shake": shake}),
            "gripper": scenario.gripper.model_copy(update=gripper),
        }
    )


def attempt(scenario: Scenario, model: ObjectModel, **more: object) -> Trial:
    return run_trial(Workcell(scenario), model, Oracle(), trial=0, attempt=1, seed=2, **more)  # type: ignore[arg-type]


@pytest.mark.parametrize("shake", [HARD, Shake(acceleration=2.0, frequency=8.0, cycles=5)])
def test_a_burst_reaches_its_acceleration_and_ends_at_rest(shake: Shake) -> None:
    period = 1e-4
    offset, speed = burst(shake, period)
    assert len(offset) * period == pytest.approx((shake.cycles + 2 * SWELL) / shake.frequency)
    assert np.abs(np.diff(offset, prepend=0) / period - speed).max() < 0.01 * np.abs(speed).max()
    acceleration = np.diff(speed, prepend=0) / period
    assert np.abs(acceleration).max() == pytest.approx(shake.acceleration, rel=0.02)
    assert np.abs(offset).max() == pytest.approx(amplitude(shake), rel=0.01)
    assert abs(offset[-1]) < 1e-6
    assert abs(speed[-1]) < 1e-5


def test_the_tcp_goes_to_and_fro_on_each_of_its_axes(scenario: Scenario) -> None:
    planner = Planner(shaking(scenario))
    pose = GraspPose.top_down([0.5, 0.05, 0.25], 0.7, 0.05)
    _, q = planner.ik.solve_grasp(pose)[0]
    pose = planner.ik.forward(q)
    bursts = planner.shake(pose, q, 0.004)
    assert bursts is not None
    assert len(bursts) == len(AXES) == 3
    for axis, motion in enumerate(bursts):
        path = np.array([planner.ik.forward(p).position for p in motion.positions]) - pose.position
        along = path @ pose.rotation
        assert np.ptp(along[:, axis]) == pytest.approx(2 * amplitude(HARD), rel=0.03)
        assert np.abs(np.delete(along, axis, axis=1)).max() < 2e-4
        np.testing.assert_allclose(motion.end, q, atol=1e-6)


def test_no_acceleration_means_no_shaking(scenario: Scenario, planner: Planner) -> None:
    assert scenario.motion.shake.acceleration == 0
    assert planner.shake(GraspPose.top_down([0.5, 0, 0.2], 0, 0.05), np.zeros(6), 0.004) == ()


def test_a_shake_faster_than_the_arm_is_refused(scenario: Scenario) -> None:
    planner = Planner(shaking(scenario, Shake(acceleration=20.0, frequency=1.0)))  # 0.5 m to and fro
    pose = GraspPose.top_down([0.5, 0.05, 0.25], 0.7, 0.05)
    assert planner.shake(pose, planner.ik.solve_grasp(pose)[0][1], 0.004) is None


def test_a_firm_grasp_survives_and_the_arm_can_do_it(scenario: Scenario, lying: ObjectModel) -> None:
    places, torques, speeds = [], [], []

    def watch(world: World) -> None:
        places.append(world.tcp.position)
        torques.append(world.joint_torques)
        speeds.append(world.joint_velocities)

    trial = attempt(shaking(scenario), lying, observer=watch)
    assert trial.record.outcome is Outcome.SUCCESS
    assert (np.abs(torques).max(axis=0) < EC66.torque_limits).all()
    assert (np.abs(speeds).max(axis=0) < EC66.velocity_limits).all()
    assert trial.plan is not None
    # What the arm really does, not only what it is told: the amplitude of the vertical burst.
    ends = np.cumsum([len(m.positions) for m in trial.plan.shake])
    after = len(trial.plan.carry.positions) + round(scenario.motion.hold_time / 0.004)
    first = len(places) - after - ends[-1]
    height = np.array(places)[first + ends[1] : first + ends[2], 2]
    assert 0.95 < np.ptp(height) / (2 * amplitude(HARD)) < 1.25  # the servos overshoot by some 15 %


def test_a_weak_grasp_is_shaken_loose(scenario: Scenario, lying: ObjectModel) -> None:
    # 2 · 20 N · 0.7 · 0.036 = 1.0 N carries 80 g (0.78 N), but not at 5 m/s² more (1.18 N).
    weak: dict[str, Any] = {"force": 20.0, "friction_scale": 0.036}
    assert attempt(shaking(scenario, Shake(), **weak), lying).record.outcome is Outcome.SUCCESS
    record = attempt(shaking(scenario, **weak), lying).record
    assert record.outcome is Outcome.DROPPED
    assert record.detail == "lost while shaken along the approach with ±5 m/s²"
    assert record.lift_height == pytest.approx(0.2, abs=0.005)


def test_the_shipped_scenario_differs_from_table4_in_nothing_else(table4: Scenario) -> None:
    shake = load_scenario("shake")
    assert shake.motion.shake.acceleration == 5.0
    assert math.isclose(amplitude(shake.motion.shake), 0.0079, rel_tol=0.01)
    calm = shake.motion.model_copy(update={"shake": table4.motion.shake})
    same = shake.model_copy(update={"motion": calm, "name": table4.name, "description": table4.description})
    assert same == table4
