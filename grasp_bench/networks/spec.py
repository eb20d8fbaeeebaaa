"""What a registration says of a grasp network, without importing torch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Kind = Literal["rgbd", "rgb", "depth", "rgd"]

PLANES: dict[str, str] = {"depth": "d", "rgb": "rgb", "rgbd": "drgb", "rgd": "rgd"}
"""Input channels of each kind by their letters; 'rgbd' has depth first, as GR-ConvNet does, 'rgd' depth
instead of blue."""
CHANNELS: dict[str, int] = {kind: len(planes) for kind, planes in PLANES.items()}
"""Their number."""

Targets = Literal["maps", "rectangles", "tries"]
"""What a network learns from: four maps, rectangles that hold, or rectangles with those that failed."""

Group = Literal["HTC-Grasp", "rivals", "rivals, reconstructed", "trunks"]
"""Headings under which networks are listed."""

ALL_KINDS: tuple[Kind, ...] = ("rgbd", "rgb", "depth")


@dataclass(frozen=True)
class Weights:
    """Weights that a shipped predictor of the same name uses.

    Attributes:
        name: what the predictor is called, and the file in ``assets/weights`` without its suffix.
        summary: one line for listings.
        rows: the row that they stand for in tables of the HTC-Grasp paper, by the table's number.
    """

    name: str
    summary: str
    rows: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Network:
    """A network that can be built, trained and run.

    Attributes:
        name: what the network and its own weights are called.
        summary: one line for listings.
        builder: ``module:Class``, imported when first built; called with ``inputs``, a number of channels.
        reference: publication that describes it.
        kinds: all inputs that the original was published with, the usual one first.
        arguments: further keyword arguments of the class.
        parameters: counts of the published networks by input; empty where no code was published.
        crop: side of the square input [px].
        rows: the same for the network's own weights as :attr:`Weights.rows`.
        group: heading under which it is listed.
        targets: what it learns from.
        labelled: share of the scenes whose labels it is shown, and which are half of every batch then; the
            others are pictures only.
        once: names under which earlier versions stored weights of this network.
        ablates: name of the weights that this ablation is compared with; None where there is none.
        others: further weights of this network that are shipped.
    """

    name: str
    summary: str
    builder: str
    reference: str
    kinds: tuple[Kind, ...] = ALL_KINDS
    arguments: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, int] = field(default_factory=dict)
    crop: int = 224
    rows: Mapping[int, str] = field(default_factory=dict)
    group: Group = "rivals"
    targets: Targets = "maps"
    labelled: float = 1.0
    once: tuple[str, ...] = ()
    ablates: str | None = None
    others: tuple[Weights, ...] = ()

    @property
    def kind(self) -> Kind:
        """The usual input."""
        return self.kinds[0]

    @property
    def channels(self) -> int:
        """Channels of the usual input."""
        return CHANNELS[self.kind]

    @property
    def weights(self) -> tuple[Weights, ...]:
        """All weights of this network, its own first."""
        return Weights(self.name, self.summary, self.rows), *self.others
