"""isaac_grasp files: what is written is read again, and what is none is one clear error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from grasp_bench.errors import AssetError
from grasp_bench.grasps import GraspPose
from grasp_bench.objects.isaac_grasp import read_isaac_grasps, write_isaac_grasps
from grasp_bench.robot.parallel_85 import PARALLEL_85

TURN = Rotation.from_euler("xyz", [0.3, -1.2, 2.0]).as_matrix()
GRASPS = [
    GraspPose(np.array([0.01, -0.02, 0.03]), TURN, 0.05, 0.4),
    GraspPose(np.array([0.0, 0.1, 0.0]), np.eye(3), 0.08, 0.9),
]
EXAMPLE = """
format: isaac_grasp
format_version: 1.0
object_frame: /World/box
gripper_frame: /World/hand
grasps:
  "a":
    confidence: 0.5
    position: [0.0, 0.0, -0.2]
    orientation: {w: 1.0, xyz: [0.0, 0.0, 0.0]}
    cspace_position: {left: 0.01}
    pregrasp_cspace_position: {left: 0.04}
"""


def test_what_is_written_is_read_again_best_first(tmp_path: Path) -> None:
    path = tmp_path / "grasps.yaml"
    write_isaac_grasps(path, GRASPS, PARALLEL_85, "thing")
    read = read_isaac_grasps(path, PARALLEL_85)
    assert [g.quality for g in read] == [0.9, 0.4]
    for wrote, got in zip(reversed(GRASPS), read, strict=True):
        np.testing.assert_allclose(got.position, wrote.position, atol=1e-8)
        np.testing.assert_allclose(got.rotation, wrote.rotation, atol=1e-8)
        assert got.opening == pytest.approx(wrote.opening, abs=1e-8)
    content = yaml.safe_load(path.read_text())
    assert (content["format"], content["format_version"]) == ("isaac_grasp", 1.0)
    first = content["grasps"]["grasp_0"]
    flange = GRASPS[0].position - PARALLEL_85.flange_to_tcp * TURN[:, 2]
    np.testing.assert_allclose(first["position"], flange, atol=1e-8)
    assert first["pregrasp_cspace_position"]["left_finger_joint"] == pytest.approx(0.025)


def test_a_file_of_another_gripper_opens_wide_and_may_have_its_jaws_along_y(tmp_path: Path) -> None:
    path = tmp_path / "hand.yaml"
    path.write_text(EXAMPLE)
    (pose,) = read_isaac_grasps(path, PARALLEL_85, jaws="y")
    assert pose.opening == PARALLEL_85.opening
    np.testing.assert_allclose(pose.rotation[:, 0], [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(pose.position, [0, 0, PARALLEL_85.flange_to_tcp - 0.2], atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("isaac_grasp", "other", "no isaac_grasp file"),
        ("1.0\nobject", "2.0\nobject", "version 2.0 is not known"),
        ("[0.0, 0.0, -0.2]", "[0.0, 0.0]", "must have position"),
        ("[0.0, 0.0, -0.2]", "[0.0, 0.0, .nan]", "must have position"),
        ("[0.0, 0.0, -0.2]", "here", "must have position"),
        ("w: 1.0", "w: 3.0", "orientation of length 3"),
        ("grasps:", "no_grasps:", "'grasps' must hold"),
        ("format:", "{format:", "cannot be read"),
    ],
)
def test_what_is_none_is_one_clear_error(tmp_path: Path, old: str, new: str, why: str) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(EXAMPLE.replace(old, new, 1))
    with pytest.raises(AssetError, match=why) as error:
        read_isaac_grasps(path, PARALLEL_85)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)
