"""A block held by two pads slips where the weight exceeds the friction of both: m g > 2 μ F."""

from __future__ import annotations

from grasp_bench.doctor.physics.check import Check, equals
from grasp_bench.doctor.physics.rig import Rig, block, threshold
from grasp_bench.scenario.sections import Scenario

G = 9.81
CASES = ((0.3, 1.5), (0.7, 4.0), (1.0, 5.0))
"""Friction coefficients and masses [kg]."""


def slip(scenario: Scenario) -> list[Check]:
    """Check the least force per pad [N] that holds blocks of different weight and friction."""
    checks = []
    for friction, mass in CASES:
        rig = Rig(scenario, block((0.04, 0.04, 0.04), mass, friction))
        expected = mass * G / (2 * friction * scenario.gripper.friction_scale)

        def slips(force: float, rig: Rig = rig) -> bool:
            rig.grip(force)
            return rig.moved(0.5)[0] > 1e-3

        force = threshold(slips, 0.7 * expected, 1.4 * expected)
        checks.append(
            equals(
                f"least grip force, {mass:g} kg at μ = {friction:g}",
                expected,
                force,
                "N",
                0.05,
                "Coulomb: F = m g / (2 μ)",
            )
        )
    return checks
