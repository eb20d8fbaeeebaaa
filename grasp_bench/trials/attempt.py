"""One trial, from an object on a table to exactly one outcome.

This is the spine of grasp-bench; it reads top to bottom: settle → sense → predict → plan →
execute → judge. Predictors never see the simulator, and the simulator never sees the network.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import CameraPose, RgbdImage
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp, GraspPose
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.planning.choice import choose_grasp
from grasp_bench.planning.planner import Plan, Planner
from grasp_bench.planning.seen import SeenScene
from grasp_bench.planning.shake import AXES
from grasp_bench.predictors.protocol import GroundTruth, Predictor, answer
from grasp_bench.robot.trajectory import Trajectory
from grasp_bench.scenario.outcomes import HARNESS_FAULTS, Outcome
from grasp_bench.scenario.sections import Calibration, Scenario
from grasp_bench.scenario.seeding import Purpose, stream
from grasp_bench.scene.builder import compile_scene
from grasp_bench.scene.rendering import Picture, SceneCamera, surfaces
from grasp_bench.scene.sensor import sense
from grasp_bench.scene.world import UnstableError, World

Floats = NDArray[np.float64]

__all__ = ["HARNESS_FAULTS", "Clock", "Outcome", "Trial", "TrialRecord", "Workcell", "run_trial"]


@dataclass(frozen=True)
class TrialRecord:
    """A line of ``trials.jsonl``; field meanings in docs/results-format.md."""

    trial: int
    object: str
    category: str
    seed: int
    outcome: Outcome
    detail: str = ""
    grasp: Grasp | None = None
    pose: GraspPose | None = None
    rank: int | None = None
    tcp_error: tuple[float, float] | None = None
    lift_height: float = 0.0
    contact_force: float = 0.0
    sim_steps: int = 0

    @property
    def success(self) -> bool:
        """The object was lifted, carried and held."""
        return self.outcome is Outcome.SUCCESS

    def to_json(self) -> dict[str, Any]:
        """Plain data with numbers rounded far below what is measurable."""
        return {
            "trial": self.trial,
            "object": self.object,
            "category": self.category,
            "seed": self.seed,
            "outcome": str(self.outcome),
            "success": self.success,
            "detail": self.detail,
            "grasp": None
            if self.grasp is None
            else {
                "x": round(self.grasp.x, 3),
                "y": round(self.grasp.y, 3),
                "angle": round(self.grasp.angle, 6),
                "width": round(self.grasp.width, 3),
                "quality": round(self.grasp.quality, 5),
            },
            "pose": None
            if self.pose is None
            else {
                "position": np.round(self.pose.position, 6).tolist(),
                "rotation": np.round(self.pose.rotation, 6).tolist(),
                "opening": round(self.pose.opening, 6),
            },
            "rank": self.rank,
            "tcp_error": None
            if self.tcp_error is None
            else {"position": round(self.tcp_error[0], 6), "angle": round(self.tcp_error[1], 6)},
            "lift_height": round(self.lift_height, 5),
            "contact_force": round(self.contact_force, 3),
            "sim_steps": self.sim_steps,
        }


@dataclass
class Clock:
    """Seconds spent in each phase."""

    seconds: dict[str, float] = field(default_factory=dict)

    def rounded(self) -> dict[str, float]:
        """The seconds, for a record."""
        return {k: round(v, 6) for k, v in self.seconds.items()}

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Time a block."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start


@dataclass
class Trial:
    """Everything a trial made on its way, for records, pictures and replays."""

    record: TrialRecord
    clock: Clock
    image: RgbdImage | None = None
    grasps: list[Grasp] = field(default_factory=list)
    plan: Plan | None = None
    world: World | None = None


class Workcell:
    """What trials of one scenario share; holds no state of any of them.

    Args:
        scenario: the trials' definition.
        renderer: see :mod:`grasp_bench.scene.rendering`.
    """

    def __init__(self, scenario: Scenario, renderer: str = "auto") -> None:
        self.scenario = scenario
        self.planner = Planner(scenario)
        self.camera = SceneCamera(scenario.camera.intrinsics, scenario.camera.pose, renderer)
        self._true_cameras: dict[int, SceneCamera] = {}

    def true_camera(self, seed: int, name: str, attempt: int) -> SceneCamera:
        """The camera that takes a trial's picture, off the nominal one by the calibration's error."""
        calibration, nominal = self.scenario.calibration, self.camera
        if calibration.exact:
            return nominal
        if calibration.drawn == "trial":
            pose = miscalibrated(nominal.pose, calibration, stream(seed, name, attempt, Purpose.CALIBRATION))
            return SceneCamera(nominal.intrinsics, pose, nominal.renderer)
        if seed not in self._true_cameras:
            pose = miscalibrated(nominal.pose, calibration, stream(seed, "", 0, Purpose.CALIBRATION))
            self._true_cameras[seed] = SceneCamera(nominal.intrinsics, pose, nominal.renderer)
        return self._true_cameras[seed]


def miscalibrated(pose: CameraPose, calibration: Calibration, rng: np.random.Generator) -> CameraPose:
    """Where a camera believed at ``pose`` truly is; directions of both errors are uniform."""
    shift, axis = (v / np.linalg.norm(v) for v in rng.standard_normal((2, 3)))
    return pose.moved(calibration.position_mm / 1000 * shift, math.radians(calibration.rotation_deg) * axis)


def take_picture(
    world: World,
    camera: SceneCamera,
    scenario: Scenario,
    rng: np.random.Generator,
    clock: Clock,
    changing: int = -1,
) -> tuple[Picture, RgbdImage]:
    """The perfect picture of a world, and what the sensor makes of it.

    Args:
        world: at rest.
        camera: where the sensor truly is.
        scenario: its sensor and light.
        rng: the sensor's stream.
        clock: for the phases ``render`` and ``sense``.
        changing: body that alone differs from the camera's last picture, −1 when others may.
    """
    with clock.phase("render"):
        picture = camera.picture(world.model, world.data, changing)
    with clock.phase("sense"):
        image = sense(
            picture, camera.intrinsics, scenario.sensor, rng, surfaces(world.model), scenario.light.level
        )
    return picture, image


def run_trial(
    cell: Workcell,
    model: ObjectModel,
    predictor: Predictor,
    *,
    trial: int = 0,
    attempt: int = 0,
    seed: int = 0,
    observer: Callable[[World], None] | None = None,
) -> Trial:
    """Try to pick up ``model`` once.

    Args:
        cell: scenario, planner and camera.
        model: the object.
        predictor: proposes grasps.
        trial: number in the run.
        attempt: how many times this object was tried before in the run.
        seed: of the run.
        observer: called after every sample of the arm's motion, for films and logs.
    """
    scenario, planner, nominal = cell.scenario, cell.planner, cell.camera
    camera = cell.true_camera(seed, model.name, attempt)
    clock = Clock()
    result = Trial(TrialRecord(trial, model.name, model.category, seed, Outcome.ERROR), clock)

    def finish(outcome: Outcome, detail: str = "", **measured: Any) -> Trial:
        steps = result.world.steps if result.world else 0
        result.record = TrialRecord(
            trial, model.name, model.category, seed, outcome, detail, sim_steps=steps, **measured
        )
        return result

    measured: dict[str, Any] = {}
    try:
        with clock.phase("build"):
            world = result.world = World(compile_scene(scenario, model), scenario)
        with clock.phase("settle"):
            put_down(world, model, scenario, stream(seed, model.name, attempt, Purpose.POSE))
        _, image = take_picture(
            world,
            camera,
            scenario,
            stream(seed, model.name, attempt, Purpose.SENSOR),
            clock,
            world.object_body,
        )
        result.image = image
        with clock.phase("predict"):
            truth = GroundTruth(model, *world.object_pose, camera.pose, camera.intrinsics)
            result.grasps = answer(
                predictor, image, truth, stream(seed, model.name, attempt, Purpose.PREDICTOR)
            )
        if not result.grasps:
            return finish(Outcome.NO_GRASP, "the predictor proposed no grasp")
        with clock.phase("plan"):
            scene = SeenScene(image, nominal.pose, nominal.directions)  # as the robot believes
            rank, plan, outcome, why = choose_grasp(planner, scene, result.grasps)
        measured = {"grasp": result.grasps[rank], "rank": rank}
        if plan is None:
            return finish(outcome, why, **measured)
        result.plan = plan
        measured["pose"] = plan.pose
        world.observer = observer
        with clock.phase("execute"):
            outcome, why = execute(world, plan, measured)
        return finish(outcome, why, **measured)
    except UnstableError as error:
        return finish(Outcome.UNSTABLE, str(error), **measured)
    except PredictorError as error:
        return finish(Outcome.ERROR, str(error), **measured)


def put_down(world: World, model: ObjectModel, scenario: Scenario, rng: np.random.Generator) -> None:
    """Put the object down in a random graspable resting pose and let it come to rest.

    Poses are drawn by their probability among those in which some grasp fits the gripper,
    with uniform yaw and a uniform place in the workspace.
    """
    height, quaternion = random_pose(model, rng)
    x, y = rng.uniform(-1, 1, 2) * scenario.table.workspace + scenario.table.center
    world.place_object(np.array([x, y, height + scenario.settling.clearance]), quaternion)
    world.settle()


def random_pose(model: ObjectModel, rng: np.random.Generator) -> tuple[float, Floats]:
    """Height of the centre of mass [m] and quaternion of a graspable resting pose at any yaw."""
    poses = model.graspable_poses
    weights = np.array([p.probability for p in poses])
    pose = poses[rng.choice(len(poses), p=weights / weights.sum())]
    yaw = rng.uniform(-math.pi, math.pi)
    turn = np.array([math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)])
    return pose.height, multiply_quaternions(turn, pose.quaternion)


def multiply_quaternions(a: Floats, b: Floats) -> Floats:
    """Hamilton product of quaternions w, x, y, z."""
    import mujoco

    product = np.zeros(4)
    mujoco.mju_mulQuat(product, np.asarray(a, float), np.asarray(b, float))
    return product


def execute(world: World, plan: Plan, measured: dict[str, Any]) -> tuple[Outcome, str]:
    """Approach, close, lift, shake, carry and hold in physics; fills ``measured`` and judges."""
    scenario = world.scenario
    gripper, motion = scenario.gripper, scenario.motion
    period = scenario.physics.timestep * scenario.physics.control_steps
    open_at = plan.pose.opening / 2
    world.mark()

    preshape = np.maximum(
        open_at,
        world.robot.gripper.stroke
        - gripper.closing_speed * period * np.arange(1, len(plan.reach.positions) + 1),
    )
    world.follow(plan.reach, preshape)
    for chunk in chunks(plan.approach, 5):
        world.follow(chunk, open_at)
        force, what = world.collision_force()
        if force > motion.collision_force:
            return Outcome.APPROACH_COLLISION, (
                f"the gripper met the {what} with {force:.0f} N on its way down"
            )
    q = plan.approach.end
    world.follow(still(q, 0.05, period), open_at)
    distance, angle = measured["tcp_error"] = tcp_error(world.tcp, plan.pose)
    if distance > motion.tcp_tolerance or angle > math.radians(motion.tcp_tolerance_deg):
        return Outcome.APPROACH_COLLISION, (
            f"the gripper was held up {1000 * distance:.1f} mm and "
            f"{math.degrees(angle):.1f}° from the planned grasp"
        )

    closing = np.arange(open_at, -gripper.squeeze, -gripper.closing_speed * period)
    world.follow(still(q, len(closing) * period, period, len(closing)), closing)
    squeeze = -gripper.squeeze
    world.follow(still(q, gripper.settle_time, period), squeeze)
    world.aim_at_held()
    if not world.touch().held:
        return Outcome.MISSED, "the fingers closed without holding the object"

    world.follow(plan.lift, squeeze)
    measured["lift_height"] = world.rise()
    touch = world.touch()
    if not touch.held or measured["lift_height"] < scenario.success.minimum_lift:
        return Outcome.SLIPPED, f"lost while lifting, {1000 * measured['lift_height']:.0f} mm above its place"

    for axis, burst in zip(AXES, plan.shake, strict=False):
        world.follow(burst, squeeze)
        if not world.touch().held:
            return Outcome.DROPPED, f"lost while shaken {axis} with ±{motion.shake.acceleration:g} m/s²"

    world.follow(plan.carry, squeeze)
    world.follow(still(plan.carry.end, motion.hold_time, period), squeeze)
    touch = world.touch()
    measured["contact_force"] = (touch.left + touch.right) / 2
    height = world.rise()
    if not touch.held or height < scenario.success.minimum_lift:
        return Outcome.DROPPED, f"lost while carried or held, {1000 * height:.0f} mm above its place"
    if touch.elsewhere:
        return Outcome.DROPPED, f"still touching {', '.join(touch.elsewhere)} at the end"
    return Outcome.SUCCESS, ""


def chunks(motion: Trajectory, size: int) -> Iterator[Trajectory]:
    """A trajectory in pieces of ``size`` samples."""
    for i in range(0, len(motion.positions), size):
        yield Trajectory(motion.positions[i : i + size], motion.velocities[i : i + size])


def still(q: Floats, seconds: float, period: float, count: int | None = None) -> Trajectory:
    """Standing still at ``q``."""
    samples = max(1, round(seconds / period)) if count is None else count
    return Trajectory(np.repeat(q[None], samples, axis=0), np.zeros((samples, len(q))))


def tcp_error(actual: GraspPose, wanted: GraspPose) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two TCP poses."""
    cosine = (np.trace(actual.rotation.T @ wanted.rotation) - 1) / 2
    return (
        float(np.linalg.norm(actual.position - wanted.position)),
        float(math.acos(min(1.0, max(-1.0, float(cosine))))),
    )
