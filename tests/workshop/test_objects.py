"""Objects: hulls, mass properties, files against their manifest, and the 180 that are shipped."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from grasp_bench.errors import AssetError, UnknownNameError
from grasp_bench.objects.catalog import Catalog, ObjectModel
from grasp_bench.planning.heightfield import CELL, HeightField, analyse, maxima
from grasp_bench.system.integrity import sha256
from grasp_bench.system.paths import assets_dir
from grasp_bench.workshop.build import build_shape, mass_properties, write_manifest
from grasp_bench.workshop.decompose import BOUNDS, MAX_HULLS, MAX_VERTICES, compare, decompose, reduce_hull
from grasp_bench.workshop.materials import MATERIALS
from grasp_bench.workshop.model import REGISTRY, ObjectSpec, Part, household
from grasp_bench.workshop.poses import build_rest, opens_visibly
from grasp_bench.workshop.shapes import Mesh, box, difference, move, scale, sphere

# ---------------------------------------------------------------- hulls


def metres(mesh: Mesh) -> Mesh:
    return scale(mesh, 0.001)


def test_a_reduced_hull_has_few_vertices_and_stays_inside() -> None:
    points = np.random.default_rng(0).normal(size=(4000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    full, reduced = ConvexHull(points), reduce_hull(points)
    assert len(reduced.vertices) <= MAX_VERTICES == 64
    assert (reduced.vertices @ full.equations[:, :3].T + full.equations[:, 3]).max() < 1e-9
    assert 0.85 * full.volume < reduced.volume <= full.volume


def test_a_hull_of_few_vertices_is_kept_as_it_is() -> None:
    corners = np.array(np.meshgrid([0, 1], [0, 2], [0, 3])).reshape(3, 8).T.astype(float)
    inner = np.random.default_rng(1).uniform(0.1, 0.9, (200, 3))
    reduced = reduce_hull(np.vstack([corners, inner]))
    assert len(reduced.vertices) == 8
    assert reduced.volume == pytest.approx(6)


def test_convex_parts_keep_their_own_hull() -> None:
    hulls = decompose(
        [Part(box(40, 20, 10), "#ffffff", "wood", "convex"), Part(sphere(15), "#ffffff", "wood", "convex")]
    )
    assert len(hulls) == 2
    assert len(hulls[0].vertices) == 8
    assert len(hulls[1].vertices) <= MAX_VERTICES


def test_too_many_hulls_are_refused() -> None:
    parts = [Part(move(box(1, 1, 1), x=3.0 * i), "#ffffff", "wood", "convex") for i in range(MAX_HULLS + 1)]
    with pytest.raises(ValueError, match=f"more than {MAX_HULLS} convex pieces"):
        decompose(parts)


def test_the_error_of_a_decomposition_is_that_of_its_volume_and_surface() -> None:
    solid = metres(difference(box(100, 100, 50), move(box(80, 80, 50), z=10)))
    exact = compare(metres(box(100, 100, 50)), [metres(box(100, 100, 50))])
    assert exact.volume_ratio == pytest.approx(1)
    assert exact.max_distance == 0
    filled = compare(solid, [metres(box(100, 100, 50))])
    assert filled.volume_ratio == pytest.approx(500 / (500 - 256), rel=1e-6)
    assert filled.max_distance == pytest.approx(0.04, abs=0.002)  # the middle of the filled-in mouth


# ---------------------------------------------------------------- mass


def test_mass_properties_of_two_boxes_agree_with_hand_values() -> None:
    # A wooden and a steel box of 0.1 x 0.1 x 0.1 m, side by side along x, weighing 1 kg together.
    wood, steel = MATERIALS["wood"].density, MATERIALS["steel"].density
    cube = metres(box(100, 100, 100))
    parts = [Part(cube, "#ffffff", "wood"), Part(move(cube, x=0.1), "#ffffff", "steel")]
    centre, inertia = mass_properties(parts, 1.0)
    first, second = wood / (wood + steel), steel / (wood + steel)
    assert centre == pytest.approx([0.1 * second, 0, 0.05])
    own = (0.1**2 + 0.1**2) / 12
    reduced = first * second * 0.1**2  # two masses about their common centre
    np.testing.assert_allclose(inertia, np.diag([own, own + reduced, own + reduced]), atol=1e-9)


def test_mass_properties_of_one_box_are_the_textbooks() -> None:
    _, inertia = mass_properties([Part(metres(box(40, 80, 30)), "#ffffff", "wood")], 0.12)
    expected = 0.12 / 12 * np.array([0.08**2 + 0.03**2, 0.04**2 + 0.03**2, 0.04**2 + 0.08**2])
    np.testing.assert_allclose(inertia, np.diag(expected), atol=1e-12)


def test_a_built_object_has_its_mass_and_its_centre_as_origin(models: dict[str, ObjectModel]) -> None:
    block = models["block"]
    assert block.mass == 0.08
    np.testing.assert_allclose(np.ptp(block.hulls[0], axis=0), [0.04, 0.08, 0.03], atol=1e-6)
    np.testing.assert_allclose(block.hulls[0].mean(0), 0, atol=1e-6)
    bar = np.vstack(models["bar"].hulls)
    assert bar[:, 0].max() < -bar[:, 0].min()  # the wide half is the heavy one


# ---------------------------------------------------------------- resting poses and reference grasps


@pytest.mark.parametrize("name", ["bar", "block", "pot"])
def test_resting_poses_stand_on_the_table_with_grasps_that_fit(
    models: dict[str, ObjectModel], name: str
) -> None:
    model = models[name]
    assert model.graspable_poses
    assert sum(p.probability for p in model.poses) <= 1.001
    assert [p.probability for p in model.poses] == sorted((p.probability for p in model.poses), reverse=True)
    cloud = np.vstack(model.hulls)
    for pose in model.poses:
        w, x, y, z = pose.quaternion
        assert np.linalg.norm(pose.quaternion) == pytest.approx(1, abs=1e-4)
        up = np.array([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])  # third row
        assert pose.height + (cloud @ up).min() == pytest.approx(0, abs=0.001)
        for grasp in pose.grasps:
            assert 0.012 <= grasp.width <= 0.085
            assert abs(grasp.axis @ up) < 0.02
            assert np.linalg.norm(grasp.axis) == pytest.approx(1, abs=1e-3)
            assert 0 < pose.height + grasp.tip @ up < grasp.top
            assert 0 <= grasp.score <= 1


def patch(*boxes: tuple[float, float, float, float, float]) -> HeightField:
    """Height field of level boxes (x, y, length in x, length in y, height) about the origin."""
    origin = -0.1 + CELL / 2
    x, y = np.meshgrid(origin + CELL * np.arange(100), origin + CELL * np.arange(100))
    heights = np.zeros((100, 100), np.float32)
    for cx, cy, along_x, along_y, height in boxes:
        heights[(np.abs(x - cx) < along_x / 2) & (np.abs(y - cy) < along_y / 2)] = height
    return HeightField(heights, (origin, origin), (0.0, 0.0))


def test_the_best_grasp_of_a_bar_is_across_its_middle() -> None:
    field = patch((0, 0, 0.12, 0.03, 0.04))
    found = analyse(field)
    row, column = maxima(found, 1)[0]
    assert abs(field.origin[0] + column * CELL) < 0.01
    assert abs(field.origin[1] + row * CELL) < 0.006
    assert found.yaw[row, column] == pytest.approx(np.pi / 2, abs=0.01)
    assert 0.03 < found.opening[row, column] < 0.05
    assert found.tip[row, column] == pytest.approx(0.012, abs=1e-3)
    assert found.top[row, column] == pytest.approx(0.04)


def test_what_is_too_wide_or_too_low_has_no_grasp() -> None:
    plate = analyse(patch((0, 0, 0.11, 0.11, 0.04)), yaws=np.array([0, np.pi / 2]))
    assert plate.quality[30:70, 30:70].max() == 0
    assert maxima(analyse(patch((0, 0, 0.03, 0.03, 0.003))), 5) == []


def test_jaws_must_open_wider_than_what_they_pass_by_what_a_camera_can_tell() -> None:
    tip, across = np.array([0.0, 0.0, 0.012]), np.pi / 2
    assert opens_visibly(patch((0, 0, 0.12, 0.03, 0.04)), tip, across, 0.036)
    assert opens_visibly(patch((0, 0, 0.12, 0.070, 0.04)), tip, across, 0.074)
    assert not opens_visibly(patch((0, 0, 0.12, 0.078, 0.04)), tip, across, 0.080)
    beside = patch((0, 0, 0.12, 0.03, 0.04), (0, 0.034, 0.12, 0.02, 0.04))  # 9 mm of room, a finger's
    assert not opens_visibly(beside, tip, across, 0.036)


def test_shipped_poses_and_grasps_are_of_this_version(tmp_path: Path) -> None:
    folder = shutil.copytree(assets_dir() / "objects" / "coffee_mug", tmp_path / "coffee_mug")
    before = (folder / "object.json").read_bytes()
    assert not build_rest(folder)
    assert (folder / "object.json").read_bytes() == before


# ---------------------------------------------------------------- models in code


def test_a_part_of_unknown_material_is_refused() -> None:
    with pytest.raises(ValueError, match="unknown material 'cheese'"):
        Part(box(1, 1, 1), "#ffffff", "cheese")


def test_an_open_part_is_refused_when_built(tmp_path: Path) -> None:
    cube = box(10, 10, 10)
    holed = Mesh(cube.vertices, cube.faces[:-1], process=False)
    spec = ObjectSpec(
        "holed", "box", "toys", 0.1, "wood", "x", lambda: [Part(holed, "#ffffff", "wood", "convex")]
    )
    with pytest.raises(ValueError, match=r"holed: parts \[0\] are not closed"):
        build_shape(spec, tmp_path)


def test_an_object_that_has_not_changed_is_not_built_again(tmp_path: Path) -> None:
    def spec(mass: float) -> ObjectSpec:
        return ObjectSpec(
            "cube",
            "box",
            "toys",
            mass,
            "wood",
            "x",
            lambda: [Part(box(20, 20, 20), "#ffffff", "wood", "convex")],
        )

    assert build_shape(spec(0.1), tmp_path)
    assert not build_shape(spec(0.1), tmp_path)
    assert build_shape(spec(0.2), tmp_path)


@pytest.mark.parametrize("wrong", [{"family": "cars"}, {"material": "cheese"}])
def test_wrong_families_and_materials_are_refused(wrong: dict[str, str]) -> None:
    sound = {"category": "box", "family": "toys", "mass": 0.1, "material": "wood", "source": "x"}
    with pytest.raises(ValueError, match="unknown"):
        household(**(sound | wrong), name="never")(list)  # type: ignore[arg-type]
    assert "never" not in REGISTRY


# ---------------------------------------------------------------- files and manifest


@pytest.fixture
def toys(toy_catalog: Path, tmp_path: Path) -> Path:
    """A copy of the three objects, to be damaged."""
    return Path(shutil.copytree(toy_catalog, tmp_path / "toys"))


def refusal(folder: Path) -> str:
    with pytest.raises(AssetError) as caught:
        Catalog(folder).load("pot")
    return str(caught.value)


def test_a_changed_file_is_refused_with_a_remedy(toys: Path) -> None:
    path = toys / "pot" / "object.json"
    path.write_text(path.read_text().replace("0.22", "0.23"))
    message = refusal(toys)
    assert f"{path} differs from the manifest" in message
    assert "objects build --only pot" in message
    assert Catalog(toys).load("bar").mass == 0.18  # the others are sound


def test_a_missing_file_is_refused_with_a_remedy(toys: Path) -> None:
    (toys / "pot" / "visual.glb").unlink()
    message = refusal(toys)
    assert f"{toys / 'pot' / 'visual.glb'} is missing" in message
    assert "objects build --only pot" in message


def test_a_truncated_file_is_refused_with_a_remedy(toys: Path) -> None:
    path = toys / "pot" / "collision.glb"
    path.write_bytes(path.read_bytes()[:1000])
    assert f"{path} differs" in refusal(toys)


def test_a_file_that_is_truncated_in_the_manifest_too_is_refused_when_read(toys: Path) -> None:
    path = toys / "pot" / "collision.glb"
    path.write_bytes(path.read_bytes()[:1000])
    write_manifest(toys)
    model = Catalog(toys).load("pot")
    with pytest.raises(AssetError, match=r"collision\.glb cannot be read as a GLB mesh.*objects build"):
        _ = model.hulls


@pytest.mark.parametrize("content", ["", "{}", "[]", '{"objects": [{}]}', '{"objects": 3}'])
def test_a_damaged_manifest_is_refused(toys: Path, content: str) -> None:
    (toys / "manifest.json").write_text(content)
    with pytest.raises(AssetError, match=r"manifest\.json is not a valid manifest"):
        Catalog(toys)


def test_a_folder_without_manifest_is_refused(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match=r"has no manifest\.json"):
        Catalog(tmp_path)


def test_objects_are_selected_by_name_category_or_all(toy_catalog: Path) -> None:
    catalog = Catalog(toy_catalog)
    assert catalog.names == catalog.select("all") == ["bar", "block", "pot"]
    assert catalog.categories == ["bar", "box", "pot"]
    assert catalog.select("box") == ["block"]
    assert catalog.select("pot, bar,pot") == ["pot", "bar"]
    with pytest.raises(UnknownNameError, match="Did you mean pot"):
        catalog.select("pott")
    with pytest.raises(UnknownNameError, match="Did you mean block"):
        catalog.load("blok")


def test_an_objects_digest_is_that_of_its_files(toys: Path) -> None:
    before = Catalog(toys).load("pot").digest
    path = toys / "pot" / "object.json"
    path.write_text(path.read_text() + "\n")
    write_manifest(toys)
    assert Catalog(toys).load("pot").digest != before


def test_meshes_come_back_as_they_were_written(models: dict[str, ObjectModel]) -> None:
    first, second = models["bar"].visual
    assert first.rgb == pytest.approx((0xCC / 255, 0x88 / 255, 0x33 / 255), abs=0.003)
    assert second.rgb == pytest.approx((0xAA / 255,) * 3, abs=0.003)
    assert first.roughness == pytest.approx(MATERIALS["aluminium"].roughness, abs=0.01)
    mesh = trimesh.Trimesh(first.vertices, first.faces)
    assert mesh.volume == pytest.approx(60 * 20 * 24 * 1e-9, rel=1e-4)


# ---------------------------------------------------------------- the 180 shipped objects, and the grid's 49

SHIPPED = assets_dir() / "objects"


def _entries() -> list[dict]:
    path = SHIPPED / "manifest.json"
    return json.loads(path.read_text())["objects"] if path.is_file() else []


ENTRIES = _entries()
complete = pytest.mark.skipif(
    len(ENTRIES) != 229, reason=f"the manifest lists {len(ENTRIES)} of 229 objects: not all are built yet"
)


@cache
def shipped_model(name: str) -> ObjectModel:
    return Catalog(SHIPPED).load(name)


@complete
def test_shipped_objects_are_180_distinct_in_60_categories() -> None:
    household = [e for e in ENTRIES if e["family"] != "grid"]
    assert len({e["name"] for e in household}) == len(household) == 180
    assert len({e["name"] for e in ENTRIES}) == 229
    categories = Counter(e["category"] for e in household)
    assert len(categories) >= 60
    assert max(categories.values()) <= 4


@complete
def test_shipped_files_are_those_of_the_manifest_and_no_more() -> None:
    for entry in ENTRIES:
        for file, digest in entry["files"].items():
            assert sha256(SHIPPED / entry["name"] / file) == digest, f"{entry['name']}/{file}"
    folders = {p.name for p in SHIPPED.iterdir() if p.is_dir()}
    assert folders == {e["name"] for e in ENTRIES}


@complete
def test_shipped_assets_are_small() -> None:
    assert sum(p.stat().st_size for p in assets_dir().rglob("*") if p.is_file()) < 60e6


@complete
def test_shipped_objects_are_plausible() -> None:
    for entry in ENTRIES:
        name = entry["name"]
        assert 0.003 < entry["mass"] < 3, name
        assert max(entry["extents"]) < 0.45, name
        assert min(entry["extents"]) > 0.001, name
        assert entry["material"] in MATERIALS, name
        assert entry["friction"] == MATERIALS[entry["material"]].friction, name
        assert len(entry["source"]) > 10, name
        moments = np.linalg.eigvalsh(np.array(entry["inertia"]))
        assert moments[0] > 0, name
        assert moments[2] <= moments[0] + moments[1] + 1e-12, name  # the triangle inequality


@complete
def test_shipped_decompositions_stay_near_the_true_shape() -> None:
    for entry in ENTRIES:
        for name, (low, high) in BOUNDS.items():
            assert low <= entry["decomposition"][name] <= high, f"{entry['name']}: {name}"


@complete
def test_shipped_hulls_are_few_and_simple() -> None:
    for entry in ENTRIES:
        hulls = shipped_model(entry["name"]).hulls
        assert 1 <= len(hulls) <= MAX_HULLS, entry["name"]
        assert len(hulls) == entry["hulls"], entry["name"]
        assert max(map(len, hulls)) <= MAX_VERTICES, entry["name"]


@complete
def test_shipped_objects_can_all_be_grasped_in_some_pose() -> None:
    assert [e["name"] for e in ENTRIES if not shipped_model(e["name"]).graspable_poses] == []


@complete
def test_shipped_visual_meshes_are_closed_and_simple() -> None:
    assert all(e["faces"] <= 6000 for e in ENTRIES)
    for i in np.random.default_rng(0).choice(229, 25, replace=False):
        model = shipped_model(ENTRIES[i]["name"])
        assert sum(len(p.faces) for p in model.visual) == ENTRIES[i]["faces"], model.name
        for part in model.visual:
            mesh = trimesh.Trimesh(part.vertices, part.faces, process=False)
            assert mesh.is_watertight, model.name
            assert mesh.volume > 0, model.name


def same_but_scaled(first: np.ndarray, second: np.ndarray) -> bool:
    """Whether two lists of vertices become equal when each is scaled to a unit box."""
    if first.shape != second.shape:
        return False
    a, b = ((v - v.min(0)) / np.maximum(np.ptp(v, axis=0), 1e-9) for v in (first, second))
    return bool(np.abs(a - b).max() < 0.02)


def test_a_scaled_shape_is_recognised() -> None:
    ball, cube = np.asarray(sphere(10).vertices), np.asarray(box(10, 20, 30).vertices)
    assert same_but_scaled(ball, 3 * ball + [1, 2, 3])
    assert same_but_scaled(cube, cube * [2, 3, 4])
    assert not same_but_scaled(ball, cube)
    bent = ball.copy()
    bent[:, 0] += 0.01 * bent[:, 2] ** 2
    assert not same_but_scaled(ball, bent)


@complete
def test_no_shipped_object_is_another_one_scaled() -> None:
    clouds = {e["name"]: np.vstack([p.vertices for p in shipped_model(e["name"]).visual]) for e in ENTRIES}
    names = list(clouds)
    pairs = [(a, b) for i, a in enumerate(names) for b in names[:i] if same_but_scaled(clouds[a], clouds[b])]
    assert pairs == []
