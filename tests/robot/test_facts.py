"""The facts of arms and grippers are those of their models."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from grasp_bench.errors import ScenarioError
from grasp_bench.robot.arm import Arm, load_arm
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.ec66 import EC66
from grasp_bench.robot.facts import shipped
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.grippers import load_gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.robot.robot import EC66_PARALLEL_85
from grasp_bench.scenario.reading import parse_scenario
from grasp_bench.scenario.sections import Scenario
from grasp_bench.workshop import gripper_meshes

ARMS = [load_arm(n) for n in shipped("arm")]
JAWS = [g for n in shipped("gripper") if not isinstance(g := load_gripper(n), SuctionCup)]
GRIPPERS = [g for g in JAWS if g.shape.linkage is None]
"""Grippers of two slides; those of hinges are in test_linkage.py, cups in test_cup.py."""
GROUP = 3
"""Geoms that collide."""


def compiled(part: Arm | Gripper) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The part alone, joints at 0."""
    model = mujoco.MjModel.from_xml_path(str(part.path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def box_of(model: mujoco.MjModel, data: mujoco.MjData, *geoms: str | int) -> np.ndarray:
    """Lower and upper corner (2, 3) of boxes that stand square in the world [m]."""
    ids = [model.geom(g).id for g in geoms]
    half = np.array([np.abs(data.geom_xmat[i].reshape(3, 3)) @ model.geom_size[i] for i in ids])
    places = data.geom_xpos[ids]
    return np.array([(places - half).min(0), (places + half).max(0)])


def solid(model: mujoco.MjModel, body: str) -> list[int]:
    """Colliding geoms of a body."""
    first, count = model.body(body).geomadr[0], model.body(body).geomnum[0]
    return [g for g in range(first, first + count) if model.geom_group[g] == GROUP]


# ---------------------------------------------------------------- arms


@pytest.mark.parametrize("arm", ARMS, ids=lambda a: a.name)
def test_joints_and_limits_of_an_arm(arm: Arm) -> None:
    model, _ = compiled(arm)
    names = list(arm.joints)
    assert [model.joint(i).name for i in range(model.njnt)] == names
    assert [model.actuator(i).name for i in range(model.nu)] == names
    np.testing.assert_array_equal(model.actuator_trnid[:, 0], range(len(names)))
    np.testing.assert_allclose(model.jnt_range, arm.position_limits, atol=1e-12)
    np.testing.assert_allclose(model.actuator_ctrlrange, arm.position_limits, atol=1e-12)
    np.testing.assert_array_equal(model.actuator_forcerange, np.array([[-v, v] for v in arm.torque_limits]))
    assert len(arm.velocity_limits) == len(names)
    assert min(arm.velocity_limits) > 0
    assert (model.dof_armature > 0).all()
    assert (model.dof_damping > 0).all()


@pytest.mark.parametrize("arm", ARMS, ids=lambda a: a.name)
def test_postures_of_an_arm(arm: Arm) -> None:
    model, data = compiled(arm)
    for key in range(model.nkey):  # where a file has a keyframe for viewers, it is home
        np.testing.assert_allclose(model.key(key).qpos, arm.home, atol=1e-12)
        np.testing.assert_allclose(model.key(key).ctrl, arm.home, atol=1e-12)
    for posture in (arm.home, arm.ready):
        assert all(low < q < high for q, (low, high) in zip(posture, arm.position_limits, strict=True))
        data.qpos[:] = posture
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.site(arm.flange).xmat.reshape(3, 3)[:, 2], [0, 0, -1], atol=1e-9)


@pytest.mark.parametrize("arm", ARMS, ids=lambda a: a.name)
def test_the_arms_plane_passes_the_base_at_the_shoulders_offset(arm: Arm) -> None:
    """The flange, tool down and arm stretched forwards, lies that much beside the base's axis."""
    model, data = compiled(arm)
    data.qpos[:] = arm.ready
    mujoco.mj_forward(model, data)
    assert arm.ready[0] == 0
    assert data.site(arm.flange).xpos[1] == pytest.approx(arm.shape.shoulder, abs=1e-6)


def test_measures_of_the_ec66_are_those_with_which_the_benchmark_was_defined() -> None:
    assert EC66.shape.shoulder == 0.122
    assert EC66.shape.turn == EC66.shape.wrist == 1
    assert EC66.torque_limits == (150.0, 150.0, 150.0, 28.0, 28.0, 28.0)


def test_measures_of_parallel_85_are_those_with_which_the_benchmark_was_defined() -> None:
    """To the bit: records depend on them."""
    shape = PARALLEL_85.shape
    assert (shape.stroke, shape.finger_thickness, shape.finger_width) == (0.0425, 0.008, 0.020)
    assert (shape.finger_length, shape.flange_to_tcp, shape.force_ratio) == (0.065, 0.165, 2.0)
    assert (shape.pad, shape.palm) == ((0.003, 0.020, 0.024), (0.132, 0.050))
    anywhere = np.random.default_rng(0).uniform(-0.03, 0.0425, 1000)
    np.testing.assert_array_equal(PARALLEL_85.command(anywhere), anywhere)
    assert PARALLEL_85.joints_at(0.0123).tolist() == [0.0123, 0.0123]


def test_velocity_limits_of_the_ec66_are_those_of_the_makers_urdf() -> None:
    np.testing.assert_allclose(EC66.velocity_limits, [2.6199] * 2 + [3.3161] + [4.5379] * 3, atol=3e-3)


# ---------------------------------------------------------------- grippers


@pytest.mark.parametrize("gripper", GRIPPERS, ids=lambda g: g.name)
def test_fingers_travel_by_the_stroke(gripper: Gripper) -> None:
    model, data = compiled(gripper)
    assert [model.joint(i).name for i in range(model.njnt)] == list(gripper.finger_joints)
    np.testing.assert_allclose(model.jnt_range, [[0, gripper.stroke]] * 2, atol=1e-9)
    for joint, finger in zip(gripper.finger_joints, gripper.fingers, strict=True):
        assert model.body(model.jnt_bodyid[model.joint(joint).id]).name == finger
    closed = [box_of(model, data, pad) for pad in gripper.pads]
    assert closed[0][0, 0] == pytest.approx(0, abs=1e-9)  # the left pad, on the positive side
    assert closed[1][1, 0] == pytest.approx(0, abs=1e-9)
    data.qpos[:] = gripper.stroke
    mujoco.mj_forward(model, data)
    left, right = (box_of(model, data, pad) for pad in gripper.pads)
    assert left[0, 0] - right[1, 0] == pytest.approx(gripper.opening, abs=1e-9)


@pytest.mark.parametrize("gripper", GRIPPERS, ids=lambda g: g.name)
def test_shape_of_fingers_pads_and_hand(gripper: Gripper) -> None:
    model, data = compiled(gripper)
    tcp = data.site(gripper.tcp)
    np.testing.assert_allclose(tcp.xpos, [0, 0, gripper.flange_to_tcp], atol=1e-9)
    np.testing.assert_allclose(tcp.xmat, np.eye(3).ravel(), atol=1e-9)
    hand = solid(model, gripper.palm_body)
    underside = box_of(model, data, *hand)[1, 2]
    assert tcp.xpos[2] - underside == pytest.approx(gripper.finger_length, abs=1e-9)
    palm = box_of(model, data, *(g for g in hand if box_of(model, data, g)[1, 2] > underside - 1e-9))
    np.testing.assert_allclose(np.ptp(palm, axis=0)[:2], gripper.palm, atol=1e-9)
    for pad, finger in zip(gripper.pads, gripper.fingers, strict=True):
        assert model.body(model.geom_bodyid[model.geom(pad).id]).name == finger
        box = box_of(model, data, pad)
        np.testing.assert_allclose(np.ptp(box, axis=0), gripper.pad, atol=1e-9)
        assert box[1, 2] == pytest.approx(tcp.xpos[2], abs=1e-9)
        whole = box_of(model, data, *solid(model, finger))
        assert np.ptp(whole, axis=0)[1] == pytest.approx(gripper.finger_width, abs=1e-9)
        assert whole[1, 2] == pytest.approx(tcp.xpos[2], abs=1e-9)  # nothing is below the tips
        beside = [g for g in solid(model, finger) if box_of(model, data, g)[1, 2] > box[0, 2] + 1e-9]
        assert np.ptp(box_of(model, data, *beside), axis=0)[0] == pytest.approx(gripper.finger_thickness)
    assert set(np.nonzero(model.geom_priority > 0)[0]) == {model.geom(pad).id for pad in gripper.pads}


@pytest.mark.parametrize("gripper", GRIPPERS, ids=lambda g: g.name)
def test_the_actuator_gives_each_pad_its_force(gripper: Gripper) -> None:
    model, data = compiled(gripper)
    assert [model.actuator(i).name for i in range(model.nu)] == [gripper.actuator]
    assert model.actuator_ctrlrange[0, 0] <= gripper.command(-gripper.squeeze)
    assert model.actuator_ctrlrange[0, 1] >= gripper.command(gripper.stroke)
    np.testing.assert_array_equal(gripper.actuator_range(1.0), [-gripper.force_ratio, gripper.force_ratio])
    data.actuator_force[0] = 1.0
    fingers = np.zeros(model.nv)
    mujoco.mju_mulMatTVec(fingers, data.actuator_moment.reshape(model.nu, model.nv), np.ones(1))
    np.testing.assert_allclose(fingers, 1 / gripper.force_ratio)  # a newton of it, shared by the fingers
    assert gripper.shape.strongest > gripper.force[1]  # squeezing reaches the greatest force


@pytest.mark.parametrize("gripper", JAWS, ids=lambda g: g.name)
def test_what_a_scenario_may_ask_of_the_gripper_is_what_it_can(gripper: Gripper) -> None:
    def asked(key: str, value: float) -> Scenario:
        content = {
            "name": "x",
            "robot": {"gripper": gripper.name},
            "gripper": {"closing_speed": 0.05, key: value},
        }
        return parse_scenario(content, "x.yaml")

    for key, least, most in (
        ("force", *gripper.force),
        ("closing_speed", None, gripper.speed),
        ("squeeze", None, gripper.squeeze),
    ):
        asked(key, most)
        with pytest.raises(ScenarioError, match=f"gripper.{key}: .*less than or equal to"):
            asked(key, math.nextafter(most, math.inf))
        if least is not None:
            asked(key, least)
            with pytest.raises(ScenarioError, match="greater than or equal"):
                asked(key, math.nextafter(least, 0))


def test_the_drawn_hand_has_the_palm() -> None:
    housing = gripper_meshes.housing()["body"]
    under = housing.vertices[np.isclose(housing.vertices[:, 2], gripper_meshes.PALM)]
    np.testing.assert_allclose(np.ptp(under[:, :2], axis=0), 1000 * np.array(PARALLEL_85.palm), atol=5)
    drawn = gripper_meshes.finger()
    assert drawn["steel"].bounds[1][2] == pytest.approx(1000 * PARALLEL_85.finger_length)
    assert drawn["steel"].bounds[1][0] >= 1000 * PARALLEL_85.finger_thickness


# ---------------------------------------------------------------- robots


def test_a_robots_files_are_its_parts_and_their_meshes() -> None:
    files = EC66_PARALLEL_85.files
    assert {EC66.path, PARALLEL_85.path} <= set(files)
    meshes = [f.name for f in files if f.parent == EC66.path.parent / "meshes"]
    assert "gripper_body.stl" in meshes
    assert "link1_body.stl" in meshes
