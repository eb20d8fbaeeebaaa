"""Image-plane grasps, the rectangle metric, dense maps, and grasps in the world."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from grasp_bench.grasps import (
    Grasp,
    GraspMaps,
    GraspPose,
    angle_difference,
    is_correct,
    rectangle_iou,
    wrap_angle,
)

angles = st.floats(-20, 20)
grasps = st.builds(Grasp, st.floats(0, 640), st.floats(0, 480), st.floats(-1.55, 1.57), st.floats(2, 200))


# ---------------------------------------------------------------- angles


@given(angles)
def test_wrapped_angles_lie_in_the_half_open_range(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi / 2 < wrapped <= math.pi / 2
    turns = (angle - wrapped) / math.pi
    assert turns == pytest.approx(round(turns), abs=1e-9)


def test_a_quarter_turn_either_way_is_plus_a_quarter() -> None:
    assert wrap_angle(math.pi / 2) == math.pi / 2
    assert wrap_angle(-math.pi / 2) == math.pi / 2


@given(angles, angles)
def test_angle_difference_is_symmetric_and_blind_to_half_turns(a: float, b: float) -> None:
    difference = angle_difference(a, b)
    assert 0 <= difference <= math.pi / 2
    assert difference == pytest.approx(angle_difference(b, a), abs=1e-9)
    assert difference == pytest.approx(angle_difference(a + math.pi, b), abs=1e-9)


def test_angle_difference_crosses_the_seam() -> None:
    assert angle_difference(math.radians(89), math.radians(-89)) == pytest.approx(math.radians(2))


# ---------------------------------------------------------------- rectangles


@given(grasps)
def test_a_grasp_survives_its_rectangle(grasp: Grasp) -> None:
    back = Grasp.from_rectangle(grasp.rectangle())
    assert (back.x, back.y, back.width) == pytest.approx((grasp.x, grasp.y, grasp.width), abs=1e-6)
    assert angle_difference(back.angle, grasp.angle) < 1e-6


@given(grasps)
def test_a_rectangle_is_as_long_as_wide_and_half_as_high(grasp: Grasp) -> None:
    corners = grasp.rectangle()
    assert np.linalg.norm(corners[1] - corners[0]) == pytest.approx(grasp.width)
    assert np.linalg.norm(corners[2] - corners[1]) == pytest.approx(grasp.width / 2)


def test_angles_run_counter_clockwise_as_seen_in_the_image() -> None:
    first, second = Grasp(100, 100, math.radians(30), 20).ends()
    np.testing.assert_allclose(second - first, [20 * math.cos(math.radians(30)), -10])  # up and to the right


def test_iou_of_shifted_rectangles_agrees_with_hand_values() -> None:
    square = [(0, 0), (4, 0), (4, 4), (0, 4)]
    assert rectangle_iou(square, square) == pytest.approx(1)
    assert rectangle_iou(square, [(2, 0), (6, 0), (6, 4), (2, 4)]) == pytest.approx(8 / 24)
    assert rectangle_iou(square, [(2, 2), (6, 2), (6, 6), (2, 6)]) == pytest.approx(4 / 28)
    assert rectangle_iou(square, [(4, 0), (8, 0), (8, 4), (4, 4)]) == 0
    assert rectangle_iou(square, [(1, 1), (3, 1), (3, 3), (1, 3)]) == pytest.approx(4 / 16)


def test_iou_of_a_square_and_its_eighth_turn_agrees_with_the_octagon() -> None:
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    c = math.sqrt(0.5)
    octagon = 8 * (math.sqrt(2) - 1)
    assert rectangle_iou(square, square @ [[c, c], [-c, c]]) == pytest.approx(octagon / (8 - octagon))


def test_iou_of_a_bow_tie_is_zero() -> None:
    assert rectangle_iou([(0, 0), (4, 4), (4, 0), (0, 4)], [(0, 0), (4, 0), (4, 4), (0, 4)]) == 0


@given(grasps, grasps)
def test_iou_is_symmetric_and_between_nought_and_one(a: Grasp, b: Grasp) -> None:
    iou = rectangle_iou(a.rectangle(), b.rectangle())
    assert 0 <= iou <= 1 + 1e-9
    assert iou == pytest.approx(rectangle_iou(b.rectangle(), a.rectangle()), abs=1e-9)


# ---------------------------------------------------------------- the metric

TRUTH = Grasp(100, 100, 0.0, 40)


@pytest.mark.parametrize(
    ("degrees", "correct"), [(0, True), (29.9, True), (30.1, False), (-29.9, True), (90, False)]
)
def test_a_grasp_is_correct_within_thirty_degrees(degrees: float, correct: bool) -> None:
    turned = Grasp(100, 100, math.radians(degrees), 40)
    assert is_correct(turned, [TRUTH]) is correct


@pytest.mark.parametrize(("shift", "correct"), [(0, True), (23.9, True), (24.1, False), (41, False)])
def test_a_grasp_is_correct_above_a_quarter_of_iou(shift: float, correct: bool) -> None:
    # Shifted along the jaws by s, rectangles of width 40 have an IoU of (40 − s)/(40 + s): 1/4 at 24.
    assert is_correct(Grasp(100 + shift, 100, 0.0, 40), [TRUTH]) is correct


def test_one_of_several_truths_is_enough_and_none_never_is() -> None:
    assert is_correct(TRUTH, [Grasp(300, 300, 0.0, 40), TRUTH])
    assert not is_correct(TRUTH, [])


def test_angle_and_overlap_must_hold_for_the_same_truth() -> None:
    near_but_turned = Grasp(100, 100, math.radians(60), 40)
    aligned_but_far = Grasp(200, 100, 0.0, 40)
    assert not is_correct(TRUTH, [near_but_turned, aligned_but_far])


# ---------------------------------------------------------------- maps


@given(st.floats(60, 140), st.floats(60, 140), angles, st.floats(20, 80))
def test_maps_of_a_grasp_lead_back_to_it(x: float, y: float, angle: float, width: float) -> None:
    maps = GraspMaps.from_grasps([Grasp(x, y, wrap_angle(angle), width, 0.8)], (200, 200))
    rows, columns = np.nonzero(maps.quality)
    assert abs(columns.mean() + 0.5 - x) < 1.5
    assert abs(rows.mean() + 0.5 - y) < 1.5
    assert angle_difference(float(maps.angle[rows[0], columns[0]]), angle) < 1e-5
    assert maps.width[rows[0], columns[0]] == pytest.approx(width)
    assert maps.quality.max() == pytest.approx(0.8)


def test_maps_fill_the_middle_third_of_a_rectangle() -> None:
    maps = GraspMaps.from_grasps([Grasp(100, 100, 0.0, 60)], (200, 200))
    rows, columns = np.nonzero(maps.quality)
    assert np.ptp(columns) + 1 == pytest.approx(20, abs=1)
    assert np.ptp(rows) + 1 == pytest.approx(30, abs=1)


def test_later_grasps_overwrite_earlier_ones() -> None:
    maps = GraspMaps.from_grasps([Grasp(50, 50, 0.0, 30), Grasp(50, 50, 1.0, 36)], (100, 100))
    assert maps.width[50, 50] == 36
    assert maps.angle[50, 50] == pytest.approx(1.0, abs=1e-6)


def flat_maps(quality: np.ndarray, angle: float = 0.3) -> GraspMaps:
    q = quality.astype(np.float32)
    one = np.ones_like(q)
    return GraspMaps(q, math.sin(2 * angle) * one, math.cos(2 * angle) * one, 25 * one)


def test_peaks_come_best_first_with_angle_width_and_pixel_centre() -> None:
    q = np.zeros((80, 90))
    q[20, 30], q[60, 70] = 0.6, 0.9
    first, second = flat_maps(q).peaks()
    assert (first.x, first.y) == (70.5, 60.5)
    assert (second.x, second.y) == (30.5, 20.5)
    assert (first.quality, second.quality) == pytest.approx((0.9, 0.6))
    assert (first.angle, first.width) == pytest.approx((0.3, 25), abs=1e-6)


def test_peaks_keep_apart_even_on_a_plateau() -> None:
    found = flat_maps(np.full((40, 40), 0.5)).peaks(count=50, min_distance=8)
    assert len(found) > 4
    for i, a in enumerate(found):
        for b in found[:i]:
            assert max(abs(a.x - b.x), abs(a.y - b.y)) > 8


def test_a_lower_peak_near_a_higher_one_is_left_out() -> None:
    q = np.zeros((60, 60))
    q[30, 30], q[30, 36], q[30, 45] = 0.9, 0.8, 0.7
    assert [g.x for g in flat_maps(q).peaks(min_distance=8)] == [30.5, 45.5]


def test_peaks_obey_threshold_and_count() -> None:
    q = np.zeros((100, 100))
    q[10, 10], q[40, 40], q[80, 80] = 0.04, 0.5, 0.6
    assert len(flat_maps(q).peaks(threshold=0.05)) == 2
    assert len(flat_maps(q).peaks(count=1)) == 1
    assert flat_maps(np.zeros((10, 10))).peaks() == []


def test_smoothing_does_not_smear_angles_across_the_seam() -> None:
    # Neighbours at +89° and −89° are 2° apart; their mean is 90°, not 0°.
    angle = np.radians(np.where(np.arange(40) % 2, 89.0, -89.0))[None].repeat(40, 0)
    one = np.ones((40, 40), np.float32)
    maps = GraspMaps(one, np.sin(2 * angle).astype(np.float32), np.cos(2 * angle).astype(np.float32), one)
    smooth = maps.smoothed().angle[10:30, 10:30]
    assert all(angle_difference(float(a), math.pi / 2) < math.radians(2) for a in smooth.ravel())


# ---------------------------------------------------------------- in the world


@given(st.floats(-math.pi, math.pi))
def test_top_down_poses_approach_straight_down_with_jaws_at_the_yaw(yaw: float) -> None:
    pose = GraspPose.top_down([0.4, 0.1, 0.02], yaw, 0.05)
    np.testing.assert_allclose(pose.rotation[:, 2], [0, 0, -1])
    np.testing.assert_allclose(pose.rotation[:, 0], [math.cos(yaw), math.sin(yaw), 0])
    np.testing.assert_allclose(pose.rotation.T @ pose.rotation, np.eye(3), atol=1e-12)
    assert np.linalg.det(pose.rotation) == pytest.approx(1)
    assert pose.opening == 0.05


@given(st.floats(-math.pi, math.pi))
def test_flipping_exchanges_the_fingers_and_nothing_else(yaw: float) -> None:
    pose = GraspPose.top_down([0.4, 0.1, 0.02], yaw, 0.05)
    flipped = pose.flipped()
    np.testing.assert_allclose(flipped.rotation[:, 0], -pose.rotation[:, 0])
    np.testing.assert_array_equal(flipped.rotation[:, 2], pose.rotation[:, 2])
    assert np.linalg.det(flipped.rotation) == pytest.approx(1)
    np.testing.assert_array_equal(flipped.position, pose.position)
    np.testing.assert_allclose(flipped.flipped().rotation, pose.rotation)


@given(grasps, st.floats(-3, 3))
def test_iou_does_not_change_when_both_rectangles_turn(grasp: Grasp, turn: float) -> None:
    other = Grasp(grasp.x + grasp.width / 5, grasp.y, grasp.angle, grasp.width)
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.array([[c, s], [-s, c]])
    before = rectangle_iou(grasp.rectangle(), other.rectangle())
    assume(before > 0.01)
    after = rectangle_iou(grasp.rectangle() @ rotation, other.rectangle() @ rotation)
    assert after == pytest.approx(before, abs=1e-6)


# ---------------------------------------------------------------- maps and peaks of any kind


@given(st.integers(0, 2**32), st.integers(1, 60), st.integers(1, 60), st.integers(1, 12), st.integers(1, 15))
def test_peaks_of_any_maps_are_sound_grasps_apart_and_in_order(
    seed: int, height: int, width: int, count: int, apart: int
) -> None:
    rng = np.random.default_rng(seed)
    quality = rng.uniform(-0.5, 1.5, (height, width)).astype(np.float32).round(1)  # with plateaus
    maps = GraspMaps(quality, *rng.normal(0, 5, (3, height, width)).astype(np.float32))
    found = maps.peaks(count=count, min_distance=apart, threshold=0.3)
    assert len(found) <= count
    assert bool(found) == bool((quality > 0.3).any())
    for g in found:
        assert 0 < g.x < width
        assert 0 < g.y < height
        assert -math.pi / 2 < g.angle <= math.pi / 2
        assert g.width >= 1
        assert 0 <= g.quality <= 1
    raw = [quality[int(g.y), int(g.x)] for g in found]
    assert raw == sorted(raw, reverse=True)
    assert not found or raw[0] == quality.max()
    for i, a in enumerate(found):
        assert all(max(abs(a.x - b.x), abs(a.y - b.y)) > apart for b in found[:i])


@settings(max_examples=15)
@given(st.floats(50, 80), st.floats(50, 80), angles, st.floats(25, 80))
def test_the_best_peak_of_a_grasps_maps_is_that_grasp(x: float, y: float, angle: float, width: float) -> None:
    grasp = Grasp(x, y, wrap_angle(angle), width)
    best = GraspMaps.from_grasps([grasp], (130, 130)).smoothed().peaks()[0]
    assert math.hypot(best.x - x, best.y - y) < width / 4 + 1.5  # the filled third is a plateau
    assert angle_difference(best.angle, angle) < 0.02
    assert best.width == pytest.approx(width, rel=0.1)


@given(grasps)
def test_turning_a_grasp_by_half_a_turn_changes_nothing(grasp: Grasp) -> None:
    turned = Grasp(grasp.x, grasp.y, grasp.angle + math.pi, grasp.width)
    assert rectangle_iou(grasp.rectangle(), turned.rectangle()) == pytest.approx(1)
    assert is_correct(turned, [grasp])
    np.testing.assert_allclose(np.sort(turned.ends(), 0), np.sort(grasp.ends(), 0), atol=1e-9)
