"""Projection, camera poses, and what an RGB-D image refuses to hold."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from grasp_bench.camera import CameraPose, Intrinsics, RgbdImage

K = Intrinsics(640, 480, 500.0, 510.0, 318.0, 243.0)
coordinate = st.floats(-2, 2)
point = st.tuples(coordinate, coordinate, coordinate)


@given(st.floats(0, 640), st.floats(0, 480), st.floats(0.1, 5))
def test_projecting_a_deprojected_pixel_gives_it_back(u: float, v: float, depth: float) -> None:
    there = K.deproject([u, v], depth)
    assert there[2] == depth
    np.testing.assert_allclose(K.project(there), [u, v], atol=1e-9)


@given(coordinate, coordinate, st.floats(0.1, 5))
def test_deprojecting_a_projected_point_gives_it_back(x: float, y: float, z: float) -> None:
    np.testing.assert_allclose(K.deproject(K.project([x, y, z]), z), [x, y, z], atol=1e-9)


def test_projection_agrees_with_the_matrix_k() -> None:
    image = K.matrix @ [0.3, -0.2, 1.5]
    np.testing.assert_allclose(K.project([0.3, -0.2, 1.5]), image[:2] / image[2])


def test_projection_takes_arrays_of_any_shape() -> None:
    points = np.random.default_rng(0).uniform(0.5, 1, (3, 4, 3))
    pixels = K.project(points)
    assert pixels.shape == (3, 4, 2)
    np.testing.assert_allclose(K.deproject(pixels, points[..., 2]), points)


def test_pixel_centres_lie_half_a_pixel_from_the_edge() -> None:
    rays = Intrinsics(4, 2, 1.0, 1.0, 0.0, 0.0).rays()
    assert rays.shape == (2, 4, 3)
    np.testing.assert_array_equal(rays[0, 0], [0.5, 0.5, 1])
    np.testing.assert_array_equal(rays[1, 3], [3.5, 1.5, 1])


def test_field_of_view_spans_the_image() -> None:
    k = Intrinsics.from_fov(640, 480, math.radians(90))
    assert k.fx == k.fy == pytest.approx(320)
    assert k.project([-1, 0, 1])[0] == pytest.approx(0)
    assert k.project([1, 0, 1])[0] == pytest.approx(640)
    assert k.vertical_fov == pytest.approx(2 * math.atan(0.75))


@given(point, point, point)
def test_look_at_makes_a_right_handed_frame_whose_z_meets_the_target(eye, target, up) -> None:
    view = np.subtract(target, eye)
    assume(np.linalg.norm(view) > 0.1 and np.linalg.norm(np.cross(view, up)) > 0.1)
    pose = CameraPose.look_at(eye, target, up)
    np.testing.assert_allclose(pose.rotation.T @ pose.rotation, np.eye(3), atol=1e-9)
    assert np.linalg.det(pose.rotation) == pytest.approx(1)
    np.testing.assert_allclose(pose.to_camera(target), [0, 0, float(np.linalg.norm(view))], atol=1e-9)
    assert pose.to_camera(np.add(target, up))[1] < 0  # y points down in the image


@given(point)
def test_world_and_camera_frames_are_inverse(p) -> None:
    pose = CameraPose.look_at([0.5, -0.4, 0.9], [0.4, 0.1, 0.0], [0, 0, 1])
    np.testing.assert_allclose(pose.to_world(pose.to_camera(p)), p, atol=1e-12)


def test_look_at_refuses_a_target_at_the_camera() -> None:
    with pytest.raises(ValueError, match="coincide"):
        CameraPose.look_at([1, 1, 1], [1, 1, 1], [0, 0, 1])


def test_look_at_refuses_an_up_along_the_view() -> None:
    with pytest.raises(ValueError, match="parallel"):
        CameraPose.look_at([0, 0, 1], [0, 0, 0], [0, 0, 1])


@pytest.mark.parametrize("size", [(0, 480), (640, 0), (-1, 2)])
def test_intrinsics_refuse_an_empty_image(size: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="image size"):
        Intrinsics(*size, 1.0, 1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "values", [(0.0, 1.0, 0.0), (1.0, -1.0, 0.0), (math.nan, 1.0, 0.0), (1.0, 1.0, math.inf)]
)
def test_intrinsics_refuse_impossible_focal_lengths(values: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="focal lengths"):
        Intrinsics(640, 480, *values, 0.0)


SMALL = Intrinsics(4, 3, 1.0, 1.0, 2.0, 1.5)


def picture(**changed: np.ndarray) -> RgbdImage:
    sound = {"rgb": np.zeros((3, 4, 3), np.uint8), "depth": np.ones((3, 4), np.float32)}
    return RgbdImage(**(sound | changed), intrinsics=SMALL)


def test_depth_zero_marks_invalid_pixels() -> None:
    depth = np.ones((3, 4), np.float32)
    depth[1, 2] = 0
    valid = picture(depth=depth).valid
    assert valid.sum() == 11
    assert not valid[1, 2]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"rgb": np.zeros((3, 4), np.uint8)}, "rgb must be"),
        ({"rgb": np.zeros((3, 4, 3), np.float32)}, "rgb must be"),
        ({"depth": np.ones((4, 3), np.float32)}, "depth must be"),
        ({"depth": np.ones((3, 4), np.float64)}, "depth must be"),
        ({"depth": np.full((3, 4), np.nan, np.float32)}, "replace NaN by 0"),
        ({"depth": np.full((3, 4), -0.1, np.float32)}, "not negative"),
    ],
)
def test_an_image_refuses_wrong_shapes_types_and_values(changed, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        picture(**changed)


# ---------------------------------------------------------------- any camera, not one

cameras = st.builds(
    lambda width, height, f, squeeze, cx, cy: Intrinsics(
        width, height, f, f * squeeze, cx * width, cy * height
    ),
    st.integers(1, 4096),
    st.integers(1, 4096),
    st.floats(20, 5000),
    st.floats(0.5, 2),
    st.floats(0, 1),
    st.floats(0, 1),
)


@given(cameras, st.floats(0, 1), st.floats(0, 1), st.floats(0.1, 5), point, point, point)
def test_a_pixel_comes_back_from_the_world_through_any_camera(k, u, v, depth, eye, target, up) -> None:
    view = np.subtract(target, eye)
    assume(np.linalg.norm(view) > 0.1 and np.linalg.norm(np.cross(view, up)) > 0.1)
    pose = CameraPose.look_at(eye, target, up)
    pixel = [u * k.width, v * k.height]
    there = pose.to_world(k.deproject(pixel, depth))
    seen = pose.to_camera(there)
    np.testing.assert_allclose(k.project(seen), pixel, atol=1e-5)
    assert seen[2] == pytest.approx(depth, abs=1e-9)
    assert np.linalg.norm(there - pose.position) >= depth - 1e-9  # z-depth is never longer than the range


@given(cameras)
def test_intrinsics_come_back_from_their_matrix(k) -> None:
    m = k.matrix
    assert Intrinsics(k.width, k.height, m[0, 0], m[1, 1], m[0, 2], m[1, 2]) == k


@given(st.integers(1, 4096), st.integers(1, 4096), st.floats(math.radians(6), math.radians(169)))
def test_the_image_spans_its_field_of_view(width: int, height: int, fov: float) -> None:
    k = Intrinsics.from_fov(width, height, fov)
    left, right = k.deproject([[0, 0], [width, 0]], [1, 1])
    assert math.atan(right[0]) - math.atan(left[0]) == pytest.approx(fov)


@pytest.mark.parametrize("far", [550.0, 21.0])
def test_depth_in_millimetres_is_refused_in_one_line(far: float) -> None:
    rgb, depth = np.zeros((480, 640, 3), np.uint8), np.full((480, 640), far, np.float32)
    depth[:240] = 0  # not measured
    with pytest.raises(ValueError, match=r"must be in metres, .*millimetres; divide it by 1000$") as raised:
        RgbdImage(rgb, depth, K)
    assert "\n" not in str(raised.value)
    RgbdImage(rgb, depth / np.float32(1000), K)


def test_a_few_far_pixels_are_no_millimetres() -> None:
    rgb, depth = np.zeros((480, 640, 3), np.uint8), np.full((480, 640), 0.6, np.float32)
    depth[0, :40] = 65.535
    assert RgbdImage(rgb, depth, K).valid.all()
    assert not RgbdImage(rgb, np.zeros((480, 640), np.float32), K).valid.any()
