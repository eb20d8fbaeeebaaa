"""On what the rim of a suction cup seals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from grasp_bench.system.arrays import Floats

AROUND = 24
"""Places at which the rim is looked at."""
WITHIN = (0.0, 0.5)
"""Radii of the rings inside of it at which holes are looked for, of the rim's."""


@dataclass(frozen=True)
class Seal:
    """Where a cup seals: the rim tilts onto the plane that fits the surface under it best, and follows what
    departs from that plane as far as it yields. Under all of it there is the same object, and nothing of it
    stands out further than the cup is hollow.

    Attributes:
        radius: of the rim [m].
        compliance: how far the rim yields from its plane [m].
        hollow: how far the surface may stand out into the cup [m].
        tilt: how far the rim tilts [rad].
    """

    radius: float
    compliance: float
    hollow: float
    tilt: float

    @property
    def places(self) -> Floats:
        """(P, 2) places in the rim's plane that are looked at [m]: the rim itself, then what is inside."""
        return self.radius * _unit_places()

    def faults(self, gaps: Floats) -> tuple[Floats, Floats, Floats]:
        """Return what keeps the cup from sealing, each (N,), at most 1 where it does.

        Args:
            gaps: (P, N) distances from the rim's plane to the surface at :attr:`places` [m].

        Returns:
            The tilt, the greatest departure from the plane and what stands out, as shares of what is allowed;
            NaN where there is no surface under the cup.
        """
        rim = gaps[:AROUND]
        plane = _solver() @ rim  # (3, N): distance of the plane at the middle, and its slopes over a radius
        departure = np.abs(rim - _planes()[:AROUND] @ plane).max(0)
        tilt = np.arctan(np.hypot(plane[1], plane[2]) / self.radius)
        out = (_planes()[AROUND:] @ plane - gaps[AROUND:]).max(0)
        return tilt / self.tilt, departure / self.compliance, out / self.hollow

    def fault(self, gaps: Floats) -> str:
        """Say why the cup does not seal over ``gaps`` (P,), NaN where nothing is; empty where it does."""
        if not np.isfinite(gaps).all():
            where = "its rim" if not np.isfinite(gaps[:AROUND]).all() else "it"
            return f"the cup does not seal: not all of {where} is over the object"
        tilt, departure, out = (float(f[0]) for f in self.faults(gaps[:, None]))
        if tilt > 1:
            most = math.degrees(self.tilt)
            return f"the cup does not seal: the surface is tilted by {most * tilt:.0f}°, not {most:.0f}°"
        if departure > 1:
            most = 1000 * self.compliance
            return (
                f"the cup does not seal: the surface departs from the rim's plane by "
                f"{most * departure:.1f} mm, not up to {most:.1f} mm"
            )
        if out > 1:
            most = 1000 * self.hollow
            return f"the cup does not seal: {most * out:.1f} mm stand out into it, not up to {most:.1f} mm"
        return ""


@lru_cache
def _unit_places() -> Floats:
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    inside = [r * ring[:: AROUND // 8] if r else np.zeros((1, 2)) for r in WITHIN]
    return np.vstack([ring, *inside])


@lru_cache
def _planes() -> Floats:
    places = _unit_places()
    return np.column_stack([np.ones(len(places)), places])


@lru_cache
def _solver() -> Floats:
    return np.asarray(np.linalg.pinv(_planes()[:AROUND]), float)
