"""Weights in eight and four bits, and where files of them belong."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

from grasp_bench.errors import AssetError
from grasp_bench.networks import store
from grasp_bench.networks.packing import packed, unpacked
from grasp_bench.networks.registry import build
from grasp_bench.networks.store import LARGEST, LARGEST_APART, LARGEST_HERE, place_to_ship, shipped_file
from grasp_bench.networks.weights import load, save


def tensors() -> dict[str, torch.Tensor]:
    torch.manual_seed(0)
    return {
        "wide": torch.randn(70, 1001).half(),
        "conv": (torch.randn(64, 40, 3, 9) * torch.logspace(-3, 0, 64)[:, None, None, None]).half(),
        "middling": torch.randn(64, 65).half(),
        "small": torch.randn(8, 8).half(),
        "bias": torch.randn(5000).half(),
        "mean": torch.randn(70, 1001),
        "steps": torch.tensor(7),
    }


@pytest.mark.parametrize(("bits", "worst", "size"), [(8, 0.01, 1.05), (4, 0.115, 0.58)])
def test_large_matrices_come_back_nearly(bits, worst: float, size: float) -> None:
    before = tensors()
    stored = packed(before, bits)
    after = unpacked(stored, "file")
    assert set(after) == set(before)
    for name in ("wide", "conv"):
        assert after[name].shape == before[name].shape
        exact = before[name].float().flatten(1)
        error = (after[name].flatten(1) - exact).norm(dim=1) / exact.norm(dim=1)
        assert error.max() < worst, "in every row, whatever its size"
        parts = [stored[k].nbytes for k in (name, name + ".scale")]
        assert sum(parts) <= size * exact.numel()
    assert stored["middling"].dtype == torch.int8, "too small for four bits"
    for name in ("small", "bias", "mean", "steps"):
        assert torch.equal(after[name], before[name])


def test_four_bits_by_hand() -> None:
    """Multiples of a scale come back as they were; a lone giant does not drown the others."""
    row = torch.arange(-7, 8).repeat(5)[:64] * 0.5
    rows = row.repeat(1024, 1)
    assert torch.equal(unpacked(packed({"a": rows.half()}, 4), "")["a"], rows)
    rows[:, 3] = 12.0
    clipped = unpacked(packed({"a": rows.half()}, 4), "")["a"]
    assert (clipped[0] - rows[0]).square().sum() < (
        rows[0] - (rows[0] * 7 / 12).round() * 12 / 7
    ).square().sum()


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("wide.scale", torch.ones(70, 3)),
        ("wide.shape", torch.tensor([70, 10_000], dtype=torch.int32)),
        ("wide.shape", torch.tensor([0, -1], dtype=torch.int32)),
        ("wide", torch.zeros(70, 4, dtype=torch.uint8)),
        ("wide", torch.zeros(70, 512)),
        ("wide", None),
        ("wide.scale", None),
    ],
)
def test_what_does_not_fit_together_is_refused(name: str, other: torch.Tensor | None) -> None:
    stored = packed(tensors(), 4)
    if other is None:
        del stored[name]
    else:
        stored[name] = other
    with pytest.raises(AssetError, match=r"my\.safetensors: wide\.scale does not belong .*4 bits"):
        unpacked(stored, "my.safetensors")


def test_a_network_too_large_for_eight_bits_is_saved_in_four(tmp_path: Path) -> None:
    torch.manual_seed(0)
    network, path = build("se-resunet").eval(), tmp_path / "a.safetensors"
    save(network, path, {"network": "se-resunet"})
    assert path.stat().st_size < LARGEST
    again, _ = load("se-resunet", path)
    for (name, was), now in zip(network.named_parameters(), again.parameters(), strict=True):
        assert (now - was).norm() < 0.12 * was.norm() + 1e-3, name


def test_large_weights_are_found_beside_the_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own, apart = tmp_path / "assets", tmp_path / "rivals"
    apart.mkdir()
    (own / "weights").mkdir(parents=True)
    monkeypatch.setattr(store, "assets_dir", lambda: own)
    monkeypatch.setattr(store, "rivals_dirs", lambda: [tmp_path / "checkout's", apart])
    assert shipped_file("fcgn").path == own / "weights" / "fcgn.safetensors"
    with pytest.raises(AssetError, match=r"pip install grasp-bench-rivals.*train --predictor fcgn"):
        shipped_file("fcgn").require()
    (apart / "fcgn.safetensors").write_bytes(b"x")
    assert shipped_file("fcgn").path == apart / "fcgn.safetensors"
    shipped_file("fcgn").enter_in_manifest()
    assert shipped_file("fcgn").intact()
    (apart / "fcgn.safetensors").write_bytes(b"y")
    with pytest.raises(AssetError, match="SHA-256"):
        shipped_file("fcgn").intact()

    monkeypatch.setattr(store, "rivals_dirs", lambda: [apart])
    assert place_to_ship("fcgn", LARGEST_HERE).path.parent == own / "weights"
    assert place_to_ship("fcgn", LARGEST_HERE + 1).path.parent == apart
    with pytest.raises(AssetError, match="30,000,001 bytes"):
        place_to_ship("fcgn", LARGEST_APART + 1)
    monkeypatch.setattr(store, "rivals_dirs", lambda: [])
    assert shipped_file("fcgn").path == own / "weights" / "fcgn.safetensors"
    with pytest.raises(AssetError, match="no folder of that is here"):
        place_to_ship("fcgn", LARGEST_HERE + 1)
