"""Whether a suction cup seals where it stands: rays from its rim to the true shape of what it touches."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from grasp_bench.robot.cup import SuctionCup
from grasp_bench.scene.contacts import touching
from grasp_bench.system.arrays import Floats

ABOVE = 0.01
"""Rays start this far above the rim [m]."""
FURTHEST = 0.03
"""What is further below the rim than this is not under the cup [m]."""


class Sealing:
    """Tells whether a cup of a compiled model seals.

    Args:
        model: with the cup.
        cup: the one it was compiled with.
        prefix: of the names of the cup's elements.
    """

    def __init__(self, model: mujoco.MjModel, cup: SuctionCup, prefix: str) -> None:
        self._model, self._seal = model, cup.seal
        self._plunger = model.body(prefix + cup.cup.plunger).id
        self._contact = model.geom(prefix + cup.cup.contact).id
        self._is_contact = np.arange(model.ngeom) == self._contact
        self._tcp = model.site(prefix + cup.tcp).id
        self._joint = int(model.joint(prefix + cup.finger_joints[0]).qposadr[0])

    def fault(self, data: mujoco.MjData, bodies: Sequence[int]) -> str:
        """Say why the cup does not seal on any of the objects ``bodies``; empty where it does."""
        touched = {
            int(self._model.geom_bodyid[g])
            for pair in data.contact.geom[touching(data, self._is_contact)]
            for g in pair
        } & set(bodies)
        if not touched:
            return "the cup does not seal: it touches no object"
        faults = [self._seal.fault(self.gaps(data, body)) for body in sorted(touched)]
        return min(faults, key=len)

    def gaps(self, data: mujoco.MjData, body: int) -> Floats:
        """Return the distances (P,) from the rim's plane down to the shape of ``body`` [m], NaN where it is
        not under the cup.

        Its parts that are only seen are its true shape; what has none is met as it collides.
        """
        model = self._model
        turn = data.site_xmat[self._tcp].reshape(3, 3)
        approach = np.ascontiguousarray(turn[:, 2])
        middle = data.site_xpos[self._tcp] + data.qpos[self._joint] * approach
        places = middle + self._seal.places @ turn[:, :2].T - ABOVE * approach
        geoms = [g for g in range(model.ngeom) if model.geom_bodyid[g] == body]
        seen = [g for g in geoms if not (model.geom_contype[g] or model.geom_conaffinity[g])]
        gaps = np.full(len(places), np.nan)
        for i, place in enumerate(places):
            found = [d for g in seen or geoms if (d := self._ray(data, g, place, approach)) >= 0]
            if found and min(found) - ABOVE < FURTHEST:
                gaps[i] = min(found) - ABOVE
        return gaps

    def _ray(self, data: mujoco.MjData, geom: int, start: Floats, way: Floats) -> float:
        model = self._model
        kind = int(model.geom_type[geom])
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            return mujoco.mj_rayMesh(model, data, geom, start, way)
        place, turn = data.geom_xpos[geom], data.geom_xmat[geom]
        return mujoco.mju_rayGeom(place, turn, model.geom_size[geom], start, way, kind)
