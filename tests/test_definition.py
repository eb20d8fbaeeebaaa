"""docs/definition.md, written anew from its text alone, gives what the benchmark does."""

from __future__ import annotations

import math
import zlib
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.ndimage import maximum_filter, minimum_filter
from scipy.stats import norm

from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.seeding import Purpose, stream
from grasp_bench.scene.builder import compile_scene
from grasp_bench.scene.rendering import Picture, SceneCamera
from grasp_bench.scene.sensor import sense
from grasp_bench.scene.world import World
from grasp_bench.trials.placing import put_down

TEXT = (Path(__file__).parents[1] / "docs" / "definition.md").read_text(encoding="utf-8")


def defined_stream(seed: int, name: str, attempt: int, purpose: int) -> np.random.Generator:
    """Section 1."""
    return np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(name.encode()), attempt, purpose]))


def times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Hamilton product, w first."""
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])


class Placed(Exception):  # noqa: N818
    """Where the object was put, before it settles."""


class FakeWorld:
    """Takes the pose that a world would be given."""

    def place_object(self, position: np.ndarray, quaternion: np.ndarray) -> None:
        raise Placed(position, quaternion)


@pytest.mark.parametrize("attempt", range(5))
@pytest.mark.parametrize("name", ["block", "bar", "pot"])
def test_an_object_is_put_down_as_section_2_says(
    models: dict[str, ObjectModel], table4: Scenario, name: str, attempt: int
) -> None:
    rng = defined_stream(7, name, attempt, 1)
    poses = [p for p in models[name].poses if p.grasps]
    chances = np.array([p.probability for p in poses])
    pose = poses[rng.choice(len(poses), p=chances / chances.sum())]
    yaw = rng.uniform(-np.pi, np.pi)
    x, y = 0.5 + rng.uniform(-0.06, 0.06), rng.uniform(-0.06, 0.06)
    with pytest.raises(Placed) as placed:
        put_down(FakeWorld(), models[name], table4, stream(7, name, attempt, Purpose.POSE))  # type: ignore[arg-type]
    position, quaternion = placed.value.args
    assert position == pytest.approx([x, y, pose.height + 0.001], abs=1e-12)
    turned = times(np.array([math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)]), pose.quaternion)
    assert quaternion == pytest.approx(turned, abs=1e-12)


def defined_sensor(picture: Picture, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Section 4: colour and depth of the noisy image."""
    h, w = picture.depth.shape

    def normal(*shape: int) -> np.ndarray:
        k = rng.integers(0, 65536, shape, dtype=np.uint16)
        return norm.ppf((k + 0.5) / 65536).astype(np.float32)

    axial, jitter = normal(h, w), normal(2, h, w)
    m, p, d, s = (rng.random((h, w), dtype=np.float32) for _ in range(4))
    colour = normal(h, w, 3)
    perfect = np.where(picture.depth > 0, picture.depth, 3.5)
    low, high = minimum_filter(perfect, 3, mode="nearest"), maximum_filter(perfect, 3, mode="nearest")
    edge = high - low > 0.010
    row, column = np.mgrid[:h, :w]
    row = np.clip(row + np.rint(0.25 * jitter[0]).astype(int), 0, h - 1)
    column = np.clip(column + np.rint(0.25 * jitter[1]).astype(int), 0, w - 1)
    depth = perfect[row, column]
    depth = np.where(edge & (m < 0.5), low + p * (np.minimum(high, 2.5) - low), depth)
    depth = depth + (0.0005 + 0.001 * np.maximum(depth - 0.5, 0)) * axial
    lost = (edge & (d < 0.25)) | ((picture.cosine < math.cos(math.radians(80))) & (d < 0.5)) | (s < 0.001)
    lost |= (depth < 0.25) | (depth > 2.5)
    return np.clip(np.rint(picture.rgb + 2 * colour), 0, 255), np.where(lost, 0, depth)


def test_the_sensor_is_that_of_section_4(models: dict[str, ObjectModel], table4: Scenario) -> None:
    world = World(compile_scene(table4, models["pot"]), table4)
    put_down(world, models["pot"], table4, stream(0, "pot", 0, Purpose.POSE))
    camera = SceneCamera(table4.camera.intrinsics, table4.camera.pose)
    picture = camera.picture(world.model, world.data)
    image = sense(picture, camera.intrinsics, table4.sensor, stream(0, "pot", 0, Purpose.SENSOR))
    rgb, depth = defined_sensor(picture, defined_stream(0, "pot", 0, 2))
    assert ((image.depth == 0) == (depth == 0)).mean() > 1 - 1e-5  # float32 at the very thresholds
    both = (image.depth > 0) & (depth > 0)
    assert np.abs(image.depth - depth)[both].max() < 1e-6
    assert np.array_equal(image.rgb, rgb)


def test_colour_and_depth_of_the_table_are_those_of_section_4(table4: Scenario) -> None:
    model = compile_scene(table4, None, robot=None)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    camera = table4.camera
    seen = camera.intrinsics
    assert (seen.width, seen.height, seen.cx, seen.cy) == (640, 480, 320, 240)
    assert (seen.fx, seen.fy) == pytest.approx((320, 320))
    picture = SceneCamera(camera.intrinsics, camera.pose).picture(model, data)
    light = 0.40 + sum(
        strength * lamp[2] / np.linalg.norm(lamp)
        for lamp, strength in ((np.array([0.25, -0.45, 0.86]), 0.45), (np.array([-0.6, 0.5, 0.62]), 0.2))
    )
    expected = np.trunc(255 * light * np.array([0.62, 0.60, 0.57]))
    assert np.abs(picture.rgb[240, 320] - expected).max() == 0
    assert picture.depth[240, 320] == pytest.approx(0.55, abs=1e-6)
    assert picture.depth[10, 320] == pytest.approx(0.55 + 0.75, abs=1e-6)  # the floor


def test_the_text_names_the_scenarios_own_values(table4: Scenario) -> None:
    motion, gripper, settling = table4.motion, table4.gripper, table4.settling
    phrases = [
        f"`gripper.force` = {gripper.force:g} N",
        f"{1000 * gripper.closing_speed:g} mm/s each",
        f"to {1000 * gripper.squeeze:g} mm inside",
        f"{gripper.settle_time:g} s",
        f"`top` − {1000 * motion.insertion:g} mm, {1000 * motion.table_clearance:g} mm",
        f"more than {motion.collision_force:g} N",
        f"more than {1000 * motion.tcp_tolerance:g} mm or {motion.tcp_tolerance_deg:g}°",
        f"straight up {motion.lift_height:.2f} m",
        f"rose less than {table4.success.minimum_lift:.2f} m",
        "(0.40, 0.25)",
        f"{motion.hold_time:g} s",
        f"below {motion.approach_speed:g} m/s going down",
        f"{motion.carry_speed:.2f} m/s carrying",
        f"below {1000 * settling.linear_speed:g} mm/s",
        f"{settling.angular_speed:g} rad/s",
        f"within {settling.timeout:g} s",
        f"`impratio` {table4.physics.impratio:g}",
        f"{table4.physics.noslip_iterations} no-slip iterations",
        f"more than {table4.trial_timeout:g} s",
    ]
    flat = " ".join(TEXT.split())
    assert [p for p in phrases if p not in flat] == []
    assert motion.carry_to == (0.40, 0.25, 0.0)
