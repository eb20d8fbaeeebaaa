"""Procedural textures: how much of a pattern's colour there is at points in space."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from grasp_bench.scenario.look import Pattern, Texture

Points = NDArray[np.float32]
Amounts = NDArray[np.float32]

LATTICE = 32
"""Side of the random lattice that repeats in space."""
LATTICES = 8
"""Different lattices; textures with other seeds take another place in one of them."""


@lru_cache(maxsize=LATTICES)
def _lattice(which: int) -> NDArray[np.float32]:
    from scipy.ndimage import gaussian_filter

    values = gaussian_filter(
        np.random.default_rng([17, which]).standard_normal((LATTICE,) * 3), 0.8, mode="wrap"
    )
    return (values / values.std()).astype(np.float32)


def noise(points: Points, seed: int, octaves: int = 2) -> Amounts:
    """Return smooth random values (N,), mean 0 and standard deviation about 1, at ``points`` (N, 3)."""
    from scipy.ndimage import map_coordinates

    offset = np.random.default_rng(seed).uniform(0, LATTICE, 3)
    total, power = np.zeros(len(points), np.float32), 0.0
    for octave in range(octaves):
        share = 0.5**octave
        place = points.T * 2.0**octave + offset[:, None]
        total += share * map_coordinates(
            _lattice((seed + octave) % LATTICES), place, order=1, mode="grid-wrap", output=np.float32
        )
        power += share**2
    return total / np.float32(0.7 * np.sqrt(power))


def _clouds(points: Points, seed: int) -> Amounts:
    return 0.5 + 0.35 * noise(points, seed, 3)


def _speckles(points: Points, seed: int) -> Amounts:
    return np.clip(4 * (noise(2 * points, seed, 1) - 0.9), 0, 1)


def _stripes(points: Points, seed: int) -> Amounts:
    share = np.random.default_rng(seed).uniform(0.1, 0.6)
    return (np.mod(points[:, 0], 1) < share).astype(np.float32)


def _checks(points: Points, seed: int) -> Amounts:
    cells = np.floor(points + [0.013, 0.017, 0.019]).astype(np.int32)  # faces lie on no cell's border
    return (cells.sum(1) % 2).astype(np.float32)


def _grain(points: Points, seed: int) -> Amounts:
    along = points * np.array([0.12, 1, 1], np.float32)
    phase = np.float32(2 * np.pi) * (np.float32(1.5) * along[:, 1] + np.float32(0.5) * noise(along, seed, 2))
    return (0.5 + 0.5 * np.sin(phase)).astype(np.float32)


def _marble(points: Points, seed: int) -> Amounts:
    return np.exp(-6 * np.abs(np.sin(0.8 * points[:, 0] + 1.3 * noise(points * np.float32(0.4), seed, 3))))


def _patches(points: Points, seed: int) -> Amounts:
    return (noise(0.5 * points, seed, 1) > 0.2).astype(np.float32)


_PATTERNS: dict[Pattern, Callable[[Points, int], Amounts]] = {
    "clouds": _clouds,
    "speckles": _speckles,
    "stripes": _stripes,
    "checks": _checks,
    "grain": _grain,
    "marble": _marble,
    "patches": _patches,
}


def amount(texture: Texture, points: NDArray[np.floating]) -> Amounts:
    """Return (N,) how much of the texture's colour there is at ``points`` (N, 3) [m], 0 to 1."""
    angle = np.radians(texture.turn_deg)
    c, s = np.cos(angle), np.sin(angle)
    turned = points @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) / texture.scale
    value = _PATTERNS[texture.pattern](turned.astype(np.float32), texture.seed)
    return (texture.contrast * np.clip(value, 0, 1)).astype(np.float32)
