"""Shaking what is held: a burst of sinusoidal acceleration along each axis of the gripper."""

from __future__ import annotations

import math

import numpy as np

from grasp_bench.robot.trajectory import Trajectory
from grasp_bench.scenario.sections import Shake
from grasp_bench.system.arrays import Floats

AXES = ("along the jaws", "across the jaws", "along the approach")
"""The TCP's x, y and z, in the order in which they are shaken."""

SWELL = 2
"""Cycles of swelling: with fewer, the swelling itself would accelerate beyond what is asked for."""


def amplitude(shake: Shake) -> float:
    """Return the greatest distance from the middle [m]: a / (2 π f)²."""
    return shake.acceleration / (2 * math.pi * shake.frequency) ** 2


def burst(shake: Shake, period: float) -> tuple[Floats, Floats]:
    """Return offsets (T,) [m] and speeds (T,) [m/s] of one burst, sampled every ``period`` seconds.

    A sine of ``shake.cycles`` full cycles, and :data:`SWELL` before and after them over which it swells and
    fades along a minimum-jerk law, so that it begins and ends at rest.
    """
    rise = SWELL / shake.frequency
    whole = shake.cycles / shake.frequency + 2 * rise
    time = period * np.arange(1, round(whole / period) + 1)
    s = np.clip(np.minimum(time, whole - time) / rise, 0, 1)
    swell = s**3 * (10 - 15 * s + 6 * s**2)
    rate = np.where(time < whole / 2, 30.0, -30.0) * s**2 * (1 - s) ** 2 / rise
    omega = 2 * math.pi * shake.frequency
    a = amplitude(shake)
    return (
        a * swell * np.sin(omega * time),
        a * (rate * np.sin(omega * time) + swell * omega * np.cos(omega * time)),
    )


def shaken(ends: tuple[Floats, Floats], middle: Floats, shake: Shake, period: float) -> Trajectory:
    """Return the joint motion of one burst.

    Args:
        ends: joint angles (6,) with the TCP at minus and at plus the amplitude [rad].
        middle: joint angles (6,) where the burst begins and ends [rad].
        shake: amplitude, frequency and number of cycles.
        period: sampling period [s].
    """
    offset, speed = burst(shake, period)
    u, rate = (x[:, None] / amplitude(shake) for x in (offset, speed))
    # The parabola through the three postures: over a few millimetres it is the straight line of the TCP.
    slope, bend = (ends[1] - ends[0]) / 2, (ends[1] + ends[0]) / 2 - middle
    return Trajectory(middle + slope * u + bend * u**2, (slope + 2 * bend * u) * rate)
