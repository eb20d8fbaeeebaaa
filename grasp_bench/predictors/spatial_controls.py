"""Controls in six degrees of freedom: the upper bound, and a baseline that sees the point cloud only."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from grasp_bench.camera import RgbdImage
from grasp_bench.grasps import Grasp, GraspPose, KnownGrasp, SpatialGrasp
from grasp_bench.predictors.pointcloud import Plane, normals, standing, table_plane
from grasp_bench.predictors.protocol import GroundTruth, PrivilegedPredictor
from grasp_bench.predictors.reference import reference_poses
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.sections import Motion
from grasp_bench.system.arrays import Floats


class Oracle6dof(PrivilegedPredictor):
    """Upper bound from any direction: reference grasps where they truly are, tried out beforehand.

    They are worked out when first asked for and kept; see :mod:`grasp_bench.predictors.reference`.
    """

    foresight = True

    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        """Return the reference grasps of the resting pose the object is in: steep ones and those that the arm
        reaches outwards first, the best of these first."""
        ups = [p.rotation[2] @ truth.rotation[2] for p in truth.model.poses]
        rank = truth.position[:2] / max(float(np.linalg.norm(truth.position[:2])), 1e-9)
        found: list[tuple[float, Grasp]] = []
        for held, height in reference_poses(truth.model, int(np.argmax(ups)), truth.gripper):
            pose = held.moved(truth.rotation, truth.position)
            down = np.array([0.0, 0.0, -1.0])
            if (
                pose.approach @ down > 1 - 1e-6
            ):  # the object rests a hair's breadth otherwise than it did then
                pose = pose.top_down(
                    [*pose.position[:2], max(float(pose.position[2]), Motion().table_clearance)],
                    float(np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0])),
                    pose.opening,
                )
            seen = truth.camera
            flat = SpatialGrasp.of(
                pose.moved(seen.rotation.T, -seen.rotation.T @ seen.position), truth.intrinsics.project
            )
            known = KnownGrasp(
                flat.x, flat.y, flat.angle, flat.width, min(1.0, held.quality), pose=pose, top=height
            )
            handy = 0.3 * float(pose.approach @ down) + 0.2 * float(pose.approach[:2] @ rank)
            found.append((held.quality + handy, known))
        return [grasp for _, grasp in sorted(found, key=lambda f: -f[0])]


class Antipodal6dof:
    """Baseline on the point cloud: sample a hand, push it as deep as it goes, see what is between its jaws.

    As Grasp Pose Detection samples its candidates (ten Pas, Gualtieri, Saenko and Platt, IJRR 2017, section
    4; ten Pas and Platt, ISRR 2015): hands at random points of the cloud, approaching along the surface's
    normal or from above, are pushed forward until they would meet the cloud, and kept where something is
    between the fingers whose surface faces them within the friction cone. There a network ranks; here
    alignment, depth and nearness to the middle of what stands there do, and how much of the fingers would be
    in sight: behind what is seen there may be anything. Sides that the camera did not see count as neither
    aligned nor not.
    """

    SAMPLES = 70
    TURNS = 8
    PROPOSED = 10
    FRICTION_ANGLE = math.radians(30)
    LEAST_POINTS = 8
    ROOM = 0.008
    ABOVE_TABLE = 0.003
    BEHIND = 0.006
    GRIPPER = PARALLEL_85

    def __init__(self) -> None:
        self._rng = np.random.default_rng(0)  # for who asks without :meth:`begin`

    def begin(self, rng: np.random.Generator) -> None:
        """Take the trial's random stream."""
        self._rng = rng

    def predict(self, image: RgbdImage) -> list[GraspPose]:
        """Return up to ten grasps; none where nothing stands out of the table."""
        plane = table_plane(image, self._rng)
        if plane is None:
            return []
        points = standing(image, plane, 2 * self.ABOVE_TABLE)
        if len(points) < 3 * self.LEAST_POINTS:
            return []
        facing, tree = normals(points, np.zeros(3)), cKDTree(points)
        middle = np.median(points, axis=0)
        found: list[GraspPose] = []
        for i in self._rng.permutation(len(points))[: self.SAMPLES]:
            near = tree.query_ball_point(points[i], 0.13)
            for approach in self._approaches(facing[i], plane):
                for turn in range(self.TURNS):
                    rotation = _frame(approach, math.pi * turn / self.TURNS)
                    pose = self._hand(points[i], rotation, points[near], facing[near], plane)
                    if pose is not None:
                        away = float(np.linalg.norm(pose.position - middle))
                        quality = pose.quality * math.exp(-away / 0.08) * (1 - self._hidden(image, pose))
                        found.append(GraspPose(pose.position, pose.rotation, pose.opening, quality))
        return self._best(found)

    def _approaches(self, normal: Floats, plane: Plane) -> list[Floats]:
        """Return from where the hand comes to a point: from above, along its normal, and between."""
        ways = [-plane.normal]
        if -normal @ -plane.normal < math.cos(math.radians(20)) and normal @ plane.normal > -0.2:
            between = -plane.normal - normal
            ways += [between / np.linalg.norm(between), -normal]
        return ways

    def _hand(
        self, place: Floats, rotation: Floats, points: Floats, facing: Floats, plane: Plane
    ) -> GraspPose | None:
        """Return the hand pushed in at a point as deep as it goes, with its quality; None where it fails."""
        gripper = self.GRIPPER
        local = (points - place) @ rotation
        beside = np.abs(local[:, 1]) < gripper.finger_width / 2
        if beside.sum() < self.LEAST_POINTS:
            return None
        fingers, reach = local[beside], gripper.pad[2]
        grip = np.abs(fingers[:, 2]) < reach
        inside = fingers[grip & (np.abs(fingers[:, 0]) < gripper.stroke)]
        if len(inside) < self.LEAST_POINTS:
            return None
        low, high = np.percentile(inside[:, 0], [1, 99])
        width, centre = float(high - low), float(high + low) / 2
        opening = min(width + 2 * self.ROOM, gripper.opening)
        if width > gripper.opening - 2 * gripper.pad[0]:
            return None
        depth = self._depth(local, beside, centre, opening)
        tcp = place + rotation @ [centre, 0.0, depth]
        outer = opening / 2 + gripper.finger_thickness
        corners = [rotation @ [x, y, 0.0] for x in (-outer, outer) for y in (-0.01, 0.01)]
        lift = self.ABOVE_TABLE - min(float(plane.height(tcp + c)) for c in corners)
        if lift > 0:  # drawn back from the table
            steep = float(-rotation[:, 2] @ plane.normal)
            if steep < 0.2:
                return None
            depth -= lift / steep
            tcp = place + rotation @ [centre, 0.0, depth]
        held = beside & (np.abs(local[:, 0] - centre) < opening / 2) & (local[:, 2] > depth - reach)
        held &= local[:, 2] < depth
        if held.sum() < self.LEAST_POINTS or depth < 0.004:
            return None
        return GraspPose(tcp, rotation, opening, self._quality(local[held], facing[held] @ rotation, depth))

    def _depth(self, local: Floats, beside: NDArray[np.bool_], centre: float, opening: float) -> float:
        """Return how far beyond the point the tips get before fingers or hand meet the cloud [m]."""
        gripper = self.GRIPPER
        x = np.abs(local[:, 0] - centre)
        under = beside & (x > opening / 2 - 1e-3) & (x < opening / 2 + gripper.finger_thickness + 1e-3)
        palm = (x < gripper.palm[0] / 2) & (np.abs(local[:, 1]) < gripper.palm[1] / 2)
        depths = [gripper.pad[2] + 0.004]
        if under.sum() >= 3:
            depths.append(float(np.partition(local[under, 2], 2)[2]) - 0.002)
        if palm.sum() >= 3:
            depths.append(float(np.partition(local[palm, 2], 2)[2]) + gripper.finger_length - 0.002)
        return min(depths)

    def _hidden(self, image: RgbdImage, pose: GraspPose) -> float:
        """Return the share of the open fingers' ends that is behind what the camera saw, from 0 to 1."""
        gripper = self.GRIPPER
        x = (pose.opening + gripper.finger_thickness) / 2
        y = gripper.finger_width / 2
        ends = np.array(np.meshgrid([-x, x], [-y, 0, y], [-gripper.pad[2], -gripper.pad[2] / 2, 0]))
        places = pose.position + ends.reshape(3, -1).T @ pose.rotation.T
        u, v = np.floor(image.intrinsics.project(places)).astype(int).T
        height, width = image.depth.shape
        shown = (u >= 0) & (u < width) & (v >= 0) & (v < height)
        depth = image.depth[v[shown], u[shown]]
        return float(((depth > 0) & (places[shown, 2] > depth + self.BEHIND)).sum() / len(places))

    def _quality(self, held: Floats, facing: Floats, depth: float) -> float:
        """Return how well what is between the jaws faces them, from 0 to 1."""
        sides = []
        for side in (-1, 1):
            edge = side * held[:, 0] > (side * held[:, 0]).max() - 0.004
            cosine = np.clip(side * facing[edge, 0], -1, 1)
            seen = cosine > 0.3
            fits = (cosine > math.cos(self.FRICTION_ANGLE)).sum()
            sides.append(0.5 if seen.sum() < 3 else float(fits / seen.sum()))
        return (0.25 + 0.75 * min(sides)) * (0.5 + 0.5 * min(1.0, depth / 0.02))

    def _best(self, found: list[GraspPose]) -> list[GraspPose]:
        """Return the best hands, best first, no two of them nearly the same."""
        kept: list[GraspPose] = []
        for pose in sorted(found, key=lambda g: -g.quality):
            if all(
                np.linalg.norm(pose.position - k.position) > 0.01
                or np.trace(pose.rotation.T @ k.rotation) < 1 + 2 * math.cos(math.radians(30))
                for k in kept
            ):
                kept.append(pose)
            if len(kept) == self.PROPOSED:
                break
        return kept


def _frame(approach: Floats, turn: float) -> Floats:
    """Return a rotation (3, 3) whose z is ``approach`` (3,), x and y turned by ``turn`` about it [rad]."""
    x = np.cross(approach, np.eye(3)[int(np.argmin(np.abs(approach)))])
    x /= np.linalg.norm(x)
    x = math.cos(turn) * x + math.sin(turn) * np.cross(approach, x)
    return np.column_stack([x, np.cross(approach, x), approach]).astype(np.float64)
