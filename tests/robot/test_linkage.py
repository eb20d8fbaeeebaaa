"""Grippers whose fingers hang on closed linkages: shipped, and of users."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

from grasp_bench.errors import AssetError
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.gripper_trial import try_out
from grasp_bench.robot.grippers import load_gripper
from grasp_bench.workshop.linkage_models import LINK, STROKE
from grasp_bench.workshop.own_gripper import Asked, import_gripper


def adaptive() -> Gripper:
    return load_gripper("adaptive-85")


def source(folder: Path, *changes: tuple[str, str]) -> Path:
    """The shipped linkage as a user's file, spoilt."""
    text = adaptive().path.read_text()
    for pattern, new in changes:
        text, count = re.subn(pattern, new, text, flags=re.DOTALL)
        assert count
    path = folder / "mine.xml"
    path.write_text(text)
    return path


def test_measures_of_the_shipped_linkage() -> None:
    gripper = adaptive()
    assert gripper.opening == pytest.approx(0.085, abs=1e-5)
    assert gripper.shape.force_ratio == pytest.approx(1.0, abs=1e-3)
    assert gripper.pad == pytest.approx((0.003, 0.020, 0.024), abs=1e-6)
    assert len(gripper.finger_joints) == 6
    moved = try_out(gripper)
    assert (moved.opened, moved.closed) == pytest.approx((0.085, 0.0), abs=1e-4)


def test_the_loops_are_closed_at_every_opening_and_positions_are_read_back() -> None:
    gripper = adaptive()
    model = mujoco.MjModel.from_xml_path(str(gripper.path))
    data = mujoco.MjData(model)
    addresses = [model.joint(n).qposadr[0] for n in gripper.finger_joints]
    for position in np.linspace(0, gripper.stroke, 12):
        joints = gripper.joints_at(float(position))
        data.qpos[addresses] = joints
        mujoco.mj_forward(model, data)
        loops = data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
        assert np.abs(loops).max() < 1e-4
        np.testing.assert_allclose(gripper.positions(joints), position, atol=1e-5)
        gap = data.geom("left_pad").xpos[0] - data.geom("right_pad").xpos[0] - gripper.pad[0]
        assert gap == pytest.approx(2 * position, abs=1e-4)


def test_a_linkage_of_a_users_file_keeps_its_loops(tmp_path: Path) -> None:
    made = import_gripper(source(tmp_path), tmp_path / "out", Asked())
    assert made.opening == pytest.approx(STROKE + 2 * LINK * np.sin(0.42), abs=1e-3)  # to the joints' ends
    assert "<connect" in made.path.read_text()
    assert made.pads == ("left_pad", "right_pad")


def test_what_a_file_leaves_open_is_coupled_so_that_the_pads_stay_parallel(tmp_path: Path) -> None:
    path = source(tmp_path, (r"<equality>.*</equality>", ""))
    made = import_gripper(path, tmp_path / "out", Asked())
    assert made.opening == pytest.approx(STROKE + 2 * LINK * np.sin(0.42), abs=1e-3)  # to the joints' ends
    assert made.path.read_text().count("<joint joint1=") == 5
    assert try_out(made).closed == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("pattern", "new", "words"),
    [
        (r'<compiler angle="radian"', '<compiler angle="degree"', "say --radian"),
        (r'<joint name="left_finger" class="follower"/>', "", "has 1 bodies on hinges with a geom named pad"),
        (r'range="-0.42 0.42"', 'range="-0.20 0.42"', r"cannot close: its pads stay \d+\.\d mm apart"),
        (r'name="base" gravcomp="1">', 'name="base" gravcomp="1" pos="0.01 0 0">', "not on the z axis"),
    ],
)
def test_a_linkage_that_is_none_is_told_in_one_line(
    tmp_path: Path, pattern: str, new: str, words: str
) -> None:
    with pytest.raises(AssetError, match=words) as caught:
        import_gripper(source(tmp_path, (pattern, new)), tmp_path / "out", Asked())
    assert "\n" not in str(caught.value)


def test_fingers_that_turn_while_they_close_are_refused(tmp_path: Path) -> None:
    folder = tmp_path / "part"
    folder.mkdir()
    path = source(
        tmp_path, (r'<connect name="left_loop"[^>]*/>', ""), (r'<connect name="right_loop"[^>]*/>', "")
    )
    weld = 'polycoef="0 1 0 0 0"'
    extra = "".join(
        f'<joint joint1="{side}_finger" polycoef="0 0 0 0 0"/>' for side in ("left", "right")
    )  # stiff fingers swing with their links
    text = path.read_text().replace("</equality>", f"{extra}</equality>")
    assert weld in text
    (folder / "gripper.xml").write_text(text)
    (folder / "gripper.yaml").write_text((adaptive().folder / "gripper.yaml").read_text())
    with pytest.raises(AssetError, match=r"the pads turn by \d+° while the fingers close|cannot close"):
        _ = load_gripper(str(folder)).shape
