"""All grasp networks by name, as :mod:`grasp_bench.networks.entries` registers them.

Nothing here imports torch before a network is built.
"""

from __future__ import annotations

from pkgutil import resolve_name
from typing import TYPE_CHECKING

from grasp_bench.errors import UnknownNameError
from grasp_bench.networks.entries import REGISTERED
from grasp_bench.networks.spec import CHANNELS, Kind, Network, Weights

if TYPE_CHECKING:
    from torch import nn

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
    """Return the number of values that training sets, also where they are fixed by now."""
    return sum(p.numel() for p in network.parameters())


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
