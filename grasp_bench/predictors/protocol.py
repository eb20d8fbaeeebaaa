"""What a grasp predictor is: one function from an image to ranked grasps."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import CameraPose, Intrinsics, RgbdImage
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp, wrap_angle
from grasp_bench.objects.catalog import ObjectModel

Floats = NDArray[np.float64]


@runtime_checkable
class Predictor(Protocol):
    """Proposes grasps for what a camera sees.

    A predictor may also have ``begin(rng: numpy.random.Generator)``, called before every
    trial with the trial's own random stream: one that draws numbers must use it, or its
    runs cannot be repeated.
    """

    def predict(self, image: RgbdImage) -> list[Grasp]:
        """Grasps in pixels and radians of the full ``image``, best first; empty for none."""
        ...


@dataclass(frozen=True)
class GroundTruth:
    """What only the controls ``oracle`` and ``displaced`` are told.

    Attributes:
        model: the object.
        position, rotation: its pose in the world.
        camera: pose of the camera.
        intrinsics: of the image.
    """

    model: ObjectModel
    position: Floats
    rotation: Floats
    camera: CameraPose
    intrinsics: Intrinsics


class PrivilegedPredictor(ABC):
    """Base of controls that see the truth; not a way in for predictors under test."""

    @abstractmethod
    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        """Grasps like :meth:`Predictor.predict`, made from the truth."""

    def predict(self, image: RgbdImage) -> list[Grasp]:
        """Refused: there is nothing to go by without the truth."""
        raise PredictorError(f"{type(self).__name__} is a control that needs the simulator's truth; "
                             "it cannot predict from an image alone")


def answer(predictor: Predictor, image: RgbdImage, truth: GroundTruth,
           rng: np.random.Generator) -> list[Grasp]:
    """Ask a predictor, and check what it says.

    Raises:
        PredictorError: for an exception in the predictor, or an answer that is no list of
            grasps inside the image.
    """
    begin = getattr(predictor, "begin", None)
    try:
        if begin is not None:
            begin(rng)
        if isinstance(predictor, PrivilegedPredictor):
            grasps = predictor.predict_from_truth(image, truth)
        else:
            grasps = predictor.predict(image)
    except PredictorError:
        raise
    except Exception as error:  # anything a foreign predictor may throw
        raise PredictorError(f"the predictor raised {type(error).__name__}: {error}") from error
    return checked(grasps, image.intrinsics)


def checked(grasps: Any, intrinsics: Intrinsics) -> list[Grasp]:
    """The grasps with angles wrapped.

    Raises:
        PredictorError: naming the first grasp that is unusable, and why.
    """
    if grasps is None or not isinstance(grasps, (list, tuple)):
        raise PredictorError(f"predict() must return a list of Grasp, got {type(grasps).__name__}")
    sound = []
    for i, grasp in enumerate(grasps):
        if not isinstance(grasp, Grasp):
            raise PredictorError(f"grasp {i} is a {type(grasp).__name__}, not a grasp_bench.Grasp")
        try:
            values = [float(v) for v in (grasp.x, grasp.y, grasp.angle, grasp.width, grasp.quality)]
        except (TypeError, ValueError) as error:
            raise PredictorError(f"grasp {i} holds something that is not a number: {grasp}") from error
        x, y, angle, width, quality = values
        if not all(map(math.isfinite, values)):
            raise PredictorError(f"grasp {i} holds NaN or infinity: {grasp}")
        if not (0 <= x <= intrinsics.width and 0 <= y <= intrinsics.height):
            raise PredictorError(f"grasp {i} at ({x:.1f}, {y:.1f}) px is outside the "
                                 f"{intrinsics.width}×{intrinsics.height} image")
        if width <= 0:
            raise PredictorError(f"grasp {i} has a width of {width:.3f} px; it must be positive")
        sound.append(Grasp(x, y, wrap_angle(angle), width, min(1.0, max(0.0, quality))))
    return sound
