"""Contacts between groups of geoms, as a trial's world and the floating gripper look for them."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]


def touching(data: mujoco.MjData, some: Mask, others: Mask | None = None) -> NDArray[np.intp]:
    """Return the indices (N,) of the contacts of a geom in ``some`` with one in ``others``, or with any.

    ``some`` and ``others`` are (ngeom,) masks. A contact need not carry a force: where it must, ask
    :func:`mujoco.mj_contactForce`.
    """
    pairs = data.contact.geom
    found = some[pairs].any(axis=1)
    if others is not None:
        found &= others[pairs].any(axis=1)
    return np.nonzero(found)[0]
