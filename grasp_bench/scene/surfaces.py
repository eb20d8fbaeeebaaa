"""How the surfaces of a compiled scene look: base colours, albedo and roughness."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray


class Surfaces(NamedTuple):
    """How the surfaces of a scene's geoms reflect.

    Attributes:
        albedo: (ngeom,) share of light that comes back, 0 to 1: luminance of the linear base colour.
        roughness: (ngeom,) 0 (mirror) to 1 (matt); 1 for geoms that say nothing.
    """

    albedo: NDArray[np.float64]
    roughness: NDArray[np.float64]


def geom_colors(model: mujoco.MjModel) -> NDArray[np.float64]:
    """Return the (ngeom, 3) base colours; a material's colour replaces the geom's own."""
    colors = model.geom_rgba[:, :3].astype(float)
    made_of = model.geom_matid >= 0
    colors[made_of] = model.mat_rgba[model.geom_matid[made_of], :3]
    return colors


def surfaces(model: mujoco.MjModel) -> Surfaces:
    """Return albedo and roughness of all geoms of a model made by :mod:`grasp_bench.scene.builder`."""
    display = geom_colors(model)
    # IEC 61966-2-1
    linear = np.where(display <= 0.04045, display / 12.92, ((display + 0.055) / 1.055) ** 2.4)
    told = model.geom_user[:, 0] if model.nuser_geom else np.zeros(model.ngeom)
    return Surfaces(linear @ [0.2126, 0.7152, 0.0722], np.where(told > 0, told, 1.0))
