"""Every registered network, and what HTC-Grasp claims of itself."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import nn
from torch.nn import functional

from grasp_bench.errors import UnknownNameError
from grasp_bench.grasps import Grasp, GraspMaps
from grasp_bench.networks.encoding import (
    encode_depth,
    fill_holes,
    maps_from_output,
    targets_from_maps,
    to_input,
)
from grasp_bench.networks.htc_grasp import CHANNELS, ExternalAttention, Fuse, HTCGrasp, SelfAttention
from grasp_bench.networks.registry import NETWORKS, build, info, parameter_count
from grasp_bench.networks.spec import CHANNELS as CHANNELS_OF
from grasp_bench.networks.spec import Kind
from grasp_bench.networks.tf_grasp import Expand, SwinBlock, TFGrasp, _from_windows, _to_windows

torch.set_num_threads(1)


DENSE = [
    name
    for name, network in NETWORKS.items()
    if network.group in ("HTC-Grasp", "rivals") and network.targets == "maps"
]
"""Those that give maps; on others see test_detectors.py."""


@pytest.fixture(params=DENSE, scope="module")
def name(request: pytest.FixtureRequest) -> str:
    return request.param


def test_output_has_the_size_of_the_input(name: str) -> None:
    network = build(name).eval()
    with torch.inference_mode():
        for h, w in ((224, 224), (97, 130)):
            assert network(torch.randn(1, info(name).channels, h, w)).shape == (1, 4, h, w)


def test_every_parameter_gets_a_gradient(name: str) -> None:
    network = build(name).train()
    output = network(torch.randn(2, info(name).channels, 64, 64))
    (output - torch.randn_like(output)).square().mean().backward()
    for parameter, value in network.named_parameters():
        assert value.grad is not None, parameter
        assert torch.isfinite(value.grad).all(), parameter
        # A convolution bias before a batch norm has none but rounding errors: not asked for.
        assert value.grad.abs().max() > 0 or parameter.endswith("bias"), parameter


@pytest.mark.parametrize(
    ("name", "kind", "count"),
    [(name, kind, count) for name, spec in NETWORKS.items() for kind, count in spec.parameters.items()],
)
def test_parameter_count_is_the_published_one(name: str, kind: Kind, count: int) -> None:
    with torch.device("meta"):
        assert parameter_count(build(name, kind)) == count


def test_published_counts_are_known_of_every_rival() -> None:
    counts = {
        (name, kind): count for name, spec in NETWORKS.items() for kind, count in spec.parameters.items()
    }
    assert counts == {
        ("gg-cnn", "depth"): 62_420,
        ("gg-cnn", "rgbd"): 70_196,
        ("gg-cnn2", "depth"): 66_676,
        ("gg-cnn2", "rgbd"): 72_484,
        ("gr-convnet", "rgbd"): 1_900_900,
        ("gr-convnet", "depth"): 1_893_124,
        ("gr-convnet-16", "rgbd"): 479_156,
        ("tf-grasp", "rgbd"): 6_812_108,
        ("tf-grasp-release", "rgbd"): 6_812_108,
        ("htc-grasp-mea4", "rgbd"): 3_482_132,
        # Of 16,404,260 and 16,401,668, of which 82,976 are in a layer that the release never calls.
        ("se-resunet", "rgbd"): 16_404_260 - 82_976,
        ("se-resunet", "rgb"): 16_401_668 - 82_976,
        ("skgnet", "rgbd"): 3_897_668,
        ("lenz-sae", "rgbd"): 204_302 + 847_202,
        ("redmon-multigrasp", "rgd"): 7_530_711,
        ("redmon-direct", "rgd"): 7_357_830,
        # Six numbers instead of five, and two scales.
        ("kumra-resnet50x2", "rgbd"): 49_378_949 + 513 + 2,
        ("kumra-resnet50", "rgb"): 24_822_341 + 513,
        ("chu-resnet50", "rgd"): 28_459_738,
        ("fcgn", "rgb"): 27_793_500,
        ("roi-gd", "rgb"): 35_891_858,
        ("gq-cnn", "depth"): 18_025_826,
        ("asif-graspnet", "rgb"): 3_711_792,
        ("wu-anchor-free", "rgb"): 12_056_663,
        ("laili-pairs", "rgb"): 12_910_841,
    }


@pytest.mark.parametrize(
    ("name", "kind"),
    [("gg-cnn", "rgbd"), ("gr-convnet-16", "rgb"), ("gr-convnet-16", "depth"), ("tf-grasp", "rgb")],
)
def test_other_inputs(name: str, kind: Kind) -> None:
    with torch.inference_mode():
        assert build(name, kind).eval()(torch.randn(1, CHANNELS_OF[kind], 64, 64)).shape == (1, 4, 64, 64)


def test_input_a_network_was_not_published_with() -> None:
    with pytest.raises(UnknownNameError, match="input of htc-grasp 'depth'"):
        build("htc-grasp", "depth")


def test_evaluation_repeats_exactly(name: str) -> None:
    network = build(name).eval()
    x = torch.randn(2, info(name).channels, 64, 64)
    with torch.inference_mode():
        first, again = network(x), network(x)
    assert torch.equal(first, again)


def test_same_seed_same_weights(name: str) -> None:
    states = []
    for _ in range(2):
        torch.manual_seed(5)
        states.append(build(name).state_dict())
    assert all(torch.equal(states[0][key], states[1][key]) for key in states[0])


def test_wrong_name_lists_the_right_ones() -> None:
    with pytest.raises(UnknownNameError, match="htc-grasp"):
        build("htc-grsp")


# --- HTC-Grasp ----------------------------------------------------------------------------


def test_double_normalisation() -> None:
    """Weights over the memory sum to 1, and are proportional to a softmax over the tokens."""
    scores = 3 * torch.randn(2, 50, 4, 64)
    weights = ExternalAttention.double_normalise(scores)
    torch.testing.assert_close(weights.sum(-1), torch.ones(2, 50, 4))
    over_tokens = scores.softmax(1)
    factor = 1 / over_tokens.sum(-1, keepdim=True)
    torch.testing.assert_close(weights / over_tokens, factor.expand_as(scores))
    huge = ExternalAttention.double_normalise(torch.full((1, 3136, 1, 64), 500.0))
    torch.testing.assert_close(huge, torch.full_like(huge, 1 / 64))


def test_external_attention_by_hand() -> None:
    """Equations 4–6 for two heads, one at a time."""
    attention = ExternalAttention(8, heads=2, memory=5)
    x = torch.randn(1, 6, 8)
    query = attention.query(x)
    heads = []
    for part in query.split(4, dim=-1):
        scores = (part @ attention.memory_key.weight.T).softmax(dim=1)
        heads.append(scores / scores.sum(-1, keepdim=True) @ attention.memory_value.weight.T)
    torch.testing.assert_close(attention(x), attention.output(torch.cat(heads, dim=-1)))


def test_self_attention_is_equation_3() -> None:
    attention = SelfAttention(8, heads=1)
    x = torch.randn(1, 6, 8)
    q, k, v = attention.query_key_value(x).split(8, dim=-1)
    expected = (q @ k.transpose(1, 2) / 8**0.5).softmax(-1) @ v
    torch.testing.assert_close(attention(x), attention.output(expected))


def test_fusing_early_equals_concatenating_first() -> None:
    """The order of computation is ours, the function is the paper's."""
    fuse = Fuse(CHANNELS, 24).eval()
    maps = [torch.randn(1, c, 56 >> i, 56 >> i) for i, c in enumerate(CHANNELS)]
    up = [functional.interpolate(m, size=(56, 56), mode="bilinear", align_corners=False) for m in maps]
    weight = torch.cat([m.get_parameter("weight") for m in fuse.merge], dim=1)
    expected = functional.relu(fuse.norm(functional.conv2d(torch.cat(up, dim=1), weight)))
    torch.testing.assert_close(fuse(maps), expected, rtol=1e-4, atol=1e-5)


def test_switches_change_the_structure() -> None:
    def count(network: nn.Module, kind: type) -> int:
        return sum(isinstance(m, kind) for m in network.modules())

    full, plain = HTCGrasp(), HTCGrasp(external_attention=False, channel_attention=False)
    assert (count(full, ExternalAttention), count(full, SelfAttention)) == (8, 0)
    assert (count(plain, ExternalAttention), count(plain, SelfAttention)) == (0, 8)
    assert full.refine.excite is not None
    assert plain.refine.excite is None
    counts = {name: parameter_count(build(name)) for name in NETWORKS if name.startswith("htc")}
    assert len(set(counts.values())) == len(counts) == 5
    assert counts["htc-grasp"] - counts["htc-grasp-no-ca"] == 256 * 16 + 16 + 16 * 256 + 256


def test_stages_have_the_resolutions_of_the_paper() -> None:
    features, shapes = torch.randn(1, 4, 224, 224), []
    for stage in HTCGrasp().eval().stages:
        features = stage(features)
        shapes.append(tuple(features.shape[1:]))
    assert shapes == [(32, 56, 56), (64, 28, 28), (128, 14, 14), (256, 7, 7)]


def test_widened_external_attention_is_that_of_its_authors() -> None:
    """Four times the heads, of the same width; memories are shared by them and have biases."""
    attention = ExternalAttention(8, heads=2, memory=5, widening=4)
    x = torch.randn(1, 6, 8)
    heads = []
    for part in attention.query(x).split(4, dim=-1):
        scores = attention.memory_key(part).softmax(dim=1)
        heads.append(attention.memory_value(scores / scores.sum(-1, keepdim=True)))
    assert len(heads) == 8
    torch.testing.assert_close(attention(x), attention.output(torch.cat(heads, dim=-1)))


# --- TF-Grasp's windows -------------------------------------------------------------------


def test_windows_go_back_where_they_came_from() -> None:
    x = torch.randn(2, 14, 21, 3)
    windows = _to_windows(x)
    assert windows.shape == (12, 49, 3)
    assert torch.equal(windows[1, :7], x[0, 0, 7:14])
    assert torch.equal(_from_windows(windows, x.shape), x)


def test_shifted_windows_do_not_join_opposite_borders() -> None:
    """Moving the upper left token leaves those at the right and bottom borders alone."""
    block = SwinBlock(8, 1, shift=3, drop_path=0.0).eval()
    x = torch.randn(1, 14, 14, 8)
    moved = x.clone()
    moved[0, 0, 0] += 1
    change = (block._attend(moved) - block._attend(x)).abs().amax(-1)[0]
    assert change[:4, :4].max() > 1e-4, "they share a window"
    assert change[4:, :].max() < 1e-6
    assert change[:, 4:].max() < 1e-6


def reach(network: nn.Module) -> float:
    """Distance [px] of a quality pixel from the middle of its squared gradient at the input."""
    x = torch.randn(1, 4, 224, 224, requires_grad=True)
    network(x)[0, 0, 30, 30].backward()
    assert x.grad is not None
    weight = x.grad[0].square().sum(0)
    weight = weight / weight.sum()
    axis = torch.arange(224.0)
    row, column = (weight.sum(1) * axis).sum(), (weight.sum(0) * axis).sum()
    return float(torch.hypot(row - 30, column - 30))


def test_expanding_keeps_tokens_in_their_place() -> None:
    """The release's reshape draws in other columns than the skip connections bring."""
    torch.manual_seed(0)
    assert reach(TFGrasp().eval()) < 16
    assert reach(TFGrasp(reshape=True).eval()) > 60
    expand = Expand(3, 2, factor=2)
    x = torch.zeros(1, 4, 5, 3)
    x[0, 1, 3] = 1
    touched = (expand(x) != expand(torch.zeros_like(x))).any(-1)[0].nonzero()
    assert touched.amin(0).tolist() == [2, 6]
    assert touched.amax(0).tolist() == [3, 7]


# --- encoding -----------------------------------------------------------------------------


def test_holes_take_the_nearest_depth() -> None:
    depth = np.zeros((5, 9), np.float32)
    depth[2, 1], depth[2, 7] = 0.5, 0.9
    filled = fill_holes(depth)
    np.testing.assert_array_equal(filled[:, :4], 0.5)
    np.testing.assert_array_equal(filled[:, 6:], np.float32(0.9))
    np.testing.assert_array_equal(fill_holes(np.zeros_like(depth)), 0)


def test_depth_becomes_height_over_the_table() -> None:
    depth = np.full((50, 50), 0.7, np.float32)
    depth[20:30, 20:30] = 0.65
    depth[0, :10], depth[1, :5], depth[25, 25] = 0.9, 0.1, 0.0
    height = encode_depth(depth)
    assert height[40, 40] == 0
    assert height[22, 22] == pytest.approx(0.5, abs=1e-5)
    assert height[25, 25] == height[22, 22], "the hole on the object is filled from it"
    assert (height.min(), height.max()) == (-1, 3)
    assert np.isfinite(encode_depth(np.zeros_like(depth))).all()


@pytest.mark.parametrize(("kind", "channels"), [("rgbd", 4), ("rgb", 3), ("depth", 1), ("rgd", 3)])
def test_input_channels(kind: Kind, channels: int) -> None:
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (30, 40, 3), dtype=np.uint8)
    depth = rng.uniform(0.5, 0.8, (30, 40)).astype(np.float32)
    x = to_input(rgb, depth, kind)
    assert x.shape == (channels, 30, 40)
    assert x.dtype == np.float32
    if kind == "rgbd":
        np.testing.assert_array_equal(x[0], encode_depth(depth))
        np.testing.assert_allclose(x[1] - x[2], (rgb[..., 0] - rgb[..., 1].astype(float)) / 255, atol=1e-6)


def test_maps_survive_the_way_through_a_network() -> None:
    maps = GraspMaps.from_grasps([Grasp(30.0, 20.0, 0.6, 45.0)], (48, 64))
    back = maps_from_output(torch.from_numpy(targets_from_maps(maps))[None])
    for field in ("quality", "sin2", "cos2", "width"):
        np.testing.assert_allclose(getattr(back, field), getattr(maps, field), atol=1e-5)
    best = back.smoothed().peaks()[0]
    assert (best.x, best.y) == pytest.approx((30, 20), abs=1.0)
    assert (best.angle, best.width) == pytest.approx((0.6, 45), rel=0.05)
