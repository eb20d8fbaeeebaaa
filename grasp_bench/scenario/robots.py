"""A scenario with another arm or gripper."""

from __future__ import annotations

from grasp_bench.robot.grippers import load_gripper
from grasp_bench.scenario.reading import parse_scenario
from grasp_bench.scenario.sections import Scenario


def with_gripper(scenario: Scenario, name: str) -> Scenario:
    """Return the scenario with another gripper, used as before as far as that can.

    Force, speed and squeeze are brought within its limits.

    Raises:
        UnknownNameError, AssetError: for a gripper that is none.
    """
    able = load_gripper(name)
    content = scenario.model_dump(mode="json")
    content["robot"]["gripper"] = name
    use = content["gripper"]
    use["force"] = min(max(use["force"], able.force[0]), able.force[1])
    use["closing_speed"] = min(use["closing_speed"], able.speed)
    use["squeeze"] = min(use["squeeze"], able.squeeze)
    return parse_scenario(content, name)
