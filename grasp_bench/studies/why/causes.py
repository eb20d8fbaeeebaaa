"""What may have cost a trial its success, and in which order causes are removed.

A *fault* is something that was wrong: what the camera measured, where it was thought to stand, or the
predicted grasp. A *remedy* is a change of the world that would have saved the trial although nothing was
wrong with it: a stickier pad, a lighter object. Faults are asked for before remedies of the same number.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.sensors import Sensor

Removed = frozenset[str]
"""Causes, by their keys, that are removed together."""
UNCHANGED: Removed = frozenset()


@dataclass(frozen=True)
class Cause:
    """One thing that a replay does without.

    Attributes:
        key: its name in files and options.
        loss: what losses to it are called.
        instead: what the replay has in its place.
        remedy: whether nothing was wrong, and the replay's world is an easier one.
        parts: keys of causes that are a part of this one: where one of them is enough, it is the one to be
            named.
    """

    key: str
    loss: str
    instead: str
    remedy: bool = False
    parts: Removed = frozenset()


CAUSES: tuple[Cause, ...] = (
    Cause("calibration", "calibration", "the camera stands exactly where robot and predictor believe"),
    Cause(
        "depth",
        "depth picture",
        "predictor and planner see a perfect depth picture",
        parts=Removed({"height"}),
    ),
    Cause("colours", "colours", "the colour picture has neither noise nor a wrong exposure, in full light"),
    Cause("place", "place", "the centres are those of the nearest reference grasp"),
    Cause("angle", "angle", "the angles are those of the nearest reference grasp, or what the place needs"),
    Cause("width", "width", "the widths are those of the nearest reference grasp, or what the place needs"),
    Cause(
        "grasp",
        "whole grasp",
        "the predicted grasps are the nearest reference grasps in all",
        parts=Removed({"place", "angle", "width"}),
    ),
    Cause(
        "height",
        "depth holes and noise at the grasp",
        "the planner sees perfect depth, the predictor what it saw",
    ),
    Cause("friction", "friction", "the pads' friction is doubled", remedy=True),
    Cause("mass", "mass", "the object has half its mass", remedy=True),
    Cause("fingers", "thick fingers", "fingers are half as thick", remedy=True),
    Cause("help", "", "", remedy=True),
)
"""All causes, in the order in which ties between them are listed."""
KEYS: tuple[str, ...] = tuple(c.key for c in CAUSES)
_ASSISTED = Cause(
    "help", "the planner's help", "the best grasp is carried out exactly as predicted", remedy=True
)
_AS_PREDICTED = Cause(
    "help",
    "no help by the planner",
    "the planner takes the first grasp that gets deep, jaws as wide as that needs",
    remedy=True,
)

_COLOUR = frozenset(n for n in Sensor.model_fields if n.startswith(("rgb_", "exposure", "white_balance"))) | {
    "auto_exposure",
    "jpeg_quality",
}
_IDEAL = Sensor(preset="ideal")
PERFECT_COLOURS = {name: getattr(_IDEAL, name) for name in sorted(_COLOUR)}
"""Values of a sensor that adds nothing to colours."""
PERFECT_DEPTH = {
    name: getattr(_IDEAL, name) for name in Sensor.model_fields if name not in {*_COLOUR, "preset"}
}
"""Values of a sensor that adds nothing to depth."""


def applying(scenario: Scenario) -> list[Cause]:
    """Return the causes that there can be in a scenario: where nothing would change, nothing is asked."""
    sensor = scenario.sensor

    def changes(perfect: dict[str, object]) -> bool:
        return any(getattr(sensor, name) != value for name, value in perfect.items())

    there = {
        "calibration": not scenario.calibration.exact,
        "depth": changes(PERFECT_DEPTH),
        "height": changes(PERFECT_DEPTH),
        "colours": changes(PERFECT_COLOURS) or scenario.light.level != 1,
    }
    help_ = _ASSISTED if scenario.execution.assisted else _AS_PREDICTED
    return [help_ if c.key == "help" else c for c in CAUSES if there.get(c.key, True)]


def levels(causes: Sequence[Cause]) -> Iterator[list[Removed]]:
    """Yield the sets to remove, level by level: single faults, single remedies, pairs of faults, other pairs.

    All of a level are tried, and no level after the first in which one succeeds. A cause is not paired with
    a part of its own.
    """
    faults, remedies = [c for c in causes if not c.remedy], [c for c in causes if c.remedy]
    pairs = [(a, b) for a, b in combinations(causes, 2) if a.key not in b.parts and b.key not in a.parts]
    yield [Removed({c.key}) for c in faults]
    yield [Removed({c.key}) for c in remedies]
    yield [Removed({a.key, b.key}) for a, b in pairs if not (a.remedy or b.remedy)]
    yield [Removed({a.key, b.key}) for a, b in pairs if a.remedy or b.remedy]


def ordered(removed: Removed) -> tuple[str, ...]:
    """Return the keys of a set in the order of :data:`CAUSES`."""
    return tuple(key for key in KEYS if key in removed)
