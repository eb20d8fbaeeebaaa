"""What a training run depends on."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

FREE_TO_CHANGE = frozenset({"workers", "threads", "checkpoint_every", "validate_every", "log_every"})
"""Fields that a resumed run may have otherwise than the run it continues."""


class TrainConfig(BaseModel):
    """Settings of one run; the defaults are those that learnt fastest in our tests.

    The paper trains with AdamW at a constant 1e-4, unmasked loss, batch 32, 20 000 steps
    (section 4.1): ``lr=1e-4, warmup=0, cosine=False, clip=0, masked=False, batch=32``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    network: str = "htc-grasp"
    input: Literal["rgbd", "rgb", "depth"] | None = Field(default=None, description="None = as published")
    init: str | None = Field(default=None, description="weights begun with, name and SHA-256; None = fresh")
    steps: int = Field(default=5000, ge=1)
    batch: int = Field(default=16, ge=1)
    seed: int = Field(default=0, ge=0)
    lr: float = Field(default=1e-3, gt=0)
    weight_decay: float = Field(default=0.01, ge=0)
    warmup: int = Field(default=50, ge=0, description="steps of linear warm-up")
    cosine: bool = Field(default=True, description="cosine decay to 0 after the warm-up; else constant")
    clip: float = Field(default=5.0, ge=0, description="largest gradient norm; 0 = no clipping")
    masked: bool = Field(default=True, description="angle and width errors only where there is a grasp")
    geometry_weight: float = Field(default=0.1, gt=0)
    positive_weight: float = Field(default=0.0, ge=0)
    augment: bool = True
    ema: float = Field(default=0.0, ge=0, lt=1, description="decay of the averaged weights; 0 = none")
    precision: Literal["auto", "fp32", "bf16"] = "auto"
    workers: int = Field(default=1, ge=1, description="threads that prepare batches")
    threads: int = Field(default=0, ge=0, description="threads of the network; 0 = all cores but one")
    checkpoint_every: int = Field(default=500, ge=1)
    validate_every: int = Field(default=500, ge=1)
    log_every: int = Field(default=20, ge=1)

    def learning_rate(self, step: int) -> float:
        """Rate at ``step`` (from 0)."""
        if step < self.warmup:
            return self.lr * (step + 1) / self.warmup
        if not self.cosine:
            return self.lr
        done = (step - self.warmup) / max(self.steps - self.warmup, 1)
        return self.lr * 0.5 * (1 + math.cos(math.pi * min(done, 1.0)))
