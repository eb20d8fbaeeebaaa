"""Off-screen colour and depth images, by MuJoCo's ray caster or by OpenGL.

The ray caster needs no graphics library at all and gives the same pixels on every machine,
so it is what ``auto`` means. EGL and OSMesa draw the same scene with OpenGL; which renderer
made a run's images is part of its record.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.errors import GraspBenchError
from grasp_bench.scene.surfaces import geom_colors
from grasp_bench.system.graphics import resolve_renderer, with_gl

FAR = 10.0
"""Rays that hit nothing within this distance are invalid [m]."""
LIGHTS = ((np.array([0.25, -0.45, 0.86]), 0.45), (np.array([-0.6, 0.5, 0.62]), 0.2))
"""Directions towards two distant lamps, and their strength."""
AMBIENT = 0.40
SHOWN_GROUPS = np.array([1, 1, 1, 0, 0, 0], dtype=np.uint8)


class Picture(NamedTuple):
    """A noise-free image.

    Attributes:
        rgb: (H, W, 3) uint8.
        depth: (H, W) float32 z-depth [m], 0 where nothing was hit.
        cosine: (H, W) float32 cosine between viewing ray and surface normal, 0 where nothing was hit.
        geom: (H, W) int32 geom ids, −1 where nothing was hit.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    cosine: NDArray[np.float32]
    geom: NDArray[np.int32]


Draw = Callable[[mujoco.MjModel, mujoco.MjData, NDArray[np.float64], NDArray[np.float64]], Picture]
"""Makes a picture of model, data, origin (3,) and world directions (H, W, 3), each with z = 1 in its camera's
frame."""


Seen = dict[str, NDArray]
"""Of the pixels that show a body: their ``place`` in the image, row by row, and channels of a picture."""
Remember = Callable[[bytes, Callable[[], Seen]], Seen]
"""Returns what was seen before where all that it depends on besides the model was the same, or looks now."""


def looking(view: bytes, look: Callable[[], Seen]) -> Seen:
    """Look, whatever was seen before."""
    return look()


class SceneCamera:
    """A fixed camera that takes pictures of scenes that differ in one body only.

    What stands still and does not change from trial to trial (table, floor) is cast once;
    after that only the rays towards the changing body are. The pictures are the same as if
    all rays were cast every time.

    Args:
        intrinsics, pose: those of the camera.
        renderer: one of :data:`~grasp_bench.system.graphics.RENDERERS`.
        draw: casts and shades rays like :func:`raycast`, for scenarios with a look of their own, which OpenGL
            does not draw; all rays are cast every time then, since shadows move.
    """

    def __init__(
        self, intrinsics: Intrinsics, pose: CameraPose, renderer: str = "auto", draw: Draw | None = None
    ) -> None:
        self._draw = draw
        self.intrinsics, self.pose, self.renderer = intrinsics, pose, resolve_renderer(renderer)
        planes = np.moveaxis(intrinsics.rays() @ pose.rotation.T, 2, 0)
        self.directions = np.moveaxis(np.ascontiguousarray(planes), 0, 2)  # who reads one axis reads it fast
        self._background: Picture | None = None

    def picture(
        self, model: mujoco.MjModel, data: mujoco.MjData, body: int = -1, remember: Remember = looking
    ) -> Picture:
        """Take an image of the scene.

        Args:
            body: the one that changes between calls, −1 when all may.
            remember: may know from before what is seen of that one.
        """
        if self.renderer != "raycast":
            return _render_gl(model, data, self.intrinsics, self.pose, self.renderer)
        if self._draw is not None:
            return self._draw(model, data, self.pose.position, self.directions)
        if body < 0:
            return raycast(model, data, self.pose.position, self.directions)
        if self._background is None:
            background = raycast(model, data, self.pose.position, self.directions, exclude=body)
            seen = model.geom_bodyid[np.unique(background.geom[background.geom >= 0])]
            if model.body_weldid[seen].any():  # the arm is in view, and never stands quite still
                return raycast(model, data, self.pose.position, self.directions)
            self._background = background
        geoms = self._shown(model, body)
        view = [self.pose.position, self.pose.rotation, data.geom_xpos[geoms], data.geom_xmat[geoms]]
        known = repr(self.intrinsics).encode() + b"".join(of.tobytes() for of in view)
        seen = remember(known, lambda: self._look(model, data, body))
        whole = Picture._make(channel.copy() for channel in self._background)
        for name, channel in whole._asdict().items():
            channel.reshape(-1, *channel.shape[2:])[seen["place"]] = seen[name]
        return whole

    def _look(self, model: mujoco.MjModel, data: mujoco.MjData, body: int) -> Seen:
        """Cast the rays towards a body."""
        region = self._region(model, data, body)
        rays = self.directions[region]
        hits = cast(model, data, self.pose.position, rays)
        fresh = (hits.geom >= 0) & (model.geom_bodyid[hits.geom] == body)
        shaded = _shade(model, rays[fresh], Hits._make(of[fresh] for of in hits))
        rows, columns = (index[fresh] for index in region)
        return {"place": rows * self.directions.shape[1] + columns, **shaded._asdict()}

    @staticmethod
    def _shown(model: mujoco.MjModel, body: int) -> NDArray[np.intp]:
        """Return the geoms of a body that cameras see."""
        return np.nonzero((model.geom_bodyid == body) & (SHOWN_GROUPS[model.geom_group] > 0))[0]

    def _region(self, model: mujoco.MjModel, data: mujoco.MjData, body: int) -> tuple[NDArray[np.intp], ...]:
        """Return the rows and columns of the pixels that may show the body's geoms."""
        corners = self.pose.to_camera(box_corners(model, data, self._shown(model, body)))
        height, width = self.directions.shape[:2]
        if (corners[..., 2] < 0.05).any():  # reaches beside or behind the camera
            return np.nonzero(np.ones((height, width), bool))
        pixels = self.intrinsics.project(corners)
        left, top = np.clip(np.floor(pixels.min((0, 1))).astype(int) - 2, 0, [width, height])
        right, bottom = np.clip(np.ceil(pixels.max((0, 1))).astype(int) + 2, 0, [width, height])
        mask = np.zeros((bottom - top, right - left), np.uint8)
        if not mask.size:
            return np.nonzero(mask)
        for box in np.round(pixels - 0.5 - [left, top]).astype(
            np.int32
        ):  # OpenCV's pixel centres are integers
            cv2.fillConvexPoly(mask, cv2.convexHull(box), (1,))
        rows, columns = np.nonzero(cv2.dilate(mask, np.ones((5, 5), np.uint8)))
        return rows + top, columns + left


def box_corners(model: mujoco.MjModel, data: mujoco.MjData, geoms: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the (G, 8, 3) corners of the geoms' bounding boxes in the world [m]."""
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    boxes = model.geom_aabb[geoms, None, :3] + signs * model.geom_aabb[geoms, None, 3:]
    corners = np.einsum("gij,gkj->gki", data.geom_xmat[geoms].reshape(-1, 3, 3), boxes)
    return corners + data.geom_xpos[geoms, None]


def raycast(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    origin: NDArray[np.float64],
    directions: NDArray[np.float64],
    exclude: int = -1,
) -> Picture:
    """Cast rays of any pattern (H, W, 3), each with z = 1 in its camera's frame.

    Args:
        origin: (3,) optical centre [m].
        directions: world directions; with z = 1 in the camera frame distances are z-depths.
        exclude: body that rays pass through, −1 for none.
    """
    shape = directions.shape[:2]
    rays = np.ascontiguousarray(directions.reshape(-1, 3))
    picture = _shade(model, rays, cast(model, data, origin, rays, exclude))
    return Picture._make(channel.reshape(*shape, *channel.shape[1:]) for channel in picture)


class Hits(NamedTuple):
    """What N rays meet first.

    Attributes:
        geom: (N,) geom ids, −1 where nothing was hit.
        distance: (N,) in lengths of the ray.
        normal: (N, 3) of the surface.
    """

    geom: NDArray[np.int32]
    distance: NDArray[np.float64]
    normal: NDArray[np.float64]


def cast(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    origin: NDArray[np.float64],
    rays: NDArray[np.float64],
    exclude: int = -1,
) -> Hits:
    """What rays (N, 3) from ``origin`` meet."""
    count = len(rays)
    hits = Hits(np.full(count, -1, dtype=np.int32), np.zeros(count), np.zeros((count, 3)))
    if count:
        mujoco.mj_multiRay(
            model,
            data,
            origin,
            rays.ravel(),
            SHOWN_GROUPS,
            True,
            exclude,
            hits.geom,
            hits.distance,
            hits.normal.ravel(),
            count,
            FAR,
        )
    return hits


def _shade(model: mujoco.MjModel, rays: NDArray[np.float64], hits: Hits) -> Picture:
    """Channels (N, …) of what rays (N, 3) meet."""
    hit, count = hits.geom >= 0, len(rays)
    cosine = np.einsum("ij,ij->i", hits.normal, rays) / np.linalg.norm(rays, axis=1)
    normal = hits.normal * -np.sign(cosine)[:, None]
    light = np.full(count, AMBIENT)
    for direction, strength in LIGHTS:
        light += strength * np.clip(normal @ (direction / np.linalg.norm(direction)), 0, None)
    color = geom_colors(model)[hits.geom] * light[:, None]
    return Picture(
        np.where(hit[:, None], np.clip(color * 255, 0, 255), 0).astype(np.uint8),
        np.where(hit, hits.distance, 0).astype(np.float32),
        np.where(hit, np.abs(cosine), 0).astype(np.float32),
        hits.geom,
    )


def incidence_cosine(depth: NDArray[np.float32], intrinsics: Intrinsics) -> NDArray[np.float32]:
    """Return the (H, W) cosine between viewing ray and surface normal, from a perfect depth image [m]."""
    rays = intrinsics.rays()
    points = rays * depth[..., None]
    normal = np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0))
    length = np.linalg.norm(normal, axis=-1) * np.linalg.norm(rays, axis=-1)
    cosine = np.abs(np.einsum("hwc,hwc->hw", normal, rays)) / np.maximum(length, 1e-12)
    return cosine.astype(np.float32)


def _render_gl(
    model: mujoco.MjModel, data: mujoco.MjData, intrinsics: Intrinsics, pose: CameraPose, backend: str
) -> Picture:
    """Draw an image by OpenGL from the model's camera ``sensor``, which is put at ``pose``."""
    with_gl(backend)
    placed = model.camera("sensor").id  # a child of the world; its OpenGL axes have y up and z backwards
    data.cam_xpos[placed] = pose.position
    data.cam_xmat[placed] = (pose.rotation * [1, -1, -1]).ravel()
    width, height = intrinsics.width, intrinsics.height
    model.vis.global_.offwidth = max(model.vis.global_.offwidth, width)
    model.vis.global_.offheight = max(model.vis.global_.offheight, height)
    try:
        context = mujoco.Renderer(model, height, width)
    except Exception as error:
        raise GraspBenchError(
            f"The renderer {backend!r} cannot start ({error}); install its library "
            "or choose --renderer raycast, which needs none."
        ) from error
    with context as gl:
        camera = model.camera("sensor").id
        option = mujoco.MjvOption()
        option.geomgroup[:] = SHOWN_GROUPS
        gl.update_scene(data, camera, option)
        rgb = gl.render().copy()
        gl.enable_depth_rendering()
        gl.update_scene(data, camera, option)
        depth = gl.render().astype(np.float32)
        gl.disable_depth_rendering()
        gl.enable_segmentation_rendering()
        gl.update_scene(data, camera, option)
        segments = gl.render()
    geom = np.where(segments[..., 1] == mujoco.mjtObj.mjOBJ_GEOM, segments[..., 0], -1).astype(np.int32)
    depth = np.where((geom >= 0) & (depth < FAR), depth, 0).astype(np.float32)
    return Picture(rgb, depth, incidence_cosine(depth, intrinsics), geom)
