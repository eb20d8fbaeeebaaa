"""A second gripper is a file with its facts: nothing else knows the names and numbers of the first."""

from __future__ import annotations

import shutil
from dataclasses import replace

import numpy as np
import pytest

from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.planning.depth import openings
from grasp_bench.planning.heightfield import CELL, HeightField, analyse, maxima
from grasp_bench.planning.planner import Planner
from grasp_bench.robot.ec66 import EC66
from grasp_bench.robot.grippers import load_gripper
from grasp_bench.robot.kinematics import InverseKinematics
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.robot.robot import EC66_PARALLEL_85, Robot
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import compile_mjcf, compile_scene, compose
from grasp_bench.scene.floating import FloatingGripper, compile_floating
from grasp_bench.scene.world import World

FACTS = """
title: hand
model: hand.xml
actuator: motor
commands: {open: 0.03, closed: 0}
fingers: [thumb_finger, index_finger]
pads: [thumb_pad, index_pad]
palm: hand
tcp: between
force: [20, 235]
speed: 0.15
squeeze: 0.03
"""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """The EC66 under another name, with a gripper of other names that opens to 60 mm."""
    folder = tmp_path_factory.mktemp("robot")
    text = PARALLEL_85.path.read_text()
    for old, new in (
        ("left_", "thumb_"),
        ("right_", "index_"),
        ('body name="gripper"', 'body name="hand"'),
        ('body1="gripper"', 'body1="hand"'),
        ('position name="gripper"', 'position name="motor"'),
        ('site name="tcp"', 'site name="between"'),
        ('range="0 0.0425"', 'range="0 0.03"'),
    ):
        assert old in text
        text = text.replace(old, new)
    (folder / "hand.xml").write_text(text)
    shutil.copytree(PARALLEL_85.path.parent / "meshes", folder / "meshes")
    (folder / "gripper.yaml").write_text(FACTS)
    gripper = load_gripper(str(folder))
    return Robot(replace(EC66, scope="manipulator"), replace(gripper, scope="tool"))


def test_a_world_is_told_its_robot(robot: Robot, table4: Scenario, models: dict[str, ObjectModel]) -> None:
    world = World(compile_mjcf(compose(table4, models["block"], robot)), table4, robot=robot)
    world.place_object(np.array([0.5, 0, 0.1]), np.array([1.0, 0, 0, 0]))
    world.step(1)
    assert world.tcp.opening == pytest.approx(0.06, abs=1e-4)
    home = InverseKinematics(robot).forward(np.array(robot.arm.home))
    np.testing.assert_allclose(world.tcp.position, home.position, atol=1e-4)
    assert [world.model.geom(i).name for i in world.pads] == [
        "manipulator/tool/thumb_pad",
        "manipulator/tool/index_pad",
    ]


def test_compiled_scenes_of_two_robots_are_two(
    robot: Robot, table4: Scenario, models: dict[str, ObjectModel]
) -> None:
    first = compile_scene(table4, models["block"])
    other = compile_scene(table4, models["block"], robot)
    assert first.body("arm/gripper/gripper").id == other.body("manipulator/tool/hand").id


def test_the_floating_gripper_holds_with_it(
    robot: Robot, table4: Scenario, models: dict[str, ObjectModel]
) -> None:
    block = models["block"]
    gripper = FloatingGripper(compile_floating(table4, [block], robot.gripper), table4, 1, robot.gripper)
    q = gripper.object_q[0]
    gripper.data.qpos[q : q + 7] = [0.5, 0, 0.0155, 1, 0, 0, 0]
    assert gripper.settle(1.0)
    assert gripper.attempt(gripper.state(), np.array([0.5, 0, 0.005]), 0.0, 0.055).held


def test_a_planner_opens_the_jaws_that_it_has(robot: Robot, table4: Scenario) -> None:
    planner = Planner(table4, robot)
    assert planner.ik.robot is robot
    assert max(openings(0.2, robot.gripper.opening)) == 0.06
    origin = -0.1 + CELL / 2
    heights = np.zeros((100, 100), np.float32)
    heights[20:80, 32:68] = 0.04  # 72 mm wide
    field = HeightField(heights, (origin, origin), (0.0, 0.0))
    across = np.array([0.0])
    assert maxima(analyse(field, across), 1)
    assert not maxima(analyse(field, across, gripper=robot.gripper), 1)


def test_kinematics_knows_the_length_of_the_gripper() -> None:
    other = load_gripper("parallel-140")
    ours, theirs = (
        InverseKinematics(r).forward(np.array(EC66.ready)).position
        for r in (EC66_PARALLEL_85, Robot(EC66, other))
    )
    longer = other.flange_to_tcp - PARALLEL_85.flange_to_tcp
    assert longer > 0.01
    np.testing.assert_allclose(ours - theirs, [0, 0, longer], atol=1e-9)
