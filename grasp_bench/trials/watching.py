"""Who watches an attempt, for pictures, films and logs; no record depends on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from grasp_bench.predictors.protocol import Predictor
from grasp_bench.scene.world import World
from grasp_bench.trials.attempt import Trial


class Watcher(Protocol):
    """Watches one attempt as its observer, and keeps something of it afterwards."""

    def __call__(self, world: World) -> None:
        """Look at the world, after every sample of the arm's motion."""
        ...

    def keep(self, done: Trial, predictor: Any) -> None:
        """Store what is wanted; never raises."""
        ...


Watch = Callable[[int | None], Watcher | None]
"""Gives the watcher of an attempt by its number in the episode, from 0, or None for a single trial."""


def unwatched(number: int | None) -> None:
    """Watch nothing."""


def watched(watcher: Watcher | None, predictor: Predictor, make: Callable[[Watcher | None], Trial]) -> Trial:
    """Make the attempt of ``make`` while it is watched, and keep what is wanted of it."""
    done = make(watcher)
    if watcher is not None:
        with done.clock.phase("media"):
            watcher.keep(done, predictor)
    return done
