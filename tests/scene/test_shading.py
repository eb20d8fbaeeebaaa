"""Lamps, shadows, highlights and textures of scenes with a look."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.scenario.look import PATTERNS, Lamp, Look, Texture
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.surroundings import Fixture, Surroundings
from grasp_bench.scene.builder import compile_mjcf, compose
from grasp_bench.scene.rendering import Picture, raycast
from grasp_bench.scene.shading import Shader, drawer
from grasp_bench.scene.textures import amount

K = Intrinsics.from_fov(160, 120, np.radians(60))
ABOVE = CameraPose.look_at([0.5, 0, 0.6], [0.5, 0, 0], [1, 0, 0])
POST = Fixture(size=(0.03, 0.03, 0.2), position=(0.5, 0.0, 0.1), color=(0.5, 0.5, 0.5))
LEFT = Lamp(position=(0.5, 1.0, 1.0), strength=0.6)


def staged(look: Look, *fixtures: Fixture) -> tuple[Scenario, mujoco.MjModel, mujoco.MjData]:
    scenario = load_scenario("table4").model_copy(
        update={"look": look, "surroundings": Surroundings(fixtures=fixtures)}
    )
    model = compile_mjcf(compose(scenario, None, robot=None))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return scenario, model, data


def shot(look: Look, *fixtures: Fixture) -> Picture:
    scenario, model, data = staged(look, *fixtures)
    return Shader(scenario, model).picture(data, ABOVE.position, K.rays() @ ABOVE.rotation.T)


def test_a_look_changes_colours_and_nothing_else() -> None:
    _, model, data = staged(Look(lamps=(LEFT,)), POST)
    rays = K.rays() @ ABOVE.rotation.T
    plain, drawn = raycast(model, data, ABOVE.position, rays), shot(Look(lamps=(LEFT,)), POST)
    for name in ("depth", "geom"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(drawn, name))
    np.testing.assert_allclose(plain.cosine, drawn.cosine, atol=1e-6)
    assert (plain.rgb != drawn.rgb).any()
    assert drawer(load_scenario("table4")) is None


def test_a_post_throws_its_shadow_away_from_the_lamp_and_as_long_as_geometry_says() -> None:
    look = Look(lamps=(LEFT,), shadow_blur=0)
    light = shot(look, POST).rgb.mean(-1) / np.maximum(shot(look).rgb.mean(-1), 1)
    # Lamp at y = 1, z = 1; the post's top at y = 0, z = 0.2 falls on y = −0.25 (near edge −0.27 to −0.23).
    for y, dark in ((-0.1, True), (-0.2, True), (-0.30, False), (0.1, False)):
        column, row = K.project(ABOVE.to_camera([0.5, y, 0.0])).astype(int)
        assert (light[row, column] < 0.9) == dark, y


def test_light_falls_off_with_the_cosine_and_adds_up() -> None:
    table = load_scenario("table4").table.color
    flat = shot(Look(lamps=(Lamp(position=(0.5, 0, 1.0), strength=0.5),), ambient=0.25)).rgb[60, 80]
    expected = 255 * (np.array(table) ** 2.2 * 0.75) ** (1 / 2.2)
    np.testing.assert_allclose(flat, expected, atol=1.5)
    red = shot(Look(lamps=(Lamp(position=(0.5, 0, 1.0), strength=0.5, color=(1, 0, 0)),), ambient=0.25)).rgb
    np.testing.assert_allclose(
        red[60, 80, 1:], 255 * (np.array(table[1:]) ** 2.2 * 0.25) ** (1 / 2.2), atol=1.5
    )


def test_smooth_things_have_highlights_and_matt_ones_none() -> None:
    lamp = Lamp(position=(0.5, 0.0, 1.5), strength=0.3)

    def brightest(roughness: float) -> int:
        ball = Fixture(shape="ellipsoid", size=(0.1, 0.1, 0.1), position=(0.5, 0, 0.05), roughness=roughness)
        return int(shot(Look(lamps=(lamp,), highlights=1.0), ball).rgb[50:70, 70:90].max())

    assert brightest(0.2) > brightest(1.0) + 20


@pytest.mark.parametrize("pattern", PATTERNS)
def test_each_texture_varies_within_its_bounds_and_is_the_same_for_its_seed(pattern: str) -> None:
    points = np.random.default_rng(0).uniform(-0.2, 0.2, (4000, 3))
    first, again, other = (
        amount(Texture.model_validate({"pattern": pattern, "contrast": 0.6, "seed": seed}), points)
        for seed in (1, 1, 2)
    )
    assert (first == again).all()
    assert 0 <= first.min() <= first.max() <= np.float32(0.6)
    assert first.std() > 0.03
    assert pattern == "checks" or (first != other).any()


def test_textures_are_on_table_and_fixtures() -> None:
    checks = Texture(pattern="checks", color=(0, 0, 0), scale=0.02, contrast=1)
    assert shot(Look(table=checks)).rgb.std() > 5 * shot(Look()).rgb.std()
    box = Fixture(size=(0.2, 0.2, 0.1), position=(0.5, 0, 0.05), texture=checks)
    assert len(np.unique(shot(Look(), box).rgb[55:65, 75:85])) >= 2
