"""Terms of the sensor that depend on what is seen, on several pictures, or on the light; and its presets."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from test_sensor import GREY, SILENT, H, K, W, perfect, seen, wall

from grasp_bench.camera import RgbdImage
from grasp_bench.scenario.sections import Sensor
from grasp_bench.scenario.sensors import PRESET_NAMES, PRESETS
from grasp_bench.scene.sensor import sense
from grasp_bench.scene.surfaces import Surfaces, surfaces


def lit(level: float = 1.0, rgb: np.ndarray = GREY, seed: int = 0, **terms: Any) -> RgbdImage:
    """A wall half a metre away in some light."""
    sensor = Sensor.model_validate(SILENT | terms)
    return sense(perfect(wall(0.5), rgb), K, sensor, np.random.default_rng(seed), None, level)


def covered(albedo: float = 1.0, roughness: float = 1.0, seed: int = 0, **terms: Any) -> np.ndarray:
    """Which pixels are lost of a wall that reflects so."""
    made_of = Surfaces(np.array([albedo]), np.array([roughness]))
    sensor = Sensor.model_validate(SILENT | terms)
    return sense(perfect(wall(0.5)), K, sensor, np.random.default_rng(seed), made_of).depth == 0


# ---------------------------------------------------------------- depth


def test_bias_is_added_to_every_reading() -> None:
    depth = seen(wall(0.8), bias=0.003, bias_per_metre=0.001).depth
    np.testing.assert_allclose(depth, 0.8 + 0.003 + 0.0008, atol=1e-6)


def test_quadratic_axial_noise_has_its_sigma() -> None:
    depth = seen(wall(1.2), axial_sigma=0.0012, axial_sigma_per_metre2=0.0019, axial_onset=0.4).depth
    assert depth.std() == pytest.approx(0.0012 + 0.0019 * 0.8**2, rel=0.02)


def test_depth_comes_in_steps_that_grow_with_its_square() -> None:
    ramp = np.broadcast_to(np.linspace(0.5, 2.0, W), (H, W))
    depth = seen(ramp, depth_step_per_metre2=0.00285, edge_step=1).depth[0]
    levels = np.unique(depth)
    steps, at = np.diff(levels), (levels[1:] + levels[:-1]) / 2
    np.testing.assert_allclose(steps[at > 1.4], 0.00285 * at[at > 1.4] ** 2, rtol=0.02)
    assert (np.abs(depth - ramp[0]) <= 0.00285 * ramp[0] ** 2 / 2 * 1.01).all()


@pytest.mark.parametrize(("albedo", "share"), [(0.0, 0.6), (0.05, 0.4), (0.15, 0.0), (0.8, 0.0)])
def test_dark_surfaces_lose_their_share(albedo: float, share: float) -> None:
    lost = covered(albedo=albedo, dark_albedo=0.15, dark_dropout=0.6, patch_px=1)
    assert lost.mean() == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize(("roughness", "share"), [(0.1, 0.375), (0.2, 0.25), (0.4, 0.0), (1.0, 0.0)])
def test_shiny_surfaces_lose_their_share(roughness: float, share: float) -> None:
    lost = covered(roughness=roughness, shiny_roughness=0.4, shiny_dropout=0.5, patch_px=1)
    assert lost.mean() == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize(("distance", "share"), [(1.0, 0.0), (1.5, 0.25), (2.0, 0.5)])
def test_distant_surfaces_lose_a_share_that_grows_to_the_maximum_range(distance: float, share: float) -> None:
    depth = seen(wall(distance), distant_onset=1.0, distant_dropout=0.5, maximum_range=2.0, patch_px=1).depth
    assert (depth == 0).mean() == pytest.approx(share, abs=0.01)


def test_unreflected_readings_are_lost_in_patches_of_the_stated_size() -> None:
    lost = covered(albedo=0, dark_dropout=0.5, patch_px=8)
    blocks = lost[: H // 8 * 8, : W // 8 * 8].reshape(H // 8, 8, W // 8, 8).mean((1, 3))
    assert set(np.unique(blocks)) == {0.0, 1.0}
    assert blocks.mean() == pytest.approx(0.5, abs=0.05)


def test_what_nothing_was_hit_by_is_neither_dark_nor_shiny() -> None:
    made_of = Surfaces(np.zeros(1), np.zeros(1))
    sensor = Sensor.model_validate(SILENT | {"dark_dropout": 1.0, "shiny_dropout": 1.0})
    assert not sense(perfect(wall(0)), K, sensor, np.random.default_rng(0), made_of).valid.any()


def test_an_average_of_frames_has_its_noise_divided_by_their_root() -> None:
    depth = seen(wall(0.5), axial_sigma=0.004, frames=16).depth
    assert depth.std() == pytest.approx(0.001, rel=0.03)
    assert depth.mean() == pytest.approx(0.5, abs=2e-5)


def test_an_average_needs_half_of_its_frames_and_bias_stays() -> None:
    lost = seen(wall(0.5), speckle_dropout=0.4, frames=16).depth == 0
    assert lost.mean() == pytest.approx(0.142, abs=0.01)  # binomial: more than 8 of 16 at 0.4
    np.testing.assert_allclose(seen(wall(0.5), bias=0.002, frames=4).depth, 0.502, atol=1e-6)


def test_frames_do_not_average_what_a_surface_swallows() -> None:
    once = covered(albedo=0, dark_dropout=0.5)
    np.testing.assert_array_equal(covered(albedo=0, dark_dropout=0.5, frames=8), once)


def test_new_terms_leave_the_numbers_of_the_others_alone() -> None:
    plain = seen(wall(0.5), axial_sigma=0.001, rgb_sigma=2.0)
    more = seen(wall(0.5), axial_sigma=0.001, rgb_sigma=2.0, distant_onset=0.1, distant_dropout=0.5)
    kept = more.depth > 0
    assert 0.05 < kept.mean() < 0.95
    np.testing.assert_array_equal(more.depth[kept], plain.depth[kept])
    np.testing.assert_array_equal(more.rgb, plain.rgb)


# ---------------------------------------------------------------- colour


def test_a_dim_scene_is_darker_and_exposure_makes_up_for_it() -> None:
    assert (lit(0.25).rgb == 32).all()
    assert (lit(0.25, exposure=4.0).rgb == 128).all()
    assert (lit(0.25, exposure=40.0).rgb == 255).all()


def test_shot_noise_has_a_variance_that_grows_with_the_signal_and_is_amplified() -> None:
    for level, exposure in ((1.0, 1.0), (0.25, 1.0), (0.25, 4.0)):
        noise = lit(level, rgb_sigma=2.0, rgb_shot_noise=0.2, exposure=exposure).rgb.astype(float)
        expected = exposure * np.sqrt(2.0**2 + 0.2 * 128 * level)
        assert noise.std() == pytest.approx(np.hypot(expected, 1 / np.sqrt(12)), rel=0.03)


def test_white_balance_scales_channels() -> None:
    assert lit(white_balance=(1.5, 1.0, 0.5)).rgb[0, 0].tolist() == [192, 128, 64]


def test_exposure_and_balance_vary_from_picture_to_picture_by_their_sigmas() -> None:
    made = np.log(
        [lit(seed=i, exposure_sigma=0.1, white_balance_sigma=0.05).rgb.mean((0, 1)) / 128 for i in range(150)]
    )
    assert made.mean() == pytest.approx(0, abs=0.02)
    assert (made - made.mean(1, keepdims=True)).std() == pytest.approx(0.05 * np.sqrt(2 / 3), rel=0.2)
    assert made.mean(1).std() == pytest.approx(np.sqrt(0.1**2 + 0.05**2 / 3), rel=0.2)


# ---------------------------------------------------------------- surfaces and presets


def test_surfaces_tell_black_from_white_and_polished_from_matt() -> None:
    model = mujoco.MjModel.from_xml_string("""<mujoco><size nuser_geom="1"/><worldbody>
      <geom type="sphere" size="1" rgba="0 0 0 1" user="0.3"/><geom type="sphere" size="1" rgba="1 1 1 1"/>
      <geom type="sphere" size="1" rgba="0.5 0.5 0.5 1" user="1"/></worldbody></mujoco>""")
    made = surfaces(model)
    np.testing.assert_allclose(made.albedo, [0, 1, 0.2140], atol=1e-3)  # IEC 61966-2-1 of a middle grey
    np.testing.assert_allclose(made.roughness, [0.3, 1, 1])


@pytest.mark.parametrize("name", PRESET_NAMES)
def test_presets_hold_their_values_and_take_changes(name: str) -> None:
    made = Sensor.model_validate({"preset": name, "axial_sigma": 0.0042})
    assert made.axial_sigma == 0.0042
    for key, value in PRESETS[name].items():
        assert key == "axial_sigma" or getattr(made, key) == value
    assert Sensor.model_validate(made.model_dump(mode="json")) == made


def test_the_reference_sensor_is_the_femto_w_preset() -> None:
    assert Sensor() == Sensor.model_validate({"preset": "femto-w"})


def test_the_ideal_preset_delivers_the_perfect_picture() -> None:
    picture = perfect(np.broadcast_to(np.linspace(0.05, 5, W), (H, W)))
    image = sense(picture, K, Sensor.model_validate({"preset": "ideal"}), np.random.default_rng(0))
    np.testing.assert_array_equal(image.depth, picture.depth)
    np.testing.assert_array_equal(image.rgb, picture.rgb)


@pytest.mark.parametrize(("preset", "sigma"), [("azure-kinect", 0.001), ("structured-light", 0.0019)])
def test_presets_have_the_noise_of_their_sources_at_one_metre(preset: str, sigma: float) -> None:
    sensor = Sensor.model_validate({"preset": preset})
    depth = sense(perfect(wall(1.0)), K, sensor, np.random.default_rng(0)).depth
    expected = np.hypot(sigma, 0.00285 / np.sqrt(12)) if preset == "structured-light" else sigma
    assert depth[depth > 0].std() == pytest.approx(expected, rel=0.05)
