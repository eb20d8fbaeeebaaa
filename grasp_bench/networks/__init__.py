"""Grasp networks by name. All map (B, C, H, W) to (B, 4, H, W): quality, sin 2θ, cos 2θ and
width in units of ``WIDTH_SCALE`` pixels, at the resolution of the input."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from torch import nn

from grasp_bench.errors import UnknownNameError
from grasp_bench.networks.encoding import CHANNELS, Kind
from grasp_bench.networks.ggcnn import GGCNN, GGCNN2
from grasp_bench.networks.grconvnet import GRConvNet
from grasp_bench.networks.htc_grasp import HTCGrasp
from grasp_bench.networks.tf_grasp import TFGrasp

ALL_KINDS: tuple[Kind, ...] = ("rgbd", "rgb", "depth")


@dataclass(frozen=True)
class NetworkInfo:
    """A network that can be built.

    Attributes:
        builder: makes it with fresh weights for a number of input channels.
        kind: its usual input, 'rgbd', 'rgb' or 'depth'.
        reference: publication.
        kinds: all inputs that the original was published with.
        parameters: counts of the published networks by input; empty where no code was published.
        crop: side of the square input in pixels.
    """

    builder: Callable[[int], nn.Module]
    kind: Kind
    reference: str
    kinds: tuple[Kind, ...] = ALL_KINDS
    parameters: Mapping[Kind, int] = field(default_factory=dict)
    crop: int = 224

    @property
    def channels(self) -> int:
        """Channels of the usual input."""
        return CHANNELS[self.kind]


_HTC = "HTC-Grasp: A Hybrid Transformer-CNN Architecture for Robotic Grasp Detection, Electronics 12(6), 2023"
_GR = "Kumra et al., Antipodal Robotic Grasping using Generative Residual CNN, IROS 2020"
_RGBD: tuple[Kind, ...] = ("rgbd",)

NETWORKS: dict[str, NetworkInfo] = {
    "htc-grasp": NetworkInfo(lambda c: HTCGrasp(inputs=c), "rgbd", _HTC, _RGBD),
    "htc-grasp-no-ea": NetworkInfo(
        lambda c: HTCGrasp(external_attention=False, inputs=c), "rgbd", _HTC, _RGBD
    ),
    "htc-grasp-no-ca": NetworkInfo(
        lambda c: HTCGrasp(channel_attention=False, inputs=c), "rgbd", _HTC, _RGBD
    ),
    "htc-grasp-plain": NetworkInfo(
        lambda c: HTCGrasp(external_attention=False, channel_attention=False, inputs=c), "rgbd", _HTC, _RGBD
    ),
    "gg-cnn": NetworkInfo(
        GGCNN,
        "depth",
        "Morrison et al., Closing the Loop for Robotic Grasping, RSS 2018",
        ("depth", "rgbd"),
        {"depth": 62_420, "rgbd": 70_196},
    ),
    "gg-cnn2": NetworkInfo(
        GGCNN2,
        "depth",
        "Morrison et al., Learning Robust, Real-Time, Reactive Robotic Grasping, IJRR 2020",
        ("depth", "rgbd"),
        {"depth": 66_676, "rgbd": 72_484},
    ),
    "gr-convnet": NetworkInfo(
        lambda c: GRConvNet(32, c), "rgbd", _GR, ALL_KINDS, {"rgbd": 1_900_900, "depth": 1_893_124}
    ),
    "gr-convnet-16": NetworkInfo(lambda c: GRConvNet(16, c), "rgbd", _GR, ALL_KINDS, {"rgbd": 479_156}),
    "tf-grasp": NetworkInfo(
        TFGrasp,
        "rgbd",
        "Wang et al., When Transformer Meets Robotic Grasping, RA-L 2022",
        ALL_KINDS,
        {"rgbd": 6_812_108},
    ),
}


def info(name: str) -> NetworkInfo:
    """Entry of ``name``; UnknownNameError lists the valid ones."""
    try:
        return NETWORKS[name]
    except KeyError:
        raise UnknownNameError("network", name, NETWORKS) from None


def input_kind(name: str, kind: str | None = None) -> Kind:
    """``kind`` as input of the network ``name``, by default its usual one.

    Raises:
        UnknownNameError: for an unknown network, or an input it was not published with.
    """
    spec = info(name)
    if kind is None:
        return spec.kind
    for known in spec.kinds:
        if known == kind:
            return known
    raise UnknownNameError(f"input of {name}", kind, spec.kinds)


def build(name: str, kind: str | None = None) -> nn.Module:
    """The network ``name`` with fresh weights, for its usual input or another it was published with."""
    return info(name).builder(CHANNELS[input_kind(name, kind)])


def parameter_count(network: nn.Module) -> int:
    """Number of trainable values."""
    return sum(p.numel() for p in network.parameters() if p.requires_grad)
