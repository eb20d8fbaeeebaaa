"""The convex pieces of shipped objects keep open what is open: cups, handles, loops."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from grasp_bench.objects.catalog import Catalog, ObjectModel
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import compile_mjcf, new_world

VISUAL = np.array([0, 0, 1, 0, 0, 0], np.uint8)
HULLS = np.array([0, 0, 0, 1, 0, 0], np.uint8)
FAR = 1000.0

HOLLOW = (
    "coffee_mug",
    "latte_mug",
    "enamel_camping_mug",
    "faceted_tumbler",
    "wine_glass",
    "beer_mug",
    "cereal_bowl",
    "mixing_bowl",
    "saucepan",
)
LOOPED = (
    "coffee_mug",
    "beer_mug",
    "padlock",
    "carabiner",
    "office_scissors",
    "blunt_kids_scissors",
    "star_cookie_cutter",
    "heart_cookie_cutter",
    "hand_saw",
    "c_clamp",
    "iced_donut",
    "toilet_roll",
)


@pytest.fixture(scope="module")
def catalog() -> Catalog:
    return Catalog()


def still_life(model: ObjectModel) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The object alone, as modelled, at the origin."""
    from grasp_bench.scene.builder import add_object

    scenario = Scenario(name="test")
    root = new_world(scenario)
    add_object(root, model, scenario)
    compiled = compile_mjcf(root)
    data = mujoco.MjData(compiled)
    data.qpos[:7] = [0, 0, 0, 1, 0, 0, 0]
    mujoco.mj_forward(compiled, data)
    return compiled, data


def depths(
    scene: tuple[mujoco.MjModel, mujoco.MjData],
    axis: int,
    group: np.ndarray,
    half: float,
    step: float = 0.002,
) -> np.ndarray:
    """Distances along ``axis`` from a far plane, on a grid of parallel rays; inf where nothing is hit."""
    ticks = np.arange(-half, half, step)
    grid = np.zeros((len(ticks) ** 2, 3))
    others = [a for a in range(3) if a != axis]
    grid[:, others[0]], grid[:, others[1]] = (g.ravel() for g in np.meshgrid(ticks, ticks))
    start = np.zeros(3)
    start[axis] = FAR
    rays = grid - start
    distance, geom = np.zeros(len(rays)), np.zeros(len(rays), np.int32)
    mujoco.mj_multiRay(*scene, start, rays.ravel(), group, True, -1, geom, distance, None, len(rays), 2 * FAR)
    return np.where(geom >= 0, FAR * distance, np.inf)


@pytest.mark.parametrize("name", HOLLOW)
def test_a_finger_fits_inside(catalog: Catalog, name: str) -> None:
    model = catalog.load(name)
    scene = still_life(model)
    rim = max(h[:, 2].max() for h in model.hulls)
    ticks = np.arange(-0.12, 0.12, 0.002)
    heights = (FAR - depths(scene, 2, HULLS, 0.12)).reshape(len(ticks), len(ticks))
    # A finger is 8 × 20 mm; somewhere that much must be free 25 mm below the rim, walls all round.
    deep = (heights < rim - 0.025) & np.isfinite(heights)
    window = np.lib.stride_tricks.sliding_window_view(deep, (10, 4)).all(axis=(2, 3))
    assert window.any(), f"no finger fits into {name}"


@pytest.mark.parametrize("name", LOOPED)
def test_what_light_passes_through_stays_open(catalog: Catalog, name: str) -> None:
    scene = still_life(catalog.load(name))
    half = float(np.abs(np.vstack(catalog.load(name).hulls)).max()) + 0.004
    worst = 0.0
    for axis in range(3):
        visual, hulls = (np.isfinite(depths(scene, axis, group, half)) for group in (VISUAL, HULLS))
        blocked = hulls & ~visual
        worst = max(worst, blocked.sum() / visual.sum())
    assert worst < 0.12, f"{name}: pieces cover {worst:.0%} more than the true outline"
