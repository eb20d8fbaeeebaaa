"""Depth images of a table: made level, and told from what surrounds the table.

Networks here are given height over the table, which they take to be at the median depth.
That holds for a camera that looks straight down, but neither for Jacquard's, which is
tilted (depth differs by 0.14 m across a plain table), nor for Cornell's distances from a robot's
base (0.6 m). The table is therefore fitted and taken off:

    depth'(u, v) = D − (S(u, v) − depth(u, v)),   D = median of S in the window

with S a polynomial of second degree in the pixel coordinates, fitted robustly in the window. It
is that and no plane since Cornell's distance to a plane is not a plane in the image: in five
samples the best plane leaves 20 % of the window within 6 mm, the second degree 81 % (2 mm
standard deviation); the third and fourth follow the wall behind the table. Heights stay those
along the depth's own direction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grasp_bench.system.arrays import Floats

Depth = NDArray[np.float32]

DEGREE = 2
LEAST_TOLERANCE = 0.004
"""Residuals below this are never taken for something on the table [m]."""
HIGHEST, LOWEST = 0.4, -0.2
"""Heights beyond these, such as walls and the floor, are clipped to them [m]."""


def levelled(depth: Depth, window: int) -> Depth:
    """Make the table level in (H, W) metres with 0 for invalid.

    Args:
        depth: metres, or distances that are smooth over the table.
        window: side of the square about the image's middle in which the table prevails [px].
    """
    surface = table_surface(depth, window)
    if surface is None:
        return depth
    h, w = depth.shape
    rows, columns = _middle(h, window), _middle(w, window)
    distance = float(np.median(surface[rows, columns]))
    height = np.clip(surface - depth, LOWEST, min(HIGHEST, 0.9 * distance))
    return np.where(depth > 0, distance - height, 0).astype(np.float32)


def table_surface(depth: Depth, window: int, step: int = 4) -> Floats | None:
    """Return the (H, W) depth of the table at each pixel; None where too little is measured to tell.

    Least absolute deviations by reweighting, then least squares over what lies within 2.5
    robust standard deviations.
    """
    h, w = depth.shape
    u, v = ((np.arange(n) + 0.5 - n / 2) / (window / 2) for n in (w, h))
    rows, columns = _middle(h, window), _middle(w, window)
    sub = depth[rows, columns][::step, ::step]
    grid = np.meshgrid(u[columns][::step], v[rows][::step])
    valid = sub > 0
    terms = _terms(grid[0][valid], grid[1][valid])
    y = sub[valid].astype(float)
    if len(y) < 10 * terms.shape[1]:
        return None
    weight = np.ones(len(y))
    residual = y
    for _ in range(15):
        residual = y - terms @ _solve(terms, y, weight)
        weight = 1 / np.maximum(np.abs(residual), 0.002)
    coefficients = _solve(terms, y, weight)
    for _ in range(4):
        near = np.abs(residual) < max(LEAST_TOLERANCE, 2.5 * 1.4826 * float(np.median(np.abs(residual))))
        coefficients = _solve(terms, y, near.astype(float))
        residual = y - terms @ coefficients
    return (_terms(*np.meshgrid(u, v)) @ coefficients).reshape(h, w)


def _middle(n: int, window: int) -> slice:
    start = max((n - window) // 2, 0)
    return slice(start, min(start + window, n))


def _terms(u: Floats, v: Floats) -> Floats:
    """Return the (…, 6) monomials up to ``DEGREE``."""
    return np.stack([u**i * v**j for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)], axis=-1)


def _solve(terms: Floats, y: Floats, weight: Floats) -> Floats:
    weighted = terms * weight[:, None]
    return np.asarray(np.linalg.lstsq(weighted.T @ terms, weighted.T @ y, rcond=None)[0], np.float64)
