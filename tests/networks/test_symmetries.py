"""Test-time augmentation: what a moved picture's maps say of the picture itself."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor, nn
from torch.nn import functional

from grasp_bench.grasps import Grasp
from grasp_bench.learning.training.augment import View
from grasp_bench.networks.symmetries import SYMMETRIES, Averaged, moved, moved_back

SIDE = 12


class AlongSlope(nn.Module):
    """Jaws open along the brightness's slope: what is right for a picture is right for its copies, too."""

    def forward(self, x: Tensor) -> Tensor:
        wide = functional.pad(x, (1, 1, 1, 1), mode="replicate")[:, 0]
        right = wide[:, 1:-1, 2:] - wide[:, 1:-1, :-2]
        up = wide[:, :-2, 1:-1] - wide[:, 2:, 1:-1]
        angle = torch.atan2(up, right)
        return torch.stack([x[:, 0], (2 * angle).sin(), (2 * angle).cos(), right.square() + up.square()], 1)


class Arbitrary(nn.Module):
    """Treats no two places or directions alike."""

    def __init__(self) -> None:
        super().__init__()
        self.layer = nn.Conv2d(1, 4, 3, padding=1)
        self.places = nn.Parameter(torch.randn(4, SIDE, SIDE))

    def forward(self, x: Tensor) -> Tensor:
        return self.layer(x) * self.places


@pytest.fixture
def pictures() -> Tensor:
    """Two pictures without edges at which a slope has no direction."""
    return torch.rand(2, 1, SIDE, SIDE, generator=torch.Generator().manual_seed(1), dtype=torch.float32)


@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_what_is_said_of_a_copy_is_brought_back(symmetry: tuple[int, bool], pictures: Tensor) -> None:
    network = AlongSlope()
    back = moved_back(network(moved(pictures, *symmetry)), *symmetry)
    torch.testing.assert_close(back, network(pictures), atol=1e-5, rtol=0)


@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_copies_are_views_as_training_draws_them(symmetry: tuple[int, bool]) -> None:
    """The grasp's place and angle in a copy, by the training's affine map, become those of the picture."""
    turns, mirror = symmetry
    grasp = Grasp(3.5, 4.5, 0.4, 6.0, 1.0)
    there = View(turns * math.pi / 2, mirror).grasp(grasp, SIDE, SIDE)
    maps = torch.zeros(1, 4, SIDE, SIDE)
    row, column = int(there.y), int(there.x)
    maps[0, :, row, column] = torch.tensor(
        [1.0, math.sin(2 * there.angle), math.cos(2 * there.angle), there.width]
    )
    said = moved_back(maps, *symmetry)[0, :, int(grasp.y), int(grasp.x)]
    expected = torch.tensor([1.0, math.sin(2 * grasp.angle), math.cos(2 * grasp.angle), grasp.width])
    torch.testing.assert_close(said, expected)


def test_the_average_treats_all_copies_alike(pictures: Tensor) -> None:
    torch.manual_seed(0)
    network = Averaged(Arbitrary(), SYMMETRIES).requires_grad_(False)
    own = network(pictures)
    assert not torch.allclose(own, network.network(pictures), atol=0.1)
    for symmetry in SYMMETRIES:
        again = moved_back(network(moved(pictures, *symmetry)), *symmetry)
        torch.testing.assert_close(again, own, atol=1e-5, rtol=0)


def test_it_is_the_mean(pictures: Tensor) -> None:
    torch.manual_seed(0)
    network, few = Arbitrary().requires_grad_(False), ((0, False), (2, False))
    turned = network(pictures.rot90(2, (2, 3))).rot90(-2, (2, 3))
    torch.testing.assert_close(Averaged(network, few)(pictures), (network(pictures) + turned) / 2)
