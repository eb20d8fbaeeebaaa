"""Depth of the pads in what they hold, at the greatest force of the gripper."""

from __future__ import annotations

import numpy as np

from grasp_bench.doctor.physics.check import Check, below, equals
from grasp_bench.doctor.physics.rig import Rig, block
from grasp_bench.scenario.sections import Scenario

MASSES = (0.011, 0.2, 2.0)
"""From the lightest of the 180 objects to more than the heaviest [kg]."""


def penetration(scenario: Scenario) -> list[Check]:
    """Check the depth [mm] of the pads in blocks from light to heavy, held still."""
    force = scenario.robot.loaded.gripper.force[1]
    deepest, reached = 0.0, force
    for mass in MASSES:
        rig = Rig(scenario, block((0.04, 0.04, 0.04), mass, 0.7))
        rig.grip(force)
        rig.run(0.2)
        pads = rig.world.pads
        contact = rig.data.contact
        ours = np.isin(contact.geom, pads).any(axis=1)
        deepest = max(deepest, -float(contact.dist[ours].min()))
        touch = rig.world.touch()
        reached = max((touch.left + touch.right) / 2, reached, key=lambda f: abs(f - force))
    return [
        below(
            f"depth of the pads in blocks of {min(MASSES):g} to {max(MASSES):g} kg at {force:g} N",
            1000 * deepest,
            0.5,
            "mm",
            "rigid bodies: none",
        ),
        equals(
            "force of each pad at the greatest setting",
            force,
            reached,
            "N",
            0.01,
            "what the scenario asks for",
        ),
    ]
