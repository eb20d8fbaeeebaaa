"""Reads the robot's parts and joins them: the gripper at the arm's flange."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.robot import Robot
from grasp_bench.scenario.sections import Scenario


def load_robot(robot: Robot, scenario: Scenario, friction: float) -> Any:
    """Load the arm with its gripper at the flange, pads set to the object's ``friction``."""
    arm, gripper = load_part(robot.arm.path), load_part(robot.gripper.path)
    arm.model, gripper.model = robot.arm.scope, robot.gripper.scope
    pads = [gripper.find("geom", name) for name in dict.fromkeys(robot.gripper.pads)]
    actuator = gripper.find("actuator", robot.gripper.actuator)
    set_gripper(robot.gripper, pads, actuator, scenario, friction)
    arm.find("site", robot.arm.flange).attach(gripper)
    for key in [*arm.find_all("key"), *gripper.find_all("key")]:
        key.remove()
    return arm


def load_part(path: Path) -> Any:
    """Load arm or gripper, without the solver settings that its file has for viewing it alone.

    Left in, they would meet those of the scenario on attaching: dm_control refuses different values, and
    takes a scenario's 0 for unset.
    """
    from dm_control import mjcf

    part = mjcf.from_path(str(path))
    part.option.remove()
    return part


def set_gripper(
    gripper: Gripper, pads: list[Any], actuator: Any, scenario: Scenario, friction: float
) -> None:
    """Set the friction and stiffness of both pads and the force limit of the actuator of ``gripper``.

    They are elements of its model, of dm_control's or of MuJoCo's own kind. The pads have priority
    over what they touch, so their ``friction`` is the pair's.
    """
    stiffness = scenario.gripper.pad_stiffness
    for pad in pads:
        if stiffness != 1:  # a contact's stiffness goes with 1 / time constant² (MuJoCo, “Solver parameters”)
            time, damping = pad.dclass.geom.solref if pad.solref is None else pad.solref
            pad.solref = [time / math.sqrt(stiffness), damping]
        pad.friction = gripper.pad_friction(
            friction * scenario.gripper.friction_scale, scenario.gripper.torsional_friction
        )
    actuator.forcerange = gripper.actuator_range(scenario.gripper.force)
