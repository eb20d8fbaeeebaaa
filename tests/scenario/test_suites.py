"""The scenario suite: inheritance, single values, calibration errors, coarser hulls, and the listing."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.errors import ScenarioError, UnknownNameError
from grasp_bench.objects.catalog import Catalog, ObjectModel
from grasp_bench.scenario.reading import load_scenario, parameters, scenario_names, with_value
from grasp_bench.scenario.sections import Calibration, Scenario
from grasp_bench.scenario.seeding import Streams
from grasp_bench.scene.builder import compile_mjcf, compose
from grasp_bench.scene.hulls import merged
from grasp_bench.trials.workcell import Workcell, miscalibrated

SUITE = {
    "adversarial",
    "calibration-error",
    "clutter",
    "dim-light",
    "heavy",
    "ideal",
    "low-friction",
    "noisy",
    "office",
    "shaded",
    "table4",
    "tilted-camera",
}


def file(folder: Path, name: str, text: str) -> str:
    path = folder / name
    path.write_text(text)
    return str(path)


# ---------------------------------------------------------------- files


def test_the_suite_is_shipped_and_every_member_says_what_it_is() -> None:
    assert set(scenario_names()) >= SUITE
    assert all(load_scenario(n).description for n in SUITE)
    assert len({load_scenario(n).description for n in SUITE}) == len(SUITE)


def test_members_differ_from_the_reference_in_what_they_are_named_for() -> None:
    table4 = load_scenario("table4")
    changed = {
        n: {k for k, v in load_scenario(n) if v != getattr(table4, k)} - {"name", "description"}
        for n in SUITE
    }
    assert changed == {
        "table4": set(),
        "adversarial": {"objects"},
        "calibration-error": {"calibration"},
        "clutter": {"clutter", "trial_timeout"},
        "dim-light": {"light", "sensor"},
        "heavy": {"objects"},
        "ideal": {"sensor"},
        "low-friction": {"gripper", "table"},
        "noisy": {"sensor"},
        "office": {"camera", "sensor", "look", "table", "surroundings"},
        "shaded": {"look", "table"},
        "tilted-camera": {"camera"},
    }


def test_the_tilted_camera_is_as_far_away_as_the_reference_and_30_degrees_off() -> None:
    tilted, straight = load_scenario("tilted-camera").camera.pose, load_scenario("table4").camera.pose
    cosine = tilted.rotation[:, 2] @ straight.rotation[:, 2]
    assert math.degrees(math.acos(cosine)) == pytest.approx(30, abs=0.02)
    assert np.linalg.norm(tilted.position - [0.5, 0, 0]) == pytest.approx(0.55, abs=1e-4)


def test_adversarial_objects_exist_and_each_has_its_reason() -> None:
    names = load_scenario("adversarial").objects.names
    assert set(names) <= set(Catalog().names)
    assert len(names) == 30
    assert min(map(len, names.values())) > 15


def test_a_file_extends_another_and_holds_only_what_differs(tmp_path: Path) -> None:
    file(tmp_path, "base.yaml", "extends: heavy\ngripper: {force: 30, friction_scale: 0.7}\n")
    made = load_scenario(file(tmp_path, "mine.yaml", "extends: base.yaml\ngripper: {force: 40}\n"))
    assert (made.name, made.description) == ("mine", "")
    assert (made.gripper.force, made.gripper.friction_scale, made.objects.mass_scale) == (40, 0.7, 3)


def test_a_preset_is_not_overlaid_by_what_is_extended(tmp_path: Path) -> None:
    made = load_scenario(file(tmp_path, "a.yaml", "extends: noisy\nsensor: {preset: ideal, rgb_sigma: 1}\n"))
    assert (made.sensor.axial_sigma, made.sensor.speckle_dropout, made.sensor.rgb_sigma) == (0, 0, 1)
    kept = load_scenario(file(tmp_path, "b.yaml", "extends: noisy\nsensor: {rgb_sigma: 1}\n"))
    assert (kept.sensor.axial_sigma, kept.sensor.rgb_sigma) == (0.002, 1)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("extends: tabel4\n", "Did you mean table4"),
        ("extends: a.yaml\n", "extends this file in turn"),
        ("extends: [table4]\n", "must name a scenario"),
        ("extends: gone.yaml\n", "does not exist"),
        ("extends: table4\nclutter: {fewest: 9, most: 4}\n", "must not be above"),
        ("extends: table4\nclutter: {fewst: 4}\n", "Did you mean fewest"),
        ("sensor: {preset: kinect}\n", "azure-kinect"),
        ("sensor: {distant_onset: 9, distant_dropout: 0.1}\n", "distant_onset must be below"),
        ("calibration: {drawn: sometimes}\n", "'run' or 'trial'"),
        ("objects: {names: 7}\n", "objects.names"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(ScenarioError, match=r"a\.yaml|gone\.yaml") as caught:
        load_scenario(file(tmp_path, "a.yaml", text))
    assert words in str(caught.value)


def test_a_list_of_objects_needs_no_reasons(tmp_path: Path) -> None:
    made = load_scenario(file(tmp_path, "a.yaml", "objects: {names: [egg, apple]}\n"))
    assert made.objects.names == {"egg": "", "apple": ""}


# ---------------------------------------------------------------- single values


def test_any_value_can_be_replaced_by_its_dotted_name(table4: Scenario) -> None:
    made = with_value(table4, "physics.timestep", 0.001)
    assert (made.physics.timestep, made.name) == (0.001, "table4+physics.timestep=0.001")
    assert made.physics.impratio == table4.physics.impratio
    assert with_value(table4, "camera.position", [0.5, 0, 0.6]).camera.position == (0.5, 0, 0.6)
    assert with_value(table4, "trial_timeout", 5).trial_timeout == 5
    assert with_value(table4, "clutter.fewest", 4).clutter is not None
    assert set(parameters()) > {"gripper.force", "sensor.preset", "calibration.position_mm", "clutter.most"}


def test_another_preset_resets_the_sensor(table4: Scenario) -> None:
    sensor = with_value(with_value(table4, "sensor.rgb_sigma", 9), "sensor.preset", "structured-light").sensor
    assert (sensor.rgb_sigma, sensor.axial_sigma) == (2.0, 0.0012)


def test_wrong_names_and_values_are_refused_with_the_nearest(table4: Scenario) -> None:
    with pytest.raises(UnknownNameError, match=r"Did you mean gripper\.force"):
        with_value(table4, "gripper.forse", 1)
    with pytest.raises(ScenarioError, match=r"gripper\.force: .*greater than or equal to 20"):
        with_value(table4, "gripper.force", 1)
    with pytest.raises(UnknownNameError):
        with_value(table4, "name", "x")


# ---------------------------------------------------------------- calibration


def test_a_calibration_error_has_its_size_and_every_direction(table4: Scenario) -> None:
    nominal = table4.camera.pose
    calibration = Calibration(position_mm=4.0, rotation_deg=1.5)
    poses = [miscalibrated(nominal, calibration, np.random.default_rng(i)) for i in range(400)]
    shifts = np.array([p.position - nominal.position for p in poses])
    np.testing.assert_allclose(np.linalg.norm(shifts, axis=1), 0.004, rtol=1e-9)
    turns = np.array([p.rotation @ nominal.rotation.T for p in poses])
    angles = np.degrees(np.arccos((np.trace(turns, axis1=1, axis2=2) - 1) / 2))
    np.testing.assert_allclose(angles, 1.5, rtol=1e-6)
    axes = np.stack(
        [turns[:, 2, 1] - turns[:, 1, 2], turns[:, 0, 2] - turns[:, 2, 0], turns[:, 1, 0] - turns[:, 0, 1]],
        axis=1,
    ) / (2 * math.sin(math.radians(1.5)))
    for directions in (shifts / 0.004, axes):  # uniform on the sphere: mean 0, each square 1/3
        assert np.abs(directions.mean(0)).max() < 0.1
        np.testing.assert_allclose((directions**2).mean(0), 1 / 3, atol=0.06)
    np.testing.assert_allclose(turns[0] @ turns[0].T, np.eye(3), atol=1e-12)


def test_calibration_is_drawn_once_a_run_or_anew_each_trial(table4: Scenario) -> None:
    wrong = with_value(table4, "calibration.position_mm", 5)
    each, once = Workcell(wrong), Workcell(with_value(wrong, "calibration.drawn", "run"))

    def place(cell: Workcell, seed: int, name: str, attempt: int) -> list[float]:
        return cell.true_camera(Streams(seed, name, attempt)).pose.position.tolist()

    assert place(each, 0, "egg", 0) == place(each, 0, "egg", 0) != place(each, 0, "egg", 1)
    assert place(once, 0, "egg", 0) == place(once, 0, "pear", 1) != place(once, 1, "egg", 0)
    assert Workcell(table4).true_camera(Streams(0, "egg", 0)).pose is Workcell(table4).camera.pose or place(
        Workcell(table4), 0, "egg", 0
    ) == list(table4.camera.position)


# ---------------------------------------------------------------- mass and hulls


def test_mass_and_inertia_are_scaled_together(table4: Scenario, models: dict[str, ObjectModel]) -> None:
    scaled = [with_value(table4, "objects.mass_scale", s) for s in (1.0, 3.0)]
    light, heavy = (compile_mjcf(compose(s, models["bar"], robot=None)) for s in scaled)
    assert heavy.body("object").mass[0] == pytest.approx(3 * models["bar"].mass)
    np.testing.assert_allclose(heavy.body("object").inertia, 3 * light.body("object").inertia)


@pytest.mark.parametrize("most", [1, 2, 4, 7])
def test_merged_hulls_are_so_many_and_hold_all_that_was(most: int) -> None:
    hulls = Catalog().load("coffee_mug").hulls
    fewer = merged(hulls, most)
    assert len(fewer) == most
    solids = [trimesh.convex.convex_hull(h) for h in fewer]
    points = np.vstack(hulls)
    offsets = [np.einsum("ij,ij->i", s.face_normals, s.triangles[:, 0]) for s in solids]
    outside = np.min([np.max(points @ s.face_normals.T - o, axis=1) for s, o in zip(solids, offsets)], axis=0)
    assert outside.max() < 1e-6


def test_merging_joins_what_fits_best_first() -> None:
    cube = np.array(np.meshgrid([0, 1], [0, 1], [0, 1]), float).reshape(3, 8).T
    pieces = [cube, cube + [5, 0, 0], cube + [1, 0, 0]]
    first, second = merged(pieces, 2)
    assert (np.ptp(first, axis=0), np.ptp(second, axis=0))[0].tolist() == [1, 1, 1]
    assert np.ptp(second, axis=0).tolist() == [2, 1, 1]
    assert merged(pieces, 0) is pieces
    assert merged(pieces, 3) is pieces


def test_max_hulls_reaches_the_model(table4: Scenario) -> None:
    mug = Catalog().load("coffee_mug")
    compiled = compile_mjcf(compose(with_value(table4, "physics.max_hulls", 3), mug, robot=None))
    names = [compiled.geom(i).name for i in range(compiled.ngeom)]
    assert sum(n.startswith("hull") for n in names) == 3


# ---------------------------------------------------------------- commands


def test_scenarios_are_listed_with_what_they_are() -> None:
    listed = json.loads(CliRunner().invoke(app, ["scenarios", "--json"]).stdout)
    assert {entry["name"] for entry in listed} >= SUITE
    text = CliRunner().invoke(app, ["scenarios"]).stdout
    assert "tilted-camera" in text
    assert "arm's base is in view" in text.replace("\n", " ")


def test_a_scenario_is_shown_whole_or_by_what_it_changes() -> None:
    whole = CliRunner().invoke(app, ["scenarios", "show", "heavy"]).stdout
    assert "mass_scale: 3.0" in whole
    assert "noslip_iterations: 3" in whole
    arguments = ["scenarios", "show", "heavy", "--changed", "--json"]
    changed = json.loads(CliRunner().invoke(app, arguments).stdout)
    assert changed.pop("objects") == {"mass_scale": 3.0}
    assert set(changed) == {"name", "description"}


def test_an_unknown_scenario_is_refused_with_the_nearest() -> None:
    result = CliRunner().invoke(app, ["scenarios", "show", "heavi"])
    assert isinstance(result.exception, UnknownNameError)
    assert "Did you mean heavy" in str(result.exception)
