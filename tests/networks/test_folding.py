"""Networks without their batch norms compute what they did with them."""

from __future__ import annotations

import pytest
import torch
from torch import nn

from grasp_bench.networks.folding import folded
from grasp_bench.networks.htc_grasp import Fuse, Upsample
from grasp_bench.networks.redmon import Redmon
from grasp_bench.networks.registry import NETWORKS, build, info
from grasp_bench.networks.resnet import Trunk

torch.set_num_threads(1)

DENSE = [
    n
    for n, network in NETWORKS.items()
    if network.group in ("HTC-Grasp", "rivals") and network.targets == "maps"
]


def trained(network: nn.Module) -> nn.Module:
    """The network in evaluation mode, every norm of it with statistics and weights of its own."""
    torch.manual_seed(0)
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            assert module.running_mean is not None
            assert module.running_var is not None
            for values, low, high in (
                (module.running_mean, -0.2, 0.2),
                (module.running_var, 0.5, 2.0),
                (module.weight.data, -1.2, 1.2),
                (module.bias.data, -0.3, 0.3),
            ):
                values.uniform_(low, high)
    return network.eval()


def norms(network: nn.Module) -> int:
    return sum(isinstance(module, nn.BatchNorm2d) for module in network.modules())


@pytest.mark.parametrize("name", DENSE)
def test_a_folded_network_is_the_same_function(name: str) -> None:
    network = trained(build(name))
    before = {key: value.clone() for key, value in network.state_dict().items()}
    cheap = folded(network)
    assert norms(cheap) == 0
    with torch.inference_mode():
        for size in ((96, 96), (61, 74)):
            x = torch.randn(2, info(name).channels, *size)
            wanted = network(x)
            largest = float(wanted.abs().max())
            torch.testing.assert_close(cheap(x), wanted, rtol=0, atol=1e-5 * max(largest, 1))
    assert all(torch.equal(value, before[key]) for key, value in network.state_dict().items())


@pytest.mark.parametrize(
    ("module", "shape"),
    [
        (nn.Sequential(nn.Conv2d(3, 5, 3, bias=False), nn.BatchNorm2d(5), nn.ReLU()), (1, 3, 8, 8)),
        (nn.Sequential(nn.Conv2d(3, 5, 3), nn.BatchNorm2d(5)), (1, 3, 8, 8)),
        (nn.Sequential(nn.ConvTranspose2d(3, 5, 4, 2), nn.BatchNorm2d(5)), (1, 3, 8, 8)),
        (Upsample(6, 4, kernel=3), (1, 6, 8, 8)),
    ],
)
def test_every_kind_of_convolution_takes_its_norm(module: nn.Sequential, shape: tuple[int, ...]) -> None:
    trained(module)
    cheap = folded(module)
    assert norms(cheap) == 0
    x = torch.randn(shape)
    torch.testing.assert_close(cheap(x), module(x), rtol=1e-5, atol=1e-5)


def test_a_norm_after_a_sum_goes_into_all_that_is_summed() -> None:
    fuse = trained(Fuse((3, 5), 6))
    maps = [torch.randn(1, 3, 8, 8), torch.randn(1, 5, 4, 4)]
    torch.testing.assert_close(folded(fuse)(maps), fuse(maps), rtol=1e-5, atol=1e-5)


def test_norms_without_weights_of_a_detector_go_too() -> None:
    network = Redmon(side=64)
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            assert module.running_mean is not None
            assert module.running_var is not None
            module.running_mean.uniform_(-0.2, 0.2)
            module.running_var.uniform_(0.5, 2.0)
    network.eval()
    cheap = folded(network)
    assert norms(cheap) == 0
    x = torch.randn(2, 3, 64, 64)
    torch.testing.assert_close(cheap(x), network(x), rtol=1e-4, atol=1e-3)


def test_a_trunk_is_folded_whole() -> None:
    trunk = trained(Trunk(3, (1, 1, 1), width=8))
    cheap = folded(trunk)
    assert norms(cheap) == 0
    x = torch.randn(1, 3, 64, 64)
    torch.testing.assert_close(cheap(x)[-1], trunk(x)[-1], rtol=1e-4, atol=1e-4)


def test_a_norm_after_something_else_stays() -> None:
    module = trained(nn.Sequential(nn.Conv2d(3, 3, 1), nn.ReLU(), nn.BatchNorm2d(3)))
    cheap = folded(module)
    assert norms(cheap) == 1
    x = torch.randn(1, 3, 4, 4)
    assert torch.equal(cheap(x), module(x))


def test_folding_is_not_for_training() -> None:
    with pytest.raises(ValueError, match="evaluation mode"):
        folded(nn.Sequential(nn.Conv2d(3, 3, 1), nn.BatchNorm2d(3)))
