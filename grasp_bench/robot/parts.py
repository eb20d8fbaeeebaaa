"""Parts of a compiled model by name, and the place of the TCP."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from grasp_bench.errors import AssetError

OFF_AXIS = 1e-4
"""How far the TCP may be beside the flange's axis [m]."""


def compiled(path: Path) -> mujoco.MjModel:
    """Compile a part's MJCF.

    Raises:
        AssetError: in one line, for what MuJoCo refuses.
    """
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise AssetError(f"{path} is refused by MuJoCo: {' '.join(str(error).split())}") from error


def find(model: mujoco.MjModel, path: Path, kind: str, table: mujoco.mjtObj, name: str) -> int:
    """Return the id of an element.

    Args:
        kind: what it is called in the error.

    Raises:
        AssetError: where there is none of that name; it lists those that are there.
    """
    found = mujoco.mj_name2id(model, table, name)
    if found < 0:
        objects = mujoco.mjtObj
        count = {
            objects.mjOBJ_BODY: model.nbody,
            objects.mjOBJ_GEOM: model.ngeom,
            objects.mjOBJ_SITE: model.nsite,
            objects.mjOBJ_ACTUATOR: model.nu,
        }[table]
        names = [n for i in range(count) if (n := mujoco.mj_id2name(model, table, i))]
        valid = ", ".join(names[:20]) or "none with a name"
        raise AssetError(f"{path} has no {kind} {name!r}; it has {valid}.")
    return found


def tcp_place(model: mujoco.MjModel, data: mujoco.MjData, path: Path, tcp: int) -> float:
    """Return how far the site ``tcp`` is from the flange [m].

    Raises:
        AssetError: where it is not on the flange's z axis with the same axes.
    """
    at = data.site_xpos[tcp]
    if max(abs(at[0]), abs(at[1])) > OFF_AXIS or np.abs(data.site_xmat[tcp] - np.eye(3).ravel()).max() > 1e-4:
        raise AssetError(
            f"{path}: the TCP {model.site(tcp).name!r} must lie on the flange's z axis with the same axes; "
            f"it is at ({1000 * at[0]:.1f}, {1000 * at[1]:.1f}, {1000 * at[2]:.1f}) mm."
        )
    return float(at[2])


def metres(length: float) -> float:
    """Return a measured length to a micrometre."""
    return round(float(length), 6) + 0.0
