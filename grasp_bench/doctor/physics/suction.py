"""What a suction cup holds, against statics: pull, shear, peeling and torsion.

A plate hangs at the cup while gravity pulls it straight down, along the cup's plane, or off-centre. The limit
surface of the contact at the cup's middle is (s / μ)² + (τ / μ r)² + (m / r)² = (V − p)², of pull p, shear s,
torsion τ and peeling moment m at vacuum force V and radius r: Coulomb's friction under the rim, and a rigid
ring that tips about its edge. See :class:`grasp_bench.robot.cup.SuctionCup`.
"""

from __future__ import annotations

import math

import numpy as np

from grasp_bench.doctor.physics.check import Check, below, equals
from grasp_bench.doctor.physics.rig import Rig, block, threshold
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.scenario.sections import Scenario

G = 9.81
MASS, FRICTION = 1.0, 0.7
SIZE = (0.08, 0.06, 0.01)
OFF = 0.008
"""How far off the plate's middle the cup holds it [m]."""
TURNED = math.radians(1.0)


def suction(scenario: Scenario) -> list[Check]:
    """Check the least vacuum force [N] that holds a plate under each kind of load."""
    cup = scenario.robot.loaded.gripper
    assert isinstance(cup, SuctionCup)
    weight, radius = MASS * G, cup.radius
    mu = FRICTION * scenario.gripper.friction_scale
    lever = SIZE[2] / 2
    down, along = np.array([0.0, 0.0, G]), np.array([0.0, G, 0.0])  # in the gripper's frame
    sheared = math.hypot(weight / mu, weight * lever / radius)
    cases = (
        ("pull-off", down, 0.0, weight, "V = W"),
        ("shear", along, 0.0, sheared, "V² = (W / μ)² + (W h / r)², h half the plate's thickness"),
        ("peeling off-centre", down, OFF, weight * (1 + OFF / radius), "V = W (1 + d / r)"),
        (
            "torsion off-centre",
            along,
            OFF,
            math.hypot(sheared, weight * OFF / (mu * radius)),
            "V² = (W / μ)² + (W h / r)² + (W d / μ r)²",
        ),
    )
    checks = []
    for name, gravity, off, expected, source in cases:
        rig = Rig(scenario, block(SIZE, MASS, FRICTION, (off, 0.0, 0.0)))

        def gives_way(force: float, rig: Rig = rig, gravity: np.ndarray = gravity) -> bool:
            rig.stick(force)
            rig.load(rig.world.tcp.rotation @ gravity)
            distance, angle = rig.moved(0.5)
            return distance > 1e-3 or angle > TURNED or not rig.world.touch().held

        force = threshold(gives_way, 0.7 * expected, 1.4 * expected)
        what = f"least vacuum force, {name}, {MASS:g} kg at μ = {FRICTION:g}"
        checks.append(equals(what, expected, force, "N", 0.05, source))
    return [*checks, depth(scenario, cup)]


def depth(scenario: Scenario, cup: SuctionCup) -> Check:
    """Check how deep [mm] the cup is in what it holds at its greatest force, from light to heavy."""
    deepest = 0.0
    for mass in (0.011, 0.2, 1.0):
        rig = Rig(scenario, block(SIZE, mass, FRICTION))
        rig.grip(cup.force[1])
        contact = rig.data.contact
        deepest = max(deepest, -float(contact.dist[np.isin(contact.geom, rig.world.pads).any(axis=1)].min()))
    return below(
        f"depth of the cup in plates of 0.011 to 1 kg at {cup.force[1]:.1f} N",
        1000 * deepest,
        0.5,
        "mm",
        "rigid bodies: none",
    )
