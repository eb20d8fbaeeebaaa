"""What a predictor's name means, and for how long a predictor is in use."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

import pytest

from grasp_bench.errors import AssetError, PredictorError, UnknownNameError
from grasp_bench.networks.store import shipped_file
from grasp_bench.predictors import names
from grasp_bench.predictors.names import Command, PythonPath, Server, parse, with_weights
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
    with pytest.raises(AssetError, match=r"mine\.safetensors are missing; train them"):
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
