"""Pictures of a tilted camera as one that looks straight down would have taken them.

The networks and heuristics of this benchmark expect a table seen face on. The depth image itself tells how to
turn a picture so: by the plane that most of it shows. A camera that is turned about its optical centre sees
the same rays, so its picture follows exactly, but for what was hidden from there, too.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any, TypeVar, cast

import cv2
import numpy as np

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.grasps import Grasp, wrap_angle
from grasp_bench.system.arrays import Floats

FACE_ON_DEG = 5.0
"""Planes turned by less than this are taken as seen face on, and their pictures as they are."""
STRIDE = 6
"""Pixels between two of those that the plane is sought among."""
TRIES, FEW = 100, 10
"""Planes that are tried, and those that are enough where most of a picture is one that is seen face on."""
MOST = 0.7
"""Share of the pixels that leaves too few for a plane turned further than :data:`FACE_ON_DEG`: of those of a
plane turned by less than half of that, it has no more than a strip."""
THICKNESS = 0.006
"""Greatest distance of a plane's pixels from it [m]."""


@dataclass(frozen=True)
class Plane:
    """Points p of the camera's frame with ``normal`` · p = ``distance`` [m]; the normal (3,) points away.

    ``share`` is that of the measured pixels that it was fitted to.
    """

    normal: Floats
    distance: float
    share: float

    @property
    def tilt(self) -> float:
        """Angle between optical axis and normal [rad]."""
        return math.acos(min(1.0, float(self.normal[2])))


def dominant_plane(image: RgbdImage, tries: int = TRIES) -> Plane | None:
    """Find the plane that most measured pixels are on; None where there are too few.

    Random sample consensus over planes through three pixels (with numbers that are always the same), then
    least squares over the inliers. On a plane inverse depth is linear in the ray: 1/z = n · ray / d.
    """
    depth = image.depth[::STRIDE, ::STRIDE].astype(np.float64)
    seen = depth > 0
    if seen.sum() < 50:
        return None
    rays = image.intrinsics.rays()[::STRIDE, ::STRIDE][seen]
    points = rays * depth[seen][:, None]
    rng = np.random.default_rng(0)
    triples = points[rng.integers(len(points), size=(tries, 3))]
    normals = np.cross(triples[:, 1] - triples[:, 0], triples[:, 2] - triples[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    offsets = np.einsum("ij,ij->i", normals, triples[lengths > 1e-9, 0])
    apart = normals @ points.T
    apart -= offsets[:, None]
    counts = (np.abs(apart, out=apart) < THICKNESS).sum(1)
    if len(counts) == 0:
        return None
    best = int(np.argmax(counts))
    near = np.abs(points @ normals[best] - offsets[best]) < THICKNESS
    slope, *_ = np.linalg.lstsq(rays[near], 1 / depth[seen][near], rcond=None)
    length = float(np.linalg.norm(slope))
    if slope[2] <= 0:
        return None
    return Plane(np.asarray(slope / length, float), 1 / length, float(near.mean()))


@dataclass(frozen=True)
class LevelView:
    """A picture as seen face on, and the way back to the one it was made of.

    Attributes:
        image: the level picture, of the same size; black and without depth where the camera did not look.
        homography: (3, 3) pixels of the original → pixels of ``image``.
    """

    image: RgbdImage
    homography: Floats

    def back(self, grasp: Grasp) -> Grasp:
        """Turn a grasp of the level picture into pixels of the original."""
        pixels = np.vstack([[grasp.x, grasp.y], grasp.ends()])
        moved = np.column_stack([pixels, np.ones(3)]) @ np.linalg.inv(self.homography).T
        centre, first, second = moved[:, :2] / moved[:, 2:]
        dx, dy = second - first
        return Grasp(
            float(centre[0]),
            float(centre[1]),
            wrap_angle(math.atan2(-dy, dx)),
            math.hypot(dx, dy),
            grasp.quality,
        )

    def inside(self, grasps: list[Grasp]) -> list[Grasp]:
        """Turn grasps into pixels of the original, and leave out those that it does not show."""
        size = self.image.intrinsics
        moved = map(self.back, grasps)
        return [g for g in moved if 0 <= g.x <= size.width and 0 <= g.y <= size.height]


def level_view(image: RgbdImage) -> LevelView | None:
    """Return the picture with its dominant plane face on; None where it is so already, or there is none.

    What is in the middle stays in the middle, and as large: the focal length makes up for a centre that is
    nearer to the plane than the ray through the middle is long.
    """
    plane = dominant_plane(image, FEW)
    if plane is not None and plane.share > MOST and 2 * plane.tilt < math.radians(FACE_ON_DEG):
        return None
    plane = dominant_plane(image)
    if plane is None or not math.radians(FACE_ON_DEG) < plane.tilt < math.radians(70):
        return None
    z = plane.normal
    x = np.array([1.0, 0, 0]) - z[0] * z
    x /= np.linalg.norm(x)
    turn = np.stack([x, np.cross(z, x), z])  # rows: the level camera's axes in the camera's frame
    given = image.intrinsics
    focal = given.fx * plane.normal[2]
    middle = turn @ given.deproject([given.width / 2, given.height / 2], np.ones(()))
    level = Intrinsics(
        given.width,
        given.height,
        focal,
        focal * given.fy / given.fx,
        given.width / 2 - focal * middle[0] / middle[2],
        given.height / 2 - focal * given.fy / given.fx * middle[1] / middle[2],
    )
    homography = np.asarray(level.matrix @ turn @ np.linalg.inv(given.matrix), float)
    # OpenCV puts pixel centres at integers, this project at integers + 0.5.
    half = np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1]])
    warp = np.asarray(np.linalg.inv(half) @ homography @ half, float)
    size = (given.width, given.height)
    depth = (image.depth * (given.rays() @ plane.normal)).astype(np.float32)
    return LevelView(
        RgbdImage(
            np.asarray(cv2.warpPerspective(image.rgb, warp, size, flags=cv2.INTER_LINEAR), np.uint8),
            np.asarray(cv2.warpPerspective(depth, warp, size, flags=cv2.INTER_NEAREST), np.float32),
            level,
        ),
        homography,
    )


_Predict = TypeVar("_Predict", bound=Callable[..., list[Grasp]])


def seen_level(predict: _Predict) -> _Predict:
    """Decorate a predictor's ``predict`` so that it is given the picture as seen face on."""

    @wraps(predict)
    def wrapped(self: Any, image: RgbdImage) -> list[Grasp]:
        view = level_view(image)
        return predict(self, image) if view is None else view.inside(predict(self, view.image))

    return cast(_Predict, wrapped)
