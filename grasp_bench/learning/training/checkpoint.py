"""Checkpoints: all that an interrupted run needs to go on as if it had not been."""

from __future__ import annotations

import json
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as to_bytes
from torch import Tensor, nn

from grasp_bench.errors import AssetError
from grasp_bench.learning.training.config import NOT_COMPARED, TrainConfig
from grasp_bench.learning.training.course import Course
from grasp_bench.system.integrity import write_whole

_MOMENTS = ("exp_avg", "exp_avg_sq")


def save_checkpoint(
    path: Path,
    step: int,
    network: nn.Module,
    average: nn.Module | None,
    optimizer: torch.optim.AdamW,
    course: Course,
    data: str,
) -> None:
    """Write one safetensors file, at once or not at all: a kill leaves the last one whole.

    Args:
        step: number of steps done.
        network, average, optimizer: their state; ``average`` None where there is none.
        course: how far the run has come; its settings are compared on resuming.
        data: the scenes' fingerprint, compared, too.
    """
    tensors = {f"model.{k}": v for k, v in network.state_dict().items()}
    if average is not None:
        tensors |= {f"average.{k}": v for k, v in average.state_dict().items()}
    for name, parameter in network.named_parameters():
        for moment in _MOMENTS:
            tensors[f"{moment}.{name}"] = optimizer.state[parameter][moment]
    header = {"step": step, "config": course.config.model_dump(), "data": data, "course": course.stored()}
    stored = {k: v.detach().cpu().contiguous() for k, v in tensors.items()}
    write_whole(path, to_bytes(stored, {"training": json.dumps(header)}))


def load_checkpoint(
    path: Path,
    network: nn.Module,
    average: nn.Module | None,
    optimizer: torch.optim.AdamW,
    course: Course,
    data: str,
) -> int:
    """Restore a run in place, its course too, and return the number of steps done.

    Raises:
        AssetError: the file is truncated, or of a run with other settings or scenes.
    """
    try:
        with safe_open(path, framework="pt") as file:
            header = json.loads((file.metadata() or {})["training"])
            tensors = {key: file.get_tensor(key) for key in file.keys()}  # noqa: SIM118
            step, then, scenes = int(header["step"]), header["config"], header["data"]
            if "course" in header:
                course.restore(header["course"])
    except (SafetensorError, OSError, ValueError, KeyError, TypeError) as error:
        raise AssetError(
            f"Checkpoint {path} is truncated or not one ({error}); delete it to start anew."
        ) from error
    earlier = {name: field.default for name, field in TrainConfig.model_fields.items()} | then
    changed = [
        f"{k} was {earlier[k]!r}, is {v!r}"
        for k, v in course.config.model_dump().items()
        if k not in NOT_COMPARED and earlier[k] != v
    ]
    if scenes != data:
        changed.append("the scenes were others")
    if changed:
        raise AssetError(
            f"Checkpoint {path} is of another run: {'; '.join(changed)}. "
            f"Give the same settings to resume it, or another --out to start anew."
        )
    try:
        _restore(tensors, network, average, optimizer, step)
    except (KeyError, RuntimeError) as error:
        raise AssetError(
            f"Checkpoint {path} does not fit the network ({error}); delete it to start anew."
        ) from error
    return step


def _restore(
    tensors: dict[str, Tensor],
    network: nn.Module,
    average: nn.Module | None,
    optimizer: torch.optim.AdamW,
    step: int,
) -> None:
    def part(prefix: str) -> dict[str, Tensor]:
        return {k.removeprefix(prefix): v for k, v in tensors.items() if k.startswith(prefix)}

    network.load_state_dict(part("model."))
    if average is not None:
        average.load_state_dict(part("average."))
    for name, parameter in network.named_parameters():
        # Moments take the parameters' memory layout, as AdamW itself makes them.
        moments = {m: torch.zeros_like(parameter).copy_(tensors[f"{m}.{name}"]) for m in _MOMENTS}
        done = torch.tensor(float(step), device=parameter.device)
        optimizer.state[parameter] = {"step": done, **moments}
