"""Whether the arm reaches where a scenario puts objects."""

from __future__ import annotations

import pytest

from grasp_bench.planning.reach import check_reach
from grasp_bench.scenario.reading import known_within_reach, load_scenario, with_value


@pytest.mark.parametrize("name", ["table4", "clutter"])
def test_what_is_known_to_be_within_reach_is(name: str) -> None:
    scenario = load_scenario(name)
    assert known_within_reach(scenario)
    check_reach(scenario)


@pytest.mark.parametrize(
    ("parameter", "value"),
    [
        ("robot.arm", "ur5e"),
        ("table.center", [0.9, 0.0]),
        ("table.workspace", [0.06, 0.07]),
        ("motion.lift_height", 0.3),
        ("motion.carry_to", [0.4, 0.3, 0.0]),
    ],
)
def test_nothing_is_known_of_other_places(parameter: str, value: object) -> None:
    assert not known_within_reach(with_value(load_scenario("table4"), parameter, value))
