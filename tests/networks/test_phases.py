"""Layers that are computed in another way in training equal PyTorch's own, as in evaluation."""

from __future__ import annotations

import pytest
import torch
from torch import nn
from torch.nn import functional

from grasp_bench.networks.htc_grasp import ExternalAttention, Tokenwise, Upsample
from grasp_bench.networks.phases import Transposed, interleaved


@pytest.mark.parametrize(
    ("kernel", "stride", "padding", "more"), [(4, 2, 1, 1), (4, 2, 2, 1), (9, 3, 3, 1), (2, 2, 0, 0)]
)
def test_transposed_convolution(kernel: int, stride: int, padding: int, more: int) -> None:
    torch.manual_seed(0)
    layer = Transposed(5, 6, kernel, stride, padding, more).double()
    x = torch.randn(2, 5, 7, 8, dtype=torch.double, requires_grad=True)
    results = []
    for mode in (True, False):
        y = layer.train(mode)(x)
        wanted = torch.autograd.grad(y.square().sum(), [x, *layer.parameters()])
        results.append([y, *wanted])
    for trained, used in zip(*results, strict=True):
        torch.testing.assert_close(trained, used)


def test_kernels_without_whole_phases_are_refused() -> None:
    with pytest.raises(ValueError, match="kernel 3, stride 2"):
        Transposed(1, 1, 3, 2, 1, 1)


def test_interleaving_is_pixel_shuffling_of_other_channels() -> None:
    x = torch.randn(2, 12, 5, 6)
    phase_first = x.unflatten(1, (3, 4)).transpose(1, 2).flatten(1, 2)
    assert torch.equal(interleaved(phase_first, 2), functional.pixel_shuffle(x, 2))


def test_upsampling_of_htc_grasp() -> None:
    torch.manual_seed(0)
    layer = Upsample(8, 3, 3).double()
    x = torch.randn(2, 8, 5, 6, dtype=torch.double)
    torch.testing.assert_close(layer.train()(x), nn.Sequential(*layer)(x))


@pytest.mark.parametrize("shape", [(2, 9, 4), (2, 9, 3, 4)])
def test_linear_map_of_tokens(shape: tuple[int, ...]) -> None:
    torch.manual_seed(0)
    layer = Tokenwise(4, 5).double()
    x = torch.randn(shape, dtype=torch.double)
    torch.testing.assert_close(layer.train()(x), layer.eval()(x))


def test_external_attention_and_its_gradient() -> None:
    torch.manual_seed(0)
    layer = ExternalAttention(8, 2, memory=6)
    x = torch.randn(2, 9, 8, requires_grad=True)
    results = []
    for mode in (True, False):
        y = layer.train(mode)(x)
        results.append([y, *torch.autograd.grad(y.square().sum(), [x, *layer.parameters()])])
    for trained, used in zip(*results, strict=True):
        torch.testing.assert_close(trained, used)
