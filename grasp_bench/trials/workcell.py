"""What all trials of a scenario share: the planner, and the camera that takes their pictures."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property

import numpy as np

from grasp_bench.camera import CameraPose, RgbdImage
from grasp_bench.errors import AssetError
from grasp_bench.grasps import GraspPose
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.objects.fitted import fitted
from grasp_bench.planning.planner import Planner
from grasp_bench.planning.viewing import view_motions
from grasp_bench.robot.trajectory import Trajectory
from grasp_bench.scenario.reading import check_current
from grasp_bench.scenario.sections import Calibration, Scenario
from grasp_bench.scenario.seeding import Purpose, Streams
from grasp_bench.scene.rendering import Picture, Remember, SceneCamera, looking
from grasp_bench.scene.sensor import sense
from grasp_bench.scene.shading import drawer
from grasp_bench.scene.surfaces import surfaces
from grasp_bench.scene.world import World
from grasp_bench.trials.clock import Clock


class Workcell:
    """What trials of one scenario share; holds no state of any of them.

    Args:
        renderer: one of :data:`~grasp_bench.system.graphics.RENDERERS`.

    Attributes:
        true_heights: whether the planner sees a perfect picture, and only the predictor what the sensor
            makes of it; for replays that ask what the sensor cost.
    """

    true_heights = False

    def __init__(self, scenario: Scenario, renderer: str = "auto") -> None:
        check_current(scenario)
        self.scenario = scenario
        self.planner = Planner(scenario)
        self._draw = drawer(scenario)
        self.camera = SceneCamera(scenario.camera.intrinsics, scenario.camera.pose, renderer, self._draw)
        self._true_cameras: dict[int, SceneCamera] = {}

    def fitted(self, model: ObjectModel) -> ObjectModel:
        """Return an object with the reference grasps of the robot's gripper, in the scenario's poses of it.

        Raises:
            AssetError: where they were not worked out yet, or the object has no such pose.
        """
        fit = fitted(model, self.planner.robot.gripper)
        chosen = self.scenario.objects.poses.get(model.name, ())
        if chosen and max(chosen) >= len(model.poses):
            raise AssetError(
                f"Scenario {self.scenario.name!r}: objects.poses asks for pose {max(chosen)} of "
                f"{model.name}, which has {len(model.poses)}, counted from 0."
            )
        return replace(fit, put_in=chosen) if chosen else fit

    @cached_property
    def view_motions(self) -> list[tuple[GraspPose, Trajectory]]:
        """How the arm brings a wrist camera to its views; see :func:`view_motions`."""
        return view_motions(self.planner)

    def camera_at(self, pose: CameraPose) -> SceneCamera:
        """Return a camera like the scenario's that stands elsewhere."""
        return SceneCamera(self.camera.intrinsics, pose, self.camera.renderer, self._draw)

    def true_camera(self, streams: Streams) -> SceneCamera:
        """Return the camera that takes an attempt's picture, off the nominal one by the calibration's
        error."""
        calibration, nominal = self.scenario.calibration, self.camera
        if calibration.exact:
            return nominal
        if calibration.drawn == "trial":
            pose = miscalibrated(nominal.pose, calibration, streams(Purpose.CALIBRATION))
            return SceneCamera(nominal.intrinsics, pose, nominal.renderer, self._draw)
        seed = streams.seed
        if seed not in self._true_cameras:
            once = Streams(seed, "", 0)
            pose = miscalibrated(nominal.pose, calibration, once(Purpose.CALIBRATION))
            self._true_cameras[seed] = SceneCamera(nominal.intrinsics, pose, nominal.renderer, self._draw)
        return self._true_cameras[seed]


def miscalibrated(pose: CameraPose, calibration: Calibration, rng: np.random.Generator) -> CameraPose:
    """Draw where a camera believed at ``pose`` truly is; directions of both errors are uniform."""
    shift, axis = (v / np.linalg.norm(v) for v in rng.standard_normal((2, 3)))
    return pose.moved(calibration.position_mm / 1000 * shift, math.radians(calibration.rotation_deg) * axis)


def take_picture(
    world: World,
    camera: SceneCamera,
    scenario: Scenario,
    rng: np.random.Generator,
    clock: Clock,
    changing: int = -1,
    remember: Remember = looking,
) -> tuple[Picture, RgbdImage]:
    """Take the perfect picture of a world, and what the sensor makes of it.

    Args:
        world: what is pictured, at rest.
        camera: stands where the sensor truly is.
        scenario: has the sensor's noise and the light.
        rng: the attempt's random stream for the sensor.
        clock: takes the times of the phases ``render`` and ``sense``.
        changing: body that alone differs from the camera's last picture, −1 when others may.
        remember: as of :meth:`SceneCamera.picture`.
    """
    with clock.phase("render"):
        picture = camera.picture(world.model, world.data, changing, remember)
    with clock.phase("sense"):
        image = sense(
            picture, camera.intrinsics, scenario.sensor, rng, surfaces(world.model), scenario.light.level
        )
    return picture, image
