"""Tensors on disk: safetensors with a JSON header of where they come from. Nothing unpickles.

Parameters are stored in float16, running statistics as they are; both are float32 in use. Where that would
make a file larger than :data:`LARGEST`, matrices are stored in eight bits, and in four where it still would.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import torch
from safetensors.torch import save as to_bytes
from torch import nn

from grasp_bench.errors import AssetError
from grasp_bench.networks.packing import packed, unpacked
from grasp_bench.networks.registry import NETWORKS, build, info
from grasp_bench.networks.store import FACTS, LARGEST, WeightsFile, shipped_file, stored_input
from grasp_bench.system.integrity import write_whole


def save(network: nn.Module, path: Path, metadata: dict[str, Any]) -> None:
    """Write weights at once or not at all.

    Args:
        path: ``….safetensors``.
        metadata: JSON-able facts (network, steps, data, seed, accuracy …).
    """
    halved = {name for name, _ in network.named_parameters()}
    tensors = {}
    for name, value in network.state_dict().items():
        tensors[name] = (value.half() if name in halved else value).detach().cpu().contiguous()
        if not torch.isfinite(tensors[name]).all():
            raise ValueError(f"{name} is not finite in float16: the training has diverged")
    path.parent.mkdir(parents=True, exist_ok=True)
    stored = tensors
    for bits in (8, 4):
        if sum(t.nbytes for t in stored.values()) > LARGEST:
            stored = packed(tensors, bits)
    write_whole(path, to_bytes(stored, _header(metadata)))


def with_facts(file: WeightsFile, metadata: dict[str, Any]) -> None:
    """Write a file of weights anew with other metadata; its tensors stay as they are, packed or not."""
    write_whole(file.path, to_bytes(_stored(file)[0], _header(metadata)))


def load(name: str, path: Path | None = None) -> tuple[nn.Module, dict[str, Any]]:
    """Build network ``name`` with weights, in evaluation mode; returned with the metadata of the weights.

    Args:
        name: a key of ``NETWORKS``.
        path: file of weights; by default the shipped one, whose SHA-256 must be that of the manifest.

    Raises:
        AssetError: the file is missing, truncated, altered or of another network.
    """
    info(name)  # a wrong name is refused before a missing file
    file = shipped_file(name) if path is None else WeightsFile(Path(path), name)
    file.intact()
    tensors, metadata = _stored(file)
    path = file.path
    stored_for = metadata.get("network", name)
    if stored_for not in (name, *info(name).once):
        raise AssetError(
            f"{path} holds weights of network {stored_for!r}, not {name!r}; "
            f"give --weights a file trained for {name!r}."
        )
    network = build(name, stored_input(metadata))
    wanted, tensors = network.state_dict(), unpacked(tensors, path)

    def misfit(why: str) -> AssetError:
        now = next((network.name for network in NETWORKS.values() if name in network.once), None)
        remedy = (
            f"weights of earlier versions are for {now!r} now" if now else "fetch the file of this version"
        )
        return AssetError(f"{path} does not fit network {name!r}: {why}; train again, or {remedy}.")

    if odd := sorted(set(wanted) ^ set(tensors)):
        raise misfit(f"{len(odd)} tensors missing or unknown, first {odd[0]!r}")
    for key, value in wanted.items():
        found = tensors[key]
        if found.shape != value.shape:
            raise misfit(f"{key} has shape {tuple(found.shape)}, not {tuple(value.shape)}")
        if found.is_floating_point() != value.is_floating_point():
            raise misfit(f"{key} holds {_kind(found)}, not {_kind(value)}")
        if not torch.isfinite(tensors[key].float()).all():
            raise AssetError(f"{path}: {key} has values that are not finite; fetch or train the file again.")
    network.load_state_dict({k: v.to(wanted[k].dtype) for k, v in tensors.items()})
    return network.eval(), metadata


def _stored(file: WeightsFile) -> tuple[dict[str, torch.Tensor], dict[str, Any]]:
    """Read tensors, as they are in the file, and metadata."""
    with file.opened("pt") as (stored, metadata):
        return {key: stored.get_tensor(key) for key in stored.keys()}, metadata  # noqa: SIM118


def _header(metadata: dict[str, Any]) -> dict[str, str]:
    return {FACTS: json.dumps(metadata, sort_keys=True, ensure_ascii=False)}


def _kind(tensor: torch.Tensor) -> str:
    return str(tensor.dtype).removeprefix("torch.")
