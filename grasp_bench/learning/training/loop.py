"""The training loop.

Memory: glibc gives large buffers back to the system at every step and faults them in again.
``MALLOC_MMAP_MAX_=0 MALLOC_TRIM_THRESHOLD_=8000000000 MALLOC_TOP_PAD_=268435456`` in the
environment keeps them, which helps training on a CPU; results do not change.
"""

from __future__ import annotations

import copy
import math
import os
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import cv2
import torch
from torch import Tensor, nn

from grasp_bench.errors import AssetError, GraspBenchError
from grasp_bench.learning.data.scenes import SceneSet
from grasp_bench.learning.training.batches import batches
from grasp_bench.learning.training.checkpoint import load_checkpoint, save_checkpoint
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.learning.training.log import RunLog
from grasp_bench.learning.training.loss import grasp_loss
from grasp_bench.learning.training.validate import Accuracy, validate
from grasp_bench.networks.registry import build, info, input_kind
from grasp_bench.networks.spec import Kind
from grasp_bench.networks.store import stored_input
from grasp_bench.networks.weights import load

CHECKPOINT = "checkpoint.safetensors"

Report = Callable[[int, dict[str, float], Accuracy | None], None]
"""Called after each step with the steps done, figures, and the accuracy where validated."""


@dataclass(frozen=True)
class Trained:
    """A finished run.

    Attributes:
        network: in evaluation mode, with averaged weights if there are any. Those of the last step, not
            the best validated one's: choosing by validation would flatter the accuracy.
        accuracy: what validation after the last step gave.
    """

    network: nn.Module
    accuracy: Accuracy


def train(
    config: TrainConfig, scenes: SceneSet, out: Path, report: Report | None = None, init: Path | None = None
) -> Trained:
    """Train a network, going on from the checkpoint in ``out`` if there is one.

    Args:
        out: folder for ``checkpoint.safetensors`` and ``log.jsonl``.
        init: weights to begin with instead of random ones.

    Raises:
        AssetError: the checkpoint is damaged or of another run, or ``init`` is for another input.
        GraspBenchError: the loss became infinite or NaN.
    """
    kind, crop = input_kind(config.network, config.input), info(config.network).crop
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    cv2.setNumThreads(1)
    # With no core left for preparing batches, OpenMP's barriers wait for the thread it pushed out.
    torch.set_num_threads(config.threads or max((os.cpu_count() or 1) - 1, 1))
    torch.manual_seed(config.seed)
    network = build(config.network, kind) if init is None else _begin(config.network, kind, init)
    network = network.to(device).train()
    network.to(memory_format=torch.channels_last)  # pyright: ignore[reportCallIssue]
    average = copy.deepcopy(network).requires_grad_(False) if config.ema else None
    optimizer = torch.optim.AdamW(network.parameters(), lr=config.lr, weight_decay=config.weight_decay)

    out.mkdir(parents=True, exist_ok=True)
    start = 0
    if (out / CHECKPOINT).is_file():
        start = load_checkpoint(out / CHECKPOINT, network, average, optimizer, config, scenes.fingerprint)
    final = average if average is not None else network
    accuracy: Accuracy | None = None
    mixed = use_bf16(config, device)

    with closing(RunLog(out, start)) as log:
        logged, since = start, time.perf_counter()
        feed = batches(scenes.train, config, kind, crop, start)
        for step, (inputs, targets) in enumerate(feed, start):
            rate = config.learning_rate(step)
            for group in optimizer.param_groups:
                group["lr"] = rate
            torch.manual_seed(config.seed * 1_000_003 + step)  # dropout, the same after a resume
            parts = _step(
                network,
                optimizer,
                torch.from_numpy(inputs).to(device),
                torch.from_numpy(targets).to(device),
                config,
                mixed,
            )
            if average is not None:
                _update_average(average, network, min(config.ema, (1 + step) / (10 + step)))

            done = step + 1
            if not math.isfinite(parts["loss"] + parts["gradient_norm"]):
                raise GraspBenchError(
                    f"The loss is {parts['loss']}, its gradient {parts['gradient_norm']} at step {done}: "
                    f"the training diverged; lower --lr, or look for damaged scenes."
                )
            speed = (done - logged) * config.batch / (time.perf_counter() - since)
            figures = {**parts, "lr": rate, "samples_per_second": round(speed, 2)}
            if done % config.log_every == 0 or done == config.steps:
                log.write(done, **figures)
                logged, since = done, time.perf_counter()
            accuracy = None
            if done % config.validate_every == 0 or done == config.steps:
                accuracy = validate(final, scenes.val, kind, crop)
                log.write(
                    done,
                    hits=accuracy.hits,
                    scenes=accuracy.scenes,
                    correct=accuracy.correct,
                    labelled=accuracy.labelled,
                )
            if done % config.checkpoint_every == 0 or done == config.steps:
                save_checkpoint(
                    out / CHECKPOINT, done, network, average, optimizer, config, scenes.fingerprint
                )
            if report is not None:
                report(done, figures, accuracy)
    final.eval()
    if accuracy is None:  # resumed after the last step
        accuracy = validate(final, scenes.val, kind, crop)
    return Trained(final, accuracy)


def shown(config: TrainConfig) -> str:
    """Return kind and side [px] of the network's input, as in the metadata of weights."""
    return f"{input_kind(config.network, config.input)} {info(config.network).crop}"


def _begin(name: str, kind: Kind, init: Path) -> nn.Module:
    """Load the weights of ``init``; AssetError when they are for another input."""
    network, metadata = load(name, init)
    stored = input_kind(name, stored_input(metadata))
    if stored != kind:
        raise AssetError(f"{init} holds weights for {stored} input, not {kind}; give --input {stored}.")
    return network.requires_grad_(True)


def _step(
    network: nn.Module,
    optimizer: torch.optim.Optimizer,
    inputs: Tensor,
    targets: Tensor,
    config: TrainConfig,
    mixed: bool,
) -> dict[str, float]:
    inputs = inputs.to(memory_format=torch.channels_last)
    with torch.autocast(inputs.device.type, torch.bfloat16, enabled=mixed):
        output = network(inputs)
    parts = grasp_loss(
        output,
        targets,
        masked=config.masked,
        geometry_weight=config.geometry_weight,
        positive_weight=config.positive_weight,
    )
    optimizer.zero_grad(set_to_none=True)
    parts["loss"].backward()
    norm = nn.utils.clip_grad_norm_(network.parameters(), config.clip or math.inf)
    optimizer.step()
    return {**{name: value.item() for name, value in parts.items()}, "gradient_norm": norm.item()}


@torch.no_grad()
def _update_average(average: nn.Module, network: nn.Module, decay: float) -> None:
    for mean, value in zip(average.parameters(), network.parameters(), strict=True):
        mean.lerp_(value, 1 - decay)
    for mean, value in zip(average.buffers(), network.buffers(), strict=True):
        mean.copy_(value)


def use_bf16(config: TrainConfig, device: torch.device) -> bool:
    """Tell whether to compute in bfloat16: as configured, or where the hardware multiplies in it."""
    if config.precision != "auto":
        return config.precision == "bf16"
    if device.type == "cuda":
        return torch.cuda.is_bf16_supported()
    able = torch.cpu.get_capabilities() if hasattr(torch.cpu, "get_capabilities") else {}
    return bool(able.get("avx512_bf16") or able.get("amx_bf16"))
