"""The items of a race: trials drawn at random, each object as likely as any other every time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from grasp_bench.runs.jobs import Job, Jobs, spread

ATTEMPTS = 100
"""Attempts at each object that a race's run has; far more than are ever drawn."""


def whole(objects: Sequence[str]) -> Jobs:
    """Return the run that all items are trials of: every object :data:`ATTEMPTS` times."""
    return spread(objects, ATTEMPTS * len(objects))


def draw(objects: Sequence[str], items: int, seed: int) -> list[Job]:
    """Draw items with replacement, so that they are independent, as tests by betting want them.

    An object that is drawn again is tried again: its next attempt, in another place. Items are trials of
    :func:`whole`, the first ones are the same whatever their number, and none comes twice.

    Raises:
        ValueError: when an object would be tried more often than a run has attempts.
    """
    rng = np.random.default_rng(np.random.SeedSequence([seed, len(objects)]))
    before: Counter[int] = Counter()
    jobs, run = [], whole(objects)
    for which in (int(rng.integers(len(objects))) for _ in range(items)):
        if before[which] >= ATTEMPTS:
            raise ValueError(f"{items} items of {len(objects)} objects are too many")
        jobs.append(run.job(before[which] * len(objects) + which))
        before[which] += 1
    return jobs
