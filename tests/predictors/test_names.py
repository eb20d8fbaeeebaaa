"""What a predictor's name means, and for how long a predictor is in use."""

from __future__ import annotations

import sys
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.errors import AssetError, PredictorError, UnknownNameError
from grasp_bench.networks.store import shipped_file
from grasp_bench.predictors import load_predictor, names
from grasp_bench.predictors.identity import identify
from grasp_bench.predictors.names import Command, PythonPath, Server, Trained, parse, with_weights
from grasp_bench.predictors.shipped import SHIPPED, Shipped
from grasp_bench.predictors.use import in_use


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("gg-cnn", "network"),
        ("gg-cnn@my/gg-cnn.safetensors", "network"),
        ("oracle", "control"),
        ("mine:Mine", "own"),
        ("__main__:Outer.Mine", "own"),
        ("http://127.0.0.1:8000", "server"),
        ("https://example.org/a", "server"),
        ("cmd: python x.py --port {port}", "command"),
    ],
)
def test_a_name_is_of_one_kind(name: str, kind: str) -> None:
    named = parse(name)
    assert (named.name, named.kind) == (name, kind)
    assert (named.weights is None) == (kind != "network")


def test_an_unknown_name_is_refused_with_the_shipped_and_the_other_ways_in() -> None:
    with pytest.raises(UnknownNameError, match=r"Did you mean oracle.*cmd: COMMAND --port"):
        parse("orakel")


def test_other_weights_of_a_network_are_a_predictor_of_their_own() -> None:
    other, own = SHIPPED["htc-grasp-1000"], SHIPPED["htc-grasp"]
    assert other.network is own.network
    assert [s.weights.name for s in (other, own) if s.weights] == [
        "htc-grasp-1000.safetensors",
        "htc-grasp.safetensors",
    ]


def test_a_network_with_weights_in_a_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.safetensors"
    name = with_weights("gg-cnn", path)
    with pytest.raises(
        AssetError,
        match=r"mine\.safetensors are missing; name a \.safetensors file that is there, or train them",
    ):
        parse(name).load()
    path.write_bytes(shipped_file("gg-cnn").path.read_bytes())
    assert parse(name).facts(None) == {"files": {"mine.safetensors": sha256(path.read_bytes()).hexdigest()}}
    assert parse(name).load().name == "gg-cnn"  # type: ignore[attr-defined]
    path.write_bytes(shipped_file("tf-grasp-release").path.read_bytes())
    with pytest.raises(AssetError, match="holds weights of network 'tf-grasp', not 'gg-cnn'"):
        parse(name).load()
    with pytest.raises(AssetError, match="weights of earlier versions are for 'tf-grasp-release' now"):
        parse(with_weights("tf-grasp", path)).load()
    with pytest.raises(PredictorError, match="--weights is for networks; oracle is none"):
        with_weights("oracle", path)


def test_any_network_of_maps_can_be_asked_with_test_time_augmentation(tmp_path: Path) -> None:
    once, four_times = SHIPPED["gg-cnn"], parse("gg-cnn-tta")
    assert isinstance(four_times, Shipped)
    assert four_times.facts(None) == once.facts(None)
    path = tmp_path / "mine.safetensors"
    path.write_bytes(shipped_file("gg-cnn").path.read_bytes())
    own = parse(with_weights("gg-cnn-tta", path))
    assert isinstance(own, Trained)
    assert (own.network, own.weights.path) == ("gg-cnn", path)
    depth = np.full((224, 224), 0.5, np.float32)
    depth[90:120, 60:160] = 0.45
    image = RgbdImage(np.zeros((224, 224, 3), np.uint8), depth, Intrinsics.from_fov(224, 224, 1.0))
    plain, averaged, owned = (named.load().predict(image) for named in (once, four_times, own))
    assert averaged == owned != plain
    with pytest.raises(PredictorError, match="gives grasps and no maps"):
        parse("wu-anchor-free-tta").load()
    with pytest.raises(UnknownNameError, match="oracle-tta"):
        parse("oracle-tta")


def test_a_predictor_is_identified_without_being_made(tmp_path: Path) -> None:
    script = tmp_path / "server.py"
    script.write_text("pass")
    digest = sha256(b"pass").hexdigest()
    assert Server("http://127.0.0.1:1").facts(None) == {}
    assert Command(f"cmd: /bin/sh {script} {{port}}").facts(None) == {"files": {str(script): digest}}
    assert PythonPath("nowhere:Thing").facts(None) == {"files": {}}
    assert list(parse("gg-cnn").facts(None)) == ["software", "files"]
    assert list(parse("random").facts(None)) == ["software"]


class Closing:
    closed = 0

    def predict(self, image: object) -> list:
        return []

    def close(self) -> None:
        self.closed += 1


def test_what_is_loaded_for_use_is_closed_whatever_happens(monkeypatch: pytest.MonkeyPatch) -> None:
    made = Closing()
    monkeypatch.setattr(names, "make", lambda path, name: made)
    with in_use("mine:Mine") as predictor:
        assert predictor is made
        assert not made.closed
    assert made.closed == 1
    with pytest.raises(ZeroDivisionError), in_use("mine:Mine"):
        raise ZeroDivisionError
    assert made.closed == 2
    with in_use(made) as predictor:
        assert predictor is made
    assert made.closed == 2, "its owner closes it"
    with in_use("random"):
        pass  # which has nothing to close


def test_a_network_whose_weights_are_missing_has_nulls_to_tell(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("grasp_bench.networks.store.assets_dir", lambda: tmp_path)
    shipped = parse("gr-convnet")
    assert isinstance(shipped, Shipped)
    assert not shipped.available
    told = shipped.details()
    assert told["weights"] == {"file": "gr-convnet.safetensors", "sha256": None}
    assert (told["parameters"], told["input"], told["crop"]) == (1_900_900, "rgbd", 224)
    assert [told[k] for k in ("trained_on", "steps", "seconds")] == [None] * 3
    (tmp_path / "weights").mkdir()
    (tmp_path / "weights" / "gr-convnet.safetensors").write_bytes(b"torn")
    told = shipped.details()
    assert told["weights"]["sha256"] == sha256(b"torn").hexdigest()
    assert told["steps"] is None


# ---------------------------------------------------------------- one's own: arguments, files, weights

OWN = """
import beside
class Mine:
    def __init__(self, size=1, *, name="a"): self.told = size, name
    def predict(self, image): return []
made = Mine()
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "own_one.py").write_text(OWN)
    (tmp_path / "far" / "beside.py").touch()
    monkeypatch.setattr("sys.path", [*sys.path])
    return tmp_path


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", (1, "a")),
        ("()", (1, "a")),
        ("(224)", (224, "a")),
        ("(size=[1, 2], name='x:y(')", ([1, 2], "x:y(")),
    ],
)
def test_a_file_of_ones_own_and_its_arguments(text: str, told: tuple[Any, ...], own: Path) -> None:
    name = f"./far/own_one.py:Mine{text}"
    with in_use(name) as made:
        assert made.told == told  # pyright: ignore[reportAttributeAccessIssue]
    facts = identify(name)
    assert facts is not None
    assert set(facts["files"]) == {"own_one.py", "beside.py"}


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("./far/own_one.py:Mine(__import__('os'))", "must be literals"),
        ("./far/own_one.py:Mine(size=", "must be literals"),
        ("./far/own_one.py:Mine(**{'size': 1})", "must be literals"),
        ("./far/own_one.py:Mine(1)(2)", "must be literals"),
        ("./far/own_one.py:Mine(length=1)", "could not be made: TypeError"),
        ("./far/own_one.py:made(1)", "takes no arguments"),
        ("./far/none.py:Mine", "There is no file"),
        ("own_two:Mine", r"was not found: neither in .* nor on Python's path"),
    ],
)
def test_what_is_no_predictor_of_ones_own_is_said(name: str, words: str, own: Path) -> None:
    with pytest.raises(PredictorError, match=words):
        load_predictor(name)


def test_weights_of_ones_own_run_by_their_file(tmp_path: Path) -> None:
    shipped = SHIPPED["gg-cnn"].weights
    assert shipped is not None
    mine = tmp_path / "mine.safetensors"
    mine.write_bytes(shipped.path.read_bytes())
    named = parse(str(mine))
    assert named.kind == "network"
    assert named.weights is not None
    assert named.weights.digest == shipped.digest
    with in_use(str(mine)) as predictor:
        assert predictor.name == "gg-cnn"  # pyright: ignore[reportAttributeAccessIssue]
    facts = identify(str(mine))
    assert facts is not None
    assert facts["files"] == {"mine.safetensors": shipped.digest}
    mine.write_bytes(b"torn")
    with pytest.raises(AssetError, match="truncated or not a safetensors file"):
        load_predictor(str(mine))
