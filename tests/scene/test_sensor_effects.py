"""What depth and colour cameras do to whole pictures, each effect against what it must be."""

from __future__ import annotations

import numpy as np
import pytest

from grasp_bench.camera import Intrinsics
from grasp_bench.scenario.sensors import Sensor
from grasp_bench.scene import sensor_effects as effects
from grasp_bench.scene.rendering import Picture
from grasp_bench.scene.sensor import sense

SIZE = 120
K = Intrinsics(SIZE, SIZE, 200.0, 200.0, SIZE / 2, SIZE / 2)


def step(near: float = 0.5, far: float = 1.0) -> np.ndarray:
    """A plate at ``near`` over columns 50 to 69, before a wall at ``far``."""
    depth = np.full((SIZE, SIZE), far, np.float32)
    depth[:, 50:70] = near
    return depth


def picture(depth: np.ndarray, rgb: np.ndarray | None = None) -> Picture:
    shape = depth.shape
    colour = np.full((*shape, 3), 128, np.uint8) if rgb is None else rgb
    return Picture(colour, depth, np.ones(shape, np.float32), np.zeros(shape, np.int32))


def quiet(**terms: object) -> Sensor:
    return Sensor.model_validate({"preset": "ideal", **terms})


@pytest.mark.parametrize(("baseline", "columns"), [(0.075, range(35, 50)), (-0.075, range(70, 85))])
def test_a_projector_beside_the_camera_leaves_a_shadow_of_its_parallax(
    baseline: float, columns: range
) -> None:
    lost = effects.projector_shadow(step(), K.fx, baseline)
    # f·b·(1/near − 1/far) = 200 · 0.075 · (2 − 1) = 15 px, on the side away from the projector
    assert lost.any(0).tolist() == lost.all(0).tolist()
    assert set(np.flatnonzero(lost.all(0))) == set(columns)


def test_windows_lose_what_is_thin_and_keep_what_is_wide() -> None:
    depth = np.full((SIZE, SIZE), 1.0, np.float32)
    depth[:, 20:22], depth[:, 60:90] = 0.9, 0.8
    seen = effects.matched(depth, 2)
    assert (seen[:, 15:30] == 1.0).all()
    assert (seen[:, 64:86] == np.float32(0.8)).all()


def test_echoes_are_in_corners_and_not_on_plains() -> None:
    plain = np.full((SIZE, SIZE), 1.0, np.float32)
    assert not effects.echoes(plain, 0.1, 10).any()
    rows = np.arange(SIZE)[:, None]
    corner = np.where(rows < 60, 1.0, 1.0 - 0.004 * (rows - 60)).astype(np.float32).repeat(SIZE, 1)
    added = effects.echoes(corner, 0.2, 10)[:, 60]
    assert added[56:60].min() > 0.0005
    assert added[:20].max() < 1e-4
    assert effects.echoes(step(0.1, 2.0), 5.0, 10).max() == pytest.approx(0.03)


def test_textureless_tells_plain_from_patterned() -> None:
    rgb = np.full((SIZE, SIZE, 3), 100, np.uint8)
    rgb[:, 60:] += (40 * (np.indices((SIZE, 60)).sum(0) % 2))[..., None].astype(np.uint8)
    plain = effects.textureless(rgb)
    assert (plain[:, :50] == 1).all()
    assert (plain[:, 70:] == 0).all()


def test_holes_are_filled_between_what_is_around_them_and_nothing_else_changes() -> None:
    depth = np.tile(np.linspace(0.8, 1.2, SIZE, dtype=np.float32), (SIZE, 1))
    holed = depth.copy()
    holed[40:70, 50:80] = 0
    filled = effects.filled(holed)
    assert (filled[holed > 0] == holed[holed > 0]).all()
    assert np.abs(filled - depth)[40:70, 50:80].max() < 0.06
    assert effects.filled(np.zeros((8, 8), np.float32)).max() == 0


def test_exposure_brings_the_mean_to_its_target_and_keeps_white_from_burning_out() -> None:
    dark = np.full((SIZE, SIZE, 3), 50, np.uint8)
    assert effects.exposed(dark, 0.5) == pytest.approx(127.5 / 50)
    dark[:, ::2] = 0
    dark[:, : SIZE // 3] = 200
    assert effects.exposed(dark, 0.9) == pytest.approx(250 / 200)


def test_jpeg_of_low_quality_is_another_picture_of_the_same() -> None:
    rgb = np.zeros((SIZE, SIZE, 3), np.uint8)
    rgb[np.hypot(*(np.indices((SIZE, SIZE)) - 60)) < 40] = (200, 180, 90)
    low, high = (np.abs(effects.compressed(rgb, q).astype(int) - rgb).mean() for q in (20, 95))
    assert low > 2 * high > 0


@pytest.mark.parametrize(
    ("term", "changes"),
    [
        ({"projector_baseline": 0.075}, "depth"),
        ({"window_px": 2}, "depth"),
        ({"multipath": 0.2}, "depth"),
        ({"textureless_dropout": 0.5}, "depth"),
        ({"jpeg_quality": 20}, "rgb"),
        ({"rgb_blur_px": 2.0}, "rgb"),
        ({"auto_exposure": 0.8}, "rgb"),
    ],
)
def test_each_term_changes_its_picture_alone_and_always_alike(term: dict[str, object], changes: str) -> None:
    depth = step()
    depth[30:32] = 0.6
    rgb = np.full((SIZE, SIZE, 3), 90, np.uint8)
    rgb[:, 50:70] = 160
    plain, there, again = (
        sense(picture(depth, rgb), K, sensor, np.random.default_rng(3))
        for sensor in (quiet(), quiet(**term), quiet(**term))
    )
    for name in ("depth", "rgb"):
        assert (getattr(plain, name) != getattr(there, name)).any() == (name == changes)
        assert (getattr(there, name) == getattr(again, name)).all()


def test_a_filled_picture_has_no_holes() -> None:
    sensor = quiet(projector_baseline=0.075, speckle_dropout=0.2, filled=True)
    assert (sense(picture(step()), K, sensor, np.random.default_rng(0)).depth > 0).all()
