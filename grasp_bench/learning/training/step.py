"""One step of a training: forward, backward and update, without waiting for the device."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.optim.swa_utils import get_ema_multi_avg_fn

from grasp_bench.errors import GraspBenchError
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.learning.training.loss import grasp_loss
from grasp_bench.networks.rows import Detector


def choose_device(name: str) -> torch.device:
    """Return the device of ``auto``, ``cpu`` or ``cuda``; GraspBenchError where there is no such one."""
    present = torch.cuda.is_available()
    if name == "cuda" and not present:
        raise GraspBenchError("--device cuda: PyTorch finds no CUDA GPU here; give --device cpu or auto.")
    return torch.device("cuda" if present and name != "cpu" else "cpu")


def use_bf16(config: TrainConfig, device: torch.device) -> bool:
    """Tell whether to compute in bfloat16: as configured, or where the hardware multiplies in it."""
    if config.precision != "auto":
        return config.precision == "bf16"
    if device.type == "cuda":
        return torch.cuda.is_bf16_supported()
    able = torch.cpu.get_capabilities() if hasattr(torch.cpu, "get_capabilities") else {}
    return bool(able.get("avx512_bf16") or able.get("amx_bf16"))


@dataclass(frozen=True)
class Learner:
    """What a training changes. Nothing here reads a value back from the device.

    Attributes:
        network: in training mode, on the device.
        average: the network with averaged weights; None without averaging.
        optimizer: of the network's parameters.
        config: settings of the run.
        mixed: whether bfloat16 is computed in.
    """

    network: nn.Module
    average: nn.Module | None
    optimizer: torch.optim.AdamW
    config: TrainConfig
    mixed: bool

    @classmethod
    def of(cls, network: nn.Module, config: TrainConfig, device: torch.device) -> Learner:
        """Bring a network to the device, with an optimiser."""
        network = network.to(device).train()
        network.to(memory_format=torch.channels_last)  # pyright: ignore[reportCallIssue]
        average = copy.deepcopy(network).requires_grad_(False) if config.ema else None
        optimizer = torch.optim.AdamW(
            network.parameters(), lr=config.lr, weight_decay=config.weight_decay, fused=True
        )
        return cls(network, average, optimizer, config, use_bf16(config, device))

    @property
    def final(self) -> nn.Module:
        """The network that counts in the end."""
        return self.network if self.average is None else self.average

    def forward(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return the loss and its parts for inputs (B, C, H, W) and targets: maps (B, 4, H, W), or what a
        detector learns from."""
        inputs = inputs.to(memory_format=torch.channels_last)
        with torch.autocast(inputs.device.type, torch.bfloat16, enabled=self.mixed):
            if isinstance(self.network, Detector):
                return self.network.loss(inputs, targets)
            output = self.network(inputs)
        return grasp_loss(
            output,
            targets,
            masked=self.config.masked,
            geometry_weight=self.config.geometry_weight,
            positive_weight=self.config.positive_weight,
            width_weight=self.config.width_weight,
            width_expectile=self.config.width_expectile,
        )

    @torch.no_grad()
    def update(self, step: int, rate: float) -> Tensor:
        """Change the weights by their gradients at ``step`` (from 0) by ``rate``; the norm these had."""
        for group in self.optimizer.param_groups:
            group["lr"] = rate
        norm = nn.utils.clip_grad_norm_(self.network.parameters(), self.config.clip or math.inf, foreach=True)
        self.optimizer.step()
        if self.average is not None:
            decay = min(self.config.ema, (1 + step) / (10 + step))
            means: list[Tensor] = [*self.average.parameters()]
            values: list[Tensor] = [*self.network.parameters()]
            get_ema_multi_avg_fn(decay)(means, values, 0)
            for mean, value in zip(self.average.buffers(), self.network.buffers(), strict=True):
                mean.copy_(value)
        return norm

    def step(self, step: int, inputs: Tensor, targets: Tensor, rate: float) -> dict[str, Tensor]:
        """Do the whole of ``step`` (from 0), by ``rate``; loss, its parts and the gradient's norm, still
        on the device."""
        torch.manual_seed(self.config.seed * 1_000_003 + step)  # dropout, the same after a resume
        parts = self.forward(inputs, targets)
        self.optimizer.zero_grad(set_to_none=True)
        parts["loss"].backward()
        return {**{k: v.detach() for k, v in parts.items()}, "gradient_norm": self.update(step, rate)}
