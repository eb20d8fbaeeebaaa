"""Makes the shipped weights again: `python scripts/train_all.py PART [NETWORK …]`, where PART is

- `data`: scenes as cameras see them and plain ones, the same for every network.
- `train`: a training of each network until held-out tries in physics get no better, or `--minutes` are over.
- `ship`: calibrate what was trained, and copy weights, card and curve to where shipped ones are.

Without networks, all are meant that have a recipe here. Every part goes on where it was stopped. On a GPU let
several train side by side, each with a share of the cores: small networks wait for their batches there.
Trainings of less time or data than the recipes' are made by the same command; their cards say so.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from grasp_bench.errors import UnknownNameError
from grasp_bench.learning.training.kept import ship
from grasp_bench.networks.store import WeightsFile
from grasp_bench.system.machine import usable_cores

ROOT = Path(__file__).resolve().parents[1]
CURVES = ROOT / "results" / "training"
LOG, FACTS = "log.jsonl", "training.json"

COMMON = "--until-flat --steps 1000000 --zoom 2.0 --validate-scenes 60 --log-every 25"
"""What all trainings have in common; the augmentation zooms as far as the lineage's protocol does."""
_TRIED = "--ema 0.998 --held-out 60 --validate-every 500"
MAPS = f"{_TRIED} --batch 16"
REGRESSION = f"{_TRIED} --batch 32 --lr 0.0003"
DETECTOR = f"{_TRIED} --batch 8 --lr 0.0005"
TRUNK = "trunk-resnet50"
_BEGUN = f"--init {TRUNK}/{TRUNK}.safetensors"
RECIPES: dict[str, str] = {
    TRUNK: f"{MAPS} --input rgd",
    **dict.fromkeys(("htc-grasp", "htc-grasp-no-ea", "htc-grasp-no-ca", "htc-grasp-plain"), MAPS),
    **dict.fromkeys(("htc-grasp-mea4", "gg-cnn", "gg-cnn2", "gr-convnet", "gr-convnet-16"), MAPS),
    **dict.fromkeys(("tf-grasp", "se-resunet", "skgnet"), MAPS),
    "asif-graspnet": f"{MAPS} --lr 0.0005",
    "lenz-sae": "--held-out 60 --validate-every 1000",
    **dict.fromkeys(("redmon-multigrasp", "redmon-direct"), REGRESSION),
    **dict.fromkeys(("kumra-resnet50x2", "kumra-resnet50"), f"{REGRESSION} {_BEGUN}"),
    "chu-resnet50": f"{MAPS} --lr 0.0003 {_BEGUN}",
    **dict.fromkeys(("fcgn", "roi-gd"), f"{DETECTOR} {_BEGUN}"),
    **dict.fromkeys(("laili-pairs", "laili-pairs-10", "wu-anchor-free"), DETECTOR),
    # Its search takes a second or more a picture.
    "gq-cnn": "--ema 0.998 --held-out 30 --validate-every 2000 --batch 8 --lr 0.0003",
}
"""Options of each network's training beside :data:`COMMON`."""


def main() -> None:
    text = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=text)
    parser.add_argument("part", choices=("data", "train", "ship"))
    parser.add_argument("networks", nargs="*", metavar="NETWORK")
    parser.add_argument("--folder", type=Path, default=ROOT / "runs", help="of data and trainings")
    parser.add_argument("--cameras", type=int, default=8500, help="scenes as cameras see them")
    parser.add_argument("--plain", type=int, default=1500, help="plain scenes")
    parser.add_argument("--minutes", type=float, default=90.0, help="of each training at most")
    parser.add_argument("--at-once", type=int, default=1, help="trainings side by side")
    asked = parser.parse_args()
    chosen = asked.networks or list(RECIPES)
    for name in chosen:
        if name not in RECIPES:
            raise SystemExit(str(UnknownNameError("network", name, RECIPES)))
    asked.folder.mkdir(parents=True, exist_ok=True)
    if asked.part == "data":
        for words in data_commands(asked.cameras, asked.plain):
            run(words, asked.folder)
    elif asked.part == "train":
        train(chosen, asked.folder, asked.minutes, asked.at_once)
    else:
        for name in chosen:
            if name != TRUNK:  # it only begins others
                finish(name, asked.folder)


def data_commands(cameras: int, plain: int) -> list[list[str]]:
    """Return the commands that make both sets of scenes."""
    made = ["data", "synth", "--workers", str(usable_cores()), "--scenes"]
    return [
        [*made, str(cameras), "--style", "camera-like", "--seed", "19", "--out", "camera-like"],
        [*made, str(plain), "--seed", "1", "--out", "plain"],
    ]


def training_words(name: str, minutes: float, threads: int) -> list[str]:
    """Return the command that trains a network, in the folder of :func:`data_commands`."""
    data = ["--data", "camera-like:0.6", "--data", "plain:0.4"]
    limits = ["--max-minutes", f"{minutes:g}", "--threads", str(threads)]
    options = f"{COMMON} {RECIPES[name]}".split()
    return ["train", "--predictor", name, *data, *options, *limits, "--out", name]


def train(names: Sequence[str], folder: Path, minutes: float, at_once: int) -> None:
    """Train networks, the trunk before those that begin with it."""
    threads = max(1, usable_cores() // at_once)
    if TRUNK in names:
        run(training_words(TRUNK, minutes, threads), folder)
    rest = [training_words(name, minutes, threads) for name in names if name != TRUNK]
    with ThreadPoolExecutor(at_once) as pool:
        for _ in pool.map(lambda words: run(words, folder), rest):
            pass


def run(words: Sequence[str], folder: Path) -> None:
    """Carry out a ``grasp-bench`` command in a folder; SystemExit where it fails."""
    print("grasp-bench", *words, flush=True)
    ended = subprocess.run([sys.executable, "-m", "grasp_bench.cli", *words], cwd=folder, check=False)
    if ended.returncode:
        raise SystemExit(
            f"`grasp-bench {' '.join(words)}` failed ({ended.returncode}); the same call goes on."
        )


def finish(name: str, folder: Path, curves: Path = CURVES) -> None:
    """Calibrate a trained network, and ship it with its learning curve."""
    made = WeightsFile(folder / name / f"{name}.safetensors", name)
    made.require()
    run(["calibrate", name, "--weights", str(made.path.resolve())], folder)
    print(ship(made).path)
    store_curve(name, folder / name, curves)


def store_curve(name: str, trained: Path, curves: Path) -> None:
    """Copy a training's curve to those of what is shipped, and keep another from whose weights it went on."""
    made, before = trained / FACTS, curves / f"{name}.json"
    begun = json.loads(made.read_text(encoding="utf-8"))["begun_with"] or ""
    again = before.is_file() and before.read_bytes() == made.read_bytes()
    if begun.startswith(f"{name}.safetensors") and not again:
        keep_part(name, curves)
    shutil.copy(made, before)
    shutil.copy(trained / LOG, curves / f"{name}.jsonl")


def keep_part(name: str, curves: Path) -> None:
    """Name the curve of a network as a part of its training, since another goes on from its weights."""
    part = f"{name}-part{1 + len(list(curves.glob(f'{name}-part*.json')))}"
    for ending in (".json", ".jsonl"):
        if (curves / f"{name}{ending}").is_file():
            (curves / f"{name}{ending}").rename(curves / f"{part}{ending}")


if __name__ == "__main__":
    main()
