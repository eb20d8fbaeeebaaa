"""The mass of an imported object, and how it is spread."""

from __future__ import annotations

import numpy as np

from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.importing.body import Body, Options
from grasp_bench.workshop.importing.folder import RefusedError
from grasp_bench.workshop.importing.units import figure
from grasp_bench.workshop.shapes import Mesh

MASSES = (0.001, 5.0)
"""What the arm can carry, gripper aside, and what contacts are stable with [kg]."""
DENSITY = 500.0
"""Assumed where no mass is given [kg/m³]: between hollow plastic and wood."""


def spread_mass(solid: Mesh, mass: float, how: str) -> tuple[Floats, Floats]:
    """Return the centre of mass (3,) [m] and inertia (3, 3) about it [kg m²].

    Args:
        solid: closed mesh [m].
        how: ``solid``, evenly over the volume; ``shell``, evenly over the surface.
    """
    if how == "solid":
        return np.asarray(solid.center_mass), np.asarray(solid.moment_inertia) * mass / solid.volume
    a, b, c = np.moveaxis(np.asarray(solid.vertices)[solid.faces], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    # The mean of a quadratic over a triangle is that over its edges' midpoints.
    middles = np.stack([a + b, b + c, c + a], axis=1) / 2
    weights = np.repeat(area / 3, 3) * mass / area.sum()
    points = middles.reshape(-1, 3)
    centre = weights @ points / mass
    offset = points - centre
    second = (weights[:, None] * offset).T @ offset
    return centre, np.trace(second) * np.eye(3) - second


def choose_mass(body: Body, options: Options) -> tuple[float, str]:
    """Return an object's mass [kg] and a note where it had to be assumed: what is given goes before a
    density, and that before the file's own.

    Raises:
        RefusedError: for a mass that cannot be lifted or simulated.
    """
    note = ""
    if options.mass is not None:
        mass = options.mass
    elif options.density is not None:
        mass = options.density * float(body.solid.volume)
    elif body.mass is not None:
        mass = body.mass
    else:
        mass = DENSITY * float(body.solid.volume)
        note = f"no mass given: {1000 * mass:.0f} g assumed, from {DENSITY:.0f} kg/m³"
    if not MASSES[0] <= mass <= MASSES[1]:
        raise RefusedError(
            f"a mass of {figure(1000 * mass)} g; {1000 * MASSES[0]:.0f} g to {MASSES[1]:.0f} kg "
            "can be lifted and simulated: give --mass, or check the size (--units, --length, --scale)"
        )
    return mass, note
