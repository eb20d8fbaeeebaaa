"""Users' own arms and grippers, rewritten as folders."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.errors import AssetError
from grasp_bench.planning.reach import check_reach
from grasp_bench.robot.gripper_trial import try_out
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Robot
from grasp_bench.system.paths import assets_dir
from grasp_bench.workshop.fitting import fit
from grasp_bench.workshop.own_arm import Asked as AskedOfArm
from grasp_bench.workshop.own_arm import import_arm
from grasp_bench.workshop.own_gripper import Asked, import_gripper
from tests.support.real_samples import SAMPLES

REAL = SAMPLES / "robots"
"""Third-party models, where a checkout has them."""
real = pytest.mark.skipif(not REAL.is_dir(), reason="the third-party models are not here")

HAND = """
<mujoco model="hand">
  <compiler angle="degree"/>
  <worldbody>
    <body name="base" euler="0 0 30">
      <geom name="base" type="box" size="0.03 0.06 0.03" pos="0 0 0.03"/>
      <body name="a" pos="0 0 0.06">
        <joint name="ja" type="slide" axis="0 1 0" range="0 0.03" limited="true"/>
        <geom name="a_back" type="box" size="0.01 0.005 0.03" pos="0 0.009 0.03"/>
        <geom name="a_pad" type="box" size="0.01 0.002 0.01" pos="0 0.002 0.05"/>
      </body>
      <body name="b" pos="0 0 0.06">
        <joint name="jb" type="slide" axis="0 1 0" range="-0.03 0" limited="true"/>
        <geom name="b_back" type="box" size="0.01 0.005 0.03" pos="0 -0.009 0.03"/>
        <geom name="b_pad" type="box" size="0.01 0.002 0.01" pos="0 -0.002 0.05"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="push_a" joint="ja" ctrlrange="-10 10"/>
    <motor name="push_b" joint="jb" ctrlrange="-10 10"/>
  </actuator>
</mujoco>
"""


def hand(folder: Path, old: str = "", new: str = "") -> Path:
    assert old in HAND
    path = folder / "hand.xml"
    path.write_text(HAND.replace(old, new) if old else HAND)
    return path


def test_a_hand_is_turned_coupled_and_measured(tmp_path: Path) -> None:
    made = import_gripper(hand(tmp_path), tmp_path / "out", Asked(force=(10, 80), title="mine"))
    assert made.title == "mine"
    assert made.force == (10, 80)
    assert made.opening == pytest.approx(0.06, abs=1e-5)
    assert made.shape.flange_to_tcp == pytest.approx(0.12, abs=1e-6)
    assert made.shape.force_ratio == pytest.approx(2.0)
    assert made.pad[1:] == pytest.approx((0.02, 0.02), abs=1e-5)
    assert made.finger_length == pytest.approx(0.06, abs=1e-5)
    assert try_out(made).opened == pytest.approx(0.06, abs=1e-3)


def test_a_hand_whose_pads_do_not_meet_cannot_close(tmp_path: Path) -> None:
    path = hand(tmp_path, 'pos="0 0.002 0.05"', 'pos="0 0.014 0.05"')
    path.write_text(path.read_text().replace('pos="0 -0.002 0.05"', 'pos="0 -0.014 0.05"'))
    with pytest.raises(
        AssetError, match=r"hand\.xml: this gripper cannot close: its pads stay 24\.0 mm apart"
    ):
        import_gripper(path, tmp_path / "out", Asked())
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            'type="slide" axis="0 1 0" range="0 0.03"',
            'type="hinge" axis="0 1 0" range="0 30"',
            "1 fingers on sl",
        ),
        ('axis="0 1 0"', 'axis="0 0 1"', "must open across z"),
        ("</worldbody>", "</worldbody><include file='x'/>", "uses <include>"),
        (
            '<mujoco model="hand">',
            '<mujoco model="hand"><asset><mesh file="../x.stl"/></asset>',
            "outside of",
        ),
        ("<actuator>", "<actuator><wheel/>", "refused by MuJoCo"),
        ('size="0.03 0.06 0.03"', 'size="30 60 30"', "m large: lengths are metres"),
        ('size="0.03 0.06 0.03"', 'size="nan 0.06 0.03"', "a <geom> whose size is not a number"),
        ('pos="0 0 0.03"/>', 'pos="0 0 0.03" contype="0" conaffinity="0"/>', "the palm"),
    ],
)
def test_what_is_no_hand_is_told_in_one_line(tmp_path: Path, old: str, new: str, words: str) -> None:
    with pytest.raises(AssetError) as caught:
        import_gripper(hand(tmp_path, old, new), tmp_path / "out", Asked())
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_pads_and_fingers_that_are_none(tmp_path: Path) -> None:
    path = hand(tmp_path)
    with pytest.raises(AssetError, match=r"--pads must be one geom of each finger; they have a_back, a_pad"):
        import_gripper(path, tmp_path / "out", Asked(pads=("a_pad", "a_back")))
    with pytest.raises(AssetError, match="--fingers names 'a' twice"):
        import_gripper(path, tmp_path / "out", Asked(fingers=("a", "a")))
    with pytest.raises(AssetError, match="has no body \\(finger\\) 'thumb'; it has base, a, b"):
        import_gripper(path, tmp_path / "out", Asked(fingers=("thumb", "a")))
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "x").touch()
    with pytest.raises(AssetError, match="is not empty"):
        import_gripper(path, tmp_path / "full", Asked())


def test_an_arm_keeps_its_kinematics_and_gets_postures(tmp_path: Path) -> None:
    source = assets_dir() / "arms" / "panda" / "arm.xml"
    made = import_arm(source, tmp_path / "out", AskedOfArm(flange="flange"))
    shipped, own = (mujoco.MjModel.from_xml_path(str(p)) for p in (source, made.path))
    rng = np.random.default_rng(0)
    for _ in range(5):
        q = rng.uniform(shipped.jnt_range[:, 0], shipped.jnt_range[:, 1])
        places = []
        for model, site in ((shipped, "flange"), (own, made.flange)):
            data = mujoco.MjData(model)
            data.qpos[:] = q
            mujoco.mj_kinematics(model, data)
            places.append(data.site(site).xpos.copy())
        np.testing.assert_allclose(*places, atol=1e-6)
    assert made.torque_limits == (87, 87, 87, 87, 12, 12, 12)
    np.testing.assert_allclose(own.body_mass.sum(), shipped.body_mass.sum(), rtol=1e-6)
    table4 = load_scenario("table4")
    check_reach(table4.model_copy(update={"robot": Robot(arm=str(tmp_path / "out"))}))


def test_an_arm_without_limits_is_told(tmp_path: Path) -> None:
    text = (assets_dir() / "arms" / "ur5e" / "arm.xml").read_text()
    path = tmp_path / "arm.xml"
    path.write_text(text.replace('forcerange="-28 28"', ""))
    with pytest.raises(AssetError, match="no greatest torque of joint 'joint4' is in the file; say --torque"):
        import_arm(path, tmp_path / "out", AskedOfArm(flange="flange"))
    path.write_text(text.replace(' range="-6.283185307179586 6.283185307179586"', ""))
    with pytest.raises(AssetError, match="joint 'joint1' has no range"):
        import_arm(path, tmp_path / "out", AskedOfArm(flange="flange"))
    path.write_text(text)
    with pytest.raises(AssetError, match=r"\(flange\) 'tool0'; it has flange"):
        import_arm(path, tmp_path / "out", AskedOfArm(flange="tool0"))
    with pytest.raises(AssetError, match="--velocity must be one positive number for all joints or 6"):
        import_arm(path, tmp_path / "out", AskedOfArm(flange="flange", velocity=(1.0, 2.0)))
    with pytest.raises(AssetError, match="--velocity must be one positive number"):
        import_arm(path, tmp_path / "out", AskedOfArm(flange="flange", velocity=(float("nan"),)))
    with pytest.raises(AssetError, match="--home must be 6 angles in degrees"):
        import_arm(path, tmp_path / "out", AskedOfArm(flange="flange", home=(0.0,)))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('childclass="arm" quat="0 0 0 1"', 'childclass="arm" quat="1 1 0 0"', "about the vertical"),
        ('childclass="arm" quat="0 0 0 1"', 'childclass="arm" pos="0.5 0 0"', "through \\(0.500, 0.000\\)"),
        ('pos="-0.425 0 0"', 'pos="-0.1 0 0"', "whose joints are 0.89 m from first to last"),
        ('pos="-0.425 0 0"', 'pos="-425 0 0"', "lengths are metres"),
    ],
)
def test_an_arm_that_does_not_stand_or_reach_is_told(tmp_path: Path, old: str, new: str, words: str) -> None:
    text = (assets_dir() / "arms" / "ur5e" / "arm.xml").read_text()
    assert old in text
    path = tmp_path / "arm.xml"
    path.write_text(text.replace(old, new))
    with pytest.raises(AssetError, match=words):
        import_arm(path, tmp_path / "out", AskedOfArm(flange="flange"))
    assert not (tmp_path / "out").exists()


@real
@pytest.mark.parametrize("name", ["panda", "xarm7"])
def test_real_arms_reach_the_table(tmp_path: Path, name: str) -> None:
    import_arm(REAL / "robots" / name / "robot.xml", tmp_path / "out", AskedOfArm())
    table4 = load_scenario("table4")
    check_reach(table4.model_copy(update={"robot": Robot(arm=str(tmp_path / "out"))}))


@real
def test_a_real_gripper_holds(tmp_path: Path) -> None:
    from grasp_bench.objects.catalog import Catalog

    made = import_gripper(REAL / "grippers" / "panda_gripper.xml", tmp_path / "out", Asked())
    assert made.opening == pytest.approx(0.079, abs=1e-3)
    assert any(p["grasps"] for p in fit(Catalog().load("lemon"), made))


@real
def test_a_real_linkage_opens_and_closes(tmp_path: Path) -> None:
    source = REAL / "grippers" / "robotiq_gripper_140.xml"
    made = import_gripper(source, tmp_path / "out", Asked(radian=True))
    assert made.opening == pytest.approx(0.126, abs=2e-3)
    assert try_out(made).closed == pytest.approx(0.0, abs=1e-3)


@real
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("xarm7_gripper", "refused by MuJoCo"),
        ("robotiq_gripper_85", "which is not in"),
        ("robotiq_gripper_140", "say --radian"),
    ],
)
def test_real_grippers_that_cannot_be_read_say_why(tmp_path: Path, name: str, words: str) -> None:
    with pytest.raises(AssetError, match=words):
        import_gripper(REAL / "grippers" / f"{name}.xml", tmp_path / "out", Asked())


@pytest.mark.parametrize(
    ("name", "limit"), [("my-hand", {"closing_speed": 0.05}), ("suction-20", {"force": 18.8495})]
)
def test_check_prints_a_scenario_that_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, limit: dict[str, float]
) -> None:
    monkeypatch.chdir(tmp_path)
    import_gripper(hand(tmp_path), tmp_path / "my-hand", Asked(speed=0.05))
    done = CliRunner().invoke(app, ["grippers", "check", name])
    assert done.exit_code == 0
    scenario = tmp_path / "mine.yaml"
    scenario.write_text("extends: table4\n" + done.output.split("extends: table4\n")[1])
    read = load_scenario(str(scenario))
    assert Path(read.robot.gripper).name == name
    assert {k: getattr(read.gripper, k) for k in limit} == limit
