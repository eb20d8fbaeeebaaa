"""Which unit a mesh is in, when the file does not say."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grasp_bench.workshop.importing.folder import RefusedError

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
LONGEST = (0.005, 0.6)
"""The longest side of what a table-top gripper can be asked to grasp [m]."""
THINNEST = 0.0003
DENSITIES = (15.0, 12_000.0)
"""From a hollow plastic toy to solid lead [kg/m³], by the volume of the convex hull."""


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
        if not LONGEST[0] <= longest * UNITS[unit] <= LONGEST[1]:
            raise RefusedError(
                f"{1000 * longest * UNITS[unit]:.3g} mm long with --units {unit}; objects of "
                f"{1000 * LONGEST[0]:.0f} to {1000 * LONGEST[1]:.0f} mm are imported"
            )
        return unit, ""
    possible = [u for u, s in UNITS.items() if LONGEST[0] <= longest * s <= LONGEST[1]]
    if not possible:
        raise RefusedError(
            f"its longest side, {longest:.4g}, is not {1000 * LONGEST[0]:.0f} to "
            f"{1000 * LONGEST[1]:.0f} mm in any of {', '.join(UNITS)}"
        )
    weighed = (
        possible
        if mass is None
        else [
            u
            for u in possible
            if DENSITIES[0] <= mass / max(hull_volume * UNITS[u] ** 3, 1e-12) <= DENSITIES[1]
        ]
    )
    likely = weighed or possible
    # Metres are what scanners and robotics write, millimetres what CAD does; centimetres are rarer,
    # and what would be below 10 mm long is more likely in centimetres.
    order = ("m", "mm", "cm") if longest >= 10 else ("m", "cm", "mm")
    chosen = next(u for u in order if u in likely)
    others = [f"{u} would make it {1000 * longest * UNITS[u]:.0f} mm" for u in possible if u != chosen]
    note = f"taken to be in {chosen}: {1000 * longest * UNITS[chosen]:.0f} mm long"
    return chosen, note + (f" ({', '.join(others)}; --units decides)" if others else "")


def check_size(extents: NDArray[np.float64]) -> None:
    """Refuse what is flat.

    Raises:
        RefusedError: with the measure.
    """
    if extents.min() < THINNEST:
        raise RefusedError(f"it is flat: {1000 * float(extents.min()):.2g} mm thin")
