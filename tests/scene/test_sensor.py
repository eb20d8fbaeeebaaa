"""Each term of the depth camera's noise, alone, against the statistics it promises."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.scenario.sections import Sensor
from grasp_bench.scene.rendering import Picture, incidence_cosine
from grasp_bench.scene.sensor import sense

H, W = 240, 320
K = Intrinsics.from_fov(W, H, np.radians(60))
SILENT = {
    "axial_sigma": 0,
    "axial_sigma_per_metre": 0,
    "lateral_sigma_px": 0,
    "mixed_pixels": 0,
    "edge_dropout": 0,
    "grazing_dropout": 0,
    "speckle_dropout": 0,
    "rgb_sigma": 0,
}
GREY = np.full((H, W, 3), 128, np.uint8)


def perfect(depth: np.ndarray, rgb: np.ndarray = GREY, cosine: np.ndarray | None = None) -> Picture:
    """Picture of a depth image; seen face on unless ``cosine`` says otherwise."""
    depth = depth.astype(np.float32)
    face_on = np.where(depth > 0, 1, 0).astype(np.float32)
    geom = np.where(depth > 0, 0, -1).astype(np.int32)
    return Picture(rgb, depth, face_on if cosine is None else cosine, geom)


def seen(
    depth: np.ndarray, seed: int = 0, rgb: np.ndarray = GREY, cosine: np.ndarray | None = None, **terms: Any
) -> RgbdImage:
    """What a sensor with only these noise terms makes of a perfect image."""
    sensor = Sensor.model_validate(SILENT | terms)
    return sense(perfect(depth, rgb, cosine), K, sensor, np.random.default_rng(seed))


def wall(distance: float) -> np.ndarray:
    return np.full((H, W), distance, np.float32)


def step(near: float = 0.5, far: float = 0.6) -> np.ndarray:
    """A near half beside a far one; the step's two pixel columns are 159 and 160."""
    depth = wall(far)
    depth[:, :160] = near
    return depth


def plane(incidence_deg: float) -> np.ndarray:
    """Perfect depth of a plane half a metre away, met at this angle in the image's middle."""
    tilt = math.radians(incidence_deg)
    depth = 0.5 * math.cos(tilt) / (K.rays() @ [0, math.sin(tilt), math.cos(tilt)])
    return np.where(depth > 0, depth, 0).astype(np.float32)


def test_a_silent_sensor_delivers_the_perfect_image() -> None:
    image = seen(step())
    np.testing.assert_array_equal(image.depth, step())
    np.testing.assert_array_equal(image.rgb, GREY)


@pytest.mark.parametrize(("distance", "sigma"), [(0.3, 0.0005), (0.5, 0.0005), (1.0, 0.001), (2.0, 0.002)])
def test_axial_noise_grows_with_distance_beyond_its_onset(distance: float, sigma: float) -> None:
    depth = seen(wall(distance), axial_sigma=0.0005, axial_sigma_per_metre=0.001, axial_onset=0.5).depth
    assert depth.std() == pytest.approx(sigma, rel=0.02)
    assert depth.mean() == pytest.approx(distance, abs=4 * sigma / math.sqrt(H * W))


def test_lateral_jitter_moves_pixels_as_often_as_its_sigma_says() -> None:
    ramp = np.broadcast_to(0.5 + 1e-4 * np.arange(W), (H, W))
    moved = np.rint((seen(ramp, lateral_sigma_px=0.25, edge_step=1).depth - ramp) / 1e-4)[:, 2:-2]
    assert set(np.unique(moved)) <= {-1, 0, 1}
    # Half a pixel is two sigma: 2.3 % on either side.
    assert (moved == 1).mean() == pytest.approx(0.0228, abs=0.003)
    assert (moved == -1).mean() == pytest.approx(0.0228, abs=0.003)


def test_mixed_pixels_lie_between_the_surfaces_and_only_beside_a_step() -> None:
    depth = seen(step(), mixed_pixels=0.5).depth
    between = (depth > 0.501) & (depth < 0.599)
    assert not np.delete(between, [159, 160], axis=1).any()
    assert between[:, [159, 160]].mean() == pytest.approx(0.5 * 0.98, abs=0.08)
    assert depth[:, [159, 160]].min() >= np.float32(0.5)
    assert depth[:, [159, 160]].max() <= np.float32(0.6)
    assert depth[between].mean() == pytest.approx(0.55, abs=0.01)


def test_mixed_pixels_at_the_edge_of_nothing_stay_within_range() -> None:
    depth = step()
    depth[:, 160:] = 0
    measured = seen(depth, mixed_pixels=1.0).depth
    assert (measured[:, 161:] == 0).all()
    assert (measured[:, 159:161] > 0).all()
    assert measured.max() <= 2.5
    assert measured[:, 159].max() > 1.0  # some are drawn towards the far limit


def test_steps_below_the_threshold_are_no_edges() -> None:
    assert (seen(step(0.5, 0.509), edge_dropout=1.0).depth > 0).all()


@pytest.mark.parametrize("rate", [0.25, 0.8])
def test_dropout_at_steps_has_its_rate_and_place(rate: float) -> None:
    lost = seen(step(), edge_dropout=rate).depth == 0
    assert not np.delete(lost, [159, 160], axis=1).any()
    assert lost[:, [159, 160]].mean() == pytest.approx(rate, abs=0.07)


def test_incidence_is_measured_against_the_viewing_ray() -> None:
    cosine = incidence_cosine(plane(60), K)
    assert cosine[H // 2, W // 2] == pytest.approx(math.cos(math.radians(60)), abs=0.005)
    flat = incidence_cosine(wall(0.5), K)
    np.testing.assert_allclose(flat, 1 / np.linalg.norm(K.rays(), axis=-1), atol=1e-4)


def test_dropout_at_grazing_incidence_has_its_rate_and_angle() -> None:
    cosine = np.cos(np.radians(np.broadcast_to(np.linspace(60, 89, W), (H, W)))).astype(np.float32)
    steep = cosine < math.cos(math.radians(80.01))
    gentle = cosine > math.cos(math.radians(79.99))
    lost = seen(wall(0.5), cosine=cosine, grazing_dropout=0.5).depth == 0
    assert steep.sum() > 2000
    assert gentle.sum() > 2000
    assert lost[steep].mean() == pytest.approx(0.5, abs=0.03)
    assert not lost[gentle].any()


def test_speckle_dropout_has_its_rate_everywhere() -> None:
    lost = seen(wall(0.5), speckle_dropout=0.02).depth == 0
    assert lost.mean() == pytest.approx(0.02, abs=0.002)


@pytest.mark.parametrize(("distance", "measured"), [(0.24, False), (0.26, True), (2.49, True), (2.51, False)])
def test_nothing_is_measured_out_of_range(distance: float, measured: bool) -> None:
    assert (seen(wall(distance)).depth > 0).all() == measured
    assert (seen(wall(distance)).depth > 0).any() == measured


def test_colour_noise_has_its_sigma_and_stays_a_colour() -> None:
    noise = seen(wall(0.5), rgb_sigma=2.0).rgb.astype(float) - 128
    assert noise.std() == pytest.approx(2.0, rel=0.03)
    assert seen(wall(0.5), rgb=np.full_like(GREY, 255), rgb_sigma=9.0).rgb.min() > 180


def test_the_same_stream_gives_the_same_image_and_another_does_not() -> None:
    noisy = Sensor().model_dump()
    first, again, other = (seen(step(), seed, **noisy) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.depth, again.depth)
    np.testing.assert_array_equal(first.rgb, again.rgb)
    assert (first.depth != other.depth).mean() > 0.9


def test_what_is_drawn_does_not_depend_on_the_image() -> None:
    streams = [np.random.default_rng(5), np.random.default_rng(5)]
    for rng, depth in zip(streams, (step(), wall(0)), strict=True):
        sense(perfect(depth), K, Sensor(), rng)
    assert streams[0].random() == streams[1].random()


def test_pixels_without_a_surface_stay_invalid() -> None:
    assert not seen(wall(0), **Sensor().model_dump()).valid.any()
