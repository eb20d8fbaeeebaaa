"""The picture of a stage as a network is shown it, and the view in which its labels are.

A tilted view becomes what it becomes in use: turned face on as in trials, or, detrended, left as it is with
its depth made level as real data sets' is. Labels are made in the camera of that picture: for one turned face
on a camera at the same place that looks along the normal of the plane that was found.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.learning.data.framing import Frame
from grasp_bench.learning.data.stages.staging import Stage
from grasp_bench.predictors.level import LevelView, level_view
from grasp_bench.predictors.tabletop import levelled
from grasp_bench.scene.rendering import Picture, raycast
from grasp_bench.scene.sensor import sense
from grasp_bench.scene.shading import Shader
from grasp_bench.scene.surfaces import surfaces
from grasp_bench.scene.surroundings import FIXTURE

WINDOW = 224
"""Side of the networks' input, in which a detrended picture's table is fitted [px]."""


ON_TABLE = 0.002
"""What is less high is table [m]."""
LEAST_PIXELS, LEAST_TABLE = 120, 0.25
"""Pixels of objects that a picture's middle shows at least, and share of it that is table."""
UNEVEN = 0.015
"""Mean height of the table beyond which it was not made level [m]."""
HORIZON = -0.1
"""Rays that go down by less for each metre of depth have no label."""


class Shot(NamedTuple):
    """What was pictured.

    Attributes:
        rgb: (S, S, 3) colour as the network is shown it.
        depth: (S, S) level depth [m], 0 where nothing was measured.
        truth: perfect picture of the same pixels.
        intrinsics, pose: of the camera that would see it so.
        seen: (S, S) pixels that the camera truly looked at.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    truth: Picture
    intrinsics: Intrinsics
    pose: CameraPose
    seen: NDArray[np.bool_]

    def usable(self, model: mujoco.MjModel) -> bool:
        """Tell whether the picture shows an object on a table whose plane was found.

        A predictor could make nothing of others: walls fill them, or hide what is to be grasped.
        """
        rays = self.intrinsics.rays() @ self.pose.rotation[2]
        height = self.pose.position[2] + rays * self.truth.depth
        table = (np.abs(height) < ON_TABLE) & self.seen & (self.truth.depth > 0)
        level = np.median(self.depth[self.depth > 0]) - self.depth[table & (self.depth > 0)]
        margin = (len(rays) - WINDOW) // 2
        shown = self.objects(model)[margin : margin + WINDOW, margin : margin + WINDOW]
        return bool(
            shown.sum() >= LEAST_PIXELS
            and table.mean() > LEAST_TABLE
            and len(level)
            and np.abs(level).mean() < UNEVEN
        )

    @property
    def scale(self) -> float:
        """Pixels a metre on the table in the middle of the picture."""
        down = -float(self.pose.rotation[2, 2])
        return self.intrinsics.fx / (float(self.pose.position[2]) / max(down, 0.1))

    def shows(self, pixels: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Return which of ``pixels`` (N, 2) the camera looked at."""
        size = len(self.seen)
        inside = ((pixels >= 0) & (pixels < size)).all(axis=1)
        column, row = np.clip(pixels, 0, size - 1).astype(int).T
        return inside & self.seen[row, column]

    def masked(self, maps: dict[str, NDArray], model: mujoco.MjModel) -> dict[str, NDArray]:
        """Return label maps (S, S) that are 0 on fixtures, above the horizon, and where nobody looked."""
        around = np.array([model.geom(i).name.startswith(FIXTURE) for i in range(model.ngeom)] + [False])
        down = self.intrinsics.rays() @ self.pose.rotation[2] < HORIZON
        keep = self.seen & down & ~around[self.truth.geom]
        return {name: np.where(keep, values, 0).astype(values.dtype) for name, values in maps.items()}

    def objects(self, model: mujoco.MjModel) -> NDArray[np.bool_]:
        """Return the (S, S) pixels that show an object."""
        movable = np.append(model.body_weldid[model.geom_bodyid] != 0, False)
        return movable[self.truth.geom] & self.seen


def shoot(
    stage: Stage, model: mujoco.MjModel, data: mujoco.MjData, size: int, rng: np.random.Generator
) -> Shot:
    """Take the picture of a stage, of which the middle ``size`` px both ways are kept."""
    scenario = stage.scenario
    camera, pose = scenario.camera.intrinsics, scenario.camera.pose
    picture = Shader(scenario, model).picture(data, pose.position, camera.rays() @ pose.rotation.T)
    image = sense(picture, camera, scenario.sensor, rng, surfaces(model))
    view = None if stage.detrended else level_view(image)
    if view is not None:
        image, pose = view.image, CameraPose(pose.position, pose.rotation @ _turn(view, camera).T)
    whole = image.intrinsics
    frame = Frame(whole.width // 2, whole.height // 2, size, size)
    left, upper = whole.width // 2 - size // 2, whole.height // 2 - size // 2
    crop = Intrinsics(size, size, whole.fx, whole.fy, whole.cx - left, whole.cy - upper)
    looked = np.ones(image.depth.shape, np.uint8) if view is None else _looked_at(view, camera)
    depth = image.depth
    if stage.origin is not None:
        points = camera.rays() * depth[..., None]
        depth = np.where(depth > 0, np.linalg.norm(points - stage.origin, axis=-1), 0).astype(np.float32)
    depth = frame.cut(depth, fill=False)
    if stage.detrended:
        depth = levelled(depth, WINDOW)
    truth = raycast(model, data, pose.position, crop.rays() @ pose.rotation.T)
    seen = frame.cut(looked, fill=False).astype(bool)
    return Shot(frame.cut(image.rgb, fill=True), depth.astype(np.float32), truth, crop, pose, seen)


def _turn(view: LevelView, camera: Intrinsics) -> NDArray[np.float64]:
    """Return the (3, 3) axes of the level camera, row by row, in the frame of the true one."""
    turn = np.linalg.inv(view.image.intrinsics.matrix) @ view.homography @ camera.matrix
    return turn / np.cbrt(np.linalg.det(turn))


def _looked_at(view: LevelView, camera: Intrinsics) -> NDArray[np.uint8]:
    """Return (H, W) 1 where the level picture shows what the camera looked at."""
    half = np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1]])  # OpenCV puts pixel centres at integers
    warp = np.linalg.inv(half) @ view.homography @ half
    ones = np.ones((camera.height, camera.width), np.uint8)
    return np.asarray(cv2.warpPerspective(ones, warp, (camera.width, camera.height)), np.uint8)
