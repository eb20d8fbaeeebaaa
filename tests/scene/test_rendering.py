"""The ray caster against geometry, and OpenGL against the ray caster."""

from __future__ import annotations

import os
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import compile_scene
from grasp_bench.scene.rendering import Picture, SceneCamera, incidence_cosine, raycast
from grasp_bench.scene.surfaces import geom_colors
from grasp_bench.scene.world import World
from grasp_bench.system.graphics import RENDERERS, available, resolve_renderer

K = Intrinsics.from_fov(160, 120, np.radians(70))
ABOVE = CameraPose.look_at([0, 0, 0.5], [0, 0, 0], [1, 0, 0])
SLANTED = CameraPose.look_at([0.4, -0.3, 0.5], [0, 0, 0], [0, 0, 1])

SCENE = """
<mujoco>
  <worldbody>
    <geom name="slab" type="box" size="0.15 0.12 0.01" pos="0 0 -0.01" rgba="0.5 0.5 0.5 1" group="1"/>
    <geom name="box" type="box" size="0.04 0.02 0.03" pos="0 0 0.03" rgba="0.8 0.2 0.1 1" group="2"/>
    <geom name="hidden" type="sphere" size="0.05" pos="0 0 0.3" group="3"/>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def scene() -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(SCENE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def cast(scene, camera: CameraPose) -> Picture:
    return SceneCamera(K, camera).picture(*scene)


def box_depth(camera: CameraPose, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(H, W) z-depth of an axis-aligned box by the slab method; infinite beside it."""
    rays = K.rays() @ camera.rotation.T
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (low - camera.position) / rays, (high - camera.position) / rays
    near, far = np.minimum(a, b).max(-1), np.maximum(a, b).min(-1)
    return np.where(near < far, near, np.inf)


@pytest.mark.parametrize("camera", [ABOVE, SLANTED])
def test_ray_cast_depth_of_known_boxes_is_exact(scene, camera: CameraPose) -> None:
    truth = np.minimum(
        box_depth(camera, np.array([-0.15, -0.12, -0.02]), np.array([0.15, 0.12, 0.0])),
        box_depth(camera, np.array([-0.04, -0.02, 0.0]), np.array([0.04, 0.02, 0.06])),
    )
    picture = cast(scene, camera)
    depth = picture.depth
    assert (np.isfinite(truth) == (depth > 0)).all()
    assert np.abs(depth - truth)[depth > 0].max() < 1e-6
    assert (picture.geom == scene[0].geom("box").id).sum() > 150


def test_background_is_zero_depth_black_and_no_geom(scene) -> None:
    picture = cast(scene, ABOVE)
    outside = picture.depth == 0
    assert outside.any()
    assert (picture.geom[outside] == -1).all()
    assert (picture.rgb[outside] == 0).all()


def test_geom_ids_and_colours_are_those_of_what_is_seen(scene) -> None:
    picture = cast(scene, ABOVE)
    model = scene[0]
    assert picture.geom[60, 80] == model.geom("box").id
    assert picture.geom[60, 100] == model.geom("slab").id
    red, green, blue = picture.rgb[60, 80].astype(int)
    assert red > 2 * green > 2 * blue


def test_groups_from_three_on_are_not_seen(scene) -> None:
    assert scene[0].geom("hidden").id not in cast(scene, ABOVE).geom


def test_the_cosine_is_that_between_ray_and_surface(scene) -> None:
    picture = cast(scene, ABOVE)
    level = np.isin(picture.depth, [np.float32(0.44), np.float32(0.5)])
    upright = 1 / np.linalg.norm(K.rays(), axis=-1)
    assert level.sum() > 3000
    np.testing.assert_allclose(picture.cosine[level], upright[level], atol=1e-6)
    assert (picture.cosine[picture.depth == 0] == 0).all()


def test_the_cosine_estimated_from_depth_is_the_true_one_away_from_edges() -> None:
    depth = (0.5 / (K.rays() @ [0, np.sin(1.0), np.cos(1.0)]).clip(0.1)).astype(np.float32)
    true = np.abs(K.rays() @ [0, np.sin(1.0), np.cos(1.0)]) / np.linalg.norm(K.rays(), axis=-1)
    np.testing.assert_allclose(incidence_cosine(depth, K)[50:110, 2:-2], true[50:110, 2:-2], atol=0.01)


def test_rays_pass_through_an_excluded_body() -> None:
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><geom type="plane" size="1 1 1"/><body name="b" pos="0 0 0.2"><geom size="0.1"/>'
        "</body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    down = K.rays() @ ABOVE.rotation.T
    assert raycast(model, data, ABOVE.position, down).depth.min() == pytest.approx(0.2, abs=1e-3)
    through = raycast(model, data, ABOVE.position, down, exclude=model.body("b").id)
    np.testing.assert_allclose(through.depth, 0.5, atol=1e-6)


def test_casting_only_what_changed_gives_the_same_picture(scenario: Scenario, models) -> None:
    camera = scenario.camera
    kept = SceneCamera(camera.intrinsics, camera.pose)
    places = {"pot": (0.5, 0.03, 0.02), "bar": (0.44, -0.06, 0.3), "block": (0.64, 0.12, 0.02)}
    for name, place in places.items():
        model = compile_scene(scenario, models[name])
        world = World(model, scenario)
        world.place_object(np.array(place), np.array([0.9, 0.1, 0.3, 0.3]))
        mujoco.mj_forward(model, world.data)
        quick = kept.picture(model, world.data, world.object_body)
        whole = SceneCamera(camera.intrinsics, camera.pose).picture(model, world.data)
        for a, b in zip(quick, whole, strict=True):
            np.testing.assert_array_equal(a, b)
        assert (np.isin(quick.geom, np.nonzero(model.geom_bodyid == world.object_body)[0])).sum() > 300


def test_a_material_gives_its_colour_to_its_geoms() -> None:
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><asset><material name="m" rgba="0.1 0.2 0.3 1"/></asset><worldbody>'
        '<geom size="0.1" material="m"/><geom size="0.1" rgba="0.4 0.5 0.6 1"/></worldbody></mujoco>'
    )
    np.testing.assert_allclose(geom_colors(model), [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])


def test_the_table_of_a_scene_lies_at_height_zero(scenario: Scenario) -> None:
    model = compile_scene(scenario, None, robot=None)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    depth = SceneCamera(scenario.camera.intrinsics, scenario.camera.pose).picture(model, data).depth
    np.testing.assert_allclose(depth, scenario.camera.position[2], atol=1e-6)


def test_auto_means_the_ray_caster() -> None:
    assert resolve_renderer("auto") == "raycast"
    assert {resolve_renderer(r) for r in RENDERERS} == set(RENDERERS) - {"auto"}


def test_an_unknown_renderer_is_refused_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean raycast"):
        resolve_renderer("raycaster")


def test_opengl_is_refused_where_mujoco_runs_without(scene) -> None:
    if os.environ["MUJOCO_GL"] != "off":
        pytest.skip("MUJOCO_GL was set before the tests were started")
    with pytest.raises(GraspBenchError, match="MUJOCO_GL=off"):
        SceneCamera(K, ABOVE, "egl").picture(*scene)


COMPARE = """
import sys
import mujoco, numpy as np
from pathlib import Path
from grasp_bench.objects.catalog import Catalog
from grasp_bench.scenario import load_scenario
from grasp_bench.scene.builder import compile_scene
from grasp_bench.scene.rendering import SceneCamera
scenario = load_scenario("table4")
camera = scenario.camera
model = compile_scene(scenario, Catalog(Path(sys.argv[1])).load("pot"), robot=None)
data = mujoco.MjData(model)
data.qpos[:3] = 0.45, 0.05, 0.02
mujoco.mj_forward(model, data)
cast, drawn = (SceneCamera(camera.intrinsics, camera.pose, r).picture(model, data)
               for r in ("raycast", sys.argv[2]))
both = (cast.depth > 0) & (drawn.depth > 0)
assert both.mean() > 0.99, both.mean()
difference = np.abs(cast.depth - drawn.depth)[both]
table = model.geom("table").id
assert (cast.geom != table).sum() > 2000
seen = ((cast.geom != table) == (drawn.geom != table)).mean()
print(np.median(difference), (difference < 1e-3).mean(), seen)
"""


@pytest.mark.parametrize("backend", ["egl", "osmesa"])
def test_opengl_and_the_ray_caster_see_the_same(toy_catalog, backend: str) -> None:
    if backend not in available():
        pytest.skip(f"no {backend} library is installed")
    done = subprocess.run(
        [sys.executable, "-c", COMPARE, str(toy_catalog), backend],
        text=True,
        capture_output=True,
        timeout=120,
        env=os.environ | {"MUJOCO_GL": backend},
    )
    assert done.returncode == 0, done.stderr
    median, near, seen = map(float, done.stdout.split())
    assert median < 1e-4
    assert near > 0.98
    assert seen > 0.995
