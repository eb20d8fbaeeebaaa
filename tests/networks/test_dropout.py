"""Dropout with a mask of 16-bit draws."""

from __future__ import annotations

import pytest
import torch

from grasp_bench.networks.dropout import Dropout


@pytest.mark.parametrize("p", [0.1, 0.5, 0.9])
def test_drops_at_its_rate_and_keeps_the_mean(p: float) -> None:
    torch.manual_seed(0)
    dropped = Dropout(p)(torch.ones(1000, 1001))
    # Five standard deviations of a binomial of 10⁶ draws.
    assert (dropped == 0).float().mean().item() == pytest.approx(p, abs=5 * (p * (1 - p) / 1e6) ** 0.5)
    assert dropped.unique().tolist() == pytest.approx([0.0, 1 / (1 - p)], rel=1e-4)


def test_neighbours_are_dropped_independently() -> None:
    torch.manual_seed(0)
    lost = Dropout(0.5)(torch.ones(10**6)) == 0
    for distance in range(1, 9):  # four draws come from one number
        assert (lost[distance:] & lost[:-distance]).float().mean().item() == pytest.approx(0.25, abs=0.003)


def test_gradient_passes_where_values_passed() -> None:
    x = torch.ones(2, 3, 5, 7).requires_grad_()
    y = Dropout(0.3)(x)
    y.sum().backward()
    assert x.grad is not None
    assert torch.equal(x.grad, y.detach())


@pytest.mark.parametrize("dtype", [torch.float32, torch.bfloat16])
def test_memory_layout_and_type_stay(dtype: torch.dtype) -> None:
    x = torch.ones(2, 3, 5, 7, dtype=dtype).to(memory_format=torch.channels_last)
    y = Dropout(0.1)(x)
    assert y.dtype == dtype
    assert y.is_contiguous(memory_format=torch.channels_last)


def test_same_seed_same_mask_with_any_number_of_threads() -> None:
    masks, threads = [], torch.get_num_threads()
    try:
        for count in (1, 2):
            torch.set_num_threads(count)
            torch.manual_seed(3)
            masks.append(Dropout(0.1)(torch.ones(100_003)))
    finally:
        torch.set_num_threads(threads)
    assert torch.equal(*masks)


def test_nothing_happens_outside_training() -> None:
    x = torch.rand(10)
    assert Dropout(0.5).eval()(x) is x


def test_impossible_probability_is_refused() -> None:
    with pytest.raises(ValueError, match=r"p = 1 is not within"):
        Dropout(1)
