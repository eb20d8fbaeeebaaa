"""Margins of grips: against closed forms, monotone, repeatable, and only where the scenario asks for them."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from test_outcomes import At, Says, attempt, changed

from grasp_bench.doctor.physics.margin import broken, flat_torque, margin
from grasp_bench.doctor.physics.rig import Rig, block
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.predictors.controls import Oracle
from grasp_bench.runs.record import MarginRecord, TrialRecord
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Margin, Scenario
from grasp_bench.trials.margin import FORCES, LOADS, STEP, TORQUES, measure

CUBE = (0.04, 0.04, 0.04)


def held(scenario: Scenario, friction: float = 0.7, force: float = 60.0, mass: float = 0.5) -> Rig:
    rig = Rig(scenario, block(CUBE, mass, friction))
    rig.grip(force)
    return rig


def test_breaking_loads_are_those_of_the_closed_forms(table4: Scenario) -> None:
    checks = margin(table4)
    assert len(checks) == 29
    failed = [f"{c.name}: {c.measured:.4g} {c.unit}, not {c.expected:.4g}" for c in checks if not c.passed]
    assert not failed
    assert np.mean([c.error for c in checks]) < 0.02


def test_the_least_of_all_directions_counts_with_the_weight_against_it(table4: Scenario) -> None:
    rig = held(table4, mass=2.0)
    found = measure(rig.world, Margin())
    weight = 2.0 * 9.81
    assert found.direction == "+approach"  # downwards, with the weight
    assert found.force == pytest.approx(2 * 0.7 * 60 - weight, rel=0.02)
    assert found.factor == pytest.approx(found.force / weight)
    assert found.torque == pytest.approx(flat_torque(0.7, 0.005, 60, weight), rel=0.05)


@pytest.mark.parametrize(
    "raised",
    [
        lambda s, x: held(s, friction=0.2 + 0.2 * x),
        lambda s, x: held(s, force=30 + 15 * x),
        lambda s, x: held(s, mass=3 - 0.7 * x),
    ],
    ids=["friction", "force", "lightness"],
)
def test_margins_grow_with_friction_force_and_lightness(
    table4: Scenario, raised: Callable[[Scenario, float], Rig]
) -> None:
    found = [measure(raised(table4, x).world, Margin()) for x in (0.0, 1.0, 2.0, 3.0)]
    for name in ("factor", "torque"):
        values = [getattr(m, name) for m in found]
        assert values == sorted(values)
        assert values[-1] > values[0]
    assert found[-1].factor > 1.1 * found[0].factor


def test_a_second_measurement_and_any_order_of_directions_give_the_same(table4: Scenario) -> None:
    rig = held(table4)
    first = measure(rig.world, Margin())
    assert measure(rig.world, Margin()) == first
    shuffled = list(LOADS)
    for seed in range(4):
        random.Random(seed).shuffle(shuffled)
        assert measure(rig.world, Margin(), shuffled) == first
    assert min(broken(rig, load) for load in FORCES) == first.force
    assert min(broken(rig, load) for load in TORQUES) == first.torque


def test_the_world_is_left_as_it_was(table4: Scenario) -> None:
    rig = held(table4)
    before = [rig.data.qpos.copy(), rig.data.qvel.copy(), rig.data.xfrc_applied.copy(), rig.data.xpos.copy()]
    armature, steps = rig.model.dof_armature.copy(), rig.world.steps
    measure(rig.world, Margin())
    after = [rig.data.qpos, rig.data.qvel, rig.data.xfrc_applied, rig.data.xpos]
    for a, b in zip(before, after, strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(armature, rig.model.dof_armature)
    assert rig.world.steps == steps


def test_no_greater_load_than_the_cap_is_tried(table4: Scenario) -> None:
    rig = held(table4)
    found = measure(rig.world, Margin(force_cap=20, torque_cap=0.5))
    assert (found.force, found.torque) == (20.0, 0.5)
    just = measure(rig.world, Margin(force_cap=200, torque_cap=10))
    assert 20 < just.force < 200


def test_what_hardly_bears_itself_bears_nothing_more(table4: Scenario) -> None:
    weight = 2 * 0.7 * 60 - 0.05
    rig = held(table4, mass=weight / 9.81)
    assert measure(rig.world, Margin(), FORCES).force < 0.01 * weight


def test_a_shorter_distance_breaks_no_later(table4: Scenario) -> None:
    rig = held(table4)
    near = measure(rig.world, Margin(distance=0.001, angle_deg=2))
    far = measure(rig.world, Margin(distance=0.02, angle_deg=40))
    assert near.force <= far.force * STEP
    assert near.torque <= far.torque * STEP


# ---------------------------------------------------------------- in trials


@pytest.fixture(scope="module")
def graded(scenario: Scenario) -> Scenario:
    return scenario.model_copy(update={"margin": Margin()})


def test_a_graded_trial_is_the_same_with_a_margin(
    scenario: Scenario, graded: Scenario, models: dict[str, ObjectModel]
) -> None:
    plain = attempt(scenario, models["block"], Oracle())
    firm = attempt(graded, models["block"], Oracle())
    assert plain.record.margin is None
    assert "margin" not in plain.record.to_json()
    found = firm.record.margin
    assert found is not None
    assert {k: v for k, v in firm.record.to_json().items() if k != "margin"} == plain.record.to_json()
    weight = models["block"].mass * 9.81
    assert found.factor == pytest.approx(found.force / weight, rel=1e-3)
    assert 5 < found.factor < 200
    assert found.torque > 0.05
    assert "margin" in firm.clock.seconds
    assert attempt(graded, models["block"], Oracle()).record.line() == firm.record.line()


def test_a_failure_has_a_margin_of_nought(graded: Scenario, models: dict[str, ObjectModel]) -> None:
    record = attempt(graded, models["block"], Says([])).record
    assert record.outcome is Outcome.NO_GRASP
    assert record.margin == MarginRecord()
    assert record.to_json()["margin"] == {"force": 0.0, "factor": 0.0, "direction": "", "torque": 0.0}


def test_half_the_friction_holds_less_firmly(graded: Scenario, models: dict[str, ObjectModel]) -> None:
    grasp = At((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.06, 0.03)
    firm, slippery = (
        attempt(changed(graded, gripper={"friction_scale": s}), models["block"], grasp).record.margin
        for s in (1.0, 0.5)
    )
    assert firm is not None
    assert slippery is not None
    assert 0 < slippery.factor < 0.7 * firm.factor


def test_graded_scenarios_differ_from_table4_in_the_margin_alone() -> None:
    table4, graded = load_scenario("table4"), load_scenario("graded")
    differ = {k for k, v in graded if v != getattr(table4, k)}
    assert differ == {"name", "description", "margin"}
    assert graded.margin == Margin()
    alone = load_scenario("graded-as-predicted")
    assert not alone.execution.assisted
    assert alone.margin == Margin()


@pytest.mark.parametrize(
    "wrong", [{"force": "much"}, {"force": -1.0}, {"factor": math.inf}, {"direction": 3}, [], "firm"]
)
def test_a_broken_margin_is_refused_by_name(wrong: Any) -> None:
    content = {"trial": 0, "object": "mug", "category": "mug", "outcome": "success", "margin": wrong}
    with pytest.raises(ValueError, match="'margin' must be an object or null"):
        TrialRecord.read(content)


def test_margins_are_written_and_read_alike() -> None:
    margin = MarginRecord(force=12.34567, factor=3.141592, direction="+across", torque=0.1234567)
    record = TrialRecord(trial=0, object="a", category="b", outcome=Outcome.SUCCESS, margin=margin)
    again = TrialRecord.read(record.to_json())
    assert again.margin == MarginRecord(force=12.346, factor=3.1416, direction="+across", torque=0.12346)
    assert again.line() == record.line()
