"""Which trials of a run get pictures and clips."""

from __future__ import annotations

from grasp_bench.errors import UnknownNameError

MODES = ("none", "failures", "all")
"""Tries that get pictures and a clip; in every mode but ``none``, all get the pictures."""


def check_mode(mode: str) -> str:
    """``mode`` if it is one.

    Raises:
        UnknownNameError: if not.
    """
    if mode not in MODES:
        raise UnknownNameError("choice of media", mode, MODES)
    return mode
