"""The sections of a scenario: all that defines a trial.

SI units throughout; angles are degrees and a calibration's lengths millimetres where the key says so.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, ValidationInfo, field_validator, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from grasp_bench.errors import GraspBenchError
from grasp_bench.robot.grippers import load_gripper
from grasp_bench.robot.robot import Robot as LoadedRobot
from grasp_bench.robot.robot import load_robot
from grasp_bench.scenario.cameras import Camera
from grasp_bench.scenario.fields import Fraction, NonNegative, Positive, Section, Vector
from grasp_bench.scenario.look import Look
from grasp_bench.scenario.sensors import Sensor
from grasp_bench.scenario.surroundings import Surroundings

VERSION = 2
"""Of the definition of a trial (docs/definition.md): only trials of this version are carried out, results of
earlier ones are still read."""


class Calibration(Section):
    """How wrong the camera's pose is known: planner and predictors believe the nominal ``camera``.

    The true optical centre lies ``position_mm`` beside the nominal one, in a direction drawn uniformly from
    the sphere, and the true camera is turned by ``rotation_deg`` about an axis drawn alike. Both are drawn
    once for a whole run, as a robot is calibrated once, or anew for every trial.
    """

    position_mm: NonNegative = 0.0
    rotation_deg: Annotated[float, Field(ge=0, le=20)] = 0.0
    drawn: Literal["run", "trial"] = "trial"

    @property
    def exact(self) -> bool:
        """Whether there is no error at all."""
        return self.position_mm == 0 and self.rotation_deg == 0


class Light(Section):
    """Lamps over the table; ``level`` 1 is the light of the reference scenario.

    It changes colours only: depth cameras bring their own light.
    """

    level: Positive = 1.0


class Objects(Section):
    """Which objects a run takes unless it names others, and what is changed in them.

    Attributes:
        names: each object's name, or that of a category or set, with the reason why it is here; empty for all
            household objects.
        folder: where they are: a shipped set below the assets, or the path of a folder with a manifest.
        poses: by an object's name, the numbers of the resting poses it is put down in, from 0; where nothing
            is said, those in which a grasp from above fits the gripper.
        mass_scale: factor on every mass and inertia.
        centre_of_mass_mm: shift of every centre of mass, in the object's frame [mm].
        graded: whether the difficulty of all of them must have been measured, with the robot's gripper.
    """

    names: dict[str, str] = Field(default_factory=dict)
    folder: str = "objects"
    poses: dict[str, tuple[Annotated[int, Field(ge=0)], ...]] = Field(default_factory=dict)
    mass_scale: Positive = 1.0
    centre_of_mass_mm: Vector = (0.0, 0.0, 0.0)
    graded: bool = False

    @field_validator("names", mode="before")
    @classmethod
    def _from_list(cls, given: Any) -> Any:
        return dict.fromkeys(given, "") if isinstance(given, list) else given


class Clutter(Section):
    """Many objects at once, taken away one after another; see :mod:`grasp_bench.trials.episode`.

    Attributes:
        fewest, most: how many objects an episode has, drawn uniformly.
        workspace: they are put down within ± this of the table's centre [m].
        failures: failed attempts in a row that end an episode.
    """

    fewest: Annotated[int, Field(ge=1, le=20)] = 5
    most: Annotated[int, Field(ge=1, le=20)] = 10
    workspace: tuple[NonNegative, NonNegative] = (0.13, 0.13)
    failures: Annotated[int, Field(ge=1, le=20)] = 3

    @model_validator(mode="after")
    def _ordered(self) -> Clutter:
        if self.fewest > self.most:
            raise ValueError("clutter.fewest must not be above clutter.most")
        return self


class Table(Section):
    """The table top at z = 0, and where objects are put."""

    size: tuple[Positive, Positive] = (0.7, 1.0)
    center: tuple[float, float] = (0.5, 0.0)
    friction: Positive = 0.5
    color: tuple[Fraction, Fraction, Fraction] = (0.62, 0.60, 0.57)
    workspace: tuple[NonNegative, NonNegative] = (0.06, 0.06)


class Settling(Section):
    """Bringing the object to rest before it is seen."""

    clearance: NonNegative = 0.001
    timeout: Positive = 3.0
    linear_speed: Positive = 0.002
    angular_speed: Positive = 0.05
    still_time: Positive = 0.1


class Robot(Section):
    """Which arm carries which gripper: shipped ones by name, others by the path of their folder.

    A path in a scenario's file is relative to that file.
    """

    arm: str = "ec66"
    gripper: str = "parallel-85"

    @property
    def loaded(self) -> LoadedRobot:
        """Arm and gripper, as their files say.

        Raises:
            UnknownNameError: for a name that is none.
            AssetError: for files that are not those of an arm or a gripper.
        """
        return load_robot(self.arm, self.gripper)


class Gripper(Section):
    """How the gripper is used, within what the robot's can."""

    force: Positive = 60.0
    closing_speed: Positive = 0.075
    squeeze: NonNegative = 0.025
    friction_scale: Positive = 1.0
    torsional_friction: NonNegative = 0.005
    pad_stiffness: Annotated[float, Field(ge=0.1, le=4)] = 1.0
    settle_time: NonNegative = 0.25


class Shake(Section):
    """Shaking after the lift, along the three axes of the gripper; see :mod:`grasp_bench.planning.shake`."""

    acceleration: Annotated[float, Field(ge=0, le=20)] = 0.0
    frequency: Annotated[float, Field(ge=1, le=20)] = 4.0
    cycles: Annotated[int, Field(ge=1, le=100)] = 2


class Motion(Section):
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
    shake: Shake = Shake()


class Execution(Section):
    """Whose grasp is carried out: the predictor's own, or the best that a planner makes of its proposals.

    A file may name the protocol alone: ``execution: as-predicted``.

    Attributes:
        protocol: ``assisted``: the first of ``proposals`` grasps whose tips get deep, jaws as wide as that
            takes. ``as-predicted``: the best grasp only, at its own centre, angle and width.
        proposals: how many grasps count when assisted; what comes after them is not looked at.
        clearance: added to the predicted width when carried out as predicted [m].
    """

    protocol: Literal["assisted", "as-predicted"] = "assisted"
    proposals: Annotated[int, Field(ge=1, le=1000)] = 10
    clearance: NonNegative = 0.0

    @property
    def assisted(self) -> bool:
        """Whether the planner helps the predictor."""
        return self.protocol == "assisted"


class Margin(Section):
    """Measuring how firmly what was lifted is held; see :mod:`grasp_bench.trials.margin`.

    Attributes:
        distance, angle_deg: the grip is broken when the object moved or turned so far in the gripper [m, °].
        force_cap, torque_cap: greatest loads that are tried [N, N m].
    """

    distance: Annotated[float, Field(ge=0.001, le=0.05)] = 0.005
    angle_deg: Annotated[float, Field(ge=1, le=45)] = 10.0
    force_cap: Annotated[float, Field(ge=1, le=1000)] = 200.0
    torque_cap: Annotated[float, Field(ge=0.1, le=100)] = 10.0


class Success(Section):
    """When a trial is a success (paper, section 4.4)."""

    minimum_lift: Positive = 0.10


class Physics(Section):
    """Solver settings; see docs/design.md for the reasons."""

    timestep: Annotated[float, Field(gt=0, le=0.005)] = 0.002
    control_steps: Annotated[int, Field(ge=1, le=20)] = 2
    cone: Literal["elliptic", "pyramidal"] = "elliptic"
    impratio: Positive = 10.0
    noslip_iterations: Annotated[int, Field(ge=0, le=20)] = 3
    """From when the fingers have closed; what is not held does not need them."""
    sleep: bool = True
    """What lies still and untouched while the arm comes is not simulated until something touches it."""
    max_hulls: Annotated[int, Field(ge=0)] = 0
    """Convex pieces an object has at most, neighbours being merged; 0 for all there are."""


class Scenario(Section):
    """A whole scenario."""

    name: str
    description: str = ""
    version: Annotated[int, Field(ge=1, le=VERSION)] = VERSION
    camera: Camera = Camera()
    sensor: Sensor = Sensor()
    calibration: Calibration = Calibration()
    light: Light = Light()
    look: Look | None = None
    surroundings: Surroundings | None = None
    table: Table = Table()
    settling: Settling = Settling()
    robot: Robot = Robot()
    gripper: Gripper = Gripper()
    motion: Motion = Motion()
    execution: Execution = Execution()
    margin: Margin | None = None
    success: Success = Success()
    physics: Physics = Physics()
    objects: Objects = Objects()
    clutter: Clutter | None = None
    trial_timeout: Positive = 60.0

    @field_validator("execution", mode="before")
    @classmethod
    def _protocol(cls, given: Any) -> Any:
        return {"protocol": given} if isinstance(given, str) else given

    @field_validator("gripper")
    @classmethod
    def _within_what_it_can(cls, asked: Gripper, info: ValidationInfo) -> Gripper:
        """Refuse what the robot's gripper cannot do; that of a folder which is not here is not asked."""
        robot = info.data.get("robot")
        try:
            able = None if robot is None else load_gripper(robot.gripper)
        except GraspBenchError:  # said when it is used: results of a run are read where its robot is not
            able = None
        if able is None:
            return asked
        limits = {"force": able.force, "closing_speed": (0, able.speed), "squeeze": (0, able.squeeze)}
        faults: list[InitErrorDetails] = []
        for key, (least, most) in limits.items():
            value = getattr(asked, key)
            if not least <= value <= most:
                side, limit = ("greater", least) if value < least else ("less", most)
                told = {"side": side, "limit": f"{limit:g}", "name": able.name}
                words = "Input should be {side} than or equal to {limit} with gripper {name}"
                kind = PydanticCustomError("beyond", words, told)
                faults.append({"type": kind, "loc": (key,), "input": value})
        if faults:
            raise ValidationError.from_exception_data("Gripper", faults)
        return asked

    @model_validator(mode="after")
    def _consistent(self) -> Scenario:
        if self.success.minimum_lift >= self.motion.lift_height:
            raise ValueError("success.minimum_lift must be below motion.lift_height")
        _ = self.camera.pose  # a degenerate view raises here
        return self
