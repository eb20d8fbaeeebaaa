"""Which unit a mesh is in, when the file does not say."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grasp_bench.workshop.importing.folder import RefusedError

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
LONGEST = (0.005, 0.6)
"""The longest side of what a table-top gripper can be asked to grasp [m]."""
THINNEST = 0.0003
DENSITIES = (15.0, 12_000.0)
"""From a hollow plastic toy to solid lead [kg/m³], by the volume of the convex hull."""
NORMALISED = (LONGEST[1], 1.2)
"""Without a mass, a mesh whose longest side is between these is taken to have been scaled to the length 1."""
REMEDY = "give its longest side with --length METRES, or its unit with --units"


def figure(value: float, digits: int = 3) -> str:
    """Return a number of so many significant digits as people write it: never with an exponent."""
    return np.format_float_positional(float(f"{value:.{digits}g}"), trim="-")


def choose_unit(
    extents: NDArray[np.float64], unit: str, mass: float | None, hull_volume: float
) -> tuple[str, str]:
    """Return the unit and, where it was guessed, a note on that.

    Args:
        extents: (3,) edges of the bounding box in the file's unit.
        unit: ``auto`` or a key of :data:`UNITS`.
        mass: that of the object, if known [kg]: rules out units in which the density would be absurd.
        hull_volume: volume of the convex hull, in the file's unit.

    Raises:
        RefusedError: for sizes that are not sensible, in this or in any unit.
    """
    longest = float(extents.max())
    if unit != "auto":
        check_length(longest * UNITS[unit], f"with --units {unit}")
        return unit, ""
    possible = [u for u, s in UNITS.items() if LONGEST[0] <= longest * s <= LONGEST[1]]
    if not possible:
        raise RefusedError(
            f"its longest side, {longest:.4g}, is not {1000 * LONGEST[0]:.0f} to "
            f"{1000 * LONGEST[1]:.0f} mm in any of {', '.join(UNITS)}; {REMEDY}"
        )
    # Metres are what scanners and robotics write, millimetres what CAD does; centimetres are rarer,
    # and what would be below 10 mm long is more likely in centimetres. Inches need a mass to be guessed.
    order = ("m", "mm", "cm", "in") if longest >= 10 else ("m", "cm", "mm", "in")
    likely = possible
    if mass is not None:
        density = {u: mass / max(hull_volume * UNITS[u] ** 3, 1e-12) for u in possible}
        likely = [u for u in possible if DENSITIES[0] <= density[u] <= DENSITIES[1]]
        if not likely:
            told = ", ".join(
                f"{figure(1000 * longest * UNITS[u])} mm and {figure(density[u], 1)} kg/m³ in {u}"
                for u in possible
            )
            raise RefusedError(f"{figure(1000 * mass)} g make no sense in any unit ({told}): {REMEDY}")
    elif NORMALISED[0] < longest <= NORMALISED[1]:
        raise RefusedError(
            f"its longest side is {longest:.4g}, as of a mesh that was scaled to the length 1 and has no "
            f"unit: {REMEDY}, or its mass with --mass"
        )
    chosen = next(u for u in order if u in likely)
    others = [f"{u} would make it {1000 * longest * UNITS[u]:.0f} mm" for u in possible if u != chosen]
    note = f"taken to be in {chosen}: {1000 * longest * UNITS[chosen]:.0f} mm long"
    return chosen, note + (f" ({', '.join(others)}; --units decides)" if others else "")


def check_length(longest: float, how: str) -> None:
    """Refuse a longest side [m] that no table-top object has; ``how`` it came about.

    Raises:
        RefusedError: with the length.
    """
    if not LONGEST[0] <= longest <= LONGEST[1]:
        raise RefusedError(
            f"{figure(1000 * longest)} mm long {how}; objects of {1000 * LONGEST[0]:.0f} to "
            f"{1000 * LONGEST[1]:.0f} mm are imported: {REMEDY}"
        )


def check_size(extents: NDArray[np.float64]) -> None:
    """Refuse what is flat.

    Raises:
        RefusedError: with the measure.
    """
    if extents.min() < THINNEST:
        raise RefusedError(f"it is flat: {1000 * float(extents.min()):.2g} mm thin")
