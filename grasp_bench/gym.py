"""One trial as a Gymnasium environment: see the picture, choose a grasp, be told whether it held.

A contextual bandit: every episode has one step. Importing this module registers
``grasp_bench/Grasp-v0``. Needs the extra ``gym`` (``pip install grasp-bench[gym]``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grasp_bench.api import PathLike, select_objects
from grasp_bench.camera import RgbdImage
from grasp_bench.errors import GraspBenchError
from grasp_bench.grasps import Grasp, wrap_angle
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Scenario
from grasp_bench.system.graphics import without_gl

ENV_ID = "grasp_bench/Grasp-v0"
HIGHEST = 0.15
"""Widths are in units of the open jaws, seen at this height above the table [m]."""

Observation = dict[str, Any]
Action = NDArray[np.floating]


class GraspEnv(gymnasium.Env[Observation, Action]):
    """One object on a table, one grasp, one verdict.

    *Observation*: ``rgb`` (size, size, 3) uint8 and ``depth`` (size, size) float32 in metres, 0 where the
    camera measured nothing: the middle square of the scenario's noisy image.

    *Action*: five numbers in [−1, 1]: x and y of the grasp's centre from the left and upper edge (−1) to
    the right and lower one (1), sin 2θ and cos 2θ of the direction in which the jaws open
    (counter-clockwise as seen; only their ratio counts), and the opening from 0 (−1) to the widest (1).

    *Reward*: 1 for ``success``, 0 for all else. ``info`` of :meth:`step` is the trial's record.

    The 180 shipped objects are for testing. Train on a folder of other objects, or the result says
    nothing about unknown ones.

    Args:
        objects: as in :func:`grasp_bench.run`; each episode draws one.
        scenario: name, path or :class:`~grasp_bench.Scenario`.
        size: edge of the square that is seen [px]; the networks' 224 by default.
        renderer: as in :func:`grasp_bench.run`.
        render_mode: ``rgb_array`` or None.

    Raises:
        GraspBenchError: for unknown names, or a square larger than the scenario's image.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 1}  # noqa: RUF012  (Gymnasium's own form)

    def __init__(
        self,
        objects: PathLike | Sequence[str] = "all",
        scenario: PathLike | Scenario = "table4",
        size: int = 224,
        renderer: str = "auto",
        render_mode: str | None = None,
    ) -> None:
        without_gl()
        from grasp_bench.trials.workcell import Workcell

        chosen = scenario if isinstance(scenario, Scenario) else load_scenario(str(scenario))
        self._catalog, self._names = select_objects(objects, home=chosen.objects.folder)
        camera = chosen.camera
        edge = min(camera.width, camera.height)
        if not 0 < size <= edge:
            raise GraspBenchError(
                f"size must be between 1 and {edge}, the shorter edge of the image of "
                f"scenario {chosen.name!r}, not {size}"
            )
        self._cell = Workcell(chosen, renderer)
        self._corner = ((camera.width - size) // 2, (camera.height - size) // 2)
        self.size = size
        opening = self._cell.planner.robot.gripper.opening
        self.widest = opening * camera.intrinsics.fx / max(camera.position[2] - HIGHEST, 0.1)
        self.render_mode = render_mode
        self.observation_space = spaces.Dict(
            {
                "rgb": spaces.Box(0, 255, (size, size, 3), np.uint8),
                "depth": spaces.Box(0, chosen.sensor.maximum_range, (size, size), np.float32),
            }
        )
        self.action_space = spaces.Box(-1, 1, (5,), np.float32)
        self._where: tuple[str, int] | None = None
        self._trial: Any = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Put an object down and look.

        Args:
            seed: seed of the sequence of episodes.
            options: ``{"object": NAME}`` and ``{"attempt": N}`` fix what is drawn otherwise.

        Returns:
            The observation, and ``object``, ``category`` and ``attempt``, which with run seed 0 name the
            trial: :func:`grasp_bench.run_trial` repeats it.
        """
        super().reset(seed=seed)
        options = options or {}
        name = options.get("object") or self._names[int(self.np_random.integers(len(self._names)))]
        while True:
            attempt = int(options.get("attempt", self.np_random.integers(2**31)))
            self._trial = self._try(name, attempt, [])
            if self._trial.image is not None:
                break
            if "attempt" in options:
                raise GraspBenchError(f"attempt {attempt} on {name}: {self._trial.record.detail}")
        self._where = (name, attempt)
        model = self._catalog.entries[name]
        return self._observe(self._trial.image), {
            "object": name,
            "category": model["category"],
            "attempt": attempt,
        }

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Carry a grasp out; the episode is over then.

        Raises:
            gymnasium.error.ResetNeeded: when there is no object to grasp.
        """
        if self._where is None:
            raise gymnasium.error.ResetNeeded("one grasp an episode: call reset() before the next step()")
        name, attempt = self._where
        self._where = None
        self._trial = self._try(name, attempt, [self.grasp(action)])
        record = self._trial.record
        return self._observe(self._trial.image), float(record.success), True, False, record.to_json()

    def render(self) -> NDArray[np.uint8] | None:
        """Return (H, W, 3) uint8: the whole scene as the camera sees it now, without noise."""
        if self.render_mode != "rgb_array" or self._trial is None:
            return None
        world = self._trial.world
        return self._cell.camera.picture(world.model, world.data).rgb

    def grasp(self, action: Action) -> Grasp:
        """Return the grasp in pixels of the whole image that an action (5,) means."""
        x, y, sin2, cos2, width = (float(v) for v in np.clip(np.asarray(action, float), -1, 1))
        return Grasp(
            self._corner[0] + (x + 1) / 2 * self.size,
            self._corner[1] + (y + 1) / 2 * self.size,
            wrap_angle(0.5 * math.atan2(sin2, cos2)),
            max((width + 1) / 2 * self.widest, 1.0),
        )

    def action(self, grasp: Grasp) -> Action:
        """Return the action (5,) float32 that means a grasp; clipped to what the action space reaches."""
        return np.clip(
            [
                2 * (grasp.x - self._corner[0]) / self.size - 1,
                2 * (grasp.y - self._corner[1]) / self.size - 1,
                math.sin(2 * grasp.angle),
                math.cos(2 * grasp.angle),
                2 * grasp.width / self.widest - 1,
            ],
            -1,
            1,
        ).astype(np.float32)

    def _observe(self, image: RgbdImage) -> Observation:
        x, y = self._corner
        window = (slice(y, y + self.size), slice(x, x + self.size))
        return {"rgb": image.rgb[window].copy(), "depth": image.depth[window].copy()}

    def _try(self, name: str, attempt: int, grasps: list[Grasp]) -> Any:
        # The same trial is built for the look and for the grasp: its streams of random numbers are its own.
        from grasp_bench.trials.trial import run_trial

        return run_trial(self._cell, self._catalog.load(name), _Given(grasps), attempt=attempt)


class _Given:
    """A predictor that proposes the grasps it was given."""

    def __init__(self, grasps: list[Grasp]) -> None:
        self._grasps = grasps

    def predict(self, image: RgbdImage) -> list[Grasp]:
        return self._grasps


if ENV_ID not in gymnasium.registry:
    gymnasium.register(ENV_ID, entry_point="grasp_bench.gym:GraspEnv")
