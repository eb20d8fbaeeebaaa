"""When a training ends: after its steps, once it gets no better, or when its time is up.

A run of a given number of steps has its rate fall along a cosine to the last of them. A run that goes on
until it has flattened does not know its last step, so it keeps its rate, and lets it fall once something ends
it (warm-up, stable, decay: Hu et al., MiniCPM, 2024; a cosine cut short would stop at too high a rate):

    flat       the best of the last ``patience`` validations is not above the best before them by more than
               the standard error of such a share, √(p (1 − p) / n)
    minutes    the time is up, so much before it that the fall still fits in
    steps      the same for the number of steps

What is compared is the share of held-out grasps that hold in physics
(:mod:`grasp_bench.learning.training.held_out`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.learning.training.validate import Accuracy

FALL = 0.25
"""Steps in which the rate falls to zero, over the steps before it."""

Why = Literal["flat", "minutes", "steps"]


@dataclass(frozen=True)
class Point:
    """A validation.

    Attributes:
        step: steps done.
        seconds: time of training so far, validations included.
        held, tried: best grasps of held-out scenes that held in physics, of how many.
        hits, scenes, correct, labelled: what :class:`Accuracy` has.
    """

    step: int
    seconds: float
    held: int
    tried: int
    hits: int
    scenes: int
    correct: int
    labelled: int

    @property
    def figures(self) -> dict[str, float]:
        """All but the step, by name; those of tries only where there are any."""
        said = {k: v for k, v in vars(self).items() if k != "step"}
        return said if self.tried else {k: v for k, v in said.items() if k not in ("held", "tried")}


@dataclass
class Course:
    """How far a run has come.

    Attributes:
        config: its settings.
        seconds: time of training so far, interruptions left out.
        curve: its validations.
        falling: steps done when the rate began to fall; None before, and in runs of a given number of steps.
        why: what ended it, or will.
        flops: floating-point operations that training with one sample takes, forwards and backwards, those
            of convolutions and products of matrices; 0 where they were not counted.
    """

    config: TrainConfig
    seconds: float = 0.0
    curve: list[Point] = field(default_factory=list)
    falling: int | None = None
    why: Why = "steps"
    flops: float = 0.0

    @property
    def end(self) -> int:
        """Steps in all, as far as is known."""
        if self.falling is None:
            return self.config.steps
        return min(self.config.steps, self.falling + max(1, round(FALL * self.falling)))

    def rate(self, step: int) -> float:
        """Return the learning rate at ``step`` (from 0)."""
        if not self.config.open_ended:
            return self.config.learning_rate(step)
        whole = self.config.lr * min(1.0, (step + 1) / max(self.config.warmup, 1))
        if self.falling is None or step < self.falling:
            return whole
        done = (step - self.falling) / max(self.end - self.falling, 1)
        return whole * 0.5 * (1 + math.cos(math.pi * min(done, 1.0)))

    def validated(self, step: int, seconds: float, accuracy: Accuracy) -> None:
        """Note a validation after ``step`` steps and ``seconds``; the rate falls where all is flat."""
        self.seconds = seconds
        self.curve.append(Point(step, round(seconds, 1), **vars(accuracy)))
        if self.config.until_flat and self.falling is None and self.flat():
            self.falling, self.why = step, "flat"

    def reached(self, step: int, seconds: float) -> None:
        """Note that ``step`` steps are done after ``seconds``, and let the rate fall where it is time."""
        self.seconds = seconds
        if not self.config.open_ended or self.falling is not None:
            return
        most = self.config.max_minutes
        if most is not None and seconds >= 60 * most / (1 + FALL):
            self.falling, self.why = step, "minutes"
        elif step >= math.ceil(self.config.steps / (1 + FALL)):
            self.falling, self.why = step, "steps"

    def flat(self) -> bool:
        """Tell whether the last validations are no better than those before them, but for noise."""
        last, before = self.curve[-self.config.patience :], self.curve[: -self.config.patience]
        if not before:
            return False
        best = max(before, key=_share)
        p, n = _share(best), max(best.tried, 1)
        return p > 0 and max(map(_share, last)) <= p + math.sqrt(p * (1 - p) / n)

    def stored(self) -> dict[str, Any]:
        """Return as plain data what a resumed run needs."""
        points = [list(vars(point).values()) for point in self.curve]
        named = {k: v for k, v in vars(self).items() if k not in ("config", "curve")}
        return named | {"curve": points}

    def restore(self, stored: dict[str, Any]) -> None:
        """Take over what :meth:`stored` gave; raises KeyError or TypeError where it is something else."""
        self.seconds, self.falling, self.why = stored["seconds"], stored["falling"], stored["why"]
        self.flops = stored.get("flops", 0.0)
        self.curve = [Point(*point) for point in stored["curve"]]

    def told(self) -> str:
        """Say in a sentence how the run ended."""
        after = f"{self.end} steps, {self.seconds / 60:.0f} minutes"
        if self.why == "flat":
            return f"Flattened, no gain above the noise in {self.config.patience} validations: {after}."
        if self.why == "minutes":
            return f"Cut off by the clock, not known to have flattened: {after}."
        return f"Done: {after}."


def _share(point: Point) -> float:
    return point.held / point.tried if point.tried else 0.0
