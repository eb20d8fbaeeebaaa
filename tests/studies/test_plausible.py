"""Worlds drawn about a scenario."""

from __future__ import annotations

import numpy as np

from grasp_bench.scenario.sections import Scenario
from grasp_bench.studies.plausible import PLAUSIBLE, plausible


def test_worlds_stay_within_their_ranges_and_use_them(table4: Scenario) -> None:
    drawn = [plausible(table4, i) for i in range(1, 200)]
    for values, low, high in (
        ([w.gripper.friction_scale for w in drawn], 1 / 1.3, 1.3),
        ([w.table.friction / table4.table.friction for w in drawn], 1 / 1.3, 1.3),
        ([w.objects.mass_scale for w in drawn], 1 / 1.2, 1.2),
        ([c for w in drawn for c in w.objects.centre_of_mass_mm], -5, 5),
        ([w.physics.timestep for w in drawn], 0.001, 0.004),
        ([w.gripper.pad_stiffness for w in drawn], 0.5, 2),
        ([w.calibration.position_mm for w in drawn], 0, 3),
    ):
        assert low - 1e-3 <= min(values)
        assert max(values) <= high + 1e-3
        assert np.ptp(values) > 0.9 * (high - low)
    assert {w.physics.cone for w in drawn} == set(PLAUSIBLE.cones)
    assert {w.sensor.preset for w in drawn} == set(PLAUSIBLE.sensors)
    assert all(w.sensor == table4.sensor for w in drawn if w.sensor.preset == table4.sensor.preset)


def test_a_world_depends_on_seed_and_number_only(table4: Scenario) -> None:
    assert plausible(table4, 0) is table4
    assert plausible(table4, 7, seed=1) == plausible(table4, 7, seed=1)
    assert plausible(table4, 7, seed=1) != plausible(table4, 7, seed=2)
    assert plausible(table4, 7).name == "table4-w7"
