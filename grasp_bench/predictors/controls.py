"""Controls that keep a benchmark honest: an upper bound, heuristics, chance, and one that must fail.

A table in which the oracle does not pass, or in which the displaced grasp does, says nothing
about the predictors between them.
"""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, label

from grasp_bench.camera import RgbdImage
from grasp_bench.grasps import Grasp, GraspPose, KnownGrasp, wrap_angle
from grasp_bench.objects.catalog import ReferenceGrasp
from grasp_bench.predictors.level import seen_level
from grasp_bench.predictors.protocol import GroundTruth, PrivilegedPredictor
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.sections import Motion
from grasp_bench.system.arrays import Floats

FOREGROUND = 0.006
"""What stands out of the table by less than this is not seen by the depth-only controls [m]."""


class Oracle(PrivilegedPredictor):
    """Upper bound: the object's reference grasps where they truly are, tried out before one is chosen.

    Reference grasps are antipodal places on the true mesh that held in physics when the
    object was built; see :mod:`grasp_bench.workshop.poses`.
    """

    foresight = True

    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        """Return the reference grasps of the resting pose the object is in, best first."""
        return [known(truth, seen, tip, axis, g) for seen, tip, axis, g in placed(truth)]


def placed(truth: GroundTruth) -> list[tuple[Grasp, Floats, Floats, ReferenceGrasp]]:
    """Return the reference grasps of the pose an object is in, as a camera sees them, with their tip and axis
    (3,) in the world."""
    ups = [p.rotation[2] @ truth.rotation[2] for p in truth.model.graspable_poses]
    if not ups:
        return []
    pose = truth.model.graspable_poses[int(np.argmax(ups))]
    found = []
    for g in pose.grasps:
        tip, axis = truth.rotation @ g.tip + truth.position, truth.rotation @ g.axis
        found.append((project_grasp(truth, tip, axis, g.top, g.width, g.score), tip, axis, g))
    return found


def known(
    truth: GroundTruth, seen: Grasp, tip: Floats, axis: Floats, reference: ReferenceGrasp
) -> KnownGrasp:
    """Return a reference grasp that says where it is; the tips stay clear of the table."""
    place = [tip[0], tip[1], max(float(tip[2]), Motion().table_clearance)]
    pose = GraspPose.top_down(place, math.atan2(axis[1], axis[0]), reference.width)
    return KnownGrasp(
        seen.x, seen.y, seen.angle, seen.width, min(max(seen.quality, 0.0), 1.0), pose=pose, top=reference.top
    )


class Displaced(PrivilegedPredictor):
    """Must fail: the oracle's grasp moved 0.2 m across the table."""

    DISTANCE = 0.2

    def __init__(self) -> None:
        self._angle = 0.0  # where nobody calls begin()

    def begin(self, rng: np.random.Generator) -> None:
        """Draw the direction of the displacement."""
        self._angle = rng.uniform(-math.pi, math.pi)

    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        """Return one grasp, 0.2 m beside where it should be."""
        shift = self.DISTANCE * np.array([math.cos(self._angle), math.sin(self._angle), 0.0])
        moved = replace(truth, position=truth.position + shift)
        inside = [
            g
            for g, *_ in placed(moved)
            if 0 <= g.x <= image.intrinsics.width and 0 <= g.y <= image.intrinsics.height
        ]
        return inside[:1]


def project_grasp(
    truth: GroundTruth, tip: Floats, axis: Floats, top: float, width: float, quality: float
) -> Grasp:
    """Return the image-plane grasp of a world grasp, on the plane where the planner deprojects it.

    Args:
        truth: has the camera's pose and intrinsics.
        tip: (3,) TCP position [m].
        axis: (3,) jaw opening direction.
        top: height of what is grasped above the table [m].
        width: distance between the pads before closing [m].
        quality: taken over by the grasp, 0 to 1.
    """
    centre = np.array([tip[0], tip[1], top])
    half = 0.5 * width * np.array([axis[0], axis[1], 0.0]) / max(float(np.hypot(axis[0], axis[1])), 1e-9)
    ends = truth.intrinsics.project(truth.camera.to_camera(np.stack([centre - half, centre + half])))
    dx, dy = ends[1] - ends[0]
    x, y = ends.mean(0)
    return Grasp(float(x), float(y), wrap_angle(math.atan2(-dy, dx)), float(math.hypot(dx, dy)), quality)


# ---------------------------------------------------------------- depth-only heuristics


def _widest() -> float:
    """Return the opening that the depth-only controls know of: that of the reference gripper [m]."""
    return PARALLEL_85.opening


def foreground(image: RgbdImage) -> tuple[NDArray[np.bool_], float]:
    """Return the (H, W) mask of the largest blob near the image's middle, and the table's depth [m].

    The table is taken to be the median depth of the middle of the image, which holds for a
    mostly empty table seen face on.
    """
    h, w = image.depth.shape
    box = (slice(h // 2 - 112, h // 2 + 112), slice(w // 2 - 112, w // 2 + 112))
    middle = image.depth[box]
    table = float(np.median(middle[middle > 0])) if (middle > 0).any() else 0.0
    mask = np.zeros((h, w), bool)
    mask[box] = (middle > 0) & (middle < table - FOREGROUND)
    mask = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0
    parts, count = label(mask)
    if count == 0:
        return mask, table
    sizes = np.bincount(parts.ravel())[1:]
    return parts == 1 + int(np.argmax(sizes)), table


class Centroid:
    """Heuristic: the middle of the depth blob, jaws across its longer principal axis."""

    @seen_level
    def predict(self, image: RgbdImage) -> list[Grasp]:
        """Return one grasp, or none where nothing stands out of the table."""
        mask, _ = foreground(image)
        rows, columns = np.nonzero(mask)
        if len(rows) < 12:
            return []
        centre = np.array([columns.mean() + 0.5, rows.mean() + 0.5])
        offsets = np.column_stack([columns + 0.5, rows + 0.5]) - centre
        _, vectors = np.linalg.eigh(offsets.T @ offsets)
        minor = vectors[:, 0]  # eigenvalues ascend: the shorter axis comes first
        extent = np.ptp(offsets @ minor)
        near = float(np.median(image.depth[mask]))
        widest = _widest() * image.intrinsics.fx / near
        return [
            Grasp(
                float(centre[0]),
                float(centre[1]),
                wrap_angle(math.atan2(-minor[1], minor[0])),
                float(min(extent + 12, widest)),
                0.5,
            )
        ]


class Random:
    """Chance: a random place on the object, a random direction, jaws wide open."""

    COUNT = 1

    def __init__(self) -> None:
        self._rng = np.random.default_rng(0)  # where nobody calls begin()

    def begin(self, rng: np.random.Generator) -> None:
        """Take the trial's random stream."""
        self._rng = rng

    @seen_level
    def predict(self, image: RgbdImage) -> list[Grasp]:
        """Return :attr:`COUNT` grasps, or none where nothing stands out of the table."""
        mask, _ = foreground(image)
        rows, columns = np.nonzero(mask)
        if len(rows) == 0:
            return []
        return [self._any(image, rows, columns) for _ in range(self.COUNT)]

    def _any(self, image: RgbdImage, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Grasp:
        i = int(self._rng.integers(len(rows)))
        angle = wrap_angle(self._rng.uniform(-math.pi / 2, math.pi / 2))
        near = max(float(image.depth[rows[i], columns[i]]), 0.1)
        return Grasp(columns[i] + 0.5, rows[i] + 0.5, angle, _widest() * image.intrinsics.fx / near, 0.5)


class Random10(Random):
    """What the planner alone can do: ten random grasps, of which it carries out the first that gets deep.

    The first is that of :class:`Random` in the same trial.
    """

    COUNT = 10


class Antipodal:
    """Heuristic: pairs of opposite depth edges, as Dex-Net 2.0 samples its candidates.

    Depth edges are pixels with a steep smoothed depth gradient; two of them make a grasp when
    their gradients oppose each other within the friction cone and the jaws span them. The pair
    nearest to the blob's middle, with the best aligned gradients, ranks first (Mahler et al.,
    RSS 2017, describe the sampling; there a network ranks).
    """

    SAMPLES = 4000
    FRICTION_ANGLE = math.atan(0.5)

    def __init__(self) -> None:
        self._rng = np.random.default_rng(0)  # where nobody calls begin()

    def begin(self, rng: np.random.Generator) -> None:
        """Take the trial's random stream."""
        self._rng = rng

    @seen_level
    def predict(self, image: RgbdImage) -> list[Grasp]:
        """Return up to ten grasps; none where no pair of edges fits the jaws."""
        mask, table = foreground(image)
        rows, columns = np.nonzero(mask)
        if len(rows) < 12:
            return []
        depth = gaussian_filter(np.where(image.valid, image.depth, table), 1.0)
        gy, gx = np.gradient(depth)
        steep = np.hypot(gx, gy)
        edge_rows, edge_columns = np.nonzero(
            (steep > 0.003) & (cv2.dilate(mask.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0)
        )
        if len(edge_rows) < 2:
            return []
        first, second = self._rng.integers(len(edge_rows), size=(2, self.SAMPLES))
        points = np.column_stack([edge_columns, edge_rows]) + 0.5
        normal = np.column_stack([gx[edge_rows, edge_columns], gy[edge_rows, edge_columns]])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        line = points[second] - points[first]
        length = np.linalg.norm(line, axis=1)
        near = float(np.median(image.depth[mask]))
        widest = _widest() * image.intrinsics.fx / near
        line = line / np.maximum(length, 1e-9)[:, None]
        # Depth grows away from the object, so its gradient points outwards.
        out_first = -np.einsum("ij,ij->i", normal[first], line)
        out_second = np.einsum("ij,ij->i", normal[second], line)
        aligned = np.minimum(out_first, out_second)
        good = (length > 4) & (length < widest - 8) & (aligned > math.cos(self.FRICTION_ANGLE))
        if not good.any():
            return []
        middle = (points[first] + points[second]) / 2
        centre = np.array([columns.mean(), rows.mean()])
        spread = np.sqrt(len(rows))
        score = aligned * np.exp(-np.linalg.norm(middle - centre, axis=1) / spread)
        order = [i for i in np.argsort(-score, kind="stable") if good[i]][:10]
        return [
            Grasp(
                float(middle[i, 0]),
                float(middle[i, 1]),
                wrap_angle(math.atan2(-line[i, 1], line[i, 0])),
                float(min(length[i] + 14, widest)),
                float(np.clip(score[i], 0, 1)),
            )
            for i in order
        ]
