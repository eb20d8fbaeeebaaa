"""Pictures of a tilted camera seen face on: the plane, the picture, and the way back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from grasp_bench.camera import CameraPose, RgbdImage
from grasp_bench.grasps import Grasp, angle_difference
from grasp_bench.predictors import level
from grasp_bench.predictors.controls import Centroid, foreground
from grasp_bench.predictors.level import dominant_plane, level_view
from grasp_bench.scenario.reading import load_scenario

CAMERA = load_scenario("tilted-camera").camera
K, TILTED = CAMERA.intrinsics, CAMERA.pose
STRAIGHT = load_scenario("table4").camera.pose
BOX = (np.array([0.44, -0.02, 0.0]), np.array([0.52, 0.04, 0.03]))


def look(pose: CameraPose, noise: float = 0.0, box: bool = True) -> RgbdImage:
    """Picture of a table, with a box on it; the box is red."""
    rays = K.rays() @ pose.rotation.T
    depth = np.where(rays[..., 2] < -0.05, -pose.position[2] / np.minimum(rays[..., 2], -0.05), 0)
    rgb = np.full((K.height, K.width, 3), 120, np.uint8)
    if box:
        with np.errstate(divide="ignore"):
            a, b = (BOX[0] - pose.position) / rays, (BOX[1] - pose.position) / rays
        near, far = np.minimum(a, b).max(-1), np.maximum(a, b).min(-1)
        hit = (near < far) & (near < depth)
        depth = np.where(hit, near, depth)
        rgb[hit] = (220, 30, 30)
    depth += noise * np.random.default_rng(0).standard_normal(depth.shape) * (depth > 0)
    return RgbdImage(rgb, np.where(depth < 3, depth, 0).astype(np.float32), K)


def test_the_plane_of_the_table_is_found_under_noise_and_things() -> None:
    for noise in (0.0, 0.002):
        plane = dominant_plane(look(TILTED, noise))
        assert plane is not None
        assert math.degrees(plane.tilt) == pytest.approx(30, abs=0.15)
        assert plane.distance == pytest.approx(TILTED.position[2], abs=5e-4)
        np.testing.assert_allclose(TILTED.rotation @ plane.normal, [0, 0, -1], atol=3e-3)


def test_nothing_seen_is_no_plane() -> None:
    shape = (K.height, K.width)
    image = RgbdImage(np.zeros((*shape, 3), np.uint8), np.zeros(shape, np.float32), K)
    assert dominant_plane(image) is None
    assert level_view(image) is None


def test_what_is_seen_face_on_is_left_alone() -> None:
    assert level_view(look(STRAIGHT, 0.001)) is None
    few = STRAIGHT.moved([0, 0, 0], [math.radians(4), 0, 0])
    assert level_view(look(few, 0.001)) is None


@pytest.mark.parametrize("degrees", [0, 1, 2, 3, 4.5, 4.9, 5.1, 6, 12])
def test_a_quick_look_decides_as_a_long_one(degrees: float, monkeypatch: pytest.MonkeyPatch) -> None:
    image = look(STRAIGHT.moved([0, 0, 0], [math.radians(degrees), 0, 0]), 0.002)
    quick = level_view(image)
    assert (quick is not None) == (degrees > 5)
    monkeypatch.setattr(level, "MOST", 1.0)
    long = level_view(image)
    if quick is not None and long is not None:
        np.testing.assert_array_equal(quick.homography, long.homography)
    else:
        assert quick is long


def test_a_face_on_table_takes_a_quick_look_only(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[int] = []

    def counted(image: RgbdImage, tries: int = level.TRIES) -> level.Plane | None:
        tried.append(tries)
        return dominant_plane(image, tries)

    monkeypatch.setattr(level, "dominant_plane", counted)
    assert level_view(look(STRAIGHT, 0.002)) is None
    assert tried == [level.FEW]
    assert level_view(look(TILTED, 0.002)) is not None
    assert tried == [level.FEW, level.FEW, level.TRIES]


def test_the_level_picture_has_the_table_at_one_depth_and_the_box_at_its_height() -> None:
    view = level_view(look(TILTED))
    assert view is not None
    depth = view.image.depth
    middle = depth[140:340, 220:420]
    table = np.median(middle)
    assert table == pytest.approx(TILTED.position[2], abs=1e-3)
    low, high = np.percentile(table - middle[middle > 0], [5, 99.5])
    assert low == pytest.approx(0, abs=1e-3)
    assert high == pytest.approx(0.03, abs=1e-3)
    # As many pixels a metre as before in the middle: the focal length over the depth.
    assert view.image.intrinsics.fx / table == pytest.approx(K.fx / 0.55, rel=2e-3)


def test_grasps_find_their_way_back_to_the_rays_they_were_on() -> None:
    view = level_view(look(TILTED))
    assert view is not None
    level = view.image.intrinsics
    for grasp in (Grasp(320, 240, 0.3, 60, 0.7), Grasp(250, 300, -1.2, 40)):
        moved = view.back(grasp)
        assert moved.quality == grasp.quality
        # Where the rays of centre and ends meet the plane 3 cm above the table, from either picture.
        plane = dominant_plane(look(TILTED))
        assert plane is not None
        turn = np.linalg.inv(view.image.intrinsics.matrix) @ view.homography @ K.matrix
        for a, b in ((np.array([grasp.x, grasp.y]), np.array([moved.x, moved.y])),):
            ray = turn.T @ level.deproject(a, np.ones(()))
            np.testing.assert_allclose(ray[:2] / ray[2], K.deproject(b, np.ones(()))[:2], atol=1e-9)
        first, second = (turn.T @ level.deproject(e, np.ones(())) for e in grasp.ends())
        pixels = K.project(np.stack([first, second]))
        direction = math.atan2(-(pixels[1] - pixels[0])[1], (pixels[1] - pixels[0])[0])
        assert angle_difference(direction, moved.angle) < 1e-9
        assert moved.width == pytest.approx(np.linalg.norm(pixels[1] - pixels[0]))


def test_a_heuristic_grasps_the_box_across_its_shorter_side_from_either_camera() -> None:
    for pose in (STRAIGHT, TILTED):
        image = look(pose, 0.0005)
        [grasp] = Centroid().predict(image)
        ray = pose.rotation @ K.deproject([grasp.x, grasp.y], np.ones(()))
        at = pose.position + ray * (0.03 - pose.position[2]) / ray[2]
        assert np.abs(at[:2] - [0.48, 0.01]).max() < 0.012  # the flank in view pulls the middle a little
        first, second = (pose.rotation @ K.deproject(e, np.ones(())) for e in grasp.ends())
        across = second / -second[2] - first / -first[2]
        assert abs(across[0]) < 0.25 * abs(across[1])


def test_without_it_a_tilted_table_is_no_foreground_and_background() -> None:
    mask, _ = foreground(look(TILTED, box=False))
    assert mask.mean() > 0.02  # half the table seems to stand out
    view = level_view(look(TILTED, box=False))
    assert view is not None
    assert foreground(view.image)[0].mean() < 0.001
