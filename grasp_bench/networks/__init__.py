"""Grasp networks by name. All map (B, C, H, W) to (B, 4, H, W): quality, sin 2θ, cos 2θ and
width in units of ``WIDTH_SCALE`` pixels, at the resolution of the input."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from torch import nn

from grasp_bench.errors import UnknownNameError
from grasp_bench.networks.encoding import CHANNELS, Kind
from grasp_bench.networks.ggcnn import GGCNN, GGCNN2
from grasp_bench.networks.grconvnet import GRConvNet
from grasp_bench.networks.htc_grasp import HTCGrasp
from grasp_bench.networks.tf_grasp import TFGrasp


@dataclass(frozen=True)
class NetworkInfo:
    """A network that can be built.

    Attributes:
        builder: makes it with fresh weights.
        kind: input, 'rgbd', 'rgb' or 'depth'.
        reference: publication.
        parameters: count of the published network; None where no code was published.
        crop: side of the square input in pixels.
    """

    builder: Callable[[], nn.Module]
    kind: Kind
    reference: str
    parameters: int | None = None
    crop: int = 224

    @property
    def channels(self) -> int:
        """Input channels."""
        return CHANNELS[self.kind]


_HTC = ("HTC-Grasp: A Hybrid Transformer-CNN Architecture for Robotic Grasp Detection, "
        "Electronics 12(6), 2023")
_GR = "Kumra et al., Antipodal Robotic Grasping using Generative Residual CNN, IROS 2020"

NETWORKS: dict[str, NetworkInfo] = {
    "htc-grasp": NetworkInfo(HTCGrasp, "rgbd", _HTC),
    "htc-grasp-no-ea": NetworkInfo(lambda: HTCGrasp(external_attention=False), "rgbd", _HTC),
    "htc-grasp-no-ca": NetworkInfo(lambda: HTCGrasp(channel_attention=False), "rgbd", _HTC),
    "htc-grasp-plain": NetworkInfo(
        lambda: HTCGrasp(external_attention=False, channel_attention=False), "rgbd", _HTC),
    "gg-cnn": NetworkInfo(
        GGCNN, "depth", "Morrison et al., Closing the Loop for Robotic Grasping, RSS 2018", 62_420),
    "gg-cnn2": NetworkInfo(
        GGCNN2, "depth", "Morrison et al., Learning Robust, Real-Time, Reactive Robotic Grasping, IJRR 2020",
        66_676),
    "gr-convnet": NetworkInfo(GRConvNet, "rgbd", _GR, 1_900_900),
    "gr-convnet-16": NetworkInfo(lambda: GRConvNet(channels=16), "rgbd", _GR, 479_156),
    "tf-grasp": NetworkInfo(
        TFGrasp, "rgbd", "Wang et al., When Transformer Meets Robotic Grasping, RA-L 2022", 6_812_108),
}


def info(name: str) -> NetworkInfo:
    """Entry of ``name``; UnknownNameError lists the valid ones."""
    try:
        return NETWORKS[name]
    except KeyError:
        raise UnknownNameError("network", name, NETWORKS) from None


def build(name: str) -> nn.Module:
    """The network ``name`` with fresh weights."""
    return info(name).builder()


def parameter_count(network: nn.Module) -> int:
    """Number of trainable values."""
    return sum(p.numel() for p in network.parameters() if p.requires_grad)
