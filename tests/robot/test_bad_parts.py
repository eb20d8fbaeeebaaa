"""Grippers and arms that cannot be used: one clear line each."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from grasp_bench.errors import AssetError, GraspBenchError, UnknownNameError
from grasp_bench.robot import facts
from grasp_bench.robot.arm import load_arm
from grasp_bench.robot.facts import MAX_YAML, folder_of
from grasp_bench.robot.gripper_trial import try_out
from grasp_bench.robot.grippers import load_gripper
from grasp_bench.system.paths import assets_dir

Spoil = Callable[[str], str]


def spoilt(
    folder: Path, kind: str, file: str, old: str, new: str, part: str | None = None
) -> Callable[[], object]:
    """Copy a shipped part, change one of its files, and return what uses it."""
    name = part or {"gripper": "parallel-50", "arm": "ur5e"}[kind]
    shutil.copytree(assets_dir() / f"{kind}s" / name, folder, dirs_exist_ok=True)
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new))
    if kind == "arm":
        return lambda: load_arm(str(folder)).shape
    return lambda: try_out(load_gripper(str(folder)))


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        ("gripper.yaml", "left_pad", "lift_pad", "has no geom (pad) 'lift_pad'; it has"),
        ("gripper.yaml", "actuator: gripper", "actuator: motor", "has no actuator 'motor'; it has gripper"),
        ("gripper.yaml", "tcp: tcp", "tcp: grip_site", "has no site (TCP) 'grip_site'; it has tcp"),
        ("gripper.yaml", "palm: hand", "palm: base", "has no body 'base'"),
        ("gripper.yaml", "force: [5.0, 80.0]", "force: [80.0, 5.0]", "force must be the least"),
        ("gripper.yaml", "force: [5.0, 80.0]", "force: [5.0, 800.0]", "375 N at most"),
        ("gripper.yaml", "speed:", "sped:", "sped: Extra inputs"),
        ("gripper.yaml", "closed: 0.0", "closed: 0.025", "the same command"),
        ("gripper.yaml", "open: 0.025, closed: 0.0", "open: 0.020, closed: 0.0", "commanded open (0.02)"),
        ("gripper.yaml", "model: gripper.xml", "model: ../gripper.xml", "lies outside of"),
        ("gripper.yaml", "model: gripper.xml", "model: hand.xml", "is not in"),
        ("gripper.yaml", "title:", "title: [", "cannot be read as YAML"),
        ("gripper.yaml", "title:", "title: twice\ntitle:", "cannot be read as YAML"),
        ("gripper.yaml", "title:", "more: &a [*a]\ntitle:", "cannot be read as YAML"),
        ("gripper.yaml", "title:", "born: 2024-13-45\ntitle:", "cannot be read as YAML"),
        ("gripper.xml", 'range="0 0.025"', 'range="0.01 0.025"', "cannot close: its pads stay 20.0 mm apart"),
        ("gripper.xml", 'axis="1 0 0"', 'axis="0 1 0"', "do not move apart along x"),
        (
            "gripper.xml",
            'name="tcp" pos="0 0 0.135"',
            'name="tcp" pos="0 0 0"',
            "must lie at the ends of the",
        ),
        (
            "gripper.xml",
            'name="tcp" pos="0 0 0.135"',
            'name="tcp" pos="0.01 0 0.135"',
            "must lie on the flange",
        ),
        ("gripper.xml", "<worldbody>", '<include file="x.xml"/><worldbody>', "uses <include>"),
        ("gripper.xml", "</worldbody>", "", "cannot be read as XML"),
        (
            "gripper.xml",
            "<tendon>",
            '<asset><mesh name="m" file="/etc/passwd"/></asset><tendon>',
            "outside of",
        ),
        ("gripper.xml", "<mujoco", '<!DOCTYPE m [<!ENTITY a "a">]><mujoco', "declares entities"),
        ("gripper.xml", 'coef="0.5"', 'coef="0"', "does not move the fingers"),
    ],
)
def test_a_gripper_that_is_none_is_told_in_one_line(
    tmp_path: Path, file: str, old: str, new: str, words: str
) -> None:
    use = spoilt(tmp_path / "part", "gripper", file, old, new)
    with pytest.raises(AssetError) as caught:
        use()
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        ("arm.yaml", "flange: flange", "flange: tool0", "has no site (flange) 'tool0'; it has flange"),
        ("arm.yaml", "joints: [joint1", "joints: [base", "its joints must be base"),
        ("arm.yaml", "home_deg: [0", "home_deg: [400", "home_deg is outside the range of joint 'joint1'"),
        (
            "arm.yaml",
            "-70, -90, 0]",
            "-20, -90, 0]",
            "in home_deg the flange 'flange' does not point straight",
        ),
        ("arm.yaml", "velocity_deg: [180, ", "velocity_deg: [", "velocity_deg must have 6 values"),
        ("arm.yaml", "velocity_deg: [180", "velocity_deg: [0", "greater than 0"),
        ("arm.xml", 'forcerange="-28 28"', "", "actuator 'joint4' has no forcerange"),
        ("arm.xml", ' range="-6.283185307179586 6.283185307179586"', "", "joint 'joint1' has no range"),
        ("arm.xml", 'joint="joint1"', 'joint="joint9"', "refused by MuJoCo"),
    ],
)
def test_an_arm_that_is_none_is_told_in_one_line(
    tmp_path: Path, file: str, old: str, new: str, words: str
) -> None:
    use = spoilt(tmp_path / "part", "arm", file, old, new)
    with pytest.raises(AssetError) as caught:
        use()
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_names_and_paths(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="Did you mean panda-hand"):
        load_gripper("panda-hnd")
    with pytest.raises(GraspBenchError, match=r"is no folder with arm\.yaml"):
        load_arm(str(tmp_path))
    spoilt(tmp_path / "mine", "gripper", "gripper.yaml", "title:", "title:")
    assert load_gripper(str(tmp_path / "mine" / "gripper.yaml")).opening == 0.05
    assert folder_of("gripper", "parallel-85") == assets_dir() / "ec66"


def test_a_pipe_in_the_place_of_a_file_holds_nobody(tmp_path: Path) -> None:
    use = spoilt(tmp_path / "part", "gripper", "gripper.yaml", "title:", "title:")
    (tmp_path / "part" / "gripper.yaml").unlink()
    os.mkfifo(tmp_path / "part" / "gripper.yaml")
    with pytest.raises(AssetError, match=r"gripper\.yaml"):
        use()


def test_sizes_are_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    use = spoilt(tmp_path / "a", "gripper", "gripper.yaml", "title:", f"# {'x' * MAX_YAML}\ntitle:")
    with pytest.raises(AssetError, match="is larger than 100 kB"):
        use()
    use = spoilt(tmp_path / "b", "gripper", "gripper.yaml", "title:", "title:")
    (tmp_path / "b" / "more.bin").write_bytes(bytes(1000))
    monkeypatch.setattr(facts, "MAX_FOLDER", 500)
    with pytest.raises(AssetError, match="keep a robot's part in a folder of its own"):
        use()
    monkeypatch.setattr(facts, "MAX_FOLDER", 10**9)
    monkeypatch.setattr(facts, "MAX_XML", 500)
    with pytest.raises(AssetError, match="MB of XML"):
        use()


def test_a_link_out_of_the_folder_is_not_followed(tmp_path: Path) -> None:
    spoilt(tmp_path / "part", "gripper", "gripper.yaml", "title:", "title:")
    model = tmp_path / "part" / "gripper.xml"
    model.rename(tmp_path / "elsewhere.xml")
    model.symlink_to(tmp_path / "elsewhere.xml")
    with pytest.raises(AssetError, match="lies outside of"):
        _ = load_gripper(str(tmp_path / "part")).shape
