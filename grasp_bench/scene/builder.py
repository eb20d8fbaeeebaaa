"""Composes the world of a trial with dm_control's MJCF library and compiles it.

One object is compiled per scene: 180 free bodies in one model would cost fifteen times the
time per step. Compiled models are cached on disk under the digest of all that goes into
them; the cache has no effect on results.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, Protocol

import mujoco
import numpy as np

from grasp_bench.objects.catalog import ObjectModel, VisualPart
from grasp_bench.robot.robot import Robot
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.surroundings import Surroundings
from grasp_bench.scene.hulls import merged
from grasp_bench.scene.mounting import load_robot
from grasp_bench.scene.surroundings import SEEN_GROUP, UNTOUCHED, add_fixtures, table_top
from grasp_bench.system import cache

OfScenario = Literal["of the scenario"]
OF_SCENARIO: OfScenario = "of the scenario"
"""The robot that the scenario names."""
OBJECT = "object"
TABLE = "table"
FLOOR = "floor"
GROUND = "ground"
VISUAL_GROUP = 2
COLLISION_GROUP = 3
ROLLING_FRICTION = 1.5e-3
"""Rolling resistance on the table [m], of the order of a thin rubber mat: with less, things that
lie on a small round patch rock for seconds."""

NOT_IN_THE_MODEL: set[str] = set(
    "name description sensor calibration light look settling motion execution margin success clutter "
    "trial_timeout".split()
)
"""Sections of a scenario that compiled models do not depend on."""


def stl_bytes(vertices: np.ndarray, faces: np.ndarray) -> bytes:
    """Return a mesh as binary STL; normals are left to the reader."""
    triangles = np.zeros(len(faces), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("tag", "<u2")])
    triangles["corners"] = np.asarray(vertices)[np.asarray(faces)]
    return bytes(80) + struct.pack("<I", len(faces)) + triangles.tobytes()


class SceneObject(Protocol):
    """What the builder needs of an object; see :class:`ObjectModel`."""

    @property
    def mass(self) -> float:
        """Kilograms."""
        ...

    @property
    def inertia(self) -> np.ndarray:
        """Inertia matrix (3, 3) about the centre of mass [kg m²]."""
        ...

    @property
    def friction(self) -> float:
        """Against the pads."""
        ...

    @property
    def visual(self) -> list[VisualPart]:
        """The coloured parts."""
        ...

    @property
    def hulls(self) -> list[np.ndarray]:
        """Vertices (V, 3) of each convex piece [m]."""
        ...


def add_object(root: Any, model: SceneObject, scenario: Scenario, name: str = OBJECT) -> None:
    """Add a free body with its visual parts and convex hulls."""
    from dm_control import mjcf
    from scipy.spatial import ConvexHull

    prefix = "" if name == OBJECT else f"{name}_"
    body = root.worldbody.add("body", name=name, pos=[0, 0, 1])
    body.add("freejoint", name=name)
    heavier = scenario.objects.mass_scale
    inertia = heavier * model.inertia
    body.add(
        "inertial",
        pos=[1e-3 * c for c in scenario.objects.centre_of_mass_mm],
        mass=heavier * model.mass,
        fullinertia=inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]],
    )
    for i, part in enumerate(model.visual):
        mesh = root.asset.add(
            "mesh",
            name=f"{prefix}visual{i}",
            inertia="shell",
            file=mjcf.Asset(stl_bytes(part.vertices, part.faces), ".stl"),
        )
        body.add(
            "geom",
            name=f"{prefix}visual{i}",
            type="mesh",
            mesh=mesh,
            rgba=[*part.rgb, 1],
            mass=0,
            group=VISUAL_GROUP,
            user=[part.roughness],
            **UNTOUCHED,
        )
    for i, hull in enumerate(merged(model.hulls, scenario.physics.max_hulls)):
        faces = ConvexHull(hull).simplices
        mesh = root.asset.add(
            "mesh", name=f"{prefix}hull{i}", inertia="convex", file=mjcf.Asset(stl_bytes(hull, faces), ".stl")
        )
        body.add(
            "geom",
            name=f"{prefix}hull{i}",
            type="mesh",
            mesh=mesh,
            mass=0,
            group=COLLISION_GROUP,
            condim=6,
            friction=[scenario.table.friction, 0.005, ROLLING_FRICTION],
            rgba=[0.9, 0.3, 0.2, 0.4],
        )


def add_table(root: Any, scenario: Scenario) -> None:
    """Add table, floor, fixtures, light and the camera's marker."""
    table, around = scenario.table, scenario.surroundings or Surroundings()
    size, center = table_top(scenario)
    root.worldbody.add(
        "geom",
        name=TABLE,
        type="box",
        size=[size[0] / 2, size[1] / 2, 0.025],
        pos=[*center, -0.025],
        rgba=[*table.color, 1],
        group=SEEN_GROUP,
        **UNTOUCHED,
    )
    # What carries is a plane: contacts of meshes with a box flicker, and keep some objects rocking for ever.
    root.worldbody.add(
        "geom",
        name=GROUND,
        type="plane",
        size=[3, 3, 0.1],
        condim=6,
        group=COLLISION_GROUP,
        friction=[table.friction, 0.005, ROLLING_FRICTION],
        rgba=[0, 0, 0, 0],
    )
    root.worldbody.add(
        "geom",
        name=FLOOR,
        type="plane",
        size=[3, 3, 0.1],
        pos=[0, 0, around.floor_height],
        rgba=[*around.floor_color, 1],
        group=SEEN_GROUP,
        **UNTOUCHED,
    )
    add_fixtures(root, scenario)
    root.asset.add(
        "texture",
        name="sky",
        type="skybox",
        builtin="gradient",
        width=32,
        height=32,
        rgb1=[0.92, 0.94, 0.96],
        rgb2=[0.70, 0.75, 0.80],
    )  # for pictures; rays see nothing there
    root.worldbody.add("light", pos=[0.2, -0.6, 2.0], dir=[0.1, 0.3, -1], diffuse=[0.6, 0.6, 0.6])
    # Shown by viewers and GL pictures; the ray caster takes the pose from the scenario itself.
    rotation = scenario.camera.pose.rotation
    root.worldbody.add(
        "camera",
        name="sensor",
        pos=scenario.camera.position,
        xyaxes=[*rotation[:, 0], *-rotation[:, 1]],
        fovy=float(np.degrees(scenario.camera.intrinsics.vertical_fov)),
    )


def new_world(scenario: Scenario) -> Any:
    """Make an empty MJCF model with the scenario's solver settings."""
    from dm_control import mjcf

    root = mjcf.RootElement(model="grasp_bench")
    root.compiler.angle = "radian"
    root.compiler.autolimits = True
    physics = scenario.physics
    root.option.timestep = physics.timestep
    root.option.integrator = "implicitfast"
    root.option.solver = "Newton"
    root.option.jacobian = "dense"
    root.option.cone = physics.cone
    root.option.impratio = physics.impratio
    root.option.noslip_iterations = physics.noslip_iterations
    root.size.nuser_geom = 1
    return root


def compose(
    scenario: Scenario, model: SceneObject | None, robot: Robot | OfScenario | None = OF_SCENARIO
) -> Any:
    """Compose the MJCF model (``dm_control.mjcf.RootElement``) of a trial's world.

    Args:
        model: the object, or None for an empty table.
        robot: stands at the origin; None for only table and object.
    """
    root = new_world(scenario)
    add_table(root, scenario)
    robot = _chosen(robot, scenario)
    if robot is not None:
        root.attach(load_robot(robot, scenario, 1.0 if model is None else model.friction))
    if model is not None:
        add_object(root, model, scenario)
    return root


def _chosen(robot: Robot | OfScenario | None, scenario: Scenario) -> Robot | None:
    return scenario.robot.loaded if isinstance(robot, str) else robot


def object_name(which: int) -> str:
    """Return the name of the body of the ``which``-th of several objects."""
    return f"{OBJECT}{which}"


def compose_many(scenario: Scenario, models: Sequence[SceneObject]) -> Any:
    """Compose the MJCF model of a world with robot, table and several objects, named by
    :func:`object_name`."""
    root = new_world(scenario)
    add_table(root, scenario)
    root.attach(load_robot(scenario.robot.loaded, scenario, 1.0))
    for i, model in enumerate(models):
        add_object(root, model, scenario, object_name(i))
    return root


def compile_mjcf(root: Any) -> mujoco.MjModel:
    """Compile a composed model with MuJoCo itself."""
    return mujoco.MjModel.from_xml_string(root.to_xml_string(), root.get_assets())


def scene_digest(
    scenario: Scenario, model: ObjectModel | None, robot: Robot | OfScenario | None = OF_SCENARIO
) -> str:
    """Return a digest of all that the model of a trial's world is made of, code included."""
    # All of the scenario but what surely is not in the model: a few keys too many cost only cache hits.
    settings = scenario.model_dump_json(exclude=NOT_IN_THE_MODEL)
    parts = f"{_fixed_digest(_chosen(robot, scenario))}|{settings}|{model.digest if model else '-'}"
    return hashlib.sha256(parts.encode()).hexdigest()[:32]


@lru_cache
def _fixed_digest(robot: Robot | None) -> str:
    """Digest what no trial of a process changes: MuJoCo, this code, and the robot's facts and files."""
    digest = hashlib.sha256(f"{mujoco.__version__}|{robot}|".encode())
    code = (
        Path(__file__).with_name(f"{name}.py") for name in ("builder", "hulls", "mounting", "surroundings")
    )
    for path in (*code, *(robot.files if robot else ())):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def compile_scene(
    scenario: Scenario, model: ObjectModel | None, robot: Robot | OfScenario | None = OF_SCENARIO
) -> mujoco.MjModel:
    """Compile the model of a trial's world, or take it from the cache where it is there."""
    path = cache.folder() / f"{scene_digest(scenario, model, robot)}.mjb"
    if cache.used(path):
        try:
            return mujoco.MjModel.from_binary_path(str(path))
        except ValueError:
            pass  # damaged, or removed by another process meanwhile: compile again and replace it
    compiled = compile_mjcf(compose(scenario, model, robot))
    cache.put(path, lambda fresh: mujoco.mj_saveModel(compiled, str(fresh)))
    return compiled
