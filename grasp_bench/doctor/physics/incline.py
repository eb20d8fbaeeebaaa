"""A block on an inclined table slides beyond tan α = μ, and then with g (sin α − μ cos α)."""

from __future__ import annotations

import math

import numpy as np

from grasp_bench.doctor.physics.check import Check, equals
from grasp_bench.doctor.physics.rig import Rig, block, threshold
from grasp_bench.scenario.sections import Scenario

G = 9.81
SIZE = (0.08, 0.08, 0.02)
SLIDING = 0.6
"""Time over which the acceleration is averaged [s]: a sliding block chatters on its corners."""


def tilted(angle: float) -> np.ndarray:
    """Return gravity (3,) [m/s²] on a table inclined by ``angle`` [rad] downwards along y."""
    return G * np.array([0.0, math.sin(angle), -math.cos(angle)])


def incline(scenario: Scenario) -> list[Check]:
    """Check the tangent of the angle at which sliding begins, and the acceleration [m/s²] of sliding."""
    rig = Rig(scenario, block(SIZE, 0.3, 0.7))
    friction = scenario.table.friction

    def stays(slope: float) -> None:
        rig.reset()
        rig.world.place_object(np.array([*scenario.table.center, SIZE[2] / 2]), np.array([1.0, 0, 0, 0]))
        rig.run(0.2)
        rig.load(tilted(math.atan(slope)))

    def slides(slope: float) -> bool:
        stays(slope)
        before = rig.world.object_pose[0]
        rig.run(0.5)
        return float(np.linalg.norm(rig.world.object_pose[0] - before)) > 1e-3

    slope = threshold(lambda s: not slides(s), 0.7 * friction, 1.4 * friction)
    angle = math.atan(1.5 * friction)
    stays(1.5 * friction)
    joint = rig.model.joint("object").dofadr[0]
    speed = float(rig.data.qvel[joint + 1])
    rig.run(SLIDING)
    acceleration = (float(rig.data.qvel[joint + 1]) - speed) / SLIDING
    return [
        equals(
            "tangent of the table's angle at which a block slides",
            friction,
            slope,
            "",
            0.05,
            "Coulomb: tan α = μ",
        ),
        equals(
            f"acceleration down a table of {math.degrees(angle):.1f}°",
            G * (math.sin(angle) - friction * math.cos(angle)),
            acceleration,
            "m/s²",
            0.05,
            "Coulomb: g (sin α − μ cos α)",
        ),
    ]
