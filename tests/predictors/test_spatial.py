"""Grasps in six degrees of freedom at the door: what is taken, what is refused, and by which name."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp, GraspPose, SpatialGrasp
from grasp_bench.predictors import wire
from grasp_bench.predictors.protocol import ask, checked
from grasp_bench.predictors.spatial_controls import Antipodal6dof

K = Intrinsics(640, 480, 320.0, 320.0, 320.0, 240.0)
TURN = Rotation.from_euler("xyz", [20, -35, 130], degrees=True).as_matrix()
POSE = GraspPose(np.array([0.05, -0.02, 0.5]), TURN, 0.06, 0.7)


class Told:
    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def predict(self, image: RgbdImage) -> Any:
        return self.answer


def image() -> RgbdImage:
    return RgbdImage(np.zeros((480, 640, 3), np.uint8), np.full((480, 640), 0.55, np.float32), K)


def test_a_pose_passes_the_door_to_the_bit_and_shows_where_it_is_in_the_image() -> None:
    (grasp,) = ask(Told([POSE]), image(), np.random.default_rng(0))
    assert isinstance(grasp, SpatialGrasp)
    assert grasp.pose == POSE
    np.testing.assert_allclose([grasp.x, grasp.y], K.project(POSE.position))
    ends = K.project(POSE.position + 0.03 * np.outer([-1, 1], TURN[:, 0]))
    np.testing.assert_allclose(
        np.sort(grasp.ends(), 0), np.sort(ends + grasp.ends().mean(0) - ends.mean(0), 0)
    )
    assert grasp.quality == 0.7


def test_jaws_along_the_view_and_half_turns() -> None:
    along = GraspPose(POSE.position, np.eye(3)[:, [2, 0, 1]], 0.08)
    (grasp,) = checked([along], K)
    assert grasp.width >= 1
    assert math.isfinite(grasp.angle)
    one, other = checked([POSE, POSE.flipped()], K)
    assert one.angle == pytest.approx(other.angle)
    assert POSE.flipped().flipped() == POSE


def test_a_rotation_with_rounding_is_made_orthonormal() -> None:
    (grasp,) = checked([replace(POSE, rotation=TURN.astype(np.float32))], K)
    assert isinstance(grasp, SpatialGrasp)
    np.testing.assert_allclose(grasp.pose.rotation.T @ grasp.pose.rotation, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(grasp.pose.rotation, TURN, atol=1e-6)


@pytest.mark.parametrize(
    ("pose", "why"),
    [
        (replace(POSE, rotation=2 * TURN), "its rotation is none"),
        (replace(POSE, rotation=np.zeros((3, 3))), "its rotation is none"),
        (replace(POSE, rotation=TURN * [1, -1, 1]), "mirrored"),
        (replace(POSE, rotation=np.full((3, 3), np.nan)), "rotation holds NaN"),
        (replace(POSE, rotation=TURN[:2]), r"shape \(3, 3\), got \(2, 3\)"),
        (replace(POSE, position=np.array([0.1, np.nan, 0.5])), "position holds NaN"),
        (replace(POSE, position=np.array([50.0, -20.0, 500.0])), "are these millimetres"),
        (replace(POSE, position=np.array([0.5, 0.0, -0.5])), "behind the camera"),
        (replace(POSE, position="here"), "not made of numbers"),
        (replace(POSE, opening=60.0), "are these millimetres"),
        (replace(POSE, opening=0.0), "must be positive"),
        (replace(POSE, opening=math.inf), "opening holds NaN or infinity"),
        (replace(POSE, quality=math.nan), "quality holds NaN"),
    ],
)
def test_what_is_no_pose_is_one_clear_error(pose: GraspPose, why: str) -> None:
    with pytest.raises(PredictorError, match=f"grasp 1.*{why}") as error:
        ask(Told([POSE, pose]), image(), np.random.default_rng(0))
    assert "\n" not in str(error.value)


def test_over_the_wire_it_is_the_same_to_the_bit() -> None:
    grasps = checked([POSE, Grasp(320, 240, 0.3, 50, 0.4)], K)
    told = wire.decode_answer(wire.encode_answer(grasps))
    assert told == [POSE, Grasp(320, 240, 0.3, 50, 0.4)]
    assert checked(told, K) == grasps


@pytest.mark.parametrize(
    ("row", "why"),
    [
        ({"position": [0, 0, 1]}, "must have position, rotation, opening"),
        (
            {"position": [0, 0, 1], "rotation": [1, 0], "opening": 0.1},
            "rotation must be 3 lists of 3 numbers",
        ),
        (
            {"position": [0, 0], "rotation": np.eye(3).tolist(), "opening": 0.1},
            "position must be a list of 3",
        ),
        ({"position": [0, 0, 1], "rotation": np.eye(3).tolist(), "opening": "1"}, "opening must be a number"),
        ({"position": [0, 0, 10**400], "rotation": np.eye(3).tolist(), "opening": 1}, "beyond reckoning"),
        ({"position": [0, 0, 1], "rotation": np.eye(3).tolist(), "opening": 1, "x": 3}, "must have x, y"),
        ({"position": [0, True, 1], "rotation": np.eye(3).tolist(), "opening": 1}, "position must be a list"),
    ],
)
def test_rows_that_are_no_pose_are_refused_with_a_reason(row: dict[str, Any], why: str) -> None:
    with pytest.raises(PredictorError, match=f"grasp 0 of the answer.*{why}"):
        wire.decode_answer(json.dumps({"grasps": [row]}).encode())


def test_the_cloud_is_what_was_measured() -> None:
    seen = image()
    seen.depth[0] = 0
    assert np.isnan(seen.points[0]).all()
    points, colours = seen.cloud()
    assert points.shape == (479 * 640, 3)
    assert colours.shape == points.shape
    np.testing.assert_allclose(K.project(points[:3]), [[0.5, 1.5], [1.5, 1.5], [2.5, 1.5]], atol=1e-4)
    within = np.zeros((480, 640), bool)
    within[:2, :5] = True
    assert len(seen.cloud(within)[0]) == 5


def stood(box: tuple[slice, slice], depth: float) -> RgbdImage:
    """The table at 0.55 m with something nearer in a part of the picture."""
    seen = image()
    seen.depth[box] = depth
    return seen


def test_fingers_behind_what_is_seen_count_as_hidden() -> None:
    """A hand from above, its jaws along the image's x, around a place 20 mm above the table."""
    chooser = Antipodal6dof()
    pose = GraspPose(np.array([0.0, 0.0, 0.53]), np.eye(3), 0.06)
    left, right = (slice(200, 280), slice(0, 320)), (slice(200, 280), slice(320, 640))
    assert chooser._hidden(image(), pose) == 0, "both fingers are above the table"
    assert chooser._hidden(stood(right, 0.45), pose) == 0.5, "what stands there hides one of them"
    assert chooser._hidden(stood(left, 0.45), pose.flipped()) == 0.5
    assert chooser._hidden(stood((slice(None), slice(None)), 0.45), pose) == 1
    assert chooser._hidden(stood(right, 0.0), pose) == 0, "where nothing was measured, nothing is known"
    upper = 0.53 - chooser.GRIPPER.pad[2] / 2 - chooser.BEHIND / 2
    assert chooser._hidden(stood(right, upper), pose) == pytest.approx(1 / 6), "only the tips of one finger"
    beyond = replace(pose, position=np.array([-0.53, 0.0, 0.53]))
    assert chooser._hidden(stood(left, 0.45), beyond) == 0.5, "one is hidden, the other not in the picture"


def test_of_two_hands_the_one_in_sight_is_proposed_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same block twice; the second time all hands on its right are out of sight."""
    seen = stood((slice(215, 265), slice(308, 332)), 0.53)
    chooser = Antipodal6dof()
    chooser.begin(np.random.default_rng(0))
    plain = chooser.predict(seen)
    assert plain
    best = plain[0]
    monkeypatch.setattr(Antipodal6dof, "_hidden", lambda self, image, pose: float(pose.position[0] > 0))
    chooser.begin(np.random.default_rng(0))
    hidden = chooser.predict(seen)
    assert hidden[0].position[0] <= 0
    assert {p.quality for p in hidden if p.position[0] > 0} <= {0.0}
    assert best.quality >= hidden[0].quality > 0
