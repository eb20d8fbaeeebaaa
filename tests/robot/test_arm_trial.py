"""An arm held stretched out: strong enough, too weak, too soft."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.errors import AssetError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.robot.arm import Arm, load_arm
from grasp_bench.robot.arm_trial import SAG, hold_out
from grasp_bench.robot.facts import shipped
from grasp_bench.robot.grippers import load_gripper

HEAVIEST = 1.0
G = 9.81


def changed(folder: Path, *changes: tuple[str, str]) -> Arm:
    """A UR5e whose model says something else."""
    shutil.copytree(load_arm("ur5e").folder, folder)
    text = (folder / "arm.xml").read_text()
    for old, new in changes:
        assert re.search(old, text)
        text = re.sub(old, new, text)
    (folder / "arm.xml").write_text(text)
    return load_arm(str(folder))


def test_the_payload_is_the_heaviest_object() -> None:
    assert Catalog().heaviest == HEAVIEST


@pytest.mark.parametrize("gripper", shipped("gripper"))
@pytest.mark.parametrize("arm", shipped("arm"))
def test_every_shipped_arm_holds_every_shipped_gripper(arm: str, gripper: str) -> None:
    held = hold_out(load_arm(arm), load_gripper(gripper), HEAVIEST)
    assert 0 < held.sag <= SAG * held.reach / 2, "with room to spare"
    assert (held.torques < load_arm(arm).torque_limits).all()


@pytest.mark.parametrize(("arm", "reach"), [("ec66", 0.914), ("ur5e", 0.850)])
def test_it_is_stretched_out(arm: str, reach: float) -> None:
    """The makers' reach is that of the wrist, or counts no hand; ours is the flange's from the axis."""
    held = hold_out(load_arm(arm), load_gripper("parallel-85"), HEAVIEST)
    assert reach < held.reach < reach + 0.15
    low, high = np.array(load_arm(arm).position_limits).T
    assert ((low <= held.posture) & (held.posture <= high)).all()


def test_what_is_asked_of_the_shoulder_is_the_weight_times_its_lever() -> None:
    """Of what hangs at the flange: one more kilogram, further out by the hand where that is level."""
    arm, gripper = load_arm("ur5e"), load_gripper("parallel-85")
    light, heavy = (hold_out(arm, gripper, load) for load in (0.0, 1.0))
    np.testing.assert_array_equal(light.posture, heavy.posture)
    lever = (heavy.torques - light.torques)[1] / G
    assert light.reach - 0.17 < lever < light.reach + 0.17
    assert light.sag < heavy.sag / 4, "servos do not know the payload, but the gripper"


def test_motors_that_are_too_weak_are_named(tmp_path: Path) -> None:
    """Its own weight alone is too much for a shoulder of 30 N m, which the compensation in trials hides."""
    weak = changed(tmp_path / "weak", ('forcerange="-150 150"', 'forcerange="-30 30"'))
    with pytest.raises(AssetError) as caught:
        hold_out(weak, load_gripper("parallel-85"), HEAVIEST)
    told = str(caught.value)
    assert re.search(
        r"arm\.xml: stretched out to 0\.97 m with gripper parallel-85 and 1 kg, the arm sinks by \d+ mm "
        r"in 1 s \(10 mm are allowed\): of joint 'joint2' \d\d\.\d N m are asked and its motor gives 30; "
        "raise its forcerange",
        told,
    )
    assert "\n" not in told


def test_servos_that_give_way_are_told(tmp_path: Path) -> None:
    soft = changed(tmp_path / "soft", ('kp="4000"', 'kp="400"'))
    with pytest.raises(AssetError, match="its motors would do, but its servos give way; raise their kp"):
        hold_out(soft, load_gripper("parallel-85"), HEAVIEST)
    sinking = changed(tmp_path / "sinking", (' gravcomp="1"', ""))
    with pytest.raises(AssetError, match="or give all bodies gravcomp=1"):
        hold_out(sinking, load_gripper("parallel-85"), HEAVIEST)


def test_the_command_tells_and_refuses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    done = CliRunner().invoke(app, ["arms", "check", "panda"])
    assert done.exit_code == 0, done.output
    assert re.search(r"Stretched out to 0\.86 m with 1 kg, it sinks by \d\.\d mm in 1 s\.", done.output)
    changed(tmp_path / "weak", ('forcerange="-28 28"', 'forcerange="-3 3"'))
    refused = CliRunner().invoke(app, ["arms", "check", str(tmp_path / "weak")])
    assert isinstance(refused.exception, AssetError)
    assert "its motor gives 3; raise its forcerange" in str(refused.exception)
