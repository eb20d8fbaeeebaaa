"""The pictures of an attempt: by one fixed camera or several, or those that a wrist camera takes from a dome.

The first is that of all predictors, and its camera's frame that of their grasps. A predictor that has a
method ``predict_views(views)`` is given all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from grasp_bench.camera import CameraPose, RgbdImage
from grasp_bench.camera import View as Told
from grasp_bench.grasps import GraspPose
from grasp_bench.planning.seen import SeenScene
from grasp_bench.scenario.seeding import Purpose, Streams
from grasp_bench.scene.rendering import Picture, SceneCamera
from grasp_bench.scene.world import World
from grasp_bench.trials.clock import Clock
from grasp_bench.trials.workcell import Workcell, miscalibrated, take_picture


@dataclass(frozen=True)
class View:
    """A picture, and where from.

    Attributes:
        picture, image: the perfect picture, and what the sensor makes of it.
        camera: the camera where it truly is.
        believed: where the robot believes it is.
    """

    picture: Picture
    image: RgbdImage
    camera: SceneCamera
    believed: CameraPose


def take_views(
    cell: Workcell,
    world: World,
    streams: Streams,
    clock: Clock,
    first: Callable[[], tuple[Picture, RgbdImage]],
) -> list[View]:
    """Return the pictures that the scenario's cameras take of a table at rest; a wrist camera moves the arm.

    Args:
        first: takes the first picture of a fixed camera.

    Raises:
        ScenarioError: for a wrist camera that the arm cannot bring to a view.
    """
    camera = cell.scenario.camera
    if camera.mount == "wrist":
        return _from_wrist(cell, world, streams, clock)
    views = [View(*first(), cell.true_camera(streams), cell.camera.pose)]
    rng, calibration = streams(Purpose.VIEWS), cell.scenario.calibration
    errors = Streams(streams.seed, "", 0)(Purpose.VIEWS) if calibration.drawn == "run" else rng
    for stand in camera.more:
        true = stand.pose if calibration.exact else miscalibrated(stand.pose, calibration, errors)
        eye = cell.camera_at(true)
        views.append(View(*take_picture(world, eye, cell.scenario, rng, clock), eye, stand.pose))
    return views


def seen(cell: Workcell, views: list[View], image: RgbdImage) -> SeenScene:
    """Return what the planner sees: ``image`` in place of the first picture, and the points of all."""
    first = views[0].believed
    known = cell.camera.directions if first is cell.camera.pose else None
    return SeenScene(image, first, known, [SeenScene(v.image, v.believed) for v in views[1:]])


def told(views: list[View]) -> list[Told]:
    """Return the pictures as predictors get them, in the first camera's frame."""
    origin = views[0].believed
    return [
        Told(v.image, origin.to_camera(v.believed.position), origin.rotation.T @ v.believed.rotation)
        for v in views
    ]


# ---------------------------------------------------------------- on the wrist


def _from_wrist(cell: Workcell, world: World, streams: Streams, clock: Clock) -> list[View]:
    scenario = cell.scenario
    nominal = CameraPose(np.array(scenario.camera.hand_eye), np.eye(3))
    calibration = scenario.calibration
    errors = Streams(streams.seed, "", 0) if calibration.drawn == "run" else streams
    true = nominal
    if not calibration.exact:
        true = miscalibrated(nominal, calibration, errors(Purpose.CALIBRATION))
    rngs = [streams(Purpose.SENSOR), streams(Purpose.VIEWS)]
    wide = world.robot.gripper.stroke
    views: list[View] = []
    for i, (believed, way) in enumerate(cell.view_motions):
        with clock.phase("execute"):
            world.follow(way, wide)
        if i == len(scenario.camera.dome):
            break  # home again
        eye = cell.camera_at(_eye(cell, world.tcp, true))
        taken = take_picture(world, eye, scenario, rngs[min(i, 1)], clock)
        views.append(View(*taken, eye, _eye(cell, believed, nominal)))
    return views


def _eye(cell: Workcell, tcp: GraspPose, in_hand: CameraPose) -> CameraPose:
    """Return the pose of a camera that sits in the hand of a robot whose TCP is at ``tcp``."""
    flange = tcp.position - cell.planner.robot.gripper.flange_to_tcp * tcp.approach
    return CameraPose(flange + tcp.rotation @ in_hand.position, tcp.rotation @ in_hand.rotation)
