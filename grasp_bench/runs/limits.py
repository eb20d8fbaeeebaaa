"""Limits of a run: its trials, its seed, and the number of harness faults that it may have."""

from __future__ import annotations

import re
from dataclasses import dataclass

from grasp_bench.errors import GraspBenchError
from grasp_bench.system.texts import shown

MOST_TRIALS = 100_000_000
"""No run has more trials."""
MOST_SEED = 2**63 - 1
"""Largest seed of a run."""


def check_seed(seed: int) -> None:
    """Refuse a seed that no record holds; GraspBenchError."""
    if not 0 <= seed <= MOST_SEED:
        raise GraspBenchError(f"seed must be from 0 to {MOST_SEED}, not {shown(seed)}")


@dataclass(frozen=True)
class ErrorLimit:
    """A number of trials, or a share of them."""

    text: str
    value: float
    is_share: bool

    @classmethod
    def parse(cls, text: str) -> ErrorLimit:
        """Read ``3`` (trials) or ``2%`` (of the trials); GraspBenchError for anything else."""
        match = re.fullmatch(r"\s*(\d{1,9}|\d{1,3}(?:\.\d+)?\s*(%))\s*", text)
        if match is None or (match[2] and float(match[1].rstrip("% ")) > 100):
            raise GraspBenchError(
                f"--max-errors must be a number of trials, e.g. 3, or a share of them, e.g. 2%, not {text!r}."
            )
        return cls(text.strip(), float(match[1].rstrip("% ")) / (100 if match[2] else 1), bool(match[2]))

    def exceeded(self, faults: int, trials: int) -> bool:
        """Return whether so many ``faults`` among ``trials`` are too many."""
        return faults > (self.value * trials if self.is_share else self.value)

    def __str__(self) -> str:
        return self.text
