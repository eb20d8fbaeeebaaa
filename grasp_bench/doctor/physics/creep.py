"""A held box stays where it is: friction in MuJoCo is regularised, and creeps unless told not to."""

from __future__ import annotations

from grasp_bench.doctor.physics.check import Check, below
from grasp_bench.doctor.physics.rig import Rig, block
from grasp_bench.scenario.sections import Scenario


def creep(scenario: Scenario, seconds: float = 60.0) -> list[Check]:
    """Check the speed [µm/s] of a held box of 200 g over a minute."""
    rig = Rig(scenario, block((0.04, 0.04, 0.04), 0.2, 0.7))
    rig.grip(scenario.gripper.force)
    rig.run(0.5)
    distance, _ = rig.moved(seconds)
    return [
        below(
            f"creep of a held box of 200 g over {seconds:g} s",
            1e6 * distance / seconds,
            5.0,
            "µm/s",
            "Coulomb: none below the limit of friction",
        )
    ]
