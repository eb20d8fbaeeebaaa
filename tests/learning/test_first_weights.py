"""What a training begins with: weights of the same network, for the same input or for more channels."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

from grasp_bench.errors import AssetError
from grasp_bench.learning.training.first_weights import first_weights
from grasp_bench.networks.registry import build
from grasp_bench.networks.spec import CHANNELS, PLANES, Kind
from grasp_bench.networks.weights import save


@pytest.mark.parametrize(
    ("name", "kind"),
    [("htc-grasp", "rgb"), ("gr-convnet-16", "rgb"), ("gr-convnet-16", "depth"), ("gg-cnn", "depth")],
)
def test_of_weights_for_more_channels_those_shown_are_taken(name: str, kind: Kind, tmp_path: Path) -> None:
    torch.manual_seed(3)
    file = tmp_path / "w.safetensors"
    save(build(name, "rgbd"), file, {"network": name, "input": "rgbd 224"})
    whole, narrow = first_weights(name, "rgbd", file).eval(), first_weights(name, kind, file).eval()
    assert all(p.requires_grad for p in narrow.parameters())
    x = torch.zeros(1, 4, 64, 64)
    shown = [PLANES["rgbd"].index(plane) for plane in PLANES[kind]]
    x[:, shown] = torch.randn(1, CHANNELS[kind], 64, 64)
    with torch.no_grad():
        torch.testing.assert_close(narrow(x[:, shown]), whole(x), atol=1e-4, rtol=1e-4)


def test_a_channel_that_is_lacking_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "w.safetensors"
    save(build("gg-cnn"), file, {"network": "gg-cnn", "input": "depth 224"})
    with pytest.raises(AssetError, match="for depth input, not rgbd; give --input depth"):
        first_weights("gg-cnn", "rgbd", file)
