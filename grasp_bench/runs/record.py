"""The record of a trial, and its timings: lines that are written and read by the same class.

docs/results-format.md says what the fields mean. Numbers are rounded, far below what is measurable.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import (
    BeforeValidator,
    Field,
    PlainSerializer,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)
from pydantic_core import CoreSchema, core_schema

from grasp_bench.grasps import Grasp, GraspPose
from grasp_bench.runs.schema import Count, Number, Stored, Text
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.system.texts import LONGEST, legible, shown


class TcpError(NamedTuple):
    """Error of the TCP against its plan before the fingers close: distance [m] and angle [rad]."""

    position: float
    angle: float


@dataclass(frozen=True)
class _Part:
    """A field that is a ``kind`` in memory, and an object of rounded numbers or null in the file.

    Attributes:
        kind: class of the field's value.
        digits: decimal places of every number, by name.
        shapes: shape of those that are arrays.
    """

    kind: type
    digits: dict[str, int]
    shapes: dict[str, tuple[int, ...]] = field(default_factory=dict)

    def read(self, value: Any) -> Any:
        if value is None or isinstance(value, self.kind):
            return value
        if not isinstance(value, dict):
            raise ValueError("not an object")
        try:
            arrays = {k: np.asarray(value[k], dtype=float) for k in self.digits if k in value}
        except (TypeError, OverflowError) as error:
            raise ValueError("not numbers") from error
        if any(not np.isfinite(a).all() or a.shape != self.shapes.get(k, ()) for k, a in arrays.items()):
            raise ValueError("not finite numbers of the right shape")
        try:
            return self.kind(**{k: a if k in self.shapes else float(a) for k, a in arrays.items()})
        except TypeError as error:
            raise ValueError("a number is missing") from error

    def written(self, part: Any) -> dict[str, Any] | None:
        if part is None:
            return None
        whole = {k: getattr(part, k) for k in self.digits}
        return {
            k: np.round(v, self.digits[k]).tolist() if k in self.shapes else round(v, self.digits[k])
            for k, v in whole.items()
        }

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        written = core_schema.plain_serializer_function_ser_schema(self.written)
        return core_schema.no_info_plain_validator_function(self.read, serialization=written)


def _digits(count: int) -> PlainSerializer:
    return PlainSerializer(lambda value: round(value, count))


_MILLIMETRES = PlainSerializer(lambda value: value if value is None else round(value, 2) + 0.0)

_GRASP = _Part(Grasp, {"x": 3, "y": 3, "angle": 6, "width": 3, "quality": 5})
_POSE = _Part(GraspPose, {"position": 6, "rotation": 6, "opening": 6}, {"position": (3,), "rotation": (3, 3)})
_ERROR = _Part(TcpError, {"position": 6, "angle": 6})
NESTED = {"grasp": tuple(_GRASP.digits), "pose": tuple(_POSE.digits), "tcp_error": tuple(_ERROR.digits)}
"""Fields that are objects in the file, and the keys of each."""
PART = "an object or null"


def _cut(text: Any) -> Any:
    return legible(text, LONGEST) if isinstance(text, str) else text


Detail = Annotated[Text, BeforeValidator(_cut)]


class MarginRecord(Stored):
    """How firmly an object was held at the end; all 0 for a failure.

    Attributes:
        force: least force that broke the grip [N].
        factor: the same as a multiple of the object's weight, which the grip bears besides.
        direction: in which direction of the gripper that was: ``+jaws``, ``-jaws``, ``+across``, ``-across``,
            ``+approach`` or ``-approach``; empty for a failure.
        torque: least torque about the jaw axis that broke the grip [N m].
    """

    force: Annotated[Number, Field(ge=0), _digits(3)] = 0.0
    factor: Annotated[Number, Field(ge=0), _digits(4)] = 0.0
    direction: Text = ""
    torque: Annotated[Number, Field(ge=0), _digits(5)] = 0.0


class Attempted(Stored):
    """The record of any attempt at an object.

    Attributes:
        object, category: names of what was tried.
        detail: why it ended like this, in words; empty for a success.
        grasp: the grasp carried out [px of the full image].
        pose: pose of the TCP at the grasp, in the world [m].
        rank: position of the grasp among the predictor's, from 0.
        widening_mm: how much wider than predicted the jaws opened; None where nothing was planned.
        shortfall_mm: how far above their wanted depth the tips were kept; None where nothing was planned.
        tcp_error: see :class:`TcpError`.
        lift_height: height of the object above its place, after lifting [m].
        contact_force: mean normal force of the two fingers at the end [N].
        sim_steps: physics steps taken, without those of the margin.
        margin: how firmly it was held; None where the scenario does not measure it.
    """

    leading = ("trial", "attempt", "object", "category", "seed", "outcome", "success")
    optional: ClassVar[tuple[str, ...]] = ("widening_mm", "shortfall_mm", "margin")
    """Keys that are not written where there is nothing to say, nor were before there were such keys."""

    object: Text
    category: Text
    outcome: Annotated[Outcome, Field(description=f"one of {', '.join(map(str, Outcome))}")]
    detail: Detail = ""
    grasp: Annotated[Grasp | None, _GRASP, Field(description=PART)] = None
    pose: Annotated[GraspPose | None, _POSE, Field(description=PART)] = None
    rank: Annotated[Count | None, Field(description="a whole number from 0 or null")] = None
    widening_mm: Annotated[Number | None, _MILLIMETRES, Field(description="a number or null")] = None
    shortfall_mm: Annotated[Number | None, _MILLIMETRES, Field(description="a number or null")] = None
    tcp_error: Annotated[TcpError | None, _ERROR, Field(description=PART)] = None
    lift_height: Annotated[Number, _digits(5)] = 0.0
    contact_force: Annotated[Number, _digits(3)] = 0.0
    sim_steps: Count = 0
    margin: Annotated[MarginRecord | None, Field(description=PART)] = None

    @property
    def success(self) -> bool:
        """Whether the object was lifted, carried and held."""
        return self.outcome is Outcome.SUCCESS

    @model_validator(mode="before")
    @classmethod
    def _without_success(cls, content: Any) -> Any:
        """Drop ``success``, written for readers of the file: ``outcome`` says it, too."""
        if not isinstance(content, dict) or "success" not in content:
            return content
        rest = dict(content)
        success = rest.pop("success")
        if success is not True and success is not False:
            raise ValueError(f"'success' must be true or false, not {shown(success)}")
        outcome = rest.get("outcome")
        if outcome in list(Outcome) and success is not (outcome == Outcome.SUCCESS):
            raise ValueError(f"'success' is {success} where the outcome is {outcome!r}")
        return rest

    @model_serializer(mode="wrap")
    def _in_order(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        content = handler(self) | {"success": self.success}
        content = {k: v for k, v in content.items() if k not in self.optional or v is not None}
        return {k: content[k] for k in [*(k for k in self.leading if k in content), *content]}


class AttemptRecord(Attempted):
    """An attempt of an episode: its number from 0, and the names of the objects that it took away."""

    attempt: Count
    removed: tuple[Text, ...] = ()


class EpisodeRecord(Stored):
    """The record of an episode of clutter: its objects, how many were cleared, and all attempts."""

    objects: Annotated[list[Text], Field(min_length=1)]
    cleared: Count
    attempts: list[AttemptRecord]

    @model_validator(mode="after")
    def _counted(self) -> EpisodeRecord:
        if self.cleared > len(self.objects):
            raise ValueError("more cleared than there were")
        return self


class TrialRecord(Attempted):
    """A line of ``trials.jsonl``: an attempt at one object, or a whole episode under ``clutter``.

    Attributes:
        trial: its number in the run.
        seed: the run's seed.
        clutter: the episode; None for a trial on one object.
    """

    trial: Count
    seed: Count | None = None
    clutter: Annotated[
        EpisodeRecord | None,
        Field(description="an episode's objects, attempts and how many objects were cleared"),
    ] = None

    @property
    def tries(self) -> list[tuple[int | None, Attempted]]:
        """Its attempts with their numbers: those of the episode, or itself with None."""
        if self.clutter is None:
            return [(None, self)]
        return list(enumerate(self.clutter.attempts))

    def as_attempt(self, number: int, removed: tuple[str, ...]) -> AttemptRecord:
        """Return the record of an episode's attempt, without what the episode says already."""
        shared = {name: getattr(self, name) for name in Attempted.model_fields}
        return AttemptRecord(attempt=number, removed=removed, **shared)

    @model_serializer(mode="wrap")
    def _in_order(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        content = super()._in_order(handler)
        return {k: v for k, v in content.items() if k not in ("seed", "clutter") or v is not None}


class Timings(Stored):
    """A line of ``timings.jsonl``: the seconds that a trial spent in each phase, by the phase's name."""

    __pydantic_extra__: dict[str, Number] = Field(init=False)

    trial: Count

    @property
    def seconds(self) -> dict[str, float]:
        """Seconds by phase."""
        return self.__pydantic_extra__

    @property
    def total(self) -> float:
        """Seconds of all phases."""
        return sum(self.seconds.values())
