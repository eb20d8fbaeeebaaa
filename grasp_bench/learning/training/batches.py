"""Batches of augmented scenes, prepared by threads while the network computes.

Which scenes a step sees, and how they are augmented, depends on (seed, step) alone: neither
on the number of threads nor on whether the run was interrupted.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import lru_cache

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from grasp_bench.learning.data.scenes import Scene
from grasp_bench.learning.training.augment import View, crop_scene, jitter_colour, jitter_depth, random_view
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.learning.training.sources import Mixture
from grasp_bench.networks.encoding import targets_from_maps, to_input
from grasp_bench.networks.spec import Kind

Batch = tuple[NDArray[np.float32], NDArray[np.float32]]


@lru_cache(maxsize=4)
def _order(seed: int, epoch: int, count: int) -> NDArray[np.int64]:
    return np.random.default_rng([seed, 1, epoch]).permutation(count)


def scenes_of_step(seed: int, step: int, batch: int, count: int) -> list[int]:
    """Return the scenes of a step by index; every scene comes once an epoch, in another order each."""
    return [int(_order(seed, k // count, count)[k % count]) for k in range(step * batch, (step + 1) * batch)]


def make_sample(scene: Scene, kind: Kind, crop: int, rng: np.random.Generator | None) -> Batch:
    """Make input (C, crop, crop) and target (4, crop, crop) of a scene, augmented if ``rng`` is given."""
    rgb, depth, labels = crop_scene(scene, random_view(rng) if rng else View(), crop)
    if rng:
        rgb, depth = jitter_colour(rgb, rng), jitter_depth(depth, rng)
    return to_input(rgb, depth, kind), targets_from_maps(labels)


def make_batch(scenes: Sequence[Scene], config: TrainConfig, kind: Kind, crop: int, step: int) -> Batch:
    """Make inputs (B, C, crop, crop) and targets (B, 4, crop, crop) of a step."""
    if isinstance(scenes, Mixture) and scenes.shares is not None:
        chosen = [scenes.draw(np.random.default_rng([config.seed, 3, step, i])) for i in range(config.batch)]
    else:
        chosen = scenes_of_step(config.seed, step, config.batch, len(scenes))
    samples = [
        make_sample(
            scenes[k],
            kind,
            crop,
            np.random.default_rng([config.seed, 2, step, i]) if config.augment else None,
        )
        for i, k in enumerate(chosen)
    ]
    inputs, targets = zip(*samples, strict=True)
    return np.stack(inputs), np.stack(targets)


def batches(
    scenes: Sequence[Scene], config: TrainConfig, kind: Kind, crop: int, start: int, pinned: bool = False
) -> Iterator[tuple[Tensor, Tensor]]:
    """Make the batches of steps ``start`` … ``config.steps`` − 1, two ahead for each thread.

    Args:
        pinned: in memory from which a GPU copies while the CPU goes on.
    """

    def prepared(step: int) -> tuple[Tensor, Tensor]:
        inputs, targets = map(torch.from_numpy, make_batch(scenes, config, kind, crop, step))
        return (inputs.pin_memory(), targets.pin_memory()) if pinned else (inputs, targets)

    with ThreadPoolExecutor(config.workers, thread_name_prefix="batch") as pool:
        waiting: deque[Future[tuple[Tensor, Tensor]]] = deque()
        following = iter(range(start, config.steps))
        try:
            for _ in range(2 * config.workers):
                if (step := next(following, None)) is not None:
                    waiting.append(pool.submit(prepared, step))
            while waiting:
                ready = waiting.popleft().result()
                if (step := next(following, None)) is not None:
                    waiting.append(pool.submit(prepared, step))
                yield ready
        finally:
            pool.shutdown(cancel_futures=True)
