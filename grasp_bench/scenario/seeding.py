"""One random stream per trial and purpose, so that nothing depends on order or company.

The stream of (seed, object, trial, purpose) is the same whatever other objects, trials or
workers a run has: adding an object or a worker changes no other trial.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from zlib import crc32

import numpy as np


class Purpose(IntEnum):
    """What a stream of random numbers is for."""

    POSE = 1
    SENSOR = 2
    PREDICTOR = 3
    APPEARANCE = 4
    CALIBRATION = 5
    CLUTTER = 6
    VIEWS = 7


def stream(run_seed: int, name: str, trial: int, purpose: Purpose) -> np.random.Generator:
    """Return the generator for one purpose of the ``trial``-th attempt on object ``name``."""
    return np.random.default_rng(np.random.SeedSequence([run_seed, crc32(name.encode()), trial, purpose]))


@dataclass(frozen=True)
class Streams:
    """The random streams of one attempt.

    Attributes:
        seed: the run's seed.
        name: the object's name; for an attempt in an episode, its own.
        attempt: how many times it was tried before in the run, from 0.
    """

    seed: int
    name: str
    attempt: int

    def __call__(self, purpose: Purpose) -> np.random.Generator:
        """Return the stream for one purpose."""
        return stream(self.seed, self.name, self.attempt, purpose)
