"""Batches of augmented scenes, prepared by threads while the network computes.

Which scenes a step sees, and how they are augmented, depends on (seed, step) alone: neither
on the number of threads nor on whether the run was interrupted.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import lru_cache
from zlib import crc32

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from grasp_bench.learning.data.scenes import Scene
from grasp_bench.learning.training.augment import (
    USUAL,
    View,
    crop_scene,
    jitter_colour,
    jitter_depth,
    random_view,
)
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.learning.training.sources import Mixture
from grasp_bench.networks.encoding import targets_from_maps, to_input
from grasp_bench.networks.registry import info
from grasp_bench.networks.rows import rows_from_grasps
from grasp_bench.networks.spec import Kind, Targets

Batch = tuple[NDArray[np.float32], NDArray[np.float32]]

ROWS = 48
"""Rows of an image's table of labels; of more grasps, those of highest quality are kept."""


@lru_cache(maxsize=4)
def _order(seed: int, epoch: int, count: int) -> NDArray[np.int64]:
    return np.random.default_rng([seed, 1, epoch]).permutation(count)


def scenes_of_step(seed: int, step: int, batch: int, count: int) -> list[int]:
    """Return the scenes of a step by index; every scene comes once an epoch, in another order each."""
    return [int(_order(seed, k // count, count)[k % count]) for k in range(step * batch, (step + 1) * batch)]


def make_sample(
    scene: Scene,
    kind: Kind,
    crop: int,
    rng: np.random.Generator | None,
    targets: Targets = "maps",
    labelled: float = 1.0,
    zoom: float = USUAL,
) -> Batch:
    """Make input (C, crop, crop) and target of a scene, augmented if ``rng`` is given.

    Args:
        targets: maps (4, crop, crop), or rows (:data:`ROWS`, 6), see :mod:`grasp_bench.networks.rows`.
        labelled: share of the scenes whose rows are given, chosen by their names.
        zoom: greatest magnification, see :func:`random_view`.
    """
    view = random_view(rng, zoom) if rng else View()
    rgb, depth, labels = crop_scene(scene, view, crop)
    if rng:
        rgb, depth = jitter_colour(rgb, rng), jitter_depth(depth, rng)
    target = targets_from_maps(labels) if targets == "maps" else _rows(scene, view, crop, targets, labelled)
    return to_input(rgb, depth, kind), target


def _rows(scene: Scene, view: View, crop: int, targets: Targets, labelled: float) -> NDArray[np.float32]:
    """Return the rows of grasps that hold, and for ``tries`` of those that failed, too."""
    graded = [(grasp, True) for grasp in scene.truths()]
    if targets == "tries" and len(scene.tried):
        graded = scene.tries()
    if not _labels_shown(scene, labelled):
        graded = []
    moved = [(view.grasp(grasp, scene.size, crop), float(held)) for grasp, held in graded]
    return rows_from_grasps(moved, crop, ROWS).numpy()


def _labels_shown(scene: Scene, share: float) -> bool:
    """Return whether a scene is of the share whose labels are shown, which its name decides."""
    return crc32(scene.name.encode()) / 2**32 < share


def _with_labels(scenes: Sequence[Scene], index: int, share: float) -> int:
    """Return the index of the first scene from ``index`` on, round the end, whose labels are shown."""
    following = ((index + i) % len(scenes) for i in range(len(scenes)))
    return next((k for k in following if _labels_shown(scenes[k], share)), index)


def make_batch(scenes: Sequence[Scene], config: TrainConfig, kind: Kind, crop: int, step: int) -> Batch:
    """Make inputs (B, C, crop, crop) and targets (B, …) of a step."""
    network = info(config.network)
    if isinstance(scenes, Mixture) and scenes.shares is not None:
        chosen = [scenes.draw(np.random.default_rng([config.seed, 3, step, i])) for i in range(config.batch)]
    else:
        chosen = scenes_of_step(config.seed, step, config.batch, len(scenes))
    if network.labelled < 1:  # every second scene is one with labels, however few of them there are
        chosen[::2] = [_with_labels(scenes, k, network.labelled) for k in chosen[::2]]
    samples = [
        make_sample(
            scenes[k],
            kind,
            crop,
            np.random.default_rng([config.seed, 2, step, i]) if config.augment else None,
            network.targets,
            network.labelled,
            config.zoom,
        )
        for i, k in enumerate(chosen)
    ]
    inputs, targets = zip(*samples, strict=True)
    return np.stack(inputs), np.stack(targets)


def batches(
    scenes: Sequence[Scene], config: TrainConfig, kind: Kind, crop: int, start: int, pinned: bool = False
) -> Generator[tuple[Tensor, Tensor]]:
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
