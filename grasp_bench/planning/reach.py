"""Whether the arm reaches where a scenario puts objects, asked before any trial."""

from __future__ import annotations

import math

import numpy as np

from grasp_bench.errors import ScenarioError
from grasp_bench.grasps import GraspPose
from grasp_bench.planning.planner import Planner, straight
from grasp_bench.planning.viewing import view_motions
from grasp_bench.robot.kinematics import InverseKinematics
from grasp_bench.scenario.sections import Scenario
from grasp_bench.system.arrays import Floats

HEIGHTS = (0.005, 0.12)
"""Heights of the finger tips that are asked for [m]."""
YAWS = (0.0, math.pi / 4, math.pi / 2, 3 * math.pi / 4)
"""Directions of the jaws [rad]; half a turn more is the same grasp."""
SURVEY = np.arange(0.10, 1.01, 0.05)
"""Distances ahead of the base at which the error says what can be reached [m]."""


def reaches(ik: InverseKinematics, scenario: Scenario, place: Floats, yaw: float) -> bool:
    """Return whether the arm gets the TCP to ``place`` (3,) [m], up from there, and to where things are
    carried."""
    motion = scenario.motion
    lifted = place + [0, 0, motion.lift_height]
    target = np.array([*motion.carry_to[:2], lifted[2] + motion.carry_to[2]])
    for candidate, q in ik.solve_grasp(GraspPose.top_down(place, yaw, 0.0)):
        way = [*straight(place, lifted), *straight(lifted, target)]
        if ik.follow([GraspPose(p, candidate.rotation, 0.0) for p in way], q) is not None:
            return True
    return False


def check_reach(scenario: Scenario) -> None:
    """Refuse a scenario whose workspace its arm does not reach, or views of a wrist camera.

    Asked are the workspace's corners and its middle, at :data:`HEIGHTS` and :data:`YAWS`.

    Raises:
        ScenarioError: in one line, with how much is reached and where the arm would.
    """
    robot = scenario.robot.loaded
    ik = InverseKinematics(robot)
    half = np.array(scenario.table.workspace if scenario.clutter is None else scenario.clutter.workspace)
    centre = np.array(scenario.table.center)
    corners = [centre + half * side for side in ((0, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))]
    asked = [(np.array([*c, z]), yaw) for c in corners for z in HEIGHTS for yaw in YAWS]
    out = [(place, yaw) for place, yaw in asked if not reaches(ik, scenario, place, yaw)]
    if not out:
        if scenario.camera.mount == "wrist":
            view_motions(Planner(scenario))
        return
    place, yaw = out[0]
    x = [float(d) for d in SURVEY if reaches(ik, scenario, np.array([d, centre[1], HEIGHTS[0]]), 0.0)]
    where = f"from x = {min(x):.2f} to {max(x):.2f} m" if x else "nowhere"
    raise ScenarioError(
        f"Scenario {scenario.name!r}: arm {robot.arm.name} with gripper {robot.gripper.name} reaches only "
        f"{len(asked) - len(out)} of {len(asked)} places that its workspace asks for, not for example "
        f"({place[0]:.2f}, {place[1]:.2f}, {place[2]:.3f}) m with jaws at {math.degrees(yaw):.0f}°. At y = "
        f"{centre[1]:g} m it reaches grasps on the table {where}; change table.center, table.workspace, "
        "motion.lift_height or motion.carry_to, or take another arm."
    )
