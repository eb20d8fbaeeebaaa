"""What a grasp predictor is: one function from an image to ranked grasps."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np

from grasp_bench.camera import CameraPose, Intrinsics, RgbdImage, View
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp, GraspPose, KnownGrasp, SpatialGrasp, wrap_angle
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.predictors.guard import Guard
from grasp_bench.predictors.spatial import checked_pose
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.system.arrays import Floats
from grasp_bench.system.texts import named, shown

MOST_GRASPS = 1000
"""Answers with more grasps than this are refused: each costs the planner time."""
WIDEST = 100_000
"""Greatest opening [px]: far beyond any image, and still a number to reckon with."""
STEEPEST = 1e6
"""Greatest size of an angle [rad] that is wrapped: of larger ones rounding leaves nothing."""


@runtime_checkable
class Predictor(Protocol):
    """Proposes grasps for what a camera sees.

    A predictor may also have

    - ``begin(rng: numpy.random.Generator)``, called before every trial with the trial's own random
      stream: one that draws numbers must use it, or its runs cannot be repeated;
    - ``info() -> dict``, JSON-able facts that identify it beyond its source, such as the hash of its
      weights: they are written to ``run.json``, and a run resumes only while they stay the same;
    - ``predict_views(views: list[View])``, asked instead in trials, where there may be several pictures;
      grasps refer to the first one;
    - ``last_maps: GraspMaps | None`` and ``crop_origin: tuple[int, int]``, its dense answer to the last image
      and where its corner is in that image [px]: pictures of trials show its quality;
    - ``close()``, called when it is not needed any more.

    The image is the predictor's own copy, and it may write into it.
    """

    def predict(self, image: RgbdImage) -> Sequence[Grasp | GraspPose]:
        """Return grasps in pixels and radians of the full ``image``, or poses in its camera's frame; best
        first, empty for none."""
        ...


@dataclass(frozen=True)
class GroundTruth:
    """What only the controls ``oracle`` and ``displaced`` are told.

    Attributes:
        position, rotation: the object's pose in the world, (3,) [m] and (3, 3).
        camera, intrinsics: those of the camera that takes the image.
        gripper: the robot's.
    """

    model: ObjectModel
    position: Floats
    rotation: Floats
    camera: CameraPose
    intrinsics: Intrinsics
    gripper: Gripper = PARALLEL_85


class PrivilegedPredictor(ABC):
    """Base of controls that see the truth; not a way in for predictors under test.

    Attributes:
        foresight: whether its grasps are tried out before one is chosen; see
            :mod:`grasp_bench.trials.foresight`.
    """

    foresight: ClassVar[bool] = False

    @abstractmethod
    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        """Return grasps like :meth:`Predictor.predict`, made from the truth."""

    def predict(self, image: RgbdImage) -> list[Grasp]:
        """Refuse: there is nothing to go by without the truth."""
        raise PredictorError(
            f"{type(self).__name__} is a control that needs the simulator's truth; "
            "it cannot predict from an image alone"
        )


def begin(predictor: Predictor, rng: np.random.Generator) -> None:
    """Give a predictor that asks for it the trial's random stream."""
    start = getattr(predictor, "begin", None)
    if start is not None:
        start(rng)


def ask(
    predictor: Predictor,
    image: RgbdImage,
    rng: np.random.Generator,
    truths: Sequence[GroundTruth] = (),
    views: Sequence[View] = (),
) -> list[Grasp]:
    """Ask a predictor, and check what it says.

    A control that may see the truth is asked about every object. Its grasps outside of the image are dropped,
    the others ranked round by round: the best of each object first, higher objects before lower ones.

    Args:
        predictor: the one asked; it gets a copy of the image.
        rng: the trial's random stream, for a predictor that has ``begin``.
        truths: what controls are told of each object; empty where there is no simulator.
        views: all pictures, ``image`` first, for a predictor that has ``predict_views``.

    Raises:
        PredictorError: for an exception in the predictor, an answer that is no list of grasps inside the
            image, or a control that needs the truth where there is none.
    """
    with Guard():
        begin(predictor, rng)
        if truths and isinstance(predictor, PrivilegedPredictor):
            return _in_turn(predictor, image, truths)
        several = getattr(predictor, "predict_views", None)
        if several is not None and views:
            grasps = several([replace(view, image=_copied(view.image)) for view in views])
        else:
            grasps = predictor.predict(_copied(image))
        return checked(grasps, image.intrinsics)


def _copied(image: RgbdImage) -> RgbdImage:
    """Copy the image for the predictor; the planner needs the original."""
    return replace(image, rgb=image.rgb.copy(), depth=image.depth.copy())


def _in_turn(control: PrivilegedPredictor, image: RgbdImage, truths: Sequence[GroundTruth]) -> list[Grasp]:
    size = image.intrinsics
    found: list[tuple[int, float, Grasp]] = []
    for truth in truths:
        told = control.predict_from_truth(_copied(image), truth)
        inside = [g for g in told if 0 <= g.x <= size.width and 0 <= g.y <= size.height]
        found += [(turn, -float(truth.position[2]), g) for turn, g in enumerate(inside)]
    ranked = [g for *_, g in sorted(found, key=lambda f: f[:2])]
    sound = checked(ranked, size)
    known = zip(ranked, sound, strict=True)
    return [g if isinstance(g, KnownGrasp) else told for g, told in known]  # who knows may say so


def checked(grasps: Any, intrinsics: Intrinsics) -> list[Grasp]:
    """Return the grasps as plain numbers, with angles wrapped, and poses as they look in the image.

    Raises:
        PredictorError: naming the first grasp that is unusable, and why.
    """
    with Guard("the answer cannot be read: it raised"):
        if not isinstance(grasps, (list, tuple)):
            raise PredictorError(f"predict() must return a list of Grasp or GraspPose, got {named(grasps)}")
        plain = list(list.__iter__(grasps) if isinstance(grasps, list) else tuple.__iter__(grasps))
        if len(plain) > MOST_GRASPS:
            raise PredictorError(f"{len(plain)} grasps are too many; return the best {MOST_GRASPS} or fewer")
        return [_checked(i, grasp, intrinsics) for i, grasp in enumerate(plain)]


def _checked(i: int, grasp: Any, intrinsics: Intrinsics) -> Grasp:
    if isinstance(grasp, SpatialGrasp):
        grasp = grasp.pose
    if isinstance(grasp, GraspPose):
        return SpatialGrasp.of(checked_pose(i, grasp), intrinsics.project)
    if not isinstance(grasp, Grasp):
        raise PredictorError(f"grasp {i} is a {named(grasp)}, not a grasp_bench.Grasp or GraspPose")
    try:
        fields = (grasp.x, grasp.y, grasp.angle, grasp.width, grasp.quality)
        if any(isinstance(v, (str, bytes)) for v in fields):
            raise TypeError("text")
        values = [float(v) for v in fields]
    except Exception as error:  # arrays and tensors of several values raise what they like
        raise PredictorError(
            f"grasp {i} holds something that is not a number: {shown(grasp, 200)}"
        ) from error
    x, y, angle, width, quality = values
    if not all(map(math.isfinite, values)):
        raise PredictorError(f"grasp {i} holds NaN or infinity: {shown(grasp, 200)}")
    if not (0 <= x <= intrinsics.width and 0 <= y <= intrinsics.height):
        raise PredictorError(
            f"grasp {i} at ({x:.1f}, {y:.1f}) px is outside the {intrinsics.width}×{intrinsics.height} image"
        )
    if not 0 < width <= WIDEST:
        raise PredictorError(
            f"grasp {i} has a width of {width:.3f} px; it must be positive, and at most {WIDEST:,} px"
        )
    if abs(angle) > STEEPEST:
        raise PredictorError(f"grasp {i} has an angle of {angle:.6g}; it must be in radians")
    return Grasp(x, y, wrap_angle(angle), width, min(1.0, max(0.0, quality)))
