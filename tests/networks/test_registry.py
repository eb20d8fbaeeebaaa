"""What is registered of each network, and that looking at it costs no torch."""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from pkgutil import resolve_name

import pytest
from torch import nn

from grasp_bench.networks.registry import NETWORKS, REGISTERED, all_weights, family, standing_for
from grasp_bench.networks.spec import CHANNELS, Network
from grasp_bench.report.paper import TABLE_1, TABLE_2, TABLE_3
from grasp_bench.report.table4 import PAPER

ROWS = {
    1: [row.method for row in TABLE_1],
    2: [row.method for row in TABLE_2],
    3: [row.method for row in TABLE_3],
    4: [row.system for row in PAPER],
}


@pytest.mark.parametrize("network", REGISTERED, ids=lambda network: network.name)
def test_a_registration_says_what_can_be_found(network: Network) -> None:
    assert issubclass(resolve_name(network.builder), nn.Module)
    assert network.reference
    assert set(network.parameters) <= set(network.kinds) <= set(CHANNELS)
    assert network.ablates is None or network.ablates in all_weights()
    for weights in network.weights:
        assert weights.summary
        assert "\n" not in weights.summary
        for table, row in weights.rows.items():
            assert row in ROWS[table]


def test_no_name_is_registered_twice() -> None:
    names = Counter(weights.name for network in REGISTERED for weights in network.weights)
    assert set(names.values()) == {1}
    assert len(NETWORKS) == len(REGISTERED)
    assert list(all_weights()) != list(names), "those of ablations come last"
    assert sorted(all_weights()) == sorted(names)


@pytest.mark.parametrize(
    ("table", "row", "names"),
    [
        (1, "GR-CNN", ["gr-convnet"]),
        (1, "GraspNet", ["asif-graspnet"]),
        (1, "AlexNet", ["redmon-multigrasp"]),
        (4, "TF-Grasp", ["tf-grasp", "tf-grasp-release"]),
        (4, "SAE", ["lenz-sae"]),
        (4, "ResNet-50", ["chu-resnet50"]),
        (2, "GG-CNN2", ["gg-cnn2"]),
        (3, "EA", ["htc-grasp-no-ca"]),
        (3, "CA", ["htc-grasp-no-ea"]),
        (3, "EA + CA", ["htc-grasp-1000", "htc-grasp"]),
        (4, "GG-CNN", ["gg-cnn"]),
    ],
)
def test_rows_of_the_paper_are_stood_for(table: int, row: str, names: list[str]) -> None:
    assert standing_for(table, row) == names


def test_ablations_follow_what_they_are_compared_with() -> None:
    assert family("htc-grasp-1000") == [
        "htc-grasp-1000",
        "htc-grasp-no-ea",
        "htc-grasp-no-ca",
        "htc-grasp-plain",
    ]
    assert family("tf-grasp") == ["tf-grasp"]


def test_neither_the_registry_nor_the_metadata_of_weights_import_torch() -> None:
    code = (
        "import sys; from grasp_bench.networks.registry import NETWORKS; "
        "from grasp_bench.networks.store import shipped_file; "
        "print(shipped_file('gg-cnn').metadata()['network'], 'torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["gg-cnn", "False"]
