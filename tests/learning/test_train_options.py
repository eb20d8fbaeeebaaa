"""Settings of a training, their options, and the command on the card: three views of one definition."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from safetensors import safe_open
from safetensors.torch import save_file
from test_training import FAST, folder  # noqa: F401 (eight synthetic scenes)

from grasp_bench.cli.train import read_settings, train_command, with_recipe
from grasp_bench.errors import AssetError
from grasp_bench.learning.data.scenes import SceneSet, load_scenes
from grasp_bench.learning.data.stages.style import Style
from grasp_bench.learning.training.card import (
    finishing_command,
    made,
    model_card,
    provenance,
    training_command,
)
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.learning.training.course import Course
from grasp_bench.learning.training.loop import CHECKPOINT, Trained, train
from grasp_bench.learning.training.sources import Source
from grasp_bench.learning.training.validate import Accuracy
from grasp_bench.networks.registry import build
from grasp_bench.networks.store import WeightsFile
from grasp_bench.networks.weights import save
from grasp_bench.system.paths import assets_dir, rivals_dirs

PAPER = "--steps 20000 --batch 32 --lr 1e-4 --warmup 0 --constant-lr --clip 0 --unmasked"
WEIGHTS = "first weights.safetensors"
SHIPPED = sorted(f for d in (assets_dir() / "weights", *rivals_dirs()) for f in d.glob("*.safetensors"))

positive = st.floats(1e-9, 1e3)
counts = st.integers(1, 10**6)
VALUES: dict[str, st.SearchStrategy[Any]] = {
    "network": st.sampled_from(["htc-grasp", "gr-convnet-16"]),
    "steps": counts,
    "until_flat": st.booleans(),
    "patience": counts,
    "max_minutes": st.none() | positive,
    "held_out": st.none() | st.integers(0, 10**6),
    "batch": counts,
    "lr": positive,
    "seed": st.integers(0, 2**40),
    "warmup": st.integers(0, 999),
    "cosine": st.booleans(),
    "weight_decay": st.floats(0, 1),
    "clip": st.floats(0, 100),
    "masked": st.booleans(),
    "geometry_weight": positive,
    "positive_weight": st.floats(0, 9),
    "width_weight": positive,
    "width_expectile": st.floats(0.01, 0.99),
    "ema": st.floats(0, 1, exclude_max=True),
    "augment": st.booleans(),
    "zoom": st.floats(1.1, 4),
    "precision": st.sampled_from(["auto", "fp32", "bf16"]),
    "device": st.sampled_from(["auto", "cpu", "cuda"]),
    "workers": counts,
    "threads": st.integers(0, 99),
    "checkpoint_every": counts,
    "validate_every": counts,
    "validate_scenes": st.integers(0, 10**6),
    "log_every": counts,
    "init": st.sampled_from([None, WEIGHTS]),
    "input": st.sampled_from([None, "rgbd"]),
    "holdout": st.sampled_from([None, "2/5"]),
    "split": st.sampled_from(["image", "object"]),
}


def made_of(words: list[str]) -> Any:
    """What the command line is read as."""
    app = typer.Typer()
    app.command()(train_command)
    return typer.main.get_command(app).make_context("train", list(words))


def parse(words: list[str]) -> dict[str, Any]:
    """What the command is called with."""
    return made_of(words).params


def read(command: str) -> tuple[TrainConfig, dict[str, Any]]:
    """Settings by a command, and what else it says."""
    program, name, *words = shlex.split(command)
    assert (program, name) == ("grasp-bench", "train")
    made = made_of(words)
    typed = dict(made.params)
    rest = {k: typed.pop(k) for k in ("data", "out", "export")}
    return read_settings(with_recipe(typed.pop("recipe"), typed, made))[0], rest


@pytest.fixture
def begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """How settings name the weights in the working folder."""
    monkeypatch.chdir(tmp_path)
    Path(WEIGHTS).write_bytes(b"any bytes")
    return WeightsFile(Path(WEIGHTS)).described()


def test_every_setting_is_tried_below() -> None:
    assert list(VALUES) == list(TrainConfig.model_fields)
    assert set(parse(["--data", "d", "--out", "o"])) == {"data", "out", "recipe", "export"} | set(VALUES)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(chosen=st.fixed_dictionaries({}, optional=VALUES))
def test_the_command_on_the_card_makes_the_same_settings(chosen: dict[str, Any], begun: str) -> None:
    config = TrainConfig.model_validate(chosen | ({"init": begun} if chosen.get("init") else {}))
    data = [Source(Path("far/my scenes"), 0.123456789012345), Source(Path("cornell"), 2.0)]
    command = training_command(config, data)
    found, rest = read(command)
    assert found == config
    assert rest["data"] == [Path("my scenes:0.123456789012345"), Path("cornell:2")]
    assert rest["out"] == Path("runs") / config.network
    usual = TrainConfig(network=config.network)
    same = [n for n in VALUES if n != "network" and getattr(config, n) == getattr(usual, n)]
    for option in (o for n in same for o in TrainConfig.option(n).names.split("/")):
        assert option not in shlex.split(command), "as by default"


@pytest.mark.parametrize("name", [n for n in VALUES if n != "network"])
def test_each_setting_is_reached_alone(name: str, begun: str) -> None:
    others: dict[str, Any] = {
        "until_flat": True,
        "cosine": False,
        "masked": False,
        "augment": False,
        "precision": "fp32",
        "device": "cpu",
        "init": begun,
        "width_expectile": 0.8,
    }
    others |= {"input": "rgbd", "holdout": "1/3", "split": "image", "ema": 0.5, "zoom": 2.0}
    config = TrainConfig.model_validate({name: others.get(name, 7)})
    command = training_command(config, [Source(Path("synth"))])
    assert command.startswith("grasp-bench train --predictor htc-grasp --data synth --")
    assert read(command)[0] == config != TrainConfig()


def test_the_papers_recipe_can_be_typed() -> None:
    config, _ = read(f"grasp-bench train --data synth --out run {PAPER}")
    assert config == TrainConfig(
        steps=20_000, batch=32, lr=1e-4, warmup=0, cosine=False, clip=0, masked=False
    )
    assert PAPER in (TrainConfig.__doc__ or "")
    by_name, _ = read("grasp-bench train --data synth --out run --recipe paper")
    assert by_name == config.model_copy(update={"validate_every": 200})
    mine, _ = read("grasp-bench train --data synth --out run --recipe paper --batch 16 --masked --steps 300")
    assert (mine.batch, mine.masked, mine.steps, mine.lr) == (16, True, 300, 1e-4), "what is typed counts"
    assert {config.learning_rate(step) for step in (0, 1, 19_999)} == {1e-4}
    command = training_command(config, [Source(Path("synth"))])
    assert command == (
        "grasp-bench train --predictor htc-grasp --data synth --steps 20000 --batch 32 --lr 0.0001 "
        "--warmup 0 --constant-lr --clip 0.0 --unmasked --out runs/htc-grasp"
    )


def test_card_shows_command_and_settings(begun: str, folder: Path) -> None:  # noqa: F811
    config = TrainConfig(network="gg-cnn", masked=False, holdout="2/5", split="image", init=begun)
    scenes = SceneSet([], [], "0123")
    facts = provenance(
        Trained(build("gg-cnn"), Accuracy(), Course(config)), config, scenes, [Source(folder, 1.5)]
    )
    commands = facts["commands"].splitlines()
    assert commands[1] == f"# {WEIGHTS}: the weights whose SHA-256 begins with {begun.split()[-1]}"
    assert read(commands[-1])[0] == config
    page = model_card(facts)
    assert facts["commands"] in page
    assert "lr 0.001" in page
    assert "masked False" in page
    assert "holdout 2/5" in page
    assert "workers" not in page
    assert "cut off" not in page
    assert "held-out synthetic scenes" in page
    real = model_card(facts | {"data": facts["data"] | {"real": ["cornell"]}})
    assert "held-out scenes and images" in real
    assert "held-out synthetic" not in real
    cut = facts | {
        "ended": "minutes",
        "seconds": 840,
        "commands": training_command(
            config.model_copy(update={"max_minutes": 14.0, "threads": 1}), [Source(folder)]
        ),
    }
    page = model_card(cut | {"device": "one GPU", "data": facts["data"] | {"stored": "depth in mm"}})
    assert "It took 14 minutes on one GPU, when it was cut off by the clock" in page
    assert "depth in mm" in page
    late = model_card(cut | {"seconds": 1271, "config": facts["config"] | {"max_minutes": 14.0}})
    assert "cut off by the clock (14 minutes, and the validations while the learning rate fell)." in late
    finish = finishing_command(cut["commands"])
    assert finish in page
    assert read(finish)[0] == config.model_copy(update={"until_flat": True, "device": "cuda"})
    older = {k: v for k, v in facts["config"].items() if k not in ("holdout", "split")}
    assert "holdout" not in model_card(facts | {"config": older, "commands": ""})


@pytest.mark.parametrize("file", SHIPPED, ids=lambda f: f.stem)
def test_cards_of_shipped_weights_say_what_their_metadata_say(file: Path) -> None:
    card = file.with_suffix(".md").read_text(encoding="utf-8").splitlines()
    page = model_card(WeightsFile(file).metadata(), file.stem).splitlines()
    assert [line for line in page if line not in card] == []
    assert card[0] == f"# {file.stem}"


def test_card_lists_openings_in_order_and_says_where_quality_tells_nothing() -> None:
    metadata = WeightsFile(assets_dir() / "weights" / "lenz-sae.safetensors").metadata()
    (told,) = [line for line in model_card(metadata).splitlines() if line.startswith("Calibrated")]
    assert [int(px) for px in re.findall(r"at (\d+) px", told)] == [0, 3, 6, 9, 12, 16, 20]
    assert told.endswith("; its quality does not tell whether a grasp holds (200 grasps).")


def test_shipped_weights_are_named_by_their_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("grasp_bench.networks.store.assets_dir", lambda: tmp_path)
    save(build("gg-cnn"), tmp_path / "weights" / "gg-cnn.safetensors", {"network": "gg-cnn"})
    config, begin = read_settings({"network": "gg-cnn", "init": "shipped"})
    assert begin == tmp_path / "weights" / "gg-cnn.safetensors"
    assert config.init == WeightsFile(tmp_path / "weights" / "gg-cnn.safetensors").described()
    with pytest.raises(AssetError, match=r"none\.safetensors"):
        read_settings({"init": "none.safetensors"})


def test_checkpoints_from_before_a_setting_was_one_go_on(folder: Path, tmp_path: Path) -> None:  # noqa: F811
    """What is held out was an argument of the command once, and no setting of the run."""
    scenes = load_scenes([folder])
    config = TrainConfig(**FAST, steps=1, batch=1)
    train(config, scenes, tmp_path)
    path = tmp_path / CHECKPOINT
    with safe_open(path, framework="pt") as file:
        header = json.loads(file.metadata()["training"])
        tensors = {key: file.get_tensor(key) for key in file.keys()}  # noqa: SIM118
    for name in ("holdout", "split"):
        del header["config"][name]
    save_file(tensors, path, {"training": json.dumps(header)})
    steps: list[int] = []
    held_out = config.model_copy(update={"holdout": "2/5", "split": "image"})
    train(held_out, scenes, tmp_path, lambda done, *_: steps.append(done))
    assert steps == [], "nothing was left to do"
    other = SceneSet(scenes.train, scenes.val, "of another fold")
    with pytest.raises(AssetError, match="the scenes were others"):
        train(held_out, other, tmp_path)


def test_the_command_that_made_the_data_names_its_style(tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "index.jsonl").write_text("{}\n" * 3)
    camera_like = Style().model_dump(mode="json")
    for style, words in (
        (None, "grasp-bench data synth --scenes 3 --seed 19 --tries 20 --out mine"),
        (
            camera_like,
            "grasp-bench data synth --style camera-like --scenes 3 --seed 19 --tries 20 --out mine",
        ),
        (
            camera_like | {"colour": {}},
            "# mine.yaml: the style in mine/config.json\n"
            "grasp-bench data synth --style mine.yaml --scenes 3 --seed 19 --tries 20 --out mine",
        ),
    ):
        config = {"tries": 20} | ({} if style is None else {"style": style})
        (mine / "config.json").write_text(json.dumps({"seed": 19, "config": config}))
        assert made(Source(mine)) == words
