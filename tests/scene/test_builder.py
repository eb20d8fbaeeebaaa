"""The composed scene carries the scenario's solver settings, whatever they are."""

from __future__ import annotations

from typing import Any

import pytest

from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import compile_mjcf, compose
from grasp_bench.scene.floating import compile_floating


@pytest.mark.parametrize("settings", [{}, {"timestep": 0.001, "impratio": 3.0, "noslip_iterations": 0}])
@pytest.mark.parametrize("floating", [False, True])
def test_solver_settings_reach_the_model(
    table4: Scenario, models: dict[str, ObjectModel], floating: bool, settings: dict[str, Any]
) -> None:
    scenario = table4.model_copy(update={"physics": table4.physics.model_copy(update=settings)})
    bar = models["bar"]
    model = compile_floating(scenario, [bar]) if floating else compile_mjcf(compose(scenario, bar))
    option, wanted = model.opt, scenario.physics
    assert (option.timestep, option.impratio, option.noslip_iterations) == (
        wanted.timestep,
        wanted.impratio,
        wanted.noslip_iterations,
    )
    assert (option.integrator, option.solver, option.jacobian, option.cone) == (3, 2, 0, 1)
