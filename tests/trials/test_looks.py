"""Trials of the scenarios that have a look and surroundings of their own."""

from __future__ import annotations

import numpy as np
import pytest

from grasp_bench.camera import RgbdImage
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.predictors.level import level_view
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scene.builder import compile_scene
from grasp_bench.scene.rendering import Picture
from grasp_bench.scene.world import World
from grasp_bench.trials.clock import Clock
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell, take_picture


def seen(name: str, model: ObjectModel) -> tuple[Picture, RgbdImage, World]:
    scenario = load_scenario(name)
    cell = Workcell(scenario)
    world = World(compile_scene(scenario, model), scenario)
    world.place_object(np.array([0.5, 0.0, 0.02]), np.array([1.0, 0, 0, 0]))
    world.settle()
    rng = np.random.default_rng(0)
    return *take_picture(world, cell.camera, scenario, rng, Clock(), world.object_body), world


def test_shaded_is_table4_in_another_light(models: dict[str, ObjectModel]) -> None:
    (_, plain, _), (_, shaded, _), (_, again, _) = (
        seen(n, models["block"]) for n in ("table4", "shaded", "shaded")
    )
    np.testing.assert_array_equal(plain.depth, shaded.depth)
    assert (plain.rgb != shaded.rgb).any(-1).mean() > 0.9
    np.testing.assert_array_equal(shaded.rgb, again.rgb)


def test_the_office_shows_walls_an_edge_and_things_and_its_table_is_found(
    models: dict[str, ObjectModel],
) -> None:
    picture, image, world = seen("office", models["block"])
    names = [world.model.geom(int(i)).name for i in np.unique(picture.geom) if i >= 0]
    assert sum(n.startswith("fixture") for n in names) >= 7
    assert {"table", "floor"} <= set(names)
    view = level_view(image)
    assert view is not None
    depth = view.image.depth
    middle = depth[200:280, 280:360]
    assert np.median(middle[middle > 0]) == pytest.approx(0.51, abs=0.01)


def test_a_trial_in_the_office_lifts_a_block(models: dict[str, ObjectModel]) -> None:
    from grasp_bench.predictors.controls import Oracle

    record = run_trial(Workcell(load_scenario("office")), models["block"], Oracle()).record
    assert record.outcome is Outcome.SUCCESS
