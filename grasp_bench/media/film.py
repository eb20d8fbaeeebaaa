"""Pictures from the side of recorded states of a trial.

MuJoCo's ray caster draws them without a graphics library; OpenGL does it with smoother edges
and, above some 300 × 300 pixels, more quickly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from types import TracebackType
from typing import Self

import mujoco
import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import compile_scene
from grasp_bench.scene.rendering import SHOWN_GROUPS, Picture, box_corners, raycast

Rgb = NDArray[np.uint8]
SKY = np.array([214, 220, 226], dtype=np.uint8)
"""Colour where rays hit nothing."""
FIELD = np.radians(45.0)
"""Vertical field of view, that of MuJoCo's free camera."""


@dataclass(frozen=True)
class View:
    """A free camera like that of MuJoCo's viewer: a point it looks at, distance [m], angles [°]."""

    lookat: tuple[float, float, float]
    distance: float = 1.05
    azimuth: float = 150.0
    elevation: float = -22.0

    @property
    def pose(self) -> CameraPose:
        """The pose of this camera."""
        azimuth, elevation = np.radians([self.azimuth, self.elevation])
        ahead = np.array(
            [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
        )
        return CameraPose.look_at(np.array(self.lookat) - self.distance * ahead, self.lookat, (0, 0, 1))


def side_view(scenario: Scenario) -> View:
    """Return the view that holds both the place where objects lie and the one they are carried to."""
    x, y = (np.array(scenario.table.center) + scenario.motion.carry_to[:2]) / 2
    return View((round(float(x) - 0.03, 3), round(float(y) - 0.02, 3), 0.14))


class Filmer:
    """A camera for states of one model.

    Args:
        model: model of the trial's world; its visual settings are changed for OpenGL.
        scenario: scenario of the trial.
        size: width and height [px].
        view: the camera; :func:`side_view` by default.
        opengl: draw with MuJoCo's OpenGL renderer, for which a library must have been chosen by
            :func:`grasp_bench.system.graphics.with_gl`.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        scenario: Scenario,
        size: tuple[int, int],
        view: View | None = None,
        opengl: bool = False,
    ) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        self._view = view or side_view(scenario)
        self._size = size
        self._gl: mujoco.Renderer | None = None
        if opengl:
            self._gl = self._start_gl()
        else:
            self._rays, self._empty = _empty_scene(scenario.model_dump_json(), size, self._view)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._gl is not None:
            self._gl.close()

    def shoot(self, qpos: NDArray[np.float64]) -> Rgb:
        """Return the picture (H, W, 3) of a state."""
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        return self._shoot_rays() if self._gl is None else self._shoot_gl(self._gl)

    def _shoot_rays(self) -> Rgb:
        """Cast only those rays anew that may hit something in front of the empty scene."""
        intrinsics, directions = self._rays
        moving = _covered(self._model, self._data, intrinsics, self._view.pose)
        picture = self._empty.copy()
        if moving.any():
            part = raycast(self._model, self._data, self._view.pose.position, directions[moving][None])
            picture[moving] = np.where(part.geom[0, :, None] >= 0, part.rgb[0], SKY)
        return picture

    def _start_gl(self) -> mujoco.Renderer:
        width, height = self._size
        visual = self._model.vis
        visual.global_.offwidth = max(visual.global_.offwidth, width)
        visual.global_.offheight = max(visual.global_.offheight, height)
        visual.headlight.ambient[:] = 0.35
        visual.quality.shadowsize = 1024  # the default 4096 costs a second a picture without a GPU
        return mujoco.Renderer(self._model, height, width)

    def _shoot_gl(self, renderer: mujoco.Renderer) -> Rgb:
        mujoco.mj_camlight(self._model, self._data)
        camera, option = mujoco.MjvCamera(), mujoco.MjvOption()
        camera.lookat[:] = self._view.lookat
        camera.distance, camera.azimuth = self._view.distance, self._view.azimuth
        camera.elevation = self._view.elevation
        option.geomgroup[:] = SHOWN_GROUPS
        renderer.update_scene(self._data, camera, option)
        return renderer.render().copy()


@cache
def _empty_scene(
    scenario: str, size: tuple[int, int], view: View
) -> tuple[tuple[Intrinsics, NDArray[np.float64]], Rgb]:
    """Return rays of the view, and its picture of the table without robot and object."""
    settings = Scenario.model_validate_json(scenario)
    width, height = size
    focal = height / 2 / np.tan(FIELD / 2)
    intrinsics = Intrinsics(width, height, focal, focal, width / 2, height / 2)
    directions = intrinsics.rays() @ view.pose.rotation.T
    model = compile_scene(settings, None, robot=None)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    picture = raycast(model, data, view.pose.position, directions)
    return (intrinsics, directions), with_sky(picture)


def with_sky(picture: Picture) -> Rgb:
    """Return the picture's colours, with a sky where nothing was hit."""
    return np.where(picture.geom[..., None] >= 0, picture.rgb, SKY)


def _covered(
    model: mujoco.MjModel, data: mujoco.MjData, intrinsics: Intrinsics, pose: CameraPose
) -> NDArray[np.bool_]:
    """Return (H, W) pixels that the bounding boxes of robot and objects may cover."""
    ours = model.geom_bodyid > 0
    shown = np.nonzero(ours & (SHOWN_GROUPS[model.geom_group] > 0))[0]
    points = pose.to_camera(box_corners(model, data, shown))
    mask = np.zeros((intrinsics.height, intrinsics.width), bool)
    for box in points:
        if (box[:, 2] < 0.01).any():  # reaches behind the camera
            mask[:] = True
            return mask
        pixels = intrinsics.project(box)
        left, top = np.maximum(np.floor(pixels.min(0)).astype(int) - 1, 0)
        right, bottom = np.maximum(np.ceil(pixels.max(0)).astype(int) + 1, 0)
        mask[top:bottom, left:right] = True
    return mask
