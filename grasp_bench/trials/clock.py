"""Where the time of a trial goes."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from grasp_bench.runs.record import Timings


@dataclass
class Clock:
    """Seconds spent in each phase."""

    seconds: dict[str, float] = field(default_factory=dict)

    def timings(self, trial: int) -> Timings:
        """Return the seconds of a trial's phases, as they are stored."""
        return Timings.model_validate({"trial": trial} | {k: round(v, 6) for k, v in self.seconds.items()})

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Time a block."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start
