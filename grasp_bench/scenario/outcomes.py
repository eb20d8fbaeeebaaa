"""How a trial can end; every trial has exactly one outcome."""

from __future__ import annotations

from enum import StrEnum


class Outcome(StrEnum):
    """How a trial ended; every trial has exactly one."""

    SUCCESS = "success"
    NO_GRASP = "no_grasp"
    IK_FAILED = "ik_failed"
    BLOCKED = "blocked"
    APPROACH_COLLISION = "approach_collision"
    MISSED = "missed"
    SLIPPED = "slipped"
    DROPPED = "dropped"
    UNSTABLE = "unstable"
    TIMEOUT = "timeout"
    ERROR = "error"


HARNESS_FAULTS = frozenset({Outcome.UNSTABLE, Outcome.TIMEOUT, Outcome.ERROR})
"""Outcomes that are the harness's fault and not the predictor's; counted as failures."""
