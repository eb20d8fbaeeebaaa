"""The composed scene carries the scenario's solver settings, whatever they are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import compile_mjcf, compile_scene, compose
from grasp_bench.scene.floating import compile_floating
from grasp_bench.system import cache


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


@pytest.mark.parametrize("floating", [False, True])
def test_uncertain_physics_reaches_the_model(
    table4: Scenario, models: dict[str, ObjectModel], floating: bool
) -> None:
    def compiled(**sections: dict[str, Any]) -> Any:
        changes = {k: getattr(table4, k).model_copy(update=v) for k, v in sections.items()}
        scenario, bar = table4.model_copy(update=changes), models["bar"]
        return compile_floating(scenario, [bar]) if floating else compile_mjcf(compose(scenario, bar))

    usual = compiled()
    model = compiled(
        physics={"cone": "pyramidal"},
        objects={"centre_of_mass_mm": (3.0, -4.0, 5.0)},
        gripper={"pad_stiffness": 4.0},
    )
    assert (usual.opt.cone, model.opt.cone) == (1, 0)
    bodies = [usual.body(n).name for n in range(usual.nbody) if usual.body(n).name.startswith("object")]
    assert bodies
    for name in bodies:
        np.testing.assert_allclose(model.body(name).ipos - usual.body(name).ipos, [0.003, -0.004, 0.005])
        np.testing.assert_allclose(model.body(name).mass, usual.body(name).mass)
    found = [g for g in range(model.ngeom) if model.geom(g).name.endswith(("left_pad", "right_pad"))]
    assert len(found) == 2
    np.testing.assert_allclose(usual.geom_solref[found, 0] / model.geom_solref[found, 0], 2)


def test_a_model_that_vanishes_or_is_damaged_is_compiled_again(
    table4: Scenario, models: dict[str, ObjectModel], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GRASP_BENCH_CACHE", str(tmp_path))
    first = compile_scene(table4, models["bar"])
    (entry,) = cache.entries()
    whole = entry.path.read_bytes()
    monkeypatch.setattr(cache, "used", lambda path: True)
    entry.path.unlink()
    again = compile_scene(table4, models["bar"])
    assert entry.path.read_bytes() == whole
    entry.path.write_bytes(whole[: len(whole) // 2])
    third = compile_scene(table4, models["bar"])
    assert entry.path.read_bytes() == whole
    for model in (again, third):
        assert np.array_equal(model.mesh_vert, first.mesh_vert)


def test_the_cache_holds_no_more_than_it_may(
    table4: Scenario, models: dict[str, ObjectModel], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GRASP_BENCH_CACHE", str(tmp_path))
    compile_scene(table4, models["bar"])
    (entry,) = cache.entries()
    monkeypatch.setenv("GRASP_BENCH_CACHE_MB", str(1 + 3 * entry.size // 2 // 10**6))
    compile_scene(table4, models["block"])
    (kept,) = cache.entries()
    assert kept.path != entry.path
