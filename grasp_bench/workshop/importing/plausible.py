"""Mass properties held against the shape: what cannot be is refused with an estimate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.importing.folder import RefusedError
from grasp_bench.workshop.importing.units import DENSITIES, figure
from grasp_bench.workshop.shapes import Mesh

CENTRE_SLACK = 0.05
"""How far outside the hull the centre may lie, as a share of the longest side."""
INERTIA_SLACK = 1.05
"""Factor by which a moment may be larger than that of all mass at the farthest point, and than the two
others together."""


def check_density(mass: float, hull_volume: float, longest: float, typical: float) -> None:
    """Refuse a mass that no material gives to the convex hull.

    Args:
        mass: [kg].
        hull_volume: [m³].
        longest: longest side [m], for the message.
        typical: what the object would weigh at a common density [kg].

    Raises:
        RefusedError: with the density and an estimate.
    """
    density = mass / max(hull_volume, 1e-12)
    if not DENSITIES[0] <= density <= DENSITIES[1]:
        kind = "more than lead's" if density > DENSITIES[1] else "less than foam's"
        raise RefusedError(
            f"{figure(1000 * mass)} g in a shape {figure(1000 * longest)} mm long is "
            f"{figure(density, 2)} kg/m³, {kind}: about {figure(1000 * typical, 2)} g would be usual. "
            f"Check --mass, or the size (--units, --length, --scale)"
        )


def check_inertia(mass: float, centre: Floats, inertia: Floats, solid: Mesh) -> None:
    """Refuse a centre of mass outside the convex hull, and an inertia that no spread of the mass gives.

    Args:
        mass: [kg].
        centre: (3,) [m].
        inertia: (3, 3) about the centre [kg m²].
        solid: closed mesh [m].

    Raises:
        RefusedError: with what the shape alone would give.
    """
    points = np.asarray(solid.vertices, float)
    longest = float(np.ptp(points, axis=0).max())
    own = np.asarray(solid.center_mass, float)
    if not (np.isfinite(centre).all() and np.isfinite(inertia).all() and np.isfinite(mass)):
        raise RefusedError("its mass, centre of mass and inertia are not finite numbers")
    try:
        planes = ConvexHull(points).equations
    except QhullError as error:
        raise RefusedError("its convex hull encloses no volume") from error
    outside = float((planes[:, :3] @ centre + planes[:, 3]).max())
    if outside > CENTRE_SLACK * longest:
        raise RefusedError(
            f"its centre of mass ({_millimetres(centre)}) lies {figure(1000 * outside)} mm outside of its "
            f"shape; that of the shape is at ({_millimetres(own)}): correct it, or leave the inertia out"
        )
    moments = np.linalg.eigvalsh((inertia + inertia.T) / 2)
    reach = float(np.linalg.norm(points - centre, axis=1).max())
    estimate = np.linalg.eigvalsh(np.asarray(solid.moment_inertia, float) * mass / solid.volume)
    usual = f"its shape gives about ({_moments(estimate)}): correct the description, or leave its inertia out"
    if moments[0] <= 0:
        raise RefusedError(
            f"its principal moments of inertia ({_moments(moments)}) are not all positive; {usual}"
        )
    if moments[2] > INERTIA_SLACK * mass * reach**2:
        raise RefusedError(
            f"its inertia ({_moments(moments)}) is more than {figure(1000 * mass)} g have with all of it at "
            f"the farthest point, {mass * reach**2:.2g} kg m²; {usual}"
        )
    if moments[2] > INERTIA_SLACK * (moments[0] + moments[1]):
        raise RefusedError(
            f"one principal moment of inertia ({_moments(moments)}) is larger than the two others together, "
            f"as in no body; {usual}"
        )


def _millimetres(point: Floats) -> str:
    return ", ".join(figure(1000 * float(x)) for x in point) + " mm"


def _moments(moments: NDArray[np.floating]) -> str:
    return ", ".join(f"{x:.2g}" for x in moments) + " kg m²"
