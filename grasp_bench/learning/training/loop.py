"""The training loop."""

from __future__ import annotations

import errno
import math
import time
from collections.abc import Callable
from contextlib import closing, nullcontext
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import torch
from torch import Tensor, nn
from torch.utils.flop_counter import FlopCounterMode

from grasp_bench.errors import GraspBenchError
from grasp_bench.learning.data.scenes import SceneSet
from grasp_bench.learning.training.batches import batches, make_batch
from grasp_bench.learning.training.checkpoint import load_checkpoint, save_checkpoint
from grasp_bench.learning.training.config import OF_MAPS, TrainConfig
from grasp_bench.learning.training.course import Course
from grasp_bench.learning.training.first_weights import first_weights
from grasp_bench.learning.training.held_out import held_out_scenes
from grasp_bench.learning.training.log import RunLog
from grasp_bench.learning.training.step import Learner, choose_device
from grasp_bench.learning.training.validate import Accuracy, Judge, evenly
from grasp_bench.networks.registry import build, info, input_kind
from grasp_bench.networks.rows import Detector
from grasp_bench.networks.spec import Kind
from grasp_bench.system.locking import Lock
from grasp_bench.system.machine import usable_cores

CHECKPOINT = "checkpoint.safetensors"
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of a disk on which there is no more room for this user or in this file."""

Report = Callable[[int, dict[str, float], Accuracy | None], None]
"""Called with the steps done, figures, and the accuracy where validated: after each step on a CPU, and where
a line of the log, a validation or a checkpoint is due on a GPU."""


@dataclass(frozen=True)
class Trained:
    """A finished run.

    Attributes:
        network: in evaluation mode, with averaged weights if there are any. Those of the last step, not
            the best validated one's: choosing by validation would flatter the accuracy.
        accuracy: what validation after the last step gave.
        course: how long it took, how it got better, and what ended it.
    """

    network: nn.Module
    accuracy: Accuracy
    course: Course


def train(
    config: TrainConfig, scenes: SceneSet, out: Path, report: Report | None = None, init: Path | None = None
) -> Trained:
    """Train a network, going on from the checkpoint in ``out`` if there is one.

    Args:
        out: folder for ``checkpoint.safetensors`` and ``log.jsonl``.
        init: weights to begin with instead of random ones.

    Raises:
        AssetError: the checkpoint is damaged or of another run, or ``init`` is for an input that lacks a
            channel.
        GraspBenchError: the loss became infinite or NaN, there is no such device, ``out`` cannot be written,
            another training writes to it, or the network has no maps whose errors could weigh as asked.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        busy = GraspBenchError(f"Another training is writing to {out}; wait for it or choose another --out.")
        with Lock(out / ".lock", busy):
            return _train(config, scenes, out, report, init)
    except OSError as error:
        remedy = "Free some space" if error.errno in _FULL else "Mend that, or choose another --out"
        if (out / CHECKPOINT).is_file():
            remedy += "; the last checkpoint is kept, and the same command goes on from there"
        raise GraspBenchError(
            f"{error.filename or out} cannot be written ({error.strerror}). {remedy}."
        ) from error


def _train(
    config: TrainConfig, scenes: SceneSet, out: Path, report: Report | None, init: Path | None
) -> Trained:
    kind, crop = input_kind(config.network, config.input), info(config.network).crop
    device = choose_device(config.device)
    cv2.setNumThreads(1)
    torch.set_num_threads(config.threads or usable_cores())
    torch.manual_seed(config.seed)
    network = build(config.network, kind) if init is None else first_weights(config.network, kind, init)
    if isinstance(network, Detector) and (ignored := config.given(OF_MAPS)):
        raise GraspBenchError(
            f"{config.network} gives grasps and no maps, and has a loss of its own: leave out {ignored[0]}."
        )
    learner = Learner.of(network, config, device)
    state = learner.network, learner.average, learner.optimizer

    start, course = 0, Course(config)
    if (out / CHECKPOINT).is_file():
        start = load_checkpoint(out / CHECKPOINT, *state, course, scenes.fingerprint)
    if start == 0 and isinstance(learner.network, Detector) and learner.network.warm_up:
        _prepare(learner.network, scenes, config, kind, crop, device)
    judge = Judge(evenly(scenes.val, config.validate_scenes), held_out_scenes(config.tried, crop), kind, crop)
    accuracy: Accuracy | None = None
    begun, before = time.perf_counter(), course.seconds

    feed = batches(scenes.train, config, kind, crop, start, pinned=device.type == "cuda")
    with closing(RunLog(out, start)) as log, closing(feed):
        logged, since = start, time.perf_counter()
        unread: list[dict[str, Tensor]] = []
        done = start
        while done < course.end:
            batch, done = next(feed), done + 1
            inputs, targets = (tensor.to(device, non_blocking=True) for tensor in batch)
            rate = course.rate(done - 1)
            with nullcontext() if course.flops else FlopCounterMode(display=False) as counter:
                unread.append(learner.step(done - 1, inputs, targets, rate))
            if counter is not None:
                course.flops = counter.get_total_flops() / config.batch
            course.reached(done, before + time.perf_counter() - begun)
            stored, judged, noted = (
                done % every == 0 or done == course.end
                for every in (config.checkpoint_every, config.validate_every, config.log_every)
            )
            # Reading waits for a GPU; a CPU has done its work anyway.
            if device.type == "cuda" and not (stored or judged or noted):
                continue
            parts = _read(unread, done)
            speed = (done - logged) * config.batch / (time.perf_counter() - since)
            figures = {**parts, "lr": rate, "samples_per_second": round(speed, 2)}
            if noted:
                log.write(done, **figures)
            accuracy = None
            if judged:
                accuracy = judge(learner.final)
                course.validated(done, before + time.perf_counter() - begun, accuracy)
                log.write(done, **course.curve[-1].figures)
            if noted:
                logged, since = done, time.perf_counter()
            if stored:
                save_checkpoint(out / CHECKPOINT, done, *state, course, scenes.fingerprint)
            if report is not None:
                report(done, figures, accuracy)
        if done > start:
            log.write(done, ended=course.why, seconds=round(course.seconds, 1))
    learner.final.eval()
    if accuracy is None:  # resumed after the last step
        accuracy = judge(learner.final)
    return Trained(learner.final, accuracy, course)


def _prepare(
    network: Detector, scenes: SceneSet, config: TrainConfig, kind: Kind, crop: int, device: torch.device
) -> None:
    """Show a detector the batches of its first steps at once."""
    made = [make_batch(scenes.train, config, kind, crop, step) for step in range(network.warm_up)]
    inputs, targets = (torch.from_numpy(np.concatenate(part)).to(device) for part in zip(*made, strict=True))
    network.prepare(inputs, targets)


def _read(unread: list[dict[str, Tensor]], done: int) -> dict[str, float]:
    """Fetch the figures of the last steps up to ``done`` in one go, empty the list; those of the last step.

    Raises:
        GraspBenchError: naming the first step whose loss or gradient is not finite.
    """
    rows = torch.stack([torch.stack(list(parts.values())) for parts in unread]).tolist()
    names = list(unread[-1])
    unread.clear()
    figures: dict[str, float] = {}
    for step, row in enumerate(rows, done - len(rows) + 1):
        figures = dict(zip(names, row, strict=True))
        if not math.isfinite(figures["loss"] + figures["gradient_norm"]):
            raise GraspBenchError(
                f"The loss is {figures['loss']}, its gradient {figures['gradient_norm']} at step {step}: "
                f"the training diverged; lower --lr, or look for damaged scenes."
            )
    return figures


def shown(config: TrainConfig) -> str:
    """Return kind and side [px] of the network's input, as in the metadata of weights."""
    return f"{input_kind(config.network, config.input)} {info(config.network).crop}"
