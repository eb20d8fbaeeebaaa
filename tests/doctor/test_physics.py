"""The physics of a trial against closed forms, and that the self-tests can fail."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.doctor.physics import suite
from grasp_bench.doctor.physics.check import Check, below, equals
from grasp_bench.doctor.physics.creep import creep
from grasp_bench.doctor.physics.falling import falling
from grasp_bench.doctor.physics.incline import incline
from grasp_bench.doctor.physics.jacobian import jacobian
from grasp_bench.doctor.physics.margin import margin
from grasp_bench.doctor.physics.penetration import penetration
from grasp_bench.doctor.physics.reference import Watched, halved, loads, time_step, watch
from grasp_bench.doctor.physics.rig import Rig, block, threshold
from grasp_bench.doctor.physics.slip import slip
from grasp_bench.doctor.physics.suction import suction
from grasp_bench.doctor.physics.torsion import collapse, torsion
from grasp_bench.doctor.physics.tracking import tracking
from grasp_bench.robot.ec66 import EC66
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.robots import with_gripper
from grasp_bench.scenario.sections import Scenario


@pytest.mark.parametrize("test", [slip, incline, torsion, margin, falling, jacobian, penetration, tracking])
def test_physics_agrees_with_the_closed_form(test: Any, table4: Scenario) -> None:
    checks = test(table4)
    assert checks
    failed = [f"{c.name}: {c.measured:.4g} {c.unit}, not {c.expected:.4g}" for c in checks if not c.passed]
    assert not failed


def test_a_held_box_does_not_creep(table4: Scenario) -> None:
    assert all(c.passed for c in creep(table4, 6.0))


def test_a_suction_cup_agrees_with_statics(table4: Scenario) -> None:
    cup = with_gripper(table4, "suction-20")
    checks = [*suction(cup), *creep(cup, 6.0), *jacobian(cup)]
    assert not [f"{c.name}: {c.measured:.4g} {c.unit}, not {c.expected:.4g}" for c in checks if not c.passed]


def test_without_its_solver_settings_it_would(table4: Scenario) -> None:
    physics = table4.physics.model_copy(update={"noslip_iterations": 0, "impratio": 1.0})
    lax = table4.model_copy(update={"physics": physics})
    assert not creep(lax, 0.5)[0].passed


def test_soft_pads_would_be_found_out(table4: Scenario) -> None:
    rig = Rig(table4, block((0.04, 0.04, 0.04), 0.011, 0.7))
    pads = rig.world.pads
    rig.model.geom_solimp[pads, :3] = 0.95, 0.99, 0.001
    rig.grip(PARALLEL_85.force[1])
    assert -rig.data.contact.dist.min() > 0.5e-3


def test_limits_of_the_plate_are_those_of_statics() -> None:
    assert collapse(0.7, 0.0, 1e-6, PARALLEL_85) == pytest.approx(
        2 * 0.7, rel=1e-3
    )  # a pure force: both pads' friction
    far = 5.0  # nearly a pure torque: each corner resists at its distance from the middle
    assert collapse(0.7, 0.0, far, PARALLEL_85) * far == pytest.approx(
        2 * 0.7 * math.hypot(*PARALLEL_85.pad[1:]) / 2, rel=0.01
    )


def test_verdicts() -> None:
    assert equals("x", 2.0, 2.09, "N", 0.05, "").passed
    assert not equals("x", 2.0, 1.89, "N", 0.05, "").passed
    assert below("x", 0.4, 0.5, "mm", "").passed
    assert not below("x", -0.6, 0.5, "mm", "").passed
    assert not below("x", math.nan, 0.5, "mm", "").passed
    with pytest.raises(ValueError, match="nothing changes between 1 and 2"):
        threshold(lambda x: True, 1, 2)
    assert threshold(lambda x: x < 1.3, 1, 2) == pytest.approx(1.3, abs=1e-3)


def watched(name: str, success: bool, share: float = 0.5) -> Watched:
    return Watched(
        name,
        Outcome.SUCCESS if success else Outcome.MISSED,
        share * np.array(EC66.torque_limits),
        share * np.array(EC66.velocity_limits),
    )


def test_trials_are_compared_one_by_one() -> None:
    whole = [watched(f"o{i}", True) for i in range(50)] + [watched("late", False)]
    half = [watched(f"o{i}", True) for i in range(50)] + [watched("late", True)]
    check = time_step(whole, half)
    assert check.passed
    assert "(1/51)" in check.name
    assert "late" in check.source
    worse = [watched("o0", False), *half[1:]]
    assert not time_step(whole, worse).passed


def test_an_overloaded_joint_is_found() -> None:
    assert all(c.passed for c in loads([watched("a", True), watched("b", True, 0.99)]))
    assert not any(c.passed for c in loads([watched("a", True), watched("b", True, 1.01)]))


def test_half_the_time_step_keeps_the_commands(table4: Scenario) -> None:
    half = halved(table4).physics
    assert half.timestep == table4.physics.timestep / 2
    assert half.timestep * half.control_steps == table4.physics.timestep * table4.physics.control_steps


def test_a_reference_trial_is_watched(scenario: Scenario) -> None:
    done = []
    (trial,) = watch(scenario, ["apple"], workers=1, progress=lambda: done.append(1))
    assert done == [1]
    assert (trial.object, trial.success) == ("apple", True)
    assert (trial.torque > 0).all()
    assert (trial.torque < EC66.torque_limits).all()
    assert 0.3 < (trial.velocity / EC66.velocity_limits).max() < 0.6  # planned for half


@pytest.mark.parametrize(("measured", "code"), [(1.0, 0), (2.0, 1)])
def test_the_command_prints_and_fails(measured: float, code: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def one(scenario: Scenario) -> list[Check]:
        return [equals("gravity", 1.0, measured, "g", 0.1, "Newton")]

    monkeypatch.setattr(suite, "QUICK", (one,))
    shown = CliRunner().invoke(app, ["doctor", "--physics"])
    assert shown.exit_code == code
    assert "gravity" in shown.output
    listed = CliRunner().invoke(app, ["doctor", "--physics", "--json"])
    assert listed.exit_code == code
    assert '"source": "Newton"' in listed.output


def test_full_belongs_to_physics() -> None:
    assert CliRunner().invoke(app, ["doctor", "--full"]).exit_code == 2


@pytest.mark.parametrize("name", ["parallel-50", "parallel-140", "panda-hand"])
def test_other_grippers_hold_as_the_closed_forms_say(name: str) -> None:
    scenario = with_gripper(load_scenario("table4"), name)
    assert scenario.robot.loaded.gripper.name == name
    failed = [c for test in suite.OF_GRIPPER for c in test(scenario) if not c.passed]
    assert not failed


def test_a_gripper_goes_with_physics() -> None:
    done = CliRunner().invoke(app, ["doctor", "--gripper", "panda-hand"])
    assert done.exit_code == 2
    assert "--gripper goes with --physics" in done.output
