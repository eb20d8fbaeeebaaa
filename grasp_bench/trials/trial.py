"""A trial on one object: a single attempt."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.scenario.seeding import Purpose, Streams
from grasp_bench.scene.builder import compile_scene, scene_digest
from grasp_bench.scene.kept import seen
from grasp_bench.scene.world import World
from grasp_bench.trials.attempt import Table, Trial
from grasp_bench.trials.attempt import attempt as try_once
from grasp_bench.trials.placing import put_down
from grasp_bench.trials.workcell import Workcell, take_picture


def run_trial(
    cell: Workcell,
    model: ObjectModel,
    predictor: Predictor,
    *,
    trial: int = 0,
    attempt: int = 0,
    seed: int = 0,
    observer: Callable[[World], None] | None = None,
    table: Table | None = None,
) -> Trial:
    """Try to pick up ``model`` once.

    Args:
        trial: the trial's number in the run, for the record.
        attempt: how many times this object was tried before in the run.
        seed: the run's seed.
        observer: called after every sample of the arm's motion, for films and logs.
        table: what the trial finds, where several find the same; by default :func:`own_table`.
    """
    streams = Streams(seed, model.name, attempt)
    found = table or own_table(cell, model, streams)
    return try_once(cell, found, predictor, streams, trial=trial, observer=observer)


def own_table(cell: Workcell, model: ObjectModel, streams: Streams) -> Table:
    """Return what a trial on one object finds: the object alone, at rest where its streams put it."""
    model = cell.fitted(model)
    scene = scene_digest(cell.scenario, model)
    return Table(
        [model],
        build=lambda: World(compile_scene(cell.scenario, model), cell.scenario),
        settle=lambda world: put_down(world, model, cell.scenario, streams(Purpose.POSE), scene),
        alone=True,
        take=partial(take_picture, remember=partial(seen, scene)),
    )
