"""Breaking forces and torques of held bodies, measured as a graded trial does.

A block held at its centre of mass by pads with F newtons each:

* along the pads the grip bears 2 μ F together with the weight W: the force that breaks it is 2 μ F + W
  upwards, 2 μ F − W downwards, and √((2 μ F)² − W²) across (Coulomb);
* along the jaws the coupled fingers give way at 2 F.

A torque about the jaw axis, the weight being borne besides:

* a pointed body: (W / 2 μ F)² + (τ / 2 μ_t F)² = 1, the limit surface of two soft fingers (Howe and Cutkosky
  1996, "Practical force-motion models for sliding manipulation");
* a flat one, touched at the four corners of each pad: the least over all centres of rotation of what eight
  frictional points dissipate, less the power of the weight (Goyal, Ruina and Papadopoulos 1991, "Planar
  sliding with dry friction").
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import minimize_scalar

from grasp_bench.doctor.physics.check import Check, equals
from grasp_bench.doctor.physics.rig import Body, Rig, block
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.sections import Margin, Scenario
from grasp_bench.trials.margin import FORCES, TORQUES, Load, measure

G = 9.81
CASES = ((0.3, 1.0, 60.0), (0.7, 0.05, 60.0), (0.7, 2.0, 60.0), (1.0, 0.5, 30.0))
"""Friction coefficients, masses [kg] and forces of each pad [N]."""
TOLERANCE = 0.05


def margin(scenario: Scenario) -> list[Check]:
    """Check breaking forces of blocks and breaking torques of a flat and a pointed body."""
    return [*forces(scenario), *torques(scenario)]


def forces(scenario: Scenario) -> list[Check]:
    """Check a block's breaking force [N] along every axis of the gripper."""
    checks = []
    for friction, mass, force in CASES:
        rig = Rig(scenario, block((0.04, 0.04, 0.04), mass, friction))
        rig.grip(force)
        grip, weight = 2 * friction * scenario.gripper.friction_scale * force, mass * G
        for load in FORCES:
            expected, source = {
                "+approach": (grip - weight, "2 μ F − W"),
                "-approach": (grip + weight, "2 μ F + W"),
                "+across": (math.sqrt(grip**2 - weight**2), "√((2 μ F)² − W²)"),
                "-across": (math.sqrt(grip**2 - weight**2), "√((2 μ F)² − W²)"),
            }.get(load.name, (2 * force, "2 F, the fingers being coupled"))
            name = f"breaking force {load.name}, {mass:g} kg at μ = {friction:g}, {force:g} N"
            checks.append(equals(name, expected, broken(rig, load), "N", TOLERANCE, source))
    return checks


def torques(scenario: Scenario) -> list[Check]:
    """Check breaking torques [N m] about the jaw axis."""
    twist, scale = scenario.gripper.torsional_friction, scenario.gripper.friction_scale
    checks = []
    for friction, mass, force in CASES:
        rig = Rig(scenario, block((0.04, 0.04, 0.04), mass, friction))
        rig.grip(force)
        expected = flat_torque(friction * scale, twist, force, mass * G)
        name = f"breaking torque, block of {mass:g} kg at μ = {friction:g}, {force:g} N"
        source = "plastic collapse of eight frictional points under torque and weight"
        checks.append(equals(name, expected, broken(rig, TORQUES[0]), "N m", TOLERANCE, source))
    friction, mass, force = 0.7, 2.0, 60.0
    tips = 0.02 * np.vstack([np.eye(3), -np.eye(3)]) * [1, 0.5, 0.5]
    rig = Rig(scenario, Body(tips, mass, mass * 1e-4 * np.eye(3), friction))
    rig.grip(force)
    share = mass * G / (2 * friction * scale * force)
    expected = 2 * twist * force * math.sqrt(1 - share**2)
    name = f"breaking torque, pointed body of {mass:g} kg at μ = {friction:g}, {force:g} N"
    source = "soft fingers: (W/2μF)² + (τ/2μ_tF)² = 1"
    checks.append(equals(name, expected, broken(rig, TORQUES[0]), "N m", TOLERANCE, source))
    return checks


def broken(rig: Rig, load: Load, limits: Margin | None = None) -> float:
    """Return the force [N] or torque [N m] of one direction that breaks the grip on a held body."""
    found = measure(rig.world, limits or Margin(), [load])
    return found.torque if load.torque else found.force


def flat_torque(friction: float, twist: float, force: float, weight: float) -> float:
    """Return the torque [N m] about the pads' centre that turns a flat body bearing ``weight`` there [N].

    By the upper-bound theorem the least over all centres of rotation; by symmetry they lie on the horizontal.

    Args:
        friction, twist: sliding and torsional [m] friction coefficients.
        force: that of each pad [N], a quarter at each corner.
    """
    _, width, height = PARALLEL_85.pad
    corners = np.array([[y, z] for y in (-width / 2, width / 2) for z in (-height / 2, height / 2)])

    def torque(centre: float) -> float:
        squared = ((corners - [centre, 0.0]) ** 2).sum(1)
        return 2 * force * float(np.sqrt(friction**2 * squared + twist**2).mean()) - weight * centre

    return float(minimize_scalar(torque, bounds=(-0.1, 0.5), method="bounded").fun)
