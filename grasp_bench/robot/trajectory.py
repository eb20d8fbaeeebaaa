"""Joint trajectories through waypoints, timed within the arm's velocity limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded

from grasp_bench.robot.ec66 import EC66
from grasp_bench.system.arrays import Floats

PEAK = 1.875
"""Greatest slope of the minimum-jerk time law 10 s³ − 15 s⁴ + 6 s⁵."""


@dataclass(frozen=True)
class Trajectory:
    """Sampled joint motion.

    Attributes:
        positions: (T, N) joint angles [rad].
        velocities: (T, N) joint velocities [rad/s].
    """

    positions: Floats
    velocities: Floats

    def then(self, other: Trajectory) -> Trajectory:
        """Return this motion followed by another, which begins where this one ends."""
        return Trajectory(
            np.concatenate([self.positions, other.positions]),
            np.concatenate([self.velocities, other.velocities]),
        )

    @property
    def end(self) -> Floats:
        """(N,) joint angles at the end."""
        return self.positions[-1]


class NaturalSpline:
    """The cubic spline through points, without curvature at both ends.

    To the bit what SciPy's ``CubicSpline(..., bc_type="natural")`` gives, whose import takes a tenth of
    a worker's start; a test compares them. Slopes at the knots solve a tridiagonal system (C. de Boor, *A
    Practical Guide to Splines*, chapter IV).

    Args:
        knots: (K,) ascending, K ≥ 3.
        points: (K, N) to pass through.
    """

    def __init__(self, knots: Floats, points: Floats) -> None:
        step = np.diff(knots)
        rise = np.diff(points, axis=0) / step[:, None]
        diagonal = 2 * np.concatenate([step[:1], step[:-1] + step[1:], step[-1:]])
        above, below = np.append(step[0], step[:-1]), np.append(step[1:], step[-1])
        slopes = np.empty_like(points)
        slopes[0], slopes[-1] = 3 * (points[1] - points[0]), 3 * (points[-1] - points[-2])
        slopes[1:-1] = 3 * (step[1:, None] * rise[:-1] + step[:-1, None] * rise[1:])
        bands = np.stack([np.append(0, above), diagonal, np.append(below, 0)])
        slopes = solve_banded((1, 1), bands, slopes)
        bend = (slopes[:-1] + slopes[1:] - 2 * rise) / step[:, None]
        self._knots = knots
        self._terms = (
            points[:-1],
            slopes[:-1],
            (rise - slopes[:-1]) / step[:, None] - bend,
            bend / step[:, None],
        )

    def __call__(self, at: Floats, order: int = 0) -> Floats:
        """Return (T, N) values, or derivatives with ``order`` 1, at (T,) places."""
        which = np.clip(np.searchsorted(self._knots, at, side="right") - 1, 0, len(self._knots) - 2)
        s = (at - self._knots[which])[:, None]
        a, b, c, d = (term[which] for term in self._terms)
        if order == 1:
            return b + c * s * 2 + d * (s * s) * 3
        return a + b * s + c * (s * s) + d * (s * s * s)


def through(
    waypoints: list[Floats],
    period: float,
    speed_fraction: float,
    length: float = 0.0,
    speed: float = np.inf,
    limits: Sequence[float] = EC66.velocity_limits,
) -> Trajectory:
    """Return a smooth motion through joint waypoints, at rest at both ends.

    The path is a cubic spline over the waypoints; a minimum-jerk law runs along it, slow
    enough for every joint to stay below ``speed_fraction`` of its velocity limit and for the
    TCP, which covers ``length`` metres, to stay below ``speed`` m/s on average peak.

    Args:
        waypoints: at least two (N,) joint vectors [rad].
        period: sampling period [s].
        speed_fraction: share of the joints' velocity limits that may be used, (0, 1].
        length: path length of the TCP [m]; 0 when only the joints matter.
        speed: greatest speed of the TCP [m/s].
        limits: (N,) the arm's velocity limits [rad/s].
    """
    q = np.asarray(waypoints, dtype=float)
    step = np.linalg.norm(np.diff(q, axis=0), axis=1)
    if step.sum() < 1e-9:
        return Trajectory(q[-1:].copy(), np.zeros((1, q.shape[1])))
    knots = np.concatenate([[0.0], np.cumsum(np.maximum(step, 1e-9))])
    knots /= knots[-1]
    spline = NaturalSpline(knots, q) if len(q) > 2 else None

    def path(s: Floats, order: int = 0) -> Floats:
        if spline is not None:
            return spline(s, order)
        if order == 0:
            return q[0] + s[:, None] * (q[-1] - q[0])
        return np.repeat((q[-1] - q[0])[None], len(s), axis=0)

    dense = np.linspace(0, 1, 65)
    law = 30 * dense**2 * (1 - dense) ** 2
    at = dense**3 * (10 - 15 * dense + 6 * dense**2)
    slope = np.abs(path(at, 1)) * law[:, None] / np.asarray(limits)
    duration = max(float(slope.max()) / speed_fraction, PEAK * length / speed, 2 * period)
    count = int(np.ceil(duration / period))
    u = np.arange(1, count + 1) / count
    s = u**3 * (10 - 15 * u + 6 * u**2)
    rate = 30 * u**2 * (1 - u) ** 2 / (count * period)
    return Trajectory(path(s), path(s, 1) * rate[:, None])
