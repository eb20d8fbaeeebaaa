"""A plate held off-centre turns about the pads where their torsional friction is exceeded.

Two closed forms, one for each way of touching:

* One point of contact per pad (a pointed body): the soft-finger limit surface is the ellipsoid
  (f / μN)² + (τ / μ_t N)² = 1 (Howe and Cutkosky 1996, "Practical force-motion models for sliding
  manipulation"; MuJoCo's elliptic cone with condim 4). With the weight W at a distance d from both
  points, W² (1/μ² + d²/μ_t²) = (2 F)².
* A flat plate, touched at the four corners of each pad: the load of plastic collapse is the least over
  all centres of rotation c of Σ N √(μ² |p − c|² + μ_t²) / |d − c|, the upper-bound theorem for planar
  sliding (Goyal, Ruina and Papadopoulos 1991, "Planar sliding with dry friction").
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from grasp_bench.doctor.physics.check import Check, equals
from grasp_bench.doctor.physics.rig import Body, Rig, block, threshold
from grasp_bench.robot.gripper import Gripper
from grasp_bench.scenario.sections import Scenario

G = 9.81
TURNED = np.radians(1.0)
"""A body that turns further than this in half a second is slipping [rad]."""


def torsion(scenario: Scenario) -> list[Check]:
    """Check the least force per pad [N] that holds a pointed body and a plate off-centre."""
    return [pointed(scenario), plate(scenario)]


def least_force(rig: Rig, expected: float, off_centre: float) -> float:
    """Find the least force per pad [N] at which the body does not turn."""

    def turns(force: float) -> bool:
        rig.grip(force, (-off_centre, 0.0))
        return rig.moved(0.5)[1] > TURNED

    return threshold(turns, 0.7 * expected, 1.4 * expected)


def pointed(scenario: Scenario, mass: float = 2.0, friction: float = 0.7, off_centre: float = 0.01) -> Check:
    """Check a body that each pad touches in one point, ``off_centre`` [m] beside its centre of mass."""
    points = np.array([[0.02, 0, 0], [-0.02, 0, 0], [0, 0.01, 0], [0, -0.01, 0], [0, 0, 0.01], [0, 0, -0.01]])
    body = Body(points - [0, off_centre, 0], mass, mass * 1e-4 * np.eye(3), friction)
    twist = scenario.gripper.torsional_friction
    mu = friction * scenario.gripper.friction_scale
    expected = mass * G / 2 * np.sqrt(1 / mu**2 + (off_centre / twist) ** 2)
    force = least_force(Rig(scenario, body), float(expected), off_centre)
    return equals(
        f"least grip force, points {1000 * off_centre:g} mm off-centre, {mass:g} kg",
        float(expected),
        force,
        "N",
        0.05,
        "soft finger: (W/2F)² (1/μ² + d²/μ_t²) = 1",
    )


def plate(scenario: Scenario, mass: float = 1.0, friction: float = 0.7, off_centre: float = 0.06) -> Check:
    """Check a plate of 6 mm held flat between the pads, ``off_centre`` [m] beside its centre of mass."""
    body = block((0.006, 0.16, 0.06), mass, friction)
    mu = friction * scenario.gripper.friction_scale
    expected = (
        mass
        * G
        / collapse(mu, scenario.gripper.torsional_friction, off_centre, scenario.robot.loaded.gripper)
    )
    force = least_force(Rig(scenario, body), expected, off_centre)
    return equals(
        f"least grip force, plate {1000 * off_centre:g} mm off-centre, {mass:g} kg",
        expected,
        force,
        "N",
        0.05,
        "plastic collapse of eight frictional points",
    )


def collapse(friction: float, twist: float, off_centre: float, gripper: Gripper) -> float:
    """Return the weight at ``off_centre`` [m] that makes a plate turn, per newton of grip force on each pad.

    Each pad presses with a quarter at each of its corners; by symmetry the centre of rotation lies on
    the horizontal through the pads' centre.
    """
    _, width, height = gripper.pad
    corners = np.array([[y, z] for y in (-width / 2, width / 2) for z in (-height / 2, height / 2)])

    def weight(centre: float) -> float:
        squared = ((corners - [centre, 0.0]) ** 2).sum(1)
        return 2 * float(np.sqrt(friction**2 * squared + twist**2).mean()) / abs(off_centre - centre)

    return float(minimize_scalar(weight, bounds=(-0.5, 0.9 * off_centre), method="bounded").fun)
