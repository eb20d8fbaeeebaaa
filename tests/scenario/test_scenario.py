"""Scenario files: the shipped ones load, and what is wrong with a file is said."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from grasp_bench.errors import ScenarioError, UnknownNameError
from grasp_bench.scenario.reading import load_scenario, parse_scenario, scenario_names
from grasp_bench.scenario.sections import Scenario
from grasp_bench.system.paths import scenarios_dir


def refusal(tmp_path: Path, text: str) -> str:
    """The message with which a scenario file of this content is refused; it names the file."""
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(str(path))
    assert str(path) in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("name", scenario_names())
def test_shipped_scenarios_load_under_their_file_name(name: str) -> None:
    assert load_scenario(name).name == name


def test_table4_is_shipped() -> None:
    assert "table4" in scenario_names()


def test_a_file_is_named_after_itself_unless_it_says_otherwise(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("gripper: {force: 30}\n")
    mine = load_scenario(str(path))
    assert (mine.name, mine.gripper.force) == ("mine", 30)
    path.write_text("name: other\n")
    assert load_scenario(str(path)).name == "other"


def test_keys_left_out_take_their_defaults() -> None:
    scenario = parse_scenario({"name": "x", "motion": {"lift_height": 0.3}}, "x.yaml")
    assert scenario.motion.lift_height == 0.3
    assert scenario.motion.hold_time == Scenario(name="x").motion.hold_time


def test_an_unknown_key_is_named_with_the_nearest_and_all_choices(tmp_path: Path) -> None:
    message = refusal(tmp_path, "gripper: {forse: 60}\n")
    assert "gripper.forse" in message
    assert "Did you mean force" in message
    assert "closing_speed" in message


def test_an_unknown_section_is_named_with_the_nearest(tmp_path: Path) -> None:
    message = refusal(tmp_path, "gripers: {force: 60}\n")
    assert "gripers" in message
    assert "Did you mean gripper" in message


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("gripper: {force: strong}", "gripper.force"),
        ("gripper: {force: 500}", "gripper.force"),
        ("gripper: {force: .nan}", "gripper.force"),
        ("motion: {lift_height: .inf}", "motion.lift_height"),
        ("motion: {speed_fraction: 0}", "motion.speed_fraction"),
        ("sensor: {mixed_pixels: 1.5}", "sensor.mixed_pixels"),
        ("camera: {width: 640.5}", "camera.width"),
        ("camera: {position: [0, 1]}", "camera.position"),
        ("physics: {timestep: 0.01}", "physics.timestep"),
        ("trial_timeout: -1", "trial_timeout"),
        ("version: 3", "version"),
        ("gripper: 60", "gripper"),
    ],
)
def test_a_wrong_value_is_named_with_its_key_and_itself(tmp_path: Path, text: str, key: str) -> None:
    message = refusal(tmp_path, text)
    assert f": {key}" in message
    assert "(got " in message


def test_all_faults_of_a_file_are_named_at_once(tmp_path: Path) -> None:
    message = refusal(tmp_path, "gripper: {force: 1}\nmotion: {hold_time: -1}\n")
    assert "gripper.force" in message
    assert "motion.hold_time" in message


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sensor: {minimum_range: 3.0}", "minimum_range must be below"),
        ("success: {minimum_lift: 0.2}", "minimum_lift must be below"),
        ("camera: {image_up: [0, 0, 1]}", "parallel"),
        ("camera: {target: [0.5, 0, 0.55]}", "coincide"),
    ],
)
def test_values_that_contradict_each_other_are_refused(tmp_path: Path, text: str, words: str) -> None:
    assert words in refusal(tmp_path, text)


@pytest.mark.parametrize("text", ["a: [", "- 1\n- 2\n", "", "just words"])
def test_a_file_that_holds_no_keys_is_refused(tmp_path: Path, text: str) -> None:
    refusal(tmp_path, text)


def test_a_binary_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_bytes(b"\xff\xfe\x00\x9f")
    with pytest.raises(ScenarioError, match="not valid YAML"):
        load_scenario(str(path))


def test_a_missing_file_is_refused_by_its_path(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"nothing\.yaml does not exist"):
        load_scenario(str(tmp_path / "nothing.yaml"))


def test_an_unknown_name_is_refused_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean table4") as caught:
        load_scenario("tabel4")
    assert "table4" in caught.value.valid


def test_a_scenario_cannot_be_changed_by_accident() -> None:
    with pytest.raises(ValueError, match="frozen"):
        load_scenario("table4").gripper.force = 30


def test_the_reference_scenario_writes_every_key_out() -> None:
    written = yaml.safe_load((scenarios_dir() / "table4.yaml").read_text())
    loaded = load_scenario("table4").model_dump()
    assert set(written) == set(loaded)
    for key, value in loaded.items():
        if isinstance(value, dict):
            assert set(written[key]) == set(value), key
