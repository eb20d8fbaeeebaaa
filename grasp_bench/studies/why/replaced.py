"""A predictor whose grasps are partly replaced by those of reference grasps."""

from __future__ import annotations

import hashlib

import numpy as np

from grasp_bench.camera import RgbdImage
from grasp_bench.grasps import Grasp, angle_difference, wrap_angle
from grasp_bench.predictors.controls import Oracle
from grasp_bench.predictors.protocol import GroundTruth, Predictor, PrivilegedPredictor, begin, checked

ARM = 30.0
"""A turn counts as the way of a finger tip this far from the centre [mm]."""
REPLACED = 0.25
"""Weight of the parts that are replaced, where the nearest reference grasp is looked for."""


class Remembering:
    """A predictor asked once about each picture of a trial: what depends on picture and random stream alone
    is the same in every replay.

    Args:
        inner: the run's predictor, not one that is told the truth.
    """

    def __init__(self, inner: Predictor) -> None:
        self._inner = inner
        self._rng = np.random.default_rng(0)  # where nobody calls begin()
        self._answers: dict[bytes, list[Grasp]] = {}

    def begin(self, rng: np.random.Generator) -> None:
        """Take the trial's random stream, for a picture that was not seen before."""
        self._rng = rng

    def predict(self, image: RgbdImage) -> list[Grasp]:
        """Return what the predictor says, or said, of an image; PredictorError for an unusable answer."""
        key = hashlib.sha256(image.rgb.tobytes() + image.depth.tobytes()).digest()
        if key not in self._answers:
            begin(self._inner, self._rng)
            self._answers[key] = checked(self._inner.predict(image), image.intrinsics)
        return self._answers[key]


class Replaced(PrivilegedPredictor):
    """A predictor whose grasps have some of their parts from the nearest reference grasp each.

    Reference grasps are where a perfect predictor would see them: with an error of calibration the robot
    misses them, too.

    Args:
        inner: the run's predictor.
        parts: what is replaced, of ``place``, ``angle`` and ``width``.
    """

    def __init__(self, inner: Predictor, parts: frozenset[str]) -> None:
        self._inner, self._parts = inner, parts

    def begin(self, rng: np.random.Generator) -> None:
        """Give the predictor the trial's random stream."""
        begin(self._inner, rng)

    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        """Return the predictor's grasps, best first, with parts replaced; the reference grasps themselves
        where it proposes none and all parts are to be replaced."""
        known = [
            Grasp(g.x, g.y, g.angle, g.width, g.quality) for g in Oracle().predict_from_truth(image, truth)
        ]
        answer = _answer(self._inner, image, truth)
        if not answer and len(self._parts) == 3:
            return known
        millimetres = 1000 * float(truth.camera.position[2]) / truth.intrinsics.fx
        return [self._mixed(g, nearest(g, known, self._parts, millimetres)) for g in answer]

    def _mixed(self, grasp: Grasp, reference: Grasp) -> Grasp:
        place = reference if "place" in self._parts else grasp
        angle = reference if "angle" in self._parts else grasp
        width = reference if "width" in self._parts else grasp
        return Grasp(place.x, place.y, angle.angle, width.width, grasp.quality)


class Turned(PrivilegedPredictor):
    """A predictor whose grasps are all turned.

    Args:
        inner: the run's predictor.
        turn: by how much, counter-clockwise as seen [rad].
    """

    def __init__(self, inner: Predictor, turn: float) -> None:
        self._inner, self._turn = inner, turn

    def begin(self, rng: np.random.Generator) -> None:
        """Give the predictor the trial's random stream."""
        begin(self._inner, rng)

    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        """Return the predictor's grasps, turned."""
        return [
            Grasp(g.x, g.y, wrap_angle(g.angle + self._turn), g.width, g.quality)
            for g in _answer(self._inner, image, truth)
        ]


def _answer(predictor: Predictor, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
    """Return what a predictor, or a control that is told the truth, says of an image."""
    if isinstance(predictor, PrivilegedPredictor):
        return predictor.predict_from_truth(image, truth)
    return checked(predictor.predict(image), image.intrinsics)


def nearest(grasp: Grasp, known: list[Grasp], parts: frozenset[str], millimetres: float) -> Grasp:
    """Return the reference grasp that is nearest to a predicted one in the parts that stay.

    Distance of the centres, way of the finger tips by the difference of angles, and half the difference of
    widths are added up [mm]; those of ``parts``, which are replaced, count a quarter.

    Args:
        known: at least one.
        millimetres: size of a pixel on the table [mm].
    """

    def distance(other: Grasp) -> float:
        terms = {
            "place": millimetres * float(np.hypot(other.x - grasp.x, other.y - grasp.y)),
            "angle": ARM * angle_difference(other.angle, grasp.angle),
            "width": millimetres * abs(other.width - grasp.width) / 2,
        }
        return sum(value * (REPLACED if part in parts else 1.0) for part, value in terms.items())

    return min(known, key=distance)
