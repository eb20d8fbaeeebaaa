"""One attempt, from objects on a table to exactly one outcome.

This is the spine of grasp-bench; it reads top to bottom: settle → sense → predict → plan → execute → judge.
Predictors never see the simulator, and the simulator never sees the network. A trial on one object
(:mod:`grasp_bench.trials.trial`) makes one attempt, an episode of clutter (:mod:`grasp_bench.trials.episode`)
several.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import RgbdImage
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp, SpatialGrasp
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.planning.choice import choose_grasp
from grasp_bench.planning.planner import Plan
from grasp_bench.planning.refusals import Refused
from grasp_bench.planning.seen import SeenScene
from grasp_bench.predictors.protocol import GroundTruth, Predictor, PrivilegedPredictor, ask
from grasp_bench.robot.gripper import Gripper
from grasp_bench.runs.record import MarginRecord, TrialRecord
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.seeding import Purpose, Streams
from grasp_bench.scene.rendering import Picture, SceneCamera
from grasp_bench.scene.world import UnstableError, World
from grasp_bench.trials.clock import Clock
from grasp_bench.trials.execution import Execution, execute
from grasp_bench.trials.foresight import foresee
from grasp_bench.trials.margin import measure
from grasp_bench.trials.views import seen, take_views, told
from grasp_bench.trials.workcell import Workcell, take_picture


@dataclass(frozen=True)
class Table:
    """What an attempt finds on the table.

    Attributes:
        build: makes the world of the objects.
        settle: brings the objects to rest in that world.
        alone: whether the world differs from all others of the workcell in one object only.
        take: takes the picture, as :func:`~grasp_bench.trials.workcell.take_picture` does.
        another: makes another world with the objects at rest, where ``build`` gives the same one each time.
    """

    models: Sequence[ObjectModel]
    build: Callable[[], World]
    settle: Callable[[World], object]
    alone: bool = False
    take: Callable[..., tuple[Picture, RgbdImage]] = take_picture
    another: Callable[[], World] | None = None

    def fresh(self) -> World:
        """Return another world of the same objects at rest, the same to the bit."""
        if self.another is not None:
            return self.another()
        world = self.build()
        self.settle(world)
        return world


@dataclass
class Trial:
    """Everything an attempt made on its way, for records, pictures and replays."""

    record: TrialRecord
    clock: Clock
    image: RgbdImage | None = None
    grasps: list[Grasp] = field(default_factory=list)
    plan: Plan | None = None
    world: World | None = None


def attempt(
    cell: Workcell,
    table: Table,
    predictor: Predictor,
    streams: Streams,
    *,
    trial: int = 0,
    clock: Clock | None = None,
    observer: Callable[[World], None] | None = None,
) -> Trial:
    """Try to pick up something, once.

    Args:
        streams: random streams of the attempt.
        trial: the trial's number in the run, for the record.
        clock: takes the times of this attempt, too; a new one by default.
        observer: called after every sample of the arm's motion, for films and logs.
    """
    clock = clock or Clock()
    target = table.models[0]
    done = Trial(_record(trial, target, streams.seed, Outcome.ERROR, ""), clock)
    grasp: Grasp | None = None
    rank: int | None = None
    margin = None if cell.scenario.margin is None else MarginRecord()

    def ended(outcome: Outcome, detail: str, execution: Execution | None = None) -> Trial:
        done.record = _record(
            trial,
            target,
            streams.seed,
            outcome,
            detail,
            grasp=grasp,
            rank=rank,
            pose=done.plan.pose if done.plan else None,
            widening_mm=1000 * done.plan.widening if done.plan else None,
            shortfall_mm=1000 * done.plan.shortfall if done.plan else None,
            sim_steps=done.world.steps if done.world else 0,
            margin=margin,
            **({} if execution is None else execution.measured),
        )
        return done

    try:
        with clock.phase("build"):
            world = done.world = table.build()
        with clock.phase("settle"):
            table.settle(world)
        views = take_views(
            cell, world, streams, clock, lambda: take_first_picture(cell, table, world, streams, clock)
        )
        picture, image, camera = views[0].picture, views[0].image, views[0].camera
        done.image = image
        with clock.phase("predict"):
            truths = _truths(world, table.models, camera, cell.planner.robot.gripper)
            done.grasps = ask(predictor, image, streams(Purpose.PREDICTOR), truths, told(views))
        if not done.grasps:
            return ended(Outcome.NO_GRASP, "the predictor proposed no grasp")
        with clock.phase("plan"):
            foresight = isinstance(predictor, PrivilegedPredictor) and predictor.foresight
            if foresight or cell.true_heights:  # not what the sensor makes of it
                image = RgbdImage(picture.rgb, picture.depth, camera.intrinsics)
            if foresight:
                choice = foresee(
                    cell.planner,
                    SeenScene(image, camera.pose, camera.directions),
                    done.grasps,
                    table.fresh,
                    lambda grasp: _meant(grasp, picture, world, camera),
                    _analysable(cell.scenario, picture, world),
                )
            else:
                scene = seen(cell, views, image)  # as the robot believes
                choice = choose_grasp(cell.planner, scene, done.grasps)
        rank, grasp = choice.rank, done.grasps[choice.rank]
        aim = _meant(grasp, picture, world, camera)
        target = table.models[aim]
        if isinstance(choice.plan, Refused):
            return ended(choice.plan.outcome, str(choice.plan))
        done.plan = choice.plan
        world.aim(aim)
        world.observer = observer
        with clock.phase("execute"):
            execution = execute(world, choice.plan)
        if execution.outcome is not Outcome.UNSTABLE:
            target = table.models[world.target]  # the fingers may have closed on another one
        if cell.scenario.margin is not None and execution.outcome is Outcome.SUCCESS:
            with clock.phase("margin"):
                margin = measure(world, cell.scenario.margin)
        return ended(execution.outcome, execution.detail, execution)
    except UnstableError as error:
        return ended(Outcome.UNSTABLE, str(error))
    except PredictorError as error:
        return ended(Outcome.ERROR, str(error))


def _analysable(scenario: Scenario, picture: Picture, world: World) -> NDArray[np.bool_] | None:
    """Return which pixels (H, W) show an object; None in scenarios in which known grasps alone are tried out:
    those of single household objects, whose records would change."""
    if scenario.clutter is None and not scenario.objects.graded:
        return None
    return (picture.geom >= 0) & np.isin(world.model.geom_bodyid[picture.geom], world.bodies)


def take_first_picture(
    cell: Workcell, table: Table, world: World, streams: Streams, clock: Clock
) -> tuple[Picture, RgbdImage]:
    """Return what :func:`~grasp_bench.trials.workcell.take_picture` does of a table at rest."""
    changing = world.object_body if table.alone else -1
    camera, rng = cell.true_camera(streams), streams(Purpose.SENSOR)
    return table.take(world, camera, cell.scenario, rng, clock, changing=changing)


def _record(
    trial: int, model: ObjectModel, seed: int, outcome: Outcome, detail: str, **measured: Any
) -> TrialRecord:
    return TrialRecord(
        trial=trial,
        object=model.name,
        category=model.category,
        seed=seed,
        outcome=outcome,
        detail=detail,
        **measured,
    )


def _truths(
    world: World, models: Sequence[ObjectModel], camera: SceneCamera, gripper: Gripper
) -> list[GroundTruth]:
    """Return what a control may be told of every object."""
    truths = []
    for which, model in enumerate(models):
        world.aim(which)
        truths.append(GroundTruth(model, *world.object_pose, camera.pose, camera.intrinsics, gripper))
    return truths


def _meant(grasp: Grasp, picture: Picture, world: World, camera: SceneCamera) -> int:
    """Return the index of the object under a grasp's centre, or of the nearest one where there is none; of a
    grasp in six degrees of freedom the one that is seen nearest to its TCP."""
    height, width = picture.geom.shape
    if isinstance(grasp, SpatialGrasp) and len(world.bodies) > 1:
        bodies = np.where(picture.geom >= 0, world.model.geom_bodyid[picture.geom], -1)
        shown = np.isin(bodies, world.bodies)
        if shown.any():
            places = camera.intrinsics.rays()[shown] * picture.depth[shown][:, None]
            nearest = int(np.argmin(np.linalg.norm(places - grasp.pose.position, axis=1)))
            return world.bodies.index(int(bodies[shown][nearest]))
    row, column = min(max(int(grasp.y), 0), height - 1), min(max(int(grasp.x), 0), width - 1)
    geom = int(picture.geom[row, column])
    if geom >= 0 and (body := int(world.model.geom_bodyid[geom])) in world.bodies:
        return world.bodies.index(body)
    pixels = camera.intrinsics.project(camera.pose.to_camera(world.data.xpos[world.bodies]))
    return int(np.argmin(np.linalg.norm(pixels - [grasp.x, grasp.y], axis=1)))
