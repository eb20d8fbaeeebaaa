"""Why a grasp cannot be planned; each reason is the outcome of a trial that has no other grasp."""

from __future__ import annotations

from typing import ClassVar

from grasp_bench.scenario.outcomes import Outcome


class Refused(Exception):
    """A grasp that cannot be planned, and the outcome of a trial in which none can."""

    outcome: ClassVar[Outcome]


class Unreachable(Refused):
    """The arm cannot carry out a grasp."""

    outcome = Outcome.IK_FAILED


class Blocked(Refused):
    """The fingers cannot get down to a grasp: what the camera saw is in their way, and the arm stays where it
    is."""

    outcome = Outcome.BLOCKED
