"""How the arm brings a camera on its wrist to where it is to see from."""

from __future__ import annotations

from functools import partial

import numpy as np

from grasp_bench.errors import ScenarioError
from grasp_bench.grasps import GraspPose
from grasp_bench.planning.planner import Planner
from grasp_bench.robot.trajectory import Trajectory, through

STILL = 0.15
"""Time for which the arm stands still before a picture [s]."""
LOOKS = 24
"""Postures on the way to a view that are looked at."""


def view_motions(planner: Planner) -> list[tuple[GraspPose, Trajectory]]:
    """Return the TCP pose of each of a wrist camera's views and the motion to it from the one before,
    beginning at home; the way home comes last.

    Raises:
        ScenarioError: for a view that the arm cannot bring its camera to.
    """
    scenario, robot, ik = planner.scenario, planner.robot, planner.ik
    period = scenario.physics.timestep * scenario.physics.control_steps
    move = partial(
        through,
        period=period,
        speed_fraction=scenario.motion.speed_fraction,
        limits=robot.arm.velocity_limits,
    )
    home = np.asarray(robot.arm.home)
    last, ways = home, []
    for i, pose in enumerate(scenario.camera.dome):
        flange = pose.position - pose.rotation @ np.array(scenario.camera.hand_eye)
        tcp = GraspPose(flange + robot.gripper.flange_to_tcp * pose.rotation[:, 2], pose.rotation, 0.0)
        solutions = [*ik.solve_grasp(tcp), *ik.solve_tilted(tcp)]
        right = [q for found, q in solutions if np.allclose(found.rotation, tcp.rotation, atol=1e-6)]
        hidden = [planner.obstacles.in_view(q, pose, scenario.camera.intrinsics) for q in right]
        ranked = [
            right[i] for i in np.argsort(hidden, kind="stable")
        ]  # rather without the arm in the picture
        q = next((q for q in ranked if _free(planner, move([last, q]))), None)
        if q is None:
            x, y, z = pose.position
            raise ScenarioError(
                f"Scenario {scenario.name!r}: arm {robot.arm.name} cannot bring its wrist camera to view {i} "
                f"at ({x:.2f}, {y:.2f}, {z:.2f}) m; change camera.position, camera.views, camera.dome_deg or "
                "camera.hand_eye."
            )
        ways.append((ik.forward(q), _and_still(move([last, q]), period)))
        last = q
    return [*ways, (ik.forward(home), _and_still(move([last, home]), period))]


def _free(planner: Planner, way: Trajectory) -> bool:
    """Return whether the arm meets neither itself nor the table."""
    looks = np.linspace(0, len(way.positions) - 1, LOOKS).astype(int)
    wide, none = planner.robot.gripper.opening, np.zeros((0, 3))
    return not any(planner.obstacles.arm(none, q, wide) for q in way.positions[looks])


def _and_still(way: Trajectory, period: float) -> Trajectory:
    """Return a motion after which the arm stands still for :data:`STILL`."""
    rest = np.repeat(way.end[None], max(1, round(STILL / period)), axis=0)
    return way.then(Trajectory(rest, np.zeros_like(rest)))
