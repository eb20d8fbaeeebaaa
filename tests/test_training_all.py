"""``scripts/train_all.py``: every network has a recipe, and every recipe is a command that is understood."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
import typer

from grasp_bench.cli.commands import app
from grasp_bench.cli.train import read_settings, with_recipe
from grasp_bench.networks.registry import NETWORKS, info

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))
import train_all
from make_curves import named
from train_all import (
    FACTS,
    LOG,
    RECIPES,
    TRUNK,
    data_commands,
    finish,
    keep_part,
    store_curve,
    train,
    training_words,
)

ALIKE = {"tf-grasp-release", "trunk-resnet101"}
"""Networks without a recipe: what was released wrongly, and a trunk that the other one stands in for."""


def test_every_network_has_a_recipe() -> None:
    assert set(RECIPES) == set(NETWORKS) - ALIKE


@pytest.mark.parametrize("name", RECIPES)
def test_recipes_are_understood(name: str) -> None:
    words = training_words(name, 90, 2)
    context = typer.main.get_command(app).commands["train"].make_context("train", words[1:])  # pyright: ignore[reportAttributeAccessIssue]
    typed = {k: v for k, v in context.params.items() if k not in {"data", "out", "recipe", "export"}}
    begun = typed.pop("init")
    config, _ = read_settings(with_recipe("own", typed, context))
    assert config.network == name
    assert (config.max_minutes, config.threads, config.until_flat) == (90, 2, True)
    assert config.tried >= 30
    assert begun is None or (begun == f"{TRUNK}/{TRUNK}.safetensors" and info(name).targets == "rectangles")


def test_data_is_the_documented_one() -> None:
    commands = data_commands(8500, 1500)
    for words in commands:
        typer.main.get_command(app).commands["data"].commands["synth"].make_context("synth", words[2:])  # pyright: ignore[reportAttributeAccessIssue]
    cameras, plain = (" ".join(words) for words in commands)
    assert "--scenes 8500 --style camera-like --seed 19" in cameras
    assert "--scenes 1500 --seed 1" in plain


def test_the_trunk_comes_first(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    ran: list[str] = []
    monkeypatch.setattr(train_all, "run", lambda words, folder: ran.append(words[2]))
    train(["chu-resnet50", TRUNK, "gg-cnn"], tmp_path, 1.0, 1)
    assert ran == [TRUNK, "chu-resnet50", "gg-cnn"]


def test_what_was_not_trained_is_not_shipped(tmp_path: Path) -> None:
    with pytest.raises(Exception, match=r"gg-cnn\.safetensors are missing"):
        finish("gg-cnn", tmp_path, tmp_path)


def test_a_curve_from_whose_weights_another_training_goes_on_is_kept_as_a_part(tmp_path: Path) -> None:
    for stem, content in (("gg-cnn-part1", "first"), ("gg-cnn", "second"), ("gg-cnn2", "another")):
        for ending in (".json", ".jsonl"):
            (tmp_path / f"{stem}{ending}").write_text(content)
    keep_part("gg-cnn", tmp_path)
    assert {path.name: path.read_text() for path in tmp_path.glob("*.json")} == {
        "gg-cnn-part1.json": "first",
        "gg-cnn-part2.json": "second",
        "gg-cnn2.json": "another",
    }
    assert (tmp_path / "gg-cnn-part2.jsonl").read_text() == "second"
    assert named(tmp_path / "gg-cnn-part2.json") == "gg-cnn, part 2"
    assert named(tmp_path / "gg-cnn.json") == "gg-cnn"


def test_a_curve_stored_twice_is_no_part_of_itself(tmp_path: Path) -> None:
    trained, curves = tmp_path / "trained", tmp_path / "curves"
    trained.mkdir()
    curves.mkdir()
    (curves / "gg-cnn.json").write_text("earlier")
    (curves / "gg-cnn.jsonl").write_text("earlier")
    (trained / FACTS).write_text('{"begun_with": "gg-cnn.safetensors 0123456789abcdef"}')
    (trained / LOG).write_text("later")
    for _ in range(2):
        store_curve("gg-cnn", trained, curves)
    assert {path.name: path.read_text() for path in curves.glob("*.jsonl")} == {
        "gg-cnn-part1.jsonl": "earlier",
        "gg-cnn.jsonl": "later",
    }
