"""Arms that come as URDF, and models of MuJoCo Menagerie by name."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from grasp_bench.errors import AssetError
from grasp_bench.robot.arm import load_arm
from grasp_bench.scene.builder import stl_bytes
from grasp_bench.system.paths import assets_dir
from grasp_bench.workshop.menagerie import model_of
from grasp_bench.workshop.own_arm import Asked, import_arm

DH = ((0.1625, 0, 90), (0, -0.425, 0), (0, -0.3922, 0), (0.1333, 0, 90), (0.0997, 0, -90), (0.0996, 0, 0))
"""d, a [m] and alpha [°] of the UR5e, from its maker."""
MESH = "package://my_arm_description/meshes/collision/box.stl"
ASKED = Asked(flange="tool0")


def urdf(mesh: str = MESH, limit: str = '<limit lower="-6.2" upper="6.2" effort="100" velocity="3"/>') -> str:
    """An arm with the UR5e's kinematics, one mesh at every link, and drawings that MuJoCo cannot read."""
    drawing = '<geometry><mesh filename="package://my_arm_description/meshes/visual/link.dae"/></geometry>'
    shape = f'<geometry><mesh filename="{mesh}"/></geometry>'
    inertia = '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/>'
    links, joints = ['<link name="base_link"/>'], []
    origin, rpy = (0.0, 0.0, 0.0), 0.0
    for i, (d, a, alpha) in enumerate(DH, 1):
        links.append(
            f'<link name="link{i}"><inertial><mass value="2"/>{inertia}</inertial>'
            f"<visual>{drawing}</visual><collision>{shape}</collision></link>"
        )
        parent = f"link{i - 1}" if i > 1 else "base_link"
        joints.append(
            f'<joint name="joint{i}" type="revolute"><parent link="{parent}"/><child link="link{i}"/>'
            f'<origin xyz="{origin[0]} {origin[1]} {origin[2]}" rpy="{rpy} 0 0"/><axis xyz="0 0 1"/>{limit}'
            "</joint>"
        )
        origin, rpy = (a, 0.0, d), math.radians(alpha)
    links.append('<link name="tool0"/>')
    joints.append(
        '<joint name="flange" type="fixed"><parent link="link6"/><child link="tool0"/>'
        f'<origin xyz="{origin[0]} 0 {origin[2]}"/></joint>'
    )
    return f'<robot name="my_arm">{"".join(links + joints)}</robot>'


def package(folder: Path, text: str, sub: str = "urdf") -> Path:
    """A ROS package with a URDF and its mesh, as a workspace has it."""
    root = folder / "my_arm_description"
    (root / sub).mkdir(parents=True)
    (root / "meshes" / "collision").mkdir(parents=True)
    (root / "package.xml").write_text("<package/>")
    corners = 0.02 * np.array([[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]], float)
    (root / "meshes" / "collision" / "box.stl").write_bytes(
        stl_bytes(corners, np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
    )
    path = root / sub / "arm.urdf"
    path.write_text(text)
    return path


def test_a_urdf_with_meshes_of_its_package_keeps_its_kinematics(tmp_path: Path) -> None:
    made = import_arm(package(tmp_path, urdf()), tmp_path / "out", ASKED)
    assert made.torque_limits == (100,) * 6
    assert sorted(p.suffix for p in (tmp_path / "out" / "meshes").iterdir()) == [".stl"]
    own = mujoco.MjModel.from_xml_path(str(made.path))
    shipped = load_arm("ur5e")
    theirs = mujoco.MjModel.from_xml_path(str(shipped.path))
    for q in np.random.default_rng(0).uniform(-2, 2, (5, 6)):
        places = []
        for model, site in ((own, made.flange), (theirs, shipped.flange)):
            data = mujoco.MjData(model)
            data.qpos[:] = q
            mujoco.mj_kinematics(model, data)
            places.append(float(np.linalg.norm(data.site(site).xpos - [0, 0, 0.1625])))
        # Where x points is each file's own affair: reach about the shoulder is not.
        np.testing.assert_allclose(places[0], places[1], atol=1e-5)


def test_a_mesh_in_the_folder_beside_the_urdf(tmp_path: Path) -> None:
    path = package(tmp_path, urdf("my_arm_description/meshes/collision/box.stl"))
    flat = tmp_path / "arm.urdf"
    path.rename(flat)
    assert import_arm(flat, tmp_path / "out", ASKED).joints[0] == "joint1"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (urdf("package://my_arm_description/meshes/none.stl"), "which is not there; it was looked for as"),
        (urdf("package://my_arm_description/../../outside.stl"), "which lies outside of"),
        (urdf("../../outside.stl"), "which lies outside of"),
        (urdf("package://my_arm_description/meshes/collision/box.dae"), "no STL, OBJ or MSH file"),
        (urdf(limit='<limit effort="100" velocity="3"/>'), "joint 'joint1' has no range"),
        (urdf(limit='<limit lower="-6" upper="6" velocity="3"/>'), "no greatest torque of joint 'joint1'"),
        (urdf().replace(' name="my_arm"', ' xmlns:xacro="http://w/xacro"><xacro:arg/'), "xacro"),
        (urdf().replace('<child link="link6"/>', '<child link="link9"/>'), "refused by MuJoCo"),
        (urdf().replace("</robot>", '<mujoco><compiler meshdir="/etc"/></mujoco></robot>'), ""),
    ],
)
def test_a_urdf_that_is_none_is_told_in_one_line(tmp_path: Path, text: str, words: str) -> None:
    path = package(tmp_path, text)
    (tmp_path / "outside.stl").write_bytes(b"no")
    if not words:  # its own compiler is not listened to
        assert import_arm(path, tmp_path / "out", ASKED).joints
        return
    with pytest.raises(AssetError) as caught:
        import_arm(path, tmp_path / "out", ASKED)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_joints_that_turn_without_end_are_given_a_range(tmp_path: Path) -> None:
    text = urdf(limit='<limit effort="100" velocity="3"/>').replace('"revolute"', '"continuous"')
    asked = Asked(flange="tool0", endless=180.0)
    made = import_arm(package(tmp_path, text), tmp_path / "out", asked)
    np.testing.assert_allclose(np.degrees(made.shape.position_limits), [[-180, 180]] * 6, atol=1e-3)


# ---------------------------------------------------------------- menagerie


def test_without_its_package_menagerie_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco_menagerie", None)
    with pytest.raises(AssetError, match=r"pip install 'grasp-bench\[menagerie\]'"):
        model_of(Path("menagerie:universal_robots_ur5e"))
    assert model_of(Path("arm.xml")) == Path("arm.xml")


def test_a_model_is_taken_from_a_folder_laid_out_like_menageries_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    menagerie = pytest.importorskip("mujoco_menagerie")
    monkeypatch.setenv("MENAGERIE_CACHE_DIR", str(tmp_path / "cache"))
    robot = menagerie.get("universal_robots_ur5e")
    folder = tmp_path / "cache" / "models" / f"{robot.name}-{robot.oid[:16]}"
    folder.mkdir(parents=True)
    text = (assets_dir() / "arms" / "ur5e" / "arm.xml").read_text()
    assert 'name="flange"' in text
    (folder / "ur5e.xml").write_text(text.replace('name="flange"', 'name="attachment_site"'))
    (folder / ".complete").write_text("{}")
    made = import_arm(Path("menagerie:universal_robots_ur5e"), tmp_path / "out", Asked())
    assert made.title == "ur5e"
    np.testing.assert_allclose(made.torque_limits, load_arm("ur5e").torque_limits)


def test_what_menagerie_does_not_have_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    class MenagerieError(Exception):
        pass

    def get(name: str) -> None:
        raise MenagerieError(f"Unknown robot {name!r}.\nDid you mean 'universal_robots_ur5e'?")

    monkeypatch.setitem(
        sys.modules, "mujoco_menagerie", SimpleNamespace(get=get, MenagerieError=MenagerieError)
    )
    with pytest.raises(AssetError, match=r"menagerie:ur5: Unknown robot 'ur5'\. Did you mean"):
        model_of(Path("menagerie:ur5"))
