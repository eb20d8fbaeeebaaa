"""Scenarios: all that defines a trial, read from ``scenarios/*.yaml`` and validated.

SI units throughout; angles in the file are degrees where the key says so. Unknown keys and
impossible values are refused, naming the file, the key and what would be valid.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.errors import ScenarioError, UnknownNameError
from grasp_bench.paths import scenarios_dir

Positive = Annotated[float, Field(gt=0)]
NonNegative = Annotated[float, Field(ge=0)]
Fraction = Annotated[float, Field(ge=0, le=1)]
Vector = tuple[float, float, float]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Camera(_Model):
    """A fixed pinhole camera."""

    width: Annotated[int, Field(ge=64, le=4096)] = 640
    height: Annotated[int, Field(ge=64, le=4096)] = 480
    horizontal_fov_deg: Annotated[float, Field(gt=5, lt=170)] = 90.0
    position: Vector = (0.5, 0.0, 0.55)
    target: Vector = (0.5, 0.0, 0.0)
    image_up: Vector = (1.0, 0.0, 0.0)

    @property
    def intrinsics(self) -> Intrinsics:
        """Pinhole intrinsics."""
        return Intrinsics.from_fov(self.width, self.height, math.radians(self.horizontal_fov_deg))

    @property
    def pose(self) -> CameraPose:
        """Pose in the world."""
        return CameraPose.look_at(self.position, self.target, self.image_up)


class Sensor(_Model):
    """Noise of a time-of-flight RGB-D camera; see :mod:`grasp_bench.scene.sensor` for the model."""

    axial_sigma: NonNegative = 0.0005
    axial_sigma_per_metre: NonNegative = 0.001
    axial_onset: NonNegative = 0.5
    lateral_sigma_px: NonNegative = 0.25
    mixed_pixels: Fraction = 0.5
    edge_step: Positive = 0.01
    edge_dropout: Fraction = 0.25
    grazing_angle_deg: Annotated[float, Field(ge=0, le=90)] = 80.0
    grazing_dropout: Fraction = 0.5
    speckle_dropout: Fraction = 0.001
    minimum_range: NonNegative = 0.25
    maximum_range: Positive = 2.5
    rgb_sigma: NonNegative = 2.0


class Table(_Model):
    """The table top at z = 0, and where objects are put."""

    size: tuple[Positive, Positive] = (0.7, 1.0)
    center: tuple[float, float] = (0.5, 0.0)
    friction: Positive = 0.5
    color: tuple[Fraction, Fraction, Fraction] = (0.62, 0.60, 0.57)
    workspace: tuple[NonNegative, NonNegative] = (0.06, 0.06)


class Settling(_Model):
    """Bringing the object to rest before it is seen."""

    clearance: NonNegative = 0.001
    timeout: Positive = 3.0
    linear_speed: Positive = 0.002
    angular_speed: Positive = 0.05
    still_time: Positive = 0.1


class Gripper(_Model):
    """The parallel gripper."""

    force: Annotated[float, Field(ge=20, le=235)] = 60.0
    closing_speed: Annotated[float, Field(gt=0, le=0.15)] = 0.075
    squeeze: Annotated[float, Field(ge=0, le=0.03)] = 0.025
    friction_scale: Positive = 1.0
    torsional_friction: NonNegative = 0.005
    settle_time: NonNegative = 0.25


class Motion(_Model):
    """Where and how fast the arm moves."""

    approach_height: Positive = 0.10
    insertion: Positive = 0.028
    table_clearance: Positive = 0.002
    speed_fraction: Annotated[float, Field(gt=0, le=1)] = 0.5
    approach_speed: Positive = 0.25
    lift_height: Positive = 0.20
    lift_speed: Positive = 0.25
    carry_to: Vector = (0.40, 0.25, 0.0)
    carry_speed: Positive = 0.50
    hold_time: Positive = 1.0
    collision_force: Positive = 40.0
    tcp_tolerance: Positive = 0.001
    tcp_tolerance_deg: Positive = 0.5


class Success(_Model):
    """When a trial is a success (paper, section 4.4)."""

    minimum_lift: Positive = 0.10


class Physics(_Model):
    """Solver settings; see docs/design.md for the reasons."""

    timestep: Annotated[float, Field(gt=0, le=0.005)] = 0.002
    control_steps: Annotated[int, Field(ge=1, le=20)] = 2
    impratio: Positive = 10.0
    noslip_iterations: Annotated[int, Field(ge=0, le=20)] = 3


class Scenario(_Model):
    """A whole scenario."""

    name: str
    description: str = ""
    version: Literal[1] = 1
    camera: Camera = Camera()
    sensor: Sensor = Sensor()
    table: Table = Table()
    settling: Settling = Settling()
    gripper: Gripper = Gripper()
    motion: Motion = Motion()
    success: Success = Success()
    physics: Physics = Physics()
    trial_timeout: Positive = 60.0

    @model_validator(mode="after")
    def _consistent(self) -> Scenario:
        if self.sensor.minimum_range >= self.sensor.maximum_range:
            raise ValueError("sensor.minimum_range must be below sensor.maximum_range")
        if self.success.minimum_lift >= self.motion.lift_height:
            raise ValueError("success.minimum_lift must be below motion.lift_height")
        _ = self.camera.pose  # a degenerate view raises here
        return self


def scenario_names() -> list[str]:
    """Names of the shipped scenarios."""
    return sorted(p.stem for p in scenarios_dir().glob("*.yaml"))


def load_scenario(name: str) -> Scenario:
    """Scenario by shipped name or by path of a YAML file.

    Raises:
        UnknownNameError: for a name that is neither.
        ScenarioError: for a file with wrong syntax, keys or values.
    """
    path = Path(name)
    if path.suffix in (".yaml", ".yml"):
        if not path.is_file():
            raise ScenarioError(f"Scenario file {path} does not exist.")
    elif name in scenario_names():
        path = scenarios_dir() / f"{name}.yaml"
    else:
        raise UnknownNameError("scenario", name, scenario_names())
    try:
        content = yaml.safe_load(path.read_text())
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{path} is not valid YAML: {error}") from error
    if not isinstance(content, dict):
        raise ScenarioError(f"{path} must hold keys and values, like scenarios/table4.yaml.")
    return parse_scenario(content | {"name": content.get("name", path.stem)}, str(path))


def parse_scenario(content: dict[str, Any], origin: str) -> Scenario:
    """Validated scenario from plain data; ``origin`` is named in errors."""
    try:
        return Scenario.model_validate(content)
    except ValidationError as error:
        raise ScenarioError("\n".join(_explain(origin, e) for e in error.errors())) from error


def _explain(origin: str, error: Any) -> str:
    keys = [str(k) for k in error["loc"]]
    where = ".".join(keys) or "scenario"
    if error["type"] == "extra_forbidden":
        model: Any = Scenario
        for key in keys[:-1]:
            model = model.model_fields[key].annotation
        return f"{origin}: {UnknownNameError(f'key in {where!r}:', keys[-1], model.model_fields)}"
    return f"{origin}: {where}: {error['msg']} (got {error['input']!r})"
