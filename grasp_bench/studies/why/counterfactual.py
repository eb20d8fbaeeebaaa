"""A recorded trial done again without some of the causes of its failure."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import mujoco

from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.predictors.protocol import Predictor, PrivilegedPredictor
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.gripper_shape import GripperShape
from grasp_bench.robot.robot import Robot
from grasp_bench.runs.jobs import Job
from grasp_bench.runs.record import TrialRecord
from grasp_bench.scenario.sections import Calibration, Execution, Scenario
from grasp_bench.scenario.seeding import Purpose, Streams
from grasp_bench.scene.builder import COLLISION_GROUP, OBJECT, compile_scene
from grasp_bench.scene.rendering import SceneCamera
from grasp_bench.scene.world import World
from grasp_bench.studies.why.causes import PERFECT_COLOURS, PERFECT_DEPTH, Removed
from grasp_bench.studies.why.replaced import Remembering, Replaced, Turned
from grasp_bench.trials.attempt import Table, attempt
from grasp_bench.trials.placing import put_down
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell

STICKIER, LIGHTER, THINNER = 2.0, 0.5, 0.5
"""Factors on friction, mass and thickness of the fingers."""
PARTS = frozenset({"place", "angle", "width"})
TURNS = tuple(math.radians(22.5 * i) for i in (1, -1, 2, -2, 3, -3, 4))
"""Other angles that are tried, from the predicted one [rad]."""


class Counterfactuals:
    """Replays of one trial.

    Args:
        cell: the run's own.
        model: the trial's object.
        predictor: the run's.
        job: the trial's number, object and attempt.
        seed: the run's seed.
    """

    def __init__(self, cell: Workcell, model: ObjectModel, predictor: Predictor, job: Job, seed: int) -> None:
        self._cell, self._model, self._job, self._seed = cell, cell.fitted(model), job, seed
        self._streams = Streams(seed, model.name, job.attempt)
        told = isinstance(predictor, PrivilegedPredictor)
        self._predictor = predictor if told else Remembering(predictor)
        self._camera: SceneCamera | None = None

    def unchanged(self) -> TrialRecord:
        """Do the trial again as it was, and return its record."""
        job = self._job
        return run_trial(
            self._cell, self._model, self._predictor, trial=job.trial, attempt=job.attempt, seed=self._seed
        ).record

    def without(self, removed: Removed) -> TrialRecord:
        """Do the trial again without some causes, and return its record.

        Reference grasps are few, and this place may take another angle or width than the nearest of them. So
        where that one's angle alone saves nothing, others are tried; and where its width does not, of a grasp
        that is carried out as predicted, the one that the planner finds to be needed.
        """
        scenario = easier(self._cell.scenario, removed)
        parts = PARTS if "grasp" in removed else removed & PARTS
        predictor = self._predictor
        record = self._again(scenario, removed, Replaced(predictor, parts) if parts else predictor)
        if record.success:
            return record
        for other in self._others(scenario, removed):
            if other.success:
                return other
        return record

    def _others(self, scenario: Scenario, removed: Removed) -> Iterator[TrialRecord]:
        """Yield further replays without the same causes."""
        predictor, rest = self._predictor, (removed & PARTS) - {"width"}
        if removed == {"angle"}:
            for turn in TURNS:
                yield self._again(scenario, removed, Turned(predictor, turn))
        if "width" in removed and not scenario.execution.assisted:
            opened = scenario.model_copy(update={"execution": Execution(protocol="assisted", proposals=1)})
            yield self._again(opened, removed, Replaced(predictor, rest) if rest else predictor)

    def _again(self, scenario: Scenario, removed: Removed, predictor: Predictor) -> TrialRecord:
        exact = "calibration" in removed
        if not exact and self._camera is None:
            self._camera = self._cell.true_camera(self._streams)  # one of a trial's own is slow to make
        cell = _Variant(self._cell, scenario, removed, None if exact else self._camera)
        robot = self._cell.planner.robot

        def build() -> World:
            model = compile_scene(self._cell.scenario, self._model, robot)
            alter(model, robot, removed)
            return World(model, scenario, robot=cell.planner.robot)

        table = Table(
            [self._model],
            build=build,
            settle=lambda world: put_down(world, self._model, scenario, self._streams(Purpose.POSE)),
            alone=True,
        )
        return attempt(cell, table, predictor, self._streams, trial=self._job.trial).record


class _Variant(Workcell):
    """A workcell like another, with some causes of failures removed; it shares the other's cameras."""

    def __init__(
        self, cell: Workcell, scenario: Scenario, removed: Removed, camera: SceneCamera | None
    ) -> None:
        self.__dict__.update(vars(cell))
        self._true = camera or cell.camera
        self.scenario = scenario
        self.true_heights = "height" in removed
        robot = thinner(cell.planner.robot) if "fingers" in removed else cell.planner.robot
        self.planner = cell.planner.varied(self.scenario, robot)

    def true_camera(self, streams: Streams) -> SceneCamera:
        return self._true


def easier(scenario: Scenario, removed: Removed) -> Scenario:
    """Return the scenario of a replay: what its sensor, calibration and planner's help are."""
    sensor = (PERFECT_DEPTH if "depth" in removed else {}) | (PERFECT_COLOURS if "colours" in removed else {})
    changes: dict[str, Any] = {"margin": None, "sensor": scenario.sensor.model_copy(update=sensor)}
    if "colours" in removed:
        changes["light"] = scenario.light.model_copy(update={"level": 1.0})
    if "calibration" in removed:
        changes["calibration"] = Calibration()
    if "help" in removed:
        other = "as-predicted" if scenario.execution.assisted else "assisted"
        changes["execution"] = scenario.execution.model_copy(update={"protocol": other})
    return scenario.model_copy(update=changes)


def thinner(robot: Robot) -> Robot:
    """Return the robot with thin fingers, as its planner knows it; a suction cup has none."""
    gripper = robot.gripper
    if isinstance(gripper, SuctionCup):
        return robot
    return replace(robot, gripper=_Thin(gripper.name, gripper.folder, gripper.facts, gripper.scope))


class _Thin(Gripper):
    """A gripper whose planner believes its fingers to be thin."""

    @property
    def shape(self) -> GripperShape:
        whole = super().shape
        return replace(whole, finger_thickness=THINNER * whole.finger_thickness)


def alter(model: mujoco.MjModel, robot: Robot, removed: Removed) -> None:
    """Change friction, mass and fingers in a compiled model of a trial's world."""
    if "friction" in removed:
        for pad in dict.fromkeys(robot.gripper.pads):
            model.geom(robot.gripper_prefix + pad).friction[0] *= STICKIER
    if "mass" in removed:
        body = model.body(OBJECT)
        body.mass *= LIGHTER
        body.inertia *= LIGHTER
    if "fingers" in removed and not isinstance(robot.gripper, SuctionCup):
        _thin(model, robot.gripper, robot.gripper_prefix)
    if removed & {"mass", "fingers"}:
        mujoco.mj_setConst(model, mujoco.MjData(model))


def _thin(model: mujoco.MjModel, gripper: Gripper, prefix: str) -> None:
    """Take off the outer side of what collides of the fingers, all but the pads.

    Boxes become smaller within what they were, so that bounds which MuJoCo made when it compiled still hold.
    """
    pads = {model.geom(prefix + p).id for p in gripper.pads}
    for name in gripper.fingers:
        body = model.body(prefix + name).id
        for geom in range(model.ngeom):
            if (
                model.geom_bodyid[geom] != body
                or geom in pads
                or model.geom_group[geom] != COLLISION_GROUP
                or model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_BOX
            ):
                continue
            centre, half = model.geom_pos[geom, 0], model.geom_size[geom, 0]
            inner, outer = centre - half, centre + half
            if inner < 0:
                continue
            outer = max(THINNER * outer, inner + 0.001)
            model.geom_pos[geom, 0], model.geom_size[geom, 0] = (inner + outer) / 2, (outer - inner) / 2
