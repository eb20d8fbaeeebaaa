"""Choices of the trials of a run that get pictures and clips."""

from __future__ import annotations

from grasp_bench.errors import UnknownNameError

MODES = ("none", "failures", "all")
"""Tries that get a clip; in every mode but ``none``, all get pictures."""


def check_mode(mode: str) -> str:
    """Return ``mode``, or raise UnknownNameError for one that is not in :data:`MODES`."""
    if mode not in MODES:
        raise UnknownNameError("choice of media", mode, MODES)
    return mode
