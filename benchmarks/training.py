"""How fast networks are trained: ``python benchmarks/training.py htc-grasp gr-convnet``.

Samples a second of whole trainings, loading included, and processor time of each part of a step for a sample
with the same number of threads. Scenes are made up, unless ``--data`` names a folder of generated ones.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from grasp_bench.learning.data.scenes import Scene, SceneSet, load_scenes
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.learning.training.process import prepare_process

PARTS = ("load", "forward", "backward", "optimiser")
WARM_UP = 3
"""Steps that are not counted: memory is gathered, kernels are chosen."""


def made_up(size: int = 320) -> Scene:
    """A scene of noise with a square to grasp, which costs about what a generated one costs."""
    rng = np.random.default_rng(0)
    depth = rng.normal(7000, 5, (size, size)).astype(np.uint16)
    depth[rng.random(depth.shape) < 0.04] = 0
    quality = np.zeros((size, size), np.uint8)
    quality[130:190, 130:190] = 200
    angle, width = np.full((2, size, size), 40, np.float16)
    rgb = rng.integers(0, 255, (size, size, 3), dtype=np.uint8)
    return Scene("made up", rgb, depth, quality, angle / 80, width, np.zeros((0, 5), np.float32))  # pyright: ignore[reportArgumentType]


def speed(config: TrainConfig, scenes: SceneSet) -> float:
    """Samples a second of a training."""
    from grasp_bench.learning.training.loop import train

    ends: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        quiet = SceneSet(scenes.train, [], scenes.fingerprint)
        train(config, quiet, Path(folder), lambda *_: ends.append(time.perf_counter()))
    first, last = ends[WARM_UP - 1], ends[-2]  # the last step stores a checkpoint
    return (config.steps - 1 - WARM_UP) * config.batch / (last - first)


def parts(config: TrainConfig, scenes: SceneSet) -> dict[str, tuple[float, float]]:
    """Wall and processor time of each part [ms a sample], one after the other, nothing at the same time."""
    import torch

    from grasp_bench.learning.training.batches import make_batch
    from grasp_bench.learning.training.step import Learner, choose_device
    from grasp_bench.networks.registry import build, info, input_kind

    device, network = choose_device(config.device), info(config.network)
    learner = Learner.of(build(config.network), config, device)
    spent = {part: np.zeros(2) for part in PARTS}

    @contextmanager
    def timed(part: str, step: int) -> Iterator[None]:
        before = np.array([time.perf_counter(), time.process_time()])
        yield
        if device.type == "cuda":
            torch.cuda.synchronize()
        if step >= WARM_UP:
            spent[part] += np.array([time.perf_counter(), time.process_time()]) - before

    for step in range(config.steps):
        with timed("load", step):
            made = make_batch(scenes.train, config, input_kind(config.network), network.crop, step)
            inputs, targets = (torch.from_numpy(array).to(device) for array in made)
        with timed("forward", step):
            loss = learner.forward(inputs, targets)["loss"]
        with timed("backward", step):
            learner.optimizer.zero_grad(set_to_none=True)
            loss.backward()
        with timed("optimiser", step):
            learner.update(step, config.learning_rate(step))
    samples = (config.steps - WARM_UP) * config.batch
    return {part: tuple(1000 * times / samples) for part, times in spent.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("networks", nargs="*", default=["htc-grasp", "gr-convnet"])
    parser.add_argument("--data", type=Path, help="folder of generated scenes")
    parser.add_argument("--steps", type=int, default=10)
    parser.add_argument("--batch", type=int, default=16)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--device", choices=("auto", "cpu", "cuda"), default="auto")
    args = parser.parse_args()
    prepare_process()
    scenes = load_scenes([args.data]) if args.data else SceneSet([made_up()] * args.batch, [], "")
    print(
        f"{'':<16}{'samples/s':>10}" + "".join(f"{part:>17}" for part in PARTS) + "   [ms wall, ms processor]"
    )
    for name in args.networks:
        config = TrainConfig(
            network=name, steps=args.steps, batch=args.batch, threads=args.threads, device=args.device
        )
        whole, apart = speed(config, scenes), parts(config, scenes)
        print(
            f"{name:<16}{whole:>10.1f}" + "".join(f"{w:>9.2f}{c:>8.2f}" for w, c in apart.values()),
            flush=True,
        )


if __name__ == "__main__":
    main()
