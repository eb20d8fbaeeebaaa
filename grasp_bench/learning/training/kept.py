"""Weights where they are kept: the file, the page to read beside it, and the manifest of its folder."""

from __future__ import annotations

from typing import Any

from torch import nn

from grasp_bench.learning.training.card import model_card
from grasp_bench.networks.store import WeightsFile, place_to_ship
from grasp_bench.networks.weights import save, with_facts
from grasp_bench.system.integrity import MANIFEST, write_whole

CARD = ".md"
"""End of the name of the page."""


def keep(network: nn.Module, file: WeightsFile, facts: dict[str, Any]) -> None:
    """Write the weights of a training, with its facts in them and on the page beside them.

    Args:
        facts: those of :func:`grasp_bench.learning.training.card.provenance`.
    """
    save(network, file.path, facts)
    _follow(file, facts)


def keep_facts(file: WeightsFile, facts: dict[str, Any]) -> None:
    """Write other facts into weights that are there, and onto the page beside them."""
    with_facts(file, facts)
    _follow(file, facts)


def ship(made: WeightsFile) -> WeightsFile:
    """Copy weights and their page to where shipped ones are, and enter them in the manifest there.

    Returns:
        the copy.

    Raises:
        AssetError: for weights that are too large, see :func:`grasp_bench.networks.store.place_to_ship`.
    """
    place = place_to_ship(made.network, made.path.stat().st_size)
    place.path.parent.mkdir(parents=True, exist_ok=True)
    for suffix in (made.path.suffix, CARD):
        write_whole(place.path.with_suffix(suffix), made.path.with_suffix(suffix).read_bytes())
    place.enter_in_manifest()
    return place


def _follow(file: WeightsFile, facts: dict[str, Any]) -> None:
    """Let page and manifest, where there is one, say what weights say now."""
    if "commands" in facts:  # weights of a fold do not tell so much, and have no page
        write_whole(file.path.with_suffix(CARD), model_card(facts, file.path.stem).encode())
    if file.path.with_name(MANIFEST).is_file():
        file.enter_in_manifest()
