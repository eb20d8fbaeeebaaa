"""The EC66 and its gripper: kinematics, limits, masses, holding, gripping, meshes."""

from __future__ import annotations

import itertools
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
from dm_control import mjcf
from scipy.spatial.transform import Rotation

from grasp_bench.robot.ec66 import EC66
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.system.paths import assets_dir
from grasp_bench.workshop.arm_meshes import arm_meshes, write_meshes

ASSETS = assets_dir() / "ec66"
LINKS = ("base_link", "link1", "link2", "link3", "link4", "link5", "link6")
TCP = "gripper/tcp"

# Modified (Craig) DH as published for the EC66: alpha_{i-1} (deg), a_{i-1} (m), d_i (m), offset_i (deg).
MODIFIED_DH = (
    (0, 0, 0.096, 180),
    (90, 0, 0, 180),
    (0, 0.418, 0, 0),
    (0, 0.398, 0.122, 0),
    (-90, 0, 0.098, 180),
    (90, 0, 0.089, 180),
)

# Pairs that the maker's SRDF leaves unchecked.
EXCLUDED = {
    ("base_link", "link1"),
    ("base_link", "link2"),
    ("link1", "link2"),
    ("link1", "link4"),
    ("link2", "link3"),
    ("link3", "link4"),
    ("link3", "link5"),
    ("link4", "link5"),
    ("link4", "link6"),
    ("link5", "link6"),
}


def attached(payload: float = 0.0) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Arm with gripper, as the scene builder joins them; ``payload`` kg held at the TCP."""
    arm = mjcf.from_path(str(ASSETS / "ec66.xml"))
    gripper = mjcf.from_path(str(ASSETS / "gripper.xml"))
    if payload:
        load = gripper.find("body", "gripper").add("body", name="load", pos=[0, 0, PARALLEL_85.flange_to_tcp])
        load.add("geom", type="sphere", size=[0.01], mass=payload, contype=0, conaffinity=0)
    arm.find("site", "flange").attach(gripper)
    physics = mjcf.Physics.from_mjcf_model(arm)
    return physics.model.ptr, physics.data.ptr


def gripping(pad_force: float = 60.0) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Gripper pointing down, closing at 75 mm/s per finger on a free 200 g box 40 mm wide."""
    root = mjcf.from_path(str(ASSETS / "gripper.xml"))
    root.find("actuator", "gripper").forcerange = [-2 * pad_force, 2 * pad_force]
    box = root.worldbody.add("body", name="box", pos=[0, 0, 0.153])
    box.add("freejoint")
    box.add("geom", name="box", type="box", size=[0.02, 0.03, 0.03], mass=0.2)
    physics = mjcf.Physics.from_mjcf_model(root)
    model, data = physics.model.ptr, physics.data.ptr
    model.opt.gravity[:] = 0
    data.qpos[:2] = data.ctrl[:] = PARALLEL_85.stroke
    for step in range(700):
        data.ctrl[0] = max(PARALLEL_85.stroke - 0.075 * step * model.opt.timestep, 0.0)
        if step == 300:
            model.opt.gravity[:] = 0, 0, 9.81
        mujoco.mj_step(model, data)
    return model, data


def pad_forces(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, float]:
    """Sum up the normal force (N) on each pad."""
    sums = {"left_pad": 0.0, "right_pad": 0.0}
    for i, contact in enumerate(data.contact):
        force = np.zeros(6)
        mujoco.mj_contactForce(model, data, i, force)
        for geom in (contact.geom1, contact.geom2):
            if (name := model.geom(geom).name) in sums:
                sums[name] += force[0]
    return sums


def world_points(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Mesh vertices and corners of the primitives' boxes, in the world."""
    clouds = []
    for i in range(model.ngeom):
        if model.geom_type[i] == mujoco.mjtGeom.mjGEOM_MESH:
            mesh = model.mesh(model.geom_dataid[i])
            start = mesh.vertadr[0]
            points = model.mesh_vert[start : start + mesh.vertnum[0]]
        else:
            corners = np.array(list(itertools.product((-1, 1), repeat=3)))
            points = model.geom_aabb[i, :3] + corners * model.geom_aabb[i, 3:]
        clouds.append(points @ data.geom_xmat[i].reshape(3, 3).T + data.geom_xpos[i])
    return np.vstack(clouds)


def modified_dh(q: np.ndarray) -> np.ndarray:
    """Flange poses (N, 4, 4) of joint vectors (N, 6), from the DH table alone."""
    pose = np.eye(4)
    for (alpha, a, d, offset), angle in zip(MODIFIED_DH, q.T, strict=True):
        before, after = np.eye(4), np.tile(np.eye(4), (len(q), 1, 1))
        before[:3, :3] = Rotation.from_euler("x", alpha, degrees=True).as_matrix()
        before[0, 3] = a
        after[:, :3, :3] = Rotation.from_rotvec(np.outer(angle + np.radians(offset), [0, 0, 1])).as_matrix()
        after[:, 2, 3] = d
        pose = pose @ before @ after
    return pose


@pytest.fixture(scope="module")
def arm() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(ASSETS / "ec66.xml"))


@pytest.fixture(scope="module")
def hand() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(ASSETS / "gripper.xml"))


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return {path.name: path for path in write_meshes(tmp_path_factory.mktemp("meshes"))}


# ---------------------------------------------------------------- arm


def test_forward_kinematics_equals_published_dh(arm: mujoco.MjModel) -> None:
    data = mujoco.MjData(arm)
    flange = data.site("flange")
    q = np.random.default_rng(66).uniform(-np.pi, np.pi, (1000, 6))
    got = np.tile(np.eye(4), (len(q), 1, 1))
    for pose, data.qpos[:] in zip(got, q, strict=True):
        mujoco.mj_kinematics(arm, data)
        pose[:3, :3], pose[:3, 3] = flange.xmat.reshape(3, 3), flange.xpos
    want = modified_dh(q)
    turn = Rotation.from_matrix(want[:, :3, :3]).inv() * Rotation.from_matrix(got[:, :3, :3])
    assert np.linalg.norm(got[:, :3, 3] - want[:, :3, 3], axis=1).max() < 1e-5
    assert np.degrees(turn.magnitude()).max() < 1e-3


def test_masses_and_inertias_are_physical(arm: mujoco.MjModel, hand: mujoco.MjModel) -> None:
    assert arm.body_mass.sum() == pytest.approx(17.5, abs=1e-3)
    assert hand.body_mass.sum() == pytest.approx(1.0, abs=0.05)
    for model in (arm, hand):
        assert (model.body_gravcomp[1:] == 1).all()
        largest = np.sort(model.body_inertia[1:], axis=1)
        assert (largest[:, 0] > 0).all()
        assert (largest[:, 0] + largest[:, 1] >= largest[:, 2]).all()


@pytest.mark.parametrize("name", ["ec66", "gripper"])
def test_solver_options(name: str) -> None:
    option = mujoco.MjModel.from_xml_path(str(ASSETS / f"{name}.xml")).opt
    assert (option.timestep, option.impratio, option.noslip_iterations) == (0.002, 10, 3)
    assert option.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert option.solver == mujoco.mjtSolver.mjSOL_NEWTON
    assert option.jacobian == mujoco.mjtJacobian.mjJAC_DENSE
    assert option.cone == mujoco.mjtCone.mjCONE_ELLIPTIC


def test_only_the_srdf_pairs_never_collide(arm: mujoco.MjModel) -> None:
    bodies = [(signature >> 16, signature & 0xFFFF) for signature in arm.exclude_signature]
    assert {tuple(arm.body(b).name for b in sorted(pair)) for pair in bodies} == EXCLUDED
    for link in LINKS:
        first, count = arm.body(link).geomadr[0], arm.body(link).geomnum[0]
        solid = [g for g in range(first, first + count) if arm.geom_contype[g] and arm.geom_conaffinity[g]]
        assert solid
        assert all(arm.geom_group[g] == 3 for g in solid)
        assert all(arm.geom_type[g] != mujoco.mjtGeom.mjGEOM_MESH for g in solid)


def test_folding_the_forearm_onto_the_shoulder_collides(arm: mujoco.MjModel) -> None:
    data = mujoco.MjData(arm)
    data.qpos[:] = np.radians([0, -90, 158, 0, 0, 0])
    mujoco.mj_forward(arm, data)
    touching = {
        tuple(sorted(arm.body(arm.geom_bodyid[g]).name for g in contact.geom)) for contact in data.contact
    }
    assert touching
    assert not touching & EXCLUDED


def test_home_keeps_arm_and_gripper_out_of_the_camera_view() -> None:
    model, data = attached()
    data.qpos[:6] = EC66.home
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    for opening in (0.0, PARALLEL_85.stroke):
        data.qpos[6:] = opening
        mujoco.mj_kinematics(model, data)
        points = world_points(model, data)
        # Camera at (0.5, 0, 0.55) looking straight down, 90 degrees along y and 74 along x.
        depth = 0.55 - points[:, 2]
        beside = np.maximum(
            np.abs(points[:, 0] - 0.5) - depth * np.tan(np.radians(37)), np.abs(points[:, 1]) - depth
        )
        outside = np.maximum(beside, -depth)
        assert outside.min() > 0.005
        assert outside[points[:, 0] > 0.15].min() > 0.1  # what reaches forward stays well out of it


# ---------------------------------------------------------------- arm and gripper together


def test_names_stay_unique_after_attachment() -> None:
    model, _ = attached()
    assert (model.nu, model.nq, model.ntendon, model.neq) == (7, 8, 1, 1)
    assert model.body_mass.sum() == pytest.approx(18.5, abs=0.05)
    spec = mujoco.MjSpec.from_file(str(ASSETS / "ec66.xml"))
    hand = mujoco.MjSpec.from_file(str(ASSETS / "gripper.xml"))
    spec.attach(hand, prefix="gripper/", site=spec.site("flange"))
    assert spec.compile().nq == 8


@pytest.mark.parametrize(("payload", "limit"), [(0.0, 0.5e-3), (0.2, 0.5e-3)])
def test_stretched_arm_does_not_sag(payload: float, limit: float) -> None:
    model, data = attached(payload)
    mujoco.mj_forward(model, data)  # joint zero: stretched out horizontally
    start = data.site(TCP).xpos.copy()
    for _ in range(500):
        mujoco.mj_step(model, data)
    assert np.linalg.norm(data.site(TCP).xpos - start) < limit
    assert np.abs(data.qvel).max() < 1e-3


@pytest.mark.parametrize("joint", range(6))
def test_a_step_of_one_joint_settles_without_overshoot(joint: int) -> None:
    model, data = attached()
    step = 0.02
    data.ctrl[joint] = step
    peak = 0.0
    for _ in range(500):
        mujoco.mj_step(model, data)
        peak = max(peak, data.qpos[joint])
    assert peak < 1.02 * step
    assert data.qpos[joint] == pytest.approx(step, abs=1e-5)


# ---------------------------------------------------------------- gripper


def test_stroke_and_closing(hand: mujoco.MjModel) -> None:
    data = mujoco.MjData(hand)
    hand.opt.gravity[:] = 0
    gaps = []
    for target in (PARALLEL_85.stroke, 0.0):
        data.ctrl[0] = target
        for _ in range(300):
            mujoco.mj_step(hand, data)
        gaps.append(data.site("left_pad").xpos[0] - data.site("right_pad").xpos[0])
    assert gaps == pytest.approx([0.085, 0.0], abs=1e-4)


@pytest.mark.parametrize("force", [20.0, 60.0, 235.0])
def test_grip_force_and_no_creep(force: float) -> None:
    model, data = gripping(force)
    data.ctrl[0] = data.qpos[0] - 0.02  # 20 mm inside the blocked position must saturate the actuator
    for _ in range(100):
        mujoco.mj_step(model, data)
    assert list(pad_forces(model, data).values()) == pytest.approx([force] * 2, rel=0.03)
    start = data.body("box").xpos.copy()
    for _ in range(250):
        mujoco.mj_step(model, data)
    assert np.linalg.norm(data.body("box").xpos - start) < 5e-6
    assert data.qpos[0] == pytest.approx(data.qpos[1], abs=1e-5)


# ---------------------------------------------------------------- meshes


def test_shipped_meshes_are_what_the_code_makes(meshes: dict[str, Path]) -> None:
    shipped = {path.name: path for path in (ASSETS / "meshes").iterdir()}
    assert shipped.keys() == meshes.keys()
    for name, path in meshes.items():
        if path.read_bytes() == shipped[name].read_bytes():
            continue
        ours, theirs = (np.asarray(trimesh.load_mesh(p).triangles) for p in (path, shipped[name]))
        np.testing.assert_allclose(ours, theirs, atol=1e-6, err_msg=name)


def test_meshes_are_watertight_and_light(meshes: dict[str, Path]) -> None:
    for name, path in meshes.items():
        mesh = trimesh.load_mesh(path)
        assert mesh.is_watertight, name
        assert mesh.is_winding_consistent, name
        assert mesh.volume > 0, name
    assert sum(len(mesh.faces) for mesh in arm_meshes().values()) < 30_000
