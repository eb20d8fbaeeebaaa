"""Postures of an arm that is known by its model alone."""

from __future__ import annotations

from pathlib import Path

import mink
import mujoco
import numpy as np

from grasp_bench.errors import AssetError
from grasp_bench.system.arrays import Floats

STARTS = 60
STEPS = 80


class Postures:
    """Looks for joint angles at which the tool points down, elbow up, ahead of the base.

    Args:
        model: of the arm alone.
        source: named in errors.
    """

    def __init__(self, model: mujoco.MjModel, source: Path) -> None:
        self.source = source
        self.configuration = mink.Configuration(model)
        self.model = model
        self.task = mink.FrameTask(
            "grasp_bench_flange", "site", position_cost=1.0, orientation_cost=0.3, lm_damping=1e-6
        )
        self.limits = [mink.ConfigurationLimit(model)]
        # With these at 0, an arm of six or seven joints stays in the vertical plane ahead of it.
        self._sideways = [0] if model.nq == 6 else [0, 2, 4]

    def find(self, ahead: float, height: float) -> Floats:
        """Return (N,) angles [rad] of the flange straight ahead: high elbow, joints far from their ends.

        Raises:
            AssetError: where there are none.
        """
        found = self._solutions(ahead, height)
        if not found:
            self.configuration.update(self.model.qpos0)
            links = np.linalg.norm(np.diff(self.configuration.data.xanchor, axis=0), axis=1).sum()
            raise AssetError(
                f"{self.source}: no posture was found with the tool pointing down {ahead:g} m ahead of the "
                f"base, {height:g} m high, of an arm whose joints are {links:.2f} m from first to last. Does "
                "z of the flange point out of it? If not, say --flange; if so, --ready and --home."
            )
        return max(found, key=self._merit)

    def first(self, places: tuple[tuple[float, float], ...], near: Floats) -> Floats:
        """Return (N,) angles [rad] at the first of ``places`` that can be reached, nearest to ``near``."""
        for ahead, height in places:
            if found := self._solutions(ahead, height, near):
                return min(found, key=lambda q: float(np.abs(q - near).max()))
        return near

    def _merit(self, q: Floats) -> float:
        self.configuration.update(q)
        data, ranges = self.configuration.data, self.model.jnt_range
        elbow = float(data.xanchor[:, 2].max())
        room = np.minimum(q - ranges[:, 0], ranges[:, 1] - q).min()
        return elbow + 0.1 * min(float(room), 1.0) - float(np.abs(q[self._sideways]).sum())

    def _solutions(self, ahead: float, height: float, near: Floats | None = None) -> list[Floats]:
        rng = np.random.default_rng(0)
        low, high = (np.clip(self.model.jnt_range[:, i], -np.pi, np.pi) for i in (0, 1))
        turn = np.diag([1.0, -1.0, -1.0])
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn, [ahead, 0.0, height]
        self.task.set_target(mink.SE3.from_matrix(pose))
        found = []
        for i in range(STARTS):
            start = rng.uniform(0.7 * low, 0.7 * high) if near is None or i else near
            start[self._sideways] = 0.0
            q = self._descend(np.clip(start, low, high))
            if q is not None and abs(q[0]) < np.pi / 2:
                found.append(q)
        return found

    def _descend(self, start: Floats) -> Floats | None:
        self.configuration.update(start)
        for _ in range(STEPS):
            error = self.task.compute_error(self.configuration)
            if np.linalg.norm(error[:3]) < 1e-5 and np.linalg.norm(error[3:]) < 1e-4:
                return self.configuration.q.copy()
            try:
                velocity = mink.solve_ik(
                    self.configuration, [self.task], 0.1, solver="daqp", damping=1e-6, limits=self.limits
                )
            except mink.MinkError:
                return None
            self.configuration.integrate_inplace(np.clip(velocity, -5, 5), 0.1)
        return None
