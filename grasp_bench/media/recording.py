"""A trial's physics, sample by sample.

Positions are kept and pictures are made of them afterwards, so that a trial which needs none
costs next to nothing, and so that watching can change nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grasp_bench.scene.touch import Touch
from grasp_bench.scene.world import World

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Moment:
    """The state of a world at one time.

    Attributes:
        time: simulated time [s].
        qpos, qvel: generalised positions and velocities of the whole model, as MuJoCo orders them.
        touch: what the object touched; None unless it was asked for.
    """

    time: float
    qpos: Floats
    qvel: Floats
    touch: Touch | None = None


@dataclass
class Recording:
    """An observer for :func:`grasp_bench.trials.attempt.run_trial` that keeps every ``every``-th sample.

    Attributes:
        every: samples of the arm's motion (4 ms in the shipped scenarios) from one moment to the next.
        touches: keep what the object touches, too, for which the contacts are read.
        moments: the states kept so far.
    """

    every: int = 1
    touches: bool = False
    moments: list[Moment] = field(default_factory=list)
    _seen: int = 0

    def __call__(self, world: World) -> None:
        """Take the state of ``world`` when it is due."""
        if self._seen % self.every == 0:
            self.moments.append(moment(world, self.touches))
        self._seen += 1


def moment(world: World, touches: bool = False) -> Moment:
    """Return the state of ``world`` now."""
    return Moment(
        float(world.data.time),
        world.data.qpos.copy(),
        world.data.qvel.copy(),
        world.touch() if touches else None,
    )
