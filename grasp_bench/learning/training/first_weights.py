"""What a training begins with instead of random weights: those of the same network, or another's trunk."""

from __future__ import annotations

from pathlib import Path

from torch import nn

from grasp_bench.errors import AssetError
from grasp_bench.networks.registry import NETWORKS, build, info, input_kind
from grasp_bench.networks.resnet import begin_with_trunk
from grasp_bench.networks.spec import PLANES, Kind
from grasp_bench.networks.store import WeightsFile, stored_input
from grasp_bench.networks.weights import load


def first_weights(name: str, kind: Kind, init: Path) -> nn.Module:
    """Build a network with the weights in a file, to be trained on.

    Weights for more channels than the network is shown, such as those of RGB-D for RGB, count too: the
    filters of the channels that it is not shown are left out, as if these were zero.

    Args:
        name: a registered network.
        kind: its input.
        init: weights of that network, or of another whose trunk fits it.

    Raises:
        AssetError: the file is missing, damaged or of another network, or for an input that lacks a channel.
    """
    stored_for = WeightsFile(init).metadata().get("network", name)
    if stored_for in NETWORKS and stored_for not in (name, *info(name).once):
        network = build(name, kind)
        if not begin_with_trunk(network, load(stored_for, init)[0]):
            raise AssetError(
                f"{init} holds weights of {stored_for}, of whose trunk nothing fits {name}; "
                f"give --init weights of {name}, or of a network with a like trunk."
            )
        return network
    network, metadata = load(name, init)
    stored = input_kind(name, stored_input(metadata))
    if stored == kind:
        return network.requires_grad_(True)
    if not set(PLANES[kind]) <= set(PLANES[stored]):
        raise AssetError(f"{init} holds weights for {stored} input, not {kind}; give --input {stored}.")
    shown = [PLANES[stored].index(plane) for plane in PLANES[kind]]
    narrower = build(name, kind)
    own, given = narrower.state_dict(), network.state_dict()
    narrower.load_state_dict(
        {key: v if v.shape == own[key].shape else v[:, shown] for key, v in given.items()}
    )
    return narrower
