"""All grasp networks by name. A new one is its architecture's module and one entry here.

The entry makes it a network that can be trained and a predictor that is listed, and puts it beside the rows
of the paper that it stands for. Nothing here imports torch before a network is built.
"""

from __future__ import annotations

from pkgutil import resolve_name
from typing import TYPE_CHECKING

from grasp_bench.errors import UnknownNameError
from grasp_bench.networks.spec import CHANNELS, Kind, Network, Weights

if TYPE_CHECKING:
    from torch import nn

_HTC = "HTC-Grasp: A Hybrid Transformer-CNN Architecture for Robotic Grasp Detection, Electronics 12(6), 2023"
_GR = "Kumra et al., Antipodal Robotic Grasping using Generative Residual CNN, IROS 2020"

REGISTERED = (
    Network(
        "htc-grasp",
        "HTC-Grasp, hybrid Transformer-CNN (Zhang et al., 2023)",
        "grasp_bench.networks.htc_grasp:HTCGrasp",
        _HTC,
        kinds=("rgbd",),
        rows={1: "HTC-Grasp", 2: "HTC-Grasp", 3: "EA + CA", 4: "HTC-Grasp"},
        others=(Weights("htc-grasp-1000", "HTC-Grasp after 1,000 steps, as all below", rows={3: "EA + CA"}),),
    ),
    Network(
        "htc-grasp-no-ea",
        "HTC-Grasp's ablation: plain self-attention",
        "grasp_bench.networks.htc_grasp:HTCGrasp",
        _HTC,
        kinds=("rgbd",),
        arguments={"external_attention": False},
        rows={3: "CA"},
        ablates="htc-grasp-1000",
    ),
    Network(
        "htc-grasp-no-ca",
        "HTC-Grasp's ablation: no channel attention",
        "grasp_bench.networks.htc_grasp:HTCGrasp",
        _HTC,
        kinds=("rgbd",),
        arguments={"channel_attention": False},
        rows={3: "EA"},
        ablates="htc-grasp-1000",
    ),
    Network(
        "htc-grasp-plain",
        "HTC-Grasp's ablation: neither",
        "grasp_bench.networks.htc_grasp:HTCGrasp",
        _HTC,
        kinds=("rgbd",),
        arguments={"external_attention": False, "channel_attention": False},
        ablates="htc-grasp-1000",
    ),
    Network(
        "gg-cnn",
        "GG-CNN on depth (Morrison et al., 2018)",
        "grasp_bench.networks.ggcnn:GGCNN",
        "Morrison et al., Closing the Loop for Robotic Grasping, RSS 2018",
        kinds=("depth", "rgbd"),
        parameters={"depth": 62_420, "rgbd": 70_196},
        rows={1: "GG-CNN", 4: "GG-CNN"},
    ),
    Network(
        "gg-cnn2",
        "GG-CNN2 on depth (Morrison et al., 2020)",
        "grasp_bench.networks.ggcnn:GGCNN2",
        "Morrison et al., Learning Robust, Real-Time, Reactive Robotic Grasping, IJRR 2020",
        kinds=("depth", "rgbd"),
        parameters={"depth": 66_676, "rgbd": 72_484},
        rows={2: "GG-CNN2"},
    ),
    Network(
        "gr-convnet",
        "GR-ConvNet, 32 channels, RGB-D (Kumra et al., 2020)",
        "grasp_bench.networks.grconvnet:GRConvNet",
        _GR,
        arguments={"channels": 32},
        parameters={"rgbd": 1_900_900, "depth": 1_893_124},
        rows={1: "GR-CNN", 2: "GR-CNN"},
    ),
    Network(
        "gr-convnet-16",
        "GR-ConvNet, 16 channels, RGB-D (Kumra et al., 2020)",
        "grasp_bench.networks.grconvnet:GRConvNet",
        _GR,
        arguments={"channels": 16},
        parameters={"rgbd": 479_156},
    ),
    Network(
        "tf-grasp",
        "TF-Grasp, Swin Transformer, RGB-D (Wang et al., 2022)",
        "grasp_bench.networks.tf_grasp:TFGrasp",
        "Wang et al., When Transformer Meets Robotic Grasping, RA-L 2022",
        parameters={"rgbd": 6_812_108},
        rows={1: "TF-Grasp", 2: "TF-Grasp", 4: "TF-Grasp"},
    ),
)

NETWORKS: dict[str, Network] = {network.name: network for network in REGISTERED}


def info(name: str) -> Network:
    """Return the entry of ``name``; UnknownNameError lists the valid ones."""
    try:
        return NETWORKS[name]
    except KeyError:
        raise UnknownNameError("network", name, NETWORKS) from None


def input_kind(name: str, kind: str | None = None) -> Kind:
    """Return ``kind`` as input of the network ``name``, by default its usual one.

    Raises:
        UnknownNameError: for an unknown network, or an input it was not published with.
    """
    kinds = info(name).kinds
    for known in kinds:
        if kind in (None, known):
            return known
    raise UnknownNameError(f"input of {name}", str(kind), kinds)


def build(name: str, kind: str | None = None) -> nn.Module:
    """Build the network ``name`` with fresh weights, for its usual input or another it was published with."""
    network, channels = info(name), CHANNELS[input_kind(name, kind)]
    return resolve_name(network.builder)(inputs=channels, **network.arguments)


def parameter_count(network: nn.Module) -> int:
    """Return the number of trainable values."""
    return sum(p.numel() for p in network.parameters() if p.requires_grad)


def all_weights() -> dict[str, tuple[Network, Weights]]:
    """Return all weights that may be shipped, by name, with their network; those of ablations last."""
    whole_first = sorted(REGISTERED, key=lambda network: network.ablates is not None)
    return {weights.name: (network, weights) for network in whole_first for weights in network.weights}


def standing_for(table: int, row: str) -> list[str]:
    """Return the names of the weights that stand for a row of the paper, those that ablations are compared
    with first.

    Args:
        table: number of the table in the HTC-Grasp paper.
        row: name of the row, as :mod:`grasp_bench.report` has it.
    """
    names = [name for name, (_, weights) in all_weights().items() if weights.rows.get(table) == row]
    compared_with = {network.ablates for network in REGISTERED}
    return sorted(names, key=lambda name: name not in compared_with)


def family(weights: str) -> list[str]:
    """Return the names of these weights and of those of its ablations."""
    return [weights, *(network.name for network in REGISTERED if network.ablates == weights)]
