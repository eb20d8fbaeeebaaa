"""The settings of a training run, each with its option of ``grasp-bench train``.

A setting is defined in :class:`TrainConfig` and nowhere else: the command makes its options of the fields,
and :meth:`TrainConfig.arguments` writes those options that make the settings again.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field

from grasp_bench.runs.evaluation import Split
from grasp_bench.runs.limits import MOST_SEED

FREE_TO_CHANGE = frozenset(
    {
        "device",
        "workers",
        "threads",
        "checkpoint_every",
        "validate_every",
        "validate_scenes",
        "log_every",
        "max_minutes",
        "held_out",
        "patience",
    }
)
"""Fields in which a resumed run may differ from the run it continues."""
OF_MAPS = ("geometry_weight", "positive_weight", "width_weight", "width_expectile")
"""Fields that say what the errors of maps weigh; a network that gives grasps instead has none."""
NOT_COMPARED = FREE_TO_CHANGE | {"holdout", "split"}
"""Fields in which a checkpoint may differ. The scenes' fingerprint tells which images are left out,
and older checkpoints do not list it."""


@dataclass(frozen=True)
class Option:
    """How a setting is typed, where that does not follow from the field's name.

    Attributes:
        names: what is typed, such as ``--predictor``; ``--on/--off`` for a switch.
        off: whether it is a switch that turns the setting off and has no counterpart.
    """

    names: str
    off: bool = False


RECIPES: dict[str, dict[str, Any]] = {
    "own": {},
    "paper": {
        "steps": 100 * 200,
        "batch": 32,
        "lr": 1e-4,
        "warmup": 0,
        "cosine": False,
        "clip": 0.0,
        "masked": False,
        "validate_every": 200,
    },
}
"""Settings that differ from the defaults, by the name of the recipe. ``paper``: section 4.1, 100 epochs of
200 batches of 32, AdamW at a constant 1e-4, the loss of equation 7, a validation each epoch. Augmentation is
that of :mod:`grasp_bench.learning.training.augment`, as in all trainings here."""
HELD_OUT = 200
"""Scenes tried in physics where a run ends by them and nothing else is said."""


class TrainConfig(BaseModel):
    """Settings of one run; the defaults are those that learnt fastest in our tests.

    The paper trains with AdamW at a constant 1e-4, unmasked loss, batch 32, 20 000 steps (section 4.1):
    ``--steps 20000 --batch 32 --lr 1e-4 --warmup 0 --constant-lr --clip 0 --unmasked``. ``--recipe paper`` is
    the same, with a validation each epoch.

    The description of a field is the help of its option. ``init`` is typed as a file, but kept as the name
    and the SHA-256 of the weights in it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    network: Annotated[str, Option("--predictor")] = Field(
        default="htc-grasp",
        description="Network to train: htc-grasp, gr-convnet, gg-cnn, tf-grasp …; a wrong name lists all.",
    )
    steps: int = Field(
        default=5000, ge=1, description="Optimiser steps in all; with --until-flat or --max-minutes, at most."
    )
    until_flat: Annotated[bool, Option("--until-flat")] = Field(
        default=False,
        description="Keep the learning rate until tries in physics get no better, then let it fall and end.",
    )
    patience: int = Field(
        default=4, ge=1, description="Validations without a gain above the noise after which a run is flat."
    )
    max_minutes: float | None = Field(
        default=None, gt=0, description="Minutes after which to end, the fall of the learning rate included."
    )
    held_out: int | None = Field(
        default=None,
        ge=0,
        description="Held-out scenes whose best grasp is tried in physics at each validation; 200 with "
        "--until-flat, else none.",
    )
    batch: int = Field(default=16, ge=1, description="Scenes a step.")
    lr: float = Field(default=1e-3, gt=0, description="Highest learning rate (warm-up, then cosine to 0).")
    seed: int = Field(default=0, ge=0, le=MOST_SEED, description="Seed of weights, order and augmentation.")
    warmup: int = Field(default=50, ge=0, description="Steps of linear warm-up.")
    cosine: Annotated[bool, Option("--constant-lr", off=True)] = Field(
        default=True, description="Keep the learning rate after the warm-up, as the paper does."
    )
    weight_decay: float = Field(default=0.01, ge=0, description="Weight decay of AdamW.")
    clip: float = Field(default=5.0, ge=0, description="Largest norm of the gradient; 0 = no clipping.")
    masked: Annotated[bool, Option("--masked/--unmasked")] = Field(
        default=True,
        description="Angle and width errors only where there is a grasp; unmasked is the paper's equation 7.",
    )
    geometry_weight: float = Field(
        default=0.1, gt=0, description="Weight of the masked angle and width errors."
    )
    positive_weight: float = Field(
        default=0.0, ge=0, description="Extra weight of quality errors where there is a grasp."
    )
    width_weight: float = Field(default=1.0, gt=0, description="Weight of width errors besides, e.g. 10.")
    width_expectile: float = Field(
        default=0.5, gt=0, lt=1, description="Share of their weight that too narrow openings have, e.g. 0.75."
    )
    ema: float = Field(default=0.0, ge=0, lt=1, description="Decay of averaged weights, e.g. 0.999; 0 = off.")
    augment: bool = Field(default=True, description="Random rotation, mirror, scale, shift and colour.")
    zoom: float = Field(
        default=1.1,
        ge=1.1,
        le=4,
        description="Greatest magnification of a third of the views; the others' is 0.9 to 1.1.",
    )
    precision: Literal["auto", "fp32", "bf16"] = Field(
        default="auto", description="fp32, bf16, or auto: bf16 where the processor or GPU multiplies in it."
    )
    device: Literal["auto", "cpu", "cuda"] = Field(
        default="auto", description="Where to train: cpu, cuda, or auto: a CUDA GPU where there is one."
    )
    workers: int = Field(default=1, ge=1, description="Threads that prepare batches.")
    threads: int = Field(
        default=0,
        ge=0,
        description="Threads of the network; 0 = all cores. Use 1 where others share the machine.",
    )
    checkpoint_every: int = Field(default=500, ge=1, description="Steps between checkpoints.")
    validate_every: int = Field(default=500, ge=1, description="Steps between validations.")
    validate_scenes: int = Field(
        default=0, ge=0, description="Scenes of the data to validate on at most, evenly chosen; 0 = all."
    )
    log_every: int = Field(default=20, ge=1, description="Steps between lines of the log.")
    init: str | None = Field(
        default=None,
        description="Weights to begin with: a .safetensors file, or 'shipped' for the installed ones.",
    )
    input: Literal["rgbd", "rgb", "depth", "rgd"] | None = Field(
        default=None, description="What the network is shown, where it was published with several."
    )
    holdout: str | None = Field(
        default=None,
        description="FOLD/FOLDS of the real images to leave out, e.g. 2/5; they are validated on only.",
    )
    split: Split = Field(
        default="object", description="How --holdout parts images: at random, or by objects."
    )

    @classmethod
    def option(cls, name: str) -> Option:
        """Return the option of the field ``name``."""
        field, dashed = cls.model_fields[name], name.replace("_", "-")
        usual = Option(f"--{dashed}/--no-{dashed}" if field.annotation is bool else f"--{dashed}")
        return next((m for m in field.metadata if isinstance(m, Option)), usual)

    @classmethod
    def from_options(cls, typed: Mapping[str, Any]) -> Self:
        """Return the settings that options give; pydantic's ValidationError when one is out of its range.

        Args:
            typed: value of each option, by the name of its field.
        """
        return cls.model_validate({k: not v if cls.option(k).off else v for k, v in typed.items()})

    def arguments(self) -> list[str]:
        """Return the words that make these settings again: the network, and what is not as by default."""
        words: list[str] = []
        for name, field in type(self).model_fields.items():
            value, names = getattr(self, name), self.option(name).names
            if value == field.default and name != "network":
                continue
            if isinstance(value, bool):
                words.append(names.split("/")[0 if value else -1])
            else:
                words += [names, value.rpartition(" ")[0] or value if name == "init" else str(value)]
        return words

    def given(self, fields: Iterable[str]) -> list[str]:
        """Return the options of those of the fields that are not as by default."""
        defaults = {name: type(self).model_fields[name].default for name in fields}
        return [self.option(name).names for name, usual in defaults.items() if getattr(self, name) != usual]

    @property
    def open_ended(self) -> bool:
        """Whether something else than the number of steps may end the run."""
        return self.until_flat or self.max_minutes is not None

    @property
    def tried(self) -> int:
        """Number of held-out scenes tried in physics at each validation."""
        return HELD_OUT * self.until_flat if self.held_out is None else self.held_out

    def learning_rate(self, step: int) -> float:
        """Return the rate at ``step`` (from 0) of a run of a given number of steps."""
        if step < self.warmup:
            return self.lr * (step + 1) / self.warmup
        if not self.cosine:
            return self.lr
        done = (step - self.warmup) / max(self.steps - self.warmup, 1)
        return self.lr * 0.5 * (1 + math.cos(math.pi * min(done, 1.0)))
