"""Grasps: in the image plane, in the world, and as dense maps.

The image-plane grasp is that of GG-CNN (Morrison et al., RSS 2018) and of section 3.1 of
the HTC-Grasp paper. Angles are counter-clockwise as seen in the image, whose rows grow
downwards: the jaws open along (cos θ, −sin θ) in pixel coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from shapely.geometry import Polygon

from grasp_bench.system.arrays import Floats

Maps = NDArray[np.float32]


def wrap_angle(angle: float) -> float:
    """Bring the angle of a two-fingered grasp to (−π/2, π/2]: a half turn changes nothing."""
    wrapped = math.fmod(angle, math.pi)
    if wrapped > math.pi / 2:
        wrapped -= math.pi
    elif wrapped <= -math.pi / 2:
        wrapped += math.pi
    return wrapped


def angle_difference(a: float, b: float) -> float:
    """Return the smallest rotation in [0, π/2] between two jaw directions."""
    return abs(wrap_angle(a - b))


@dataclass(frozen=True)
class Grasp:
    """A parallel-jaw grasp in the image plane.

    Attributes:
        x, y: centre in pixels of the full image (edge of the image = 0).
        angle: direction in which the jaws open, radians in (−π/2, π/2], counter-clockwise.
        width: opening between the jaws in pixels.
        quality: predicted chance of success in [0, 1].
    """

    x: float
    y: float
    angle: float
    width: float
    quality: float = 1.0

    def ends(self) -> Floats:
        """Return the (2, 2) pixel positions of the two finger tips."""
        half = 0.5 * self.width * np.array([math.cos(self.angle), -math.sin(self.angle)])
        centre = np.array([self.x, self.y])
        return np.stack([centre - half, centre + half])

    def rectangle(self, height: float | None = None) -> Floats:
        """Return the (4, 2) corners, the first edge along the jaw opening direction.

        ``height`` (jaw size) defaults to half the width, as the GG-CNN lineage evaluates.
        """
        along = np.array([math.cos(self.angle), -math.sin(self.angle)])
        across = np.array([along[1], -along[0]])
        a = 0.5 * self.width * along
        b = 0.5 * (self.width / 2 if height is None else height) * across
        centre = np.array([self.x, self.y])
        return np.stack([centre - a + b, centre + a + b, centre + a - b, centre - a - b])

    @classmethod
    def from_rectangle(cls, corners: ArrayLike, quality: float = 1.0) -> Grasp:
        """Make the grasp of a labelled rectangle (4, 2) whose first edge is the jaw opening direction."""
        c = np.asarray(corners, dtype=float)
        dx, dy = c[1] - c[0]
        x, y = c.mean(0)
        return cls(float(x), float(y), wrap_angle(math.atan2(-dy, dx)), float(math.hypot(dx, dy)), quality)


def rectangle_iou(first: ArrayLike, second: ArrayLike) -> float:
    """Return the intersection over union of two convex quadrilaterals (4, 2), paper equation 9."""
    a, b = Polygon(np.asarray(first)), Polygon(np.asarray(second))
    if not (a.is_valid and b.is_valid):
        return 0.0
    overlap = a.intersection(b).area
    whole = a.area + b.area - overlap
    return float(overlap / whole) if whole > 0 else 0.0


def is_correct(
    grasp: Grasp, truths: Iterable[Grasp], *, iou: float = 0.25, angle: float = math.radians(30)
) -> bool:
    """Judge by the rectangle metric of the paper's section 4.1(c): within 30° of and IoU above 0.25 with at
    least one labelled grasp."""
    corners = grasp.rectangle()
    return any(
        angle_difference(grasp.angle, t.angle) <= angle and rectangle_iou(corners, t.rectangle()) > iou
        for t in truths
    )


@dataclass(frozen=True)
class GraspMaps:
    """Dense grasps, one a pixel (paper equation 2): four (H, W) float32 arrays.

    Attributes:
        quality: predicted chance of success in [0, 1].
        sin2, cos2: sine and cosine of twice the angle, which a half turn leaves unchanged.
        width: jaw opening in pixels of this map.
    """

    quality: Maps
    sin2: Maps
    cos2: Maps
    width: Maps

    @property
    def angle(self) -> Maps:
        """(H, W) angles in (−π/2, π/2]."""
        return (0.5 * np.arctan2(self.sin2, self.cos2)).astype(np.float32)

    def smoothed(self, sigma: float = 2.0) -> GraspMaps:
        """Return Gaussian-filtered maps. The angle is filtered as sine and cosine: filtering it directly, as
        GG-CNN's code does, smears across the ±π/2 seam."""
        import cv2

        def filtered(values: Maps, deviation: float) -> Maps:
            size = 2 * round(4 * deviation) + 1
            smooth = cv2.GaussianBlur(values, (size, size), deviation, borderType=cv2.BORDER_REFLECT)
            return np.asarray(smooth, np.float32)

        maps = (self.quality, self.sin2, self.cos2, self.width)
        sigmas = (sigma, sigma, sigma, sigma / 2)
        return GraspMaps(*(filtered(m, s) for m, s in zip(maps, sigmas, strict=True)))

    def peaks(self, count: int = 8, min_distance: int = 8, threshold: float = 0.05) -> list[Grasp]:
        """Return the best places, best first, as grasps in pixels of this map.

        Greedy non-maximum suppression: of what is left, the best place is taken and its surroundings are
        dropped. So there are others where the best cannot be carried out, on a ridge with one maximum, too.

        Args:
            count: greatest number of grasps returned.
            min_distance: no two within this many pixels (square neighbourhood).
            threshold: places of less quality are left out.
        """
        left, angle = np.array(self.quality), self.angle
        found: list[Grasp] = []
        while len(found) < count and left.size:
            r, c = (int(i) for i in np.unravel_index(np.argmax(left), left.shape))
            if not left[r, c] > threshold:
                break
            found.append(
                Grasp(
                    c + 0.5,
                    r + 0.5,
                    wrap_angle(float(angle[r, c])),
                    max(float(self.width[r, c]), 1.0),
                    float(np.clip(left[r, c], 0, 1)),
                )
            )
            left[
                max(r - min_distance, 0) : r + min_distance + 1,
                max(c - min_distance, 0) : c + min_distance + 1,
            ] = -np.inf
        return found

    @classmethod
    def from_grasps(cls, grasps: Iterable[Grasp], shape: tuple[int, int]) -> GraspMaps:
        """Make training maps of grasps, taken as rectangles half as high as wide."""
        listed = list(grasps)
        return cls.from_rectangles([g.rectangle() for g in listed], shape, [g.quality for g in listed])

    @classmethod
    def from_rectangles(
        cls, rectangles: Iterable[ArrayLike], shape: tuple[int, int], qualities: Iterable[float] | None = None
    ) -> GraspMaps:
        """Make training maps of labelled rectangles (4, 2), their first edge along the jaws' opening.

        The third of each in its middle is filled, later ones overwrite earlier ones (the
        convention of GG-CNN's code).
        """
        import cv2

        corners = [np.asarray(r, dtype=float) for r in rectangles]
        quality, sin2, cos2, width = (np.zeros(shape, np.float32) for _ in range(4))
        for c, q in zip(corners, [1.0] * len(corners) if qualities is None else qualities, strict=True):
            g = Grasp.from_rectangle(c)
            third = np.stack(
                [(2 * c[0] + c[1]) / 3, (c[0] + 2 * c[1]) / 3, (2 * c[2] + c[3]) / 3, (c[2] + 2 * c[3]) / 3]
            )
            mask = np.zeros(shape, np.uint8)
            cv2.fillPoly(mask, [np.round(third - 0.5).astype(np.int32)], (1,))
            inside = mask > 0
            quality[inside] = q
            sin2[inside], cos2[inside] = math.sin(2 * g.angle), math.cos(2 * g.angle)
            width[inside] = g.width
        return cls(quality, sin2, cos2, width)


@dataclass(frozen=True)
class GraspPose:
    """A grasp in six degrees of freedom: in the camera's frame from predictors, in the world's elsewhere.

    Attributes:
        position: (3,) the TCP, the midpoint between the finger tips' ends [m].
        rotation: (3, 3), columns x = jaw opening direction, y, z = approach direction.
        opening: distance between the finger pads before closing [m].
        quality: predicted chance of success in [0, 1].
    """

    position: Floats
    rotation: Floats
    opening: float
    quality: float = 1.0

    def __eq__(self, other: object) -> bool:
        return isinstance(other, GraspPose) and all(
            np.array_equal(getattr(self, f.name), getattr(other, f.name)) for f in fields(self)
        )

    __hash__ = None  # type: ignore[assignment]  # of arrays

    @classmethod
    def top_down(cls, position: ArrayLike, yaw: float, opening: float) -> GraspPose:
        """Make the pose straight down on ``position``, jaws opening at ``yaw`` from world x towards world
        y."""
        c, s = math.cos(yaw), math.sin(yaw)
        rotation = np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])
        return cls(np.asarray(position, dtype=float), rotation, float(opening))

    @property
    def approach(self) -> Floats:
        """(3,) direction in which the hand comes."""
        return self.rotation[:, 2]

    def flipped(self) -> GraspPose:
        """Return the same grasp with the two fingers exchanged."""
        return replace(self, rotation=self.rotation * [-1.0, -1.0, 1.0])

    def moved(self, rotation: Floats, shift: Floats) -> GraspPose:
        """Return the pose in another frame, whose points are ``rotation`` (3, 3) · p + ``shift`` (3,)."""
        return replace(self, position=rotation @ self.position + shift, rotation=rotation @ self.rotation)


@dataclass(frozen=True)
class SpatialGrasp(Grasp):
    """A predictor's grasp in six degrees of freedom, and how it looks in the image.

    Attributes:
        pose: TCP pose in the camera's frame.
    """

    pose: GraspPose = field(kw_only=True)

    @classmethod
    def of(cls, pose: GraspPose, project: Callable[[Floats], Floats]) -> SpatialGrasp:
        """Make it of a pose before the camera.

        Args:
            pose: in the camera's frame.
            project: turns camera-frame points (…, 3) [m] into pixels (…, 2).
        """
        x, y = project(pose.position)
        half = 0.5 * pose.opening * pose.rotation[:, 0]
        ends = pose.position + np.stack([-half, half])
        # Jaws that open along the view look closed; one of them may even be behind the camera.
        ends[:, 2] = np.maximum(ends[:, 2], 0.1 * pose.position[2])
        dx, dy = np.diff(project(ends), axis=0)[0]
        width = max(float(math.hypot(dx, dy)), 1.0)
        angle = wrap_angle(math.atan2(-dy, dx))
        return cls(float(x), float(y), angle, width, pose.quality, pose=pose)


@dataclass(frozen=True)
class KnownGrasp(Grasp):
    """A grasp of a control that knows the truth: where it is in the world, besides how a camera sees it.

    Attributes:
        pose: TCP pose in the world.
        top: height of what is grasped, above the table [m].
    """

    pose: GraspPose = field(kw_only=True)
    top: float = field(kw_only=True)

    def seen(self) -> Grasp:
        """Return what a camera sees of it alone."""
        return Grasp(self.x, self.y, self.angle, self.width, self.quality)
