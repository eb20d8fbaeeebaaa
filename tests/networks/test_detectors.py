"""Networks with losses of their own: what they learn, and what they say of it."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
import torch
from torch import Tensor, nn

from grasp_bench.grasps import Grasp, angle_difference
from grasp_bench.networks.asif import Asif
from grasp_bench.networks.boxes import aligned, box_offsets, moved, overlaps, suppressed
from grasp_bench.networks.chu import Chu, orientation
from grasp_bench.networks.encoding import WIDTH_SCALE, grasps_from_output
from grasp_bench.networks.fcgn import FCGN
from grasp_bench.networks.gqcnn import GQCNN, antipodal_pairs
from grasp_bench.networks.kumra import Kumra
from grasp_bench.networks.laili import Laili
from grasp_bench.networks.lenz import AutoEncoder, Lenz, structure
from grasp_bench.networks.lenz_features import FEATURES, candidates, features, prepared
from grasp_bench.networks.oriented import Oriented
from grasp_bench.networks.redmon import Redmon, decoded, encoded
from grasp_bench.networks.resnet import DenseTrunk, Trunk, begin_with_trunk
from grasp_bench.networks.roi_gd import RoiGD, objects
from grasp_bench.networks.rows import NONE, Detector, cut_out, drawn, grasps_from_rows, rows_from_grasps
from grasp_bench.networks.tries import examples
from grasp_bench.networks.wu import Wu, upright_sides

torch.set_num_threads(1)

SIZE = 96
BARS = ((38.0, 44.0, 0.3), (58.0, 50.0, -1.1))
"""Middle and direction of the opening across a bar of each image."""
OPENING, LENGTH = 24.0, 44.0


def scenes(size: int) -> tuple[Tensor, Tensor, Tensor]:
    """Images (2, 4, S, S) of a bar each, rows (2, 6, 6), three that hold and one that fails, and maps."""
    scale = size / SIZE
    images, maps = torch.zeros(2, 4, size, size), torch.zeros(2, 4, size, size)
    rows = torch.zeros(2, 6, 6)
    rows[..., 5] = NONE
    axis = torch.arange(size) + 0.5
    y, x = torch.meshgrid(axis, axis, indexing="ij")
    for i, (cx, cy, angle) in enumerate(BARS):
        cx, cy = cx * scale, cy * scale
        u = (x - cx) * math.cos(angle) - (y - cy) * math.sin(angle)
        v = (x - cx) * math.sin(angle) + (y - cy) * math.cos(angle)
        bar = (u.abs() < 6 * scale) & (v.abs() < LENGTH / 2 * scale)
        images[i, 0][bar] = 0.4
        images[i, 1:, bar] = 0.5
        for k, off in enumerate((0.0, -10.0, 10.0)):
            off *= scale
            place = cx + off * math.sin(angle), cy + off * math.cos(angle)
            rows[i, k] = torch.tensor([*place, angle, OPENING * scale, OPENING * scale / 2, 1])
        rows[i, 3] = torch.tensor([cx, cy, angle + 1.4, OPENING * scale, OPENING * scale / 2, 0])
        label = (1.0, math.sin(2 * angle), math.cos(2 * angle), OPENING * scale / WIDTH_SCALE)
        maps[i][:, bar & (v.abs() < 14 * scale)] = torch.tensor(label)[:, None]
    return images, rows, maps


def right(grasp: Grasp, image: int, scale: float) -> bool:
    """Whether a grasp lies across the image's bar."""
    cx, cy, angle = BARS[image]
    dx, dy = grasp.x / scale - cx, grasp.y / scale - cy
    across = dx * math.cos(angle) - dy * math.sin(angle)
    along = dx * math.sin(angle) + dy * math.cos(angle)
    return (
        abs(across) < 7
        and abs(along) < LENGTH / 2
        and angle_difference(grasp.angle, angle) < math.radians(25)
        and 0.6 * OPENING < grasp.width / scale < 1.7 * OPENING
    )


LEARNERS: dict[str, tuple[Callable[[], Detector], int, int, int]] = {
    "redmon-direct": (lambda: Redmon(dropout=0.0, side=SIZE), 3, 80, SIZE),
    "redmon-multigrasp": (lambda: Redmon(multiple=True, dropout=0.0, side=SIZE), 3, 50, SIZE),
    "kumra-resnet50": (lambda: Kumra(blocks=(1, 1, 1, 1), width=16, dropout=0.0), 3, 40, SIZE),
    "kumra-resnet50x2": (lambda: Kumra(4, blocks=(1, 1, 1), width=16, dropout=0.0), 4, 40, SIZE),
    "fcgn": (lambda: FCGN(blocks=(1, 1, 1), width=16), 3, 50, SIZE),
    "chu-resnet50": (lambda: Chu(blocks=(1, 1, 1, 1), width=8, regions=16), 3, 70, SIZE),
    "roi-gd": (lambda: RoiGD(blocks=(1, 1, 1), width=8, regions=6), 3, 40, SIZE),
    "wu-anchor-free": (lambda: Wu(blocks=(1, 1, 1, 1), width=16), 3, 50, SIZE),
    "laili-pairs": (lambda: Laili(blocks=(1, 1, 1, 1), width=32), 3, 120, SIZE),
    "asif-graspnet": (Asif, 3, 40, SIZE),
    "gq-cnn": (lambda: GQCNN(each=4), 1, 8, SIZE),
    "lenz-sae": (lambda: Lenz(iterations=8), 4, 25, SIZE),
}
"""What makes each with a smaller trunk and without dropout, its channels, steps, and side of the image."""


@pytest.mark.parametrize("name", LEARNERS)
def test_images_without_labels_break_nothing(name: str) -> None:
    """Nor does bfloat16."""
    make, channels, _, size = LEARNERS[name]
    torch.manual_seed(1)
    network = make().train()
    images, rows, maps = scenes(size)
    inputs = {4: images, 3: images[:, 1:], 1: images[:, :1]}[channels]
    rows[..., 5] = NONE
    with torch.autocast("cpu", torch.bfloat16):
        parts = network.loss(inputs, 0 * maps if name == "asif-graspnet" else rows)
    parts["loss"].backward()
    for parameter, value in network.named_parameters():
        assert value.grad is not None, parameter
        assert torch.isfinite(value.grad).all(), parameter
    blank = network.eval()(torch.zeros_like(inputs[:1]))[0]
    assert all(math.isfinite(g.width) for g in grasps_from_output(blank, 3))


def test_an_image_without_labels_says_nothing_of_where_objects_are_not() -> None:
    """Contact pairs learn from few labels: pictures alone must not teach that there is nothing on them."""
    torch.manual_seed(1)
    network = LEARNERS["laili-pairs"][0]().eval()
    images, rows, _ = scenes(SIZE)
    both, labels = images[:2, 1:], rows[:2].clone()
    labels[1, :, 5] = NONE
    torch.manual_seed(2)
    mixed = network.loss(both, labels)
    torch.manual_seed(2)
    alone = network.loss(both[:1], labels[:1])
    torch.testing.assert_close(mixed["proposal"], alone["proposal"])
    labels[..., 5] = NONE
    assert network.loss(both, labels)["proposal"] == 0


@pytest.mark.parametrize("name", LEARNERS)
def test_a_handful_of_scenes_is_learnt(name: str) -> None:
    make, channels, steps, size = LEARNERS[name]
    torch.manual_seed(1)
    network = make().train()
    images, rows, maps = scenes(size)
    inputs = {4: images, 3: images[:, 1:], 1: images[:, :1]}[channels]
    targets = maps if name == "asif-graspnet" else rows
    network.prepare(inputs, targets)
    optimizer = torch.optim.AdamW(network.parameters(), lr=1e-3)
    losses: list[float] = []
    for step in range(steps):
        for group in optimizer.param_groups:
            group["lr"] = 1e-3 * min(1, (step + 1) / 8)
        parts = network.loss(inputs, targets)
        optimizer.zero_grad()
        parts["loss"].backward()
        if not step:
            for parameter, value in network.named_parameters():
                assert value.grad is not None, parameter
        nn.utils.clip_grad_norm_(network.parameters(), 5.0)
        optimizer.step()
        losses.append(parts["loss"].item())
    assert all(math.isfinite(loss) for loss in losses)
    assert min(losses[-3:]) < 0.7 * losses[0]
    # Norms have seen a few steps only: those of the two images are what they were taught with.
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.momentum = None
            module.reset_running_stats()
    with torch.no_grad():
        for _ in range(2):
            network.loss(inputs, targets)
    network.eval()
    with torch.inference_mode():
        outputs = network(inputs)
    for i, output in enumerate(outputs):
        best = grasps_from_output(output, 3)
        assert best, "nothing was found"
        assert right(best[0], i, size / SIZE), (best, BARS[i], losses[0], losses[-1])


# --- parts they share ---------------------------------------------------------------------


def test_what_is_cut_out_is_turned_with_the_grasp() -> None:
    """A bar lies upright in the patch whose opening goes across it, at any angle."""
    images, rows, _ = scenes(SIZE)
    patches = cut_out(images[:, :1], rows[:, :1], (12, 24))[:, 0, 0]
    assert patches.shape == (2, 12, 24)
    for patch in patches:
        assert patch[:, 7:17].min() > 0.3
        assert patch[:, :5].max() < 0.05
        assert patch[:, 19:].max() < 0.05


def test_of_like_answers_the_best_is_given() -> None:
    rows = torch.tensor(
        [
            [50.0, 50, 0.1, 30, 15, 0.5],
            [53.0, 50, 0.2, 30, 15, 0.9],
            [53.0, 50, 1.4, 30, 15, 0.7],
            [90.0, 50, 0.1, 30, 15, 0.6],
            [20.0, 20, 0.1, 30, 15, 0.0],
        ]
    )
    found = grasps_from_rows(rows, 10)
    assert [round(g.quality, 1) for g in found] == [0.9, 0.7, 0.6]
    assert len(grasps_from_rows(rows, 2)) == 2


def test_tables_of_labels() -> None:
    grasps = [(Grasp(10.0 * k, 30.0, 0.3, 20.0, quality=k / 10), 1.0) for k in range(12)]
    table = rows_from_grasps(grasps, 100, 4)
    assert table[:, 0].tolist() == [90, 80, 70, 60]
    assert rows_from_grasps([], 100, 3)[:, 5].tolist() == [NONE] * 3
    rows, there = drawn(rows_from_grasps(grasps[:2], 100, 8)[None], 5)
    assert there.sum() == 2
    assert sorted(rows[0, there[0], 0].tolist()) == [0, 10]


def test_numbers_of_a_regression_and_back() -> None:
    rows = torch.tensor([[100.0, 80.0, -1.2, 44.0, 22.0, 0.8]])
    torch.testing.assert_close(decoded(encoded(rows, 224), rows[:, 5], 224), rows)


def test_boxes() -> None:
    a = torch.tensor([[0.0, 0, 10, 10], [5.0, 0, 15, 10], [40.0, 40, 50, 60]])
    torch.testing.assert_close(overlaps(a, a)[0], torch.tensor([1, 1 / 3, 0]))
    torch.testing.assert_close(moved(a[:1], box_offsets(a[:1], a[2:])), a[2:])
    assert suppressed(a, torch.tensor([0.2, 0.9, 0.5]), 0.3, 5).tolist() == [1, 2]
    assert suppressed(a, torch.tensor([0.2, 0.9, 0.5]), 0.4, 5).tolist() == [1, 2, 0]
    assert suppressed(a[:0], torch.zeros(0), 0.4, 5).tolist() == []


def test_features_of_a_region_are_those_at_its_place() -> None:
    """Of a map that holds its own coordinates."""
    axis = 16 * (torch.arange(10) + 0.5)
    y, x = torch.meshgrid(axis, axis, indexing="ij")
    found = aligned(torch.stack([x, y])[None], torch.tensor([[[20.0, 40.0, 90.0, 110.0]]]), 16, 7)[0, 0]
    centres = 10 * (torch.arange(7) + 0.5)
    torch.testing.assert_close(found[0], (20 + centres).expand(7, 7), atol=1e-3, rtol=0)
    torch.testing.assert_close(found[1], (40 + centres)[:, None].expand(7, 7), atol=1e-3, rtol=0)


def test_oriented_anchors_code_and_match() -> None:
    kind = Oriented(4, (0.1, 0.1, 0.2, 0.2, 0.2))
    anchors = kind.anchors(torch.tensor([[8.0, 8.0], [24.0, 8.0]]), 38.0)
    assert anchors.shape == (8, 5)
    degrees = [round(math.degrees(a), 1) for a in anchors[:4, 2].tolist()]
    assert degrees == [-67.5, -22.5, 22.5, 67.5]
    row = torch.tensor([[26.0, 6.0, 0.5, 30.0, 15.0, 1.0]])
    assert torch.allclose(kind.decode(anchors, kind.encode(anchors, row), torch.ones(8)), row, atol=1e-4)
    logits = torch.zeros(1, 8, 2, requires_grad=True)
    offsets = torch.zeros(1, 8, 5, requires_grad=True)
    kind.loss(logits, offsets, anchors[None], torch.tensor(16.0), row[None])[1].backward()
    assert offsets.grad is not None
    assert offsets.grad.abs().sum(-1).nonzero()[:, 1].tolist() == [6], "second cell, +22.5°"


def test_orientations_of_a_half_turn_are_one_class() -> None:
    angles = torch.deg2rad(torch.tensor([-90.0, 90.0, -86.0, 0.0, 84.0, 86.0]))
    assert orientation(angles).tolist() == [1, 1, 1, 10, 18, 1]


def test_grasps_near_each_other_are_one_object() -> None:
    rows = torch.zeros(1, 5, 6)
    rows[0, :, 5] = torch.tensor([1.0, 1.0, 1.0, 1.0, NONE])
    rows[0, :, 0] = torch.tensor([20.0, 50.0, 80.0, 180.0, 0.0])
    rows[0, :, 3:5] = torch.tensor([20.0, 10.0])
    boxes, first = objects(rows)
    assert first[0].tolist() == [True, False, False, True, False]
    assert boxes[0, 0].tolist() == [10, -5, 90, 5], "a chain of three"
    assert boxes[0, 3].tolist() == [170, -5, 190, 5]


def test_a_rectangle_is_turned_to_the_nearer_axis() -> None:
    rows = torch.tensor([[0.0, 0, math.radians(a), 40, 10, 1] for a in (0, 40, -40, 50, 90)])
    assert upright_sides(rows).tolist() == [[40, 10], [40, 10], [40, 10], [10, 40], [10, 40]]


def test_failures_of_physics_are_learnt_from() -> None:
    torch.manual_seed(0)
    _, rows, _ = scenes(SIZE)
    drawn_rows, label, known = examples(rows, 64)
    assert known.all()
    assert label.sum(1).tolist() == [64, 64]
    assert (drawn_rows[label][:, 5] == 1).all()
    failed = (drawn_rows[~label][:, 5] == 0).float().mean()
    assert 0.3 < failed < 0.7
    rows[1, :, 5] = NONE
    assert not examples(rows, 4)[2][1].any()


def test_antipodal_pairs_lie_across_a_bar() -> None:
    images, _, _ = scenes(SIZE)
    for image, (_, _, angle) in zip(images, BARS, strict=True):
        pairs = antipodal_pairs(image[0], 50, torch.Generator().manual_seed(0))
        near = [angle_difference(float(a), angle) < math.radians(40) for a in pairs[:, 2]]
        assert len(near) >= 20
        assert sum(near) > 0.6 * len(near), "the others join its ends"
    assert not len(antipodal_pairs(torch.zeros(50, 50), 50, torch.Generator().manual_seed(0)))


# --- Lenz's features ----------------------------------------------------------------------


def test_features_keep_a_rectangle_s_shape_and_turn_its_normals() -> None:
    images, rows, _ = scenes(SIZE)
    found, mask = features(prepared(images), rows[:, :1])
    assert found.shape == mask.shape == (2, 7, 576)
    shape = mask[0, 0].view(24, 24)
    assert shape.sum() == 24 * 12, "half as high as wide"
    assert shape[6:18].all()
    assert not found[mask == 0].any()
    across, along = (found[0, i].view(24, 24) for i in (4, 5))
    left, right_side = across[8:16, 5:7].mean(), across[8:16, 17:19].mean()
    assert left < -0.3
    assert right_side > 0.3, "the bar's sides face away from it"
    assert along.abs().mean() < 0.35 * across.abs().mean()


def test_the_search_stays_on_the_object_and_within_the_image() -> None:
    images, _, _ = scenes(SIZE)
    rows = candidates(images[:1])
    assert len(rows) > 1000
    assert (rows[:, 3] >= rows[:, 4]).all()
    assert len(rows[:, 2].unique()) == 12
    assert candidates(torch.zeros(1, 4, 60, 60)).shape == (0, 5)


def test_the_structured_penalty_counts_units_and_modes_in_use() -> None:
    weight = torch.zeros(3, FEATURES)
    none = structure(weight, 200, 1e15)
    weight[0, 0], weight[2, 600], weight[2, 601] = 0.5, -0.5, 0.5
    two = structure(weight, 200, 1e15)
    weight[1, 5] = 0.5
    assert none < 0.2 * two
    assert structure(weight, 200, 1e15) - none == pytest.approx(1.5 * float(two - none), rel=0.05)


def test_pretraining_rebuilds_and_rescales() -> None:
    torch.manual_seed(0)
    network, kinds = AutoEncoder(6), torch.randn(3, FEATURES)
    x = kinds[torch.randint(3, (40,))] + 0.1 * torch.randn(40, FEATURES)
    network.pretrain(x, torch.ones_like(x), iterations=10)
    before = nn.functional.linear(x, network.first.weight, network.first.bias)
    torch.testing.assert_close(before.std(0), torch.full((6,), 1.5), rtol=1e-3, atol=0)
    torch.testing.assert_close(before.mean(0).sigmoid(), torch.full((6,), 0.15), rtol=1e-3, atol=0)


# --- trunks -------------------------------------------------------------------------------


def test_a_trunk_begins_a_detector() -> None:
    dense, detector = DenseTrunk(3, (1, 1, 1)), FCGN(blocks=(1, 1, 1))
    assert begin_with_trunk(detector, dense) == len(detector.trunk.state_dict())
    for key, value in dense.trunk.state_dict().items():
        assert torch.equal(detector.trunk.state_dict()[key], value)
    both = Kumra(4, blocks=(1, 1, 1, 1))
    assert begin_with_trunk(both, dense) == 2 * len(dense.trunk.state_dict())
    other = FCGN(inputs=1, blocks=(1, 1, 1))
    stem = len(dense.trunk.stem.state_dict())
    assert begin_with_trunk(other, dense) == len(dense.trunk.state_dict()) - stem
    deeper = FCGN(blocks=(1, 1, 3))
    assert begin_with_trunk(deeper, dense) == len(dense.trunk.state_dict())
    basic = nn.ModuleList([Trunk(3, (1, 1, 1), basic=True)])
    assert begin_with_trunk(basic, dense) == stem, "blocks of another kind stay as they are"
    back = DenseTrunk(3, (1, 1, 1))
    assert begin_with_trunk(back, both) == len(back.trunk.state_dict()), "Kumra's, wherever they lie within"
    colour = both.state_dict()["trunks.1.stem.0.weight"]
    assert torch.equal(back.state_dict()["trunk.stem.0.weight"], colour)
    assert begin_with_trunk(detector, nn.Linear(2, 2)) == 0


def test_strides_of_a_trunk() -> None:
    maps = Trunk(3, (1, 1, 1, 1), width=8)(torch.randn(1, 3, 96, 96))
    assert [tuple(m.shape[1:]) for m in maps] == [(32, 24, 24), (64, 12, 12), (128, 6, 6), (256, 3, 3)]
