"""Why a grasp is not carried out."""

from __future__ import annotations


class Unreachable(Exception):
    """The arm cannot carry out a grasp: outcome ``ik_failed``."""


class Blocked(Exception):
    """The fingers cannot get down to a grasp: outcome ``approach_collision``."""
