"""Where weights come from: as metadata inside them, and as a page to read beside them."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from typing import Any

import torch
from torch import nn

from grasp_bench.learning.data.opening import open_collection
from grasp_bench.learning.data.scenes import INDEX, SceneSet, is_generated
from grasp_bench.learning.data.stages.style import Style
from grasp_bench.learning.training.config import FREE_TO_CHANGE, TrainConfig
from grasp_bench.learning.training.loop import Trained, shown
from grasp_bench.learning.training.sources import Source
from grasp_bench.networks.calibration import KEY
from grasp_bench.networks.registry import info, parameter_count
from grasp_bench.runs.statistics import wilson
from grasp_bench.system.machine import cpu_name

TOLD_ELSEWHERE = FREE_TO_CHANGE | {"network", "input", "init", "steps", "seed"}
"""Settings that the card has in other places, or that change no weights."""
OVER = 1.2
"""How many times as long as its clock a training takes at least for the card to say why."""


def provenance(
    trained: Trained, config: TrainConfig, scenes: SceneSet, data: Sequence[Source]
) -> dict[str, Any]:
    """Return JSON-able facts on a run."""
    accuracy, course = trained.accuracy, trained.course
    return {
        "network": config.network,
        "reference": info(config.network).reference,
        "parameters": parameter_count(trained.network),
        "input": shown(config),
        "begun_with": config.init,
        "steps": course.end,
        "seconds": round(course.seconds),
        "device": _device(trained.network),
        "ended": course.why,
        "flops": course.flops * config.batch * course.end,
        "curve": [{"step": point.step} | point.figures for point in course.curve],
        "seed": config.seed,
        "config": config.model_dump(),
        "data": {
            "folders": [s.folder.name for s in data],
            "real": [s.folder.name for s in data if not is_generated(s.folder)],
            "fingerprint": scenes.fingerprint,
            "train": len(scenes.train),
            "val": len(scenes.val),
        },
        "commands": "\n".join([*map(made, data), *_begun_with(config), training_command(config, data)]),
        "accuracy": {
            "top1": [accuracy.hits, accuracy.scenes],
            "rectangle": [accuracy.correct, accuracy.labelled],
            "held": [accuracy.held, accuracy.tried],
        },
    }


def _device(network: nn.Module) -> str:
    """Return what a network is on: the name of the GPU, or of the processor."""
    device = next(network.parameters()).device
    return torch.cuda.get_device_name(device) if device.type == "cuda" else cpu_name()


def _begun_with(config: TrainConfig) -> list[str]:
    if config.init is None:
        return []
    name, _, digest = config.init.rpartition(" ")
    return [f"# {name}: the weights whose SHA-256 begins with {digest}"]


def made(source: Source) -> str:
    """Return the command that makes a data set, as far as the folder tells."""
    folder = source.folder
    if not is_generated(folder):
        return f"# {folder.name}: a copy of {open_collection(folder).describe().split(' in ')[0]}"
    try:
        told = json.loads((folder / "config.json").read_text())
        scenes = len((folder / INDEX).read_text().splitlines())
        style, own = told["config"].get("style"), ""
        if style is not None and style != Style().model_dump(mode="json"):
            own = f"# {folder.name}.yaml: the style in {folder.name}/config.json\n"
        named = "" if style is None else f"--style {f'{folder.name}.yaml' if own else 'camera-like'} "
        return (
            f"{own}grasp-bench data synth {named}--scenes {scenes} --seed {told['seed']} "
            f"--tries {told['config']['tries']} --out {folder.name}"
        )
    except (OSError, ValueError, KeyError):
        return f"# {folder.name}: not made by `grasp-bench data synth`"


def training_command(config: TrainConfig, data: Sequence[Source]) -> str:
    """Return the command that repeats a training; data and first weights are named as in their folders."""
    network, options = config.arguments()[:2], config.arguments()[2:]
    folders = [word for s in data for word in ("--data", s.folder.name + _share(s))]
    words = ["grasp-bench", "train", *network, *folders, *options, "--out", f"runs/{config.network}"]
    return shlex.join(words)


def _share(source: Source) -> str:
    return "" if source.weight is None else f":{source.weight!r}".removesuffix(".0")


def finishing_command(command: str) -> str:
    """Return the command that brings a training which the clock cut off to its end, on a GPU.

    Args:
        command: as :func:`training_command` gives it.
    """
    words = shlex.split(command)
    for option in ("--max-minutes", "--threads", "--device"):
        while option in words:
            at = words.index(option)
            del words[at : at + 2]
    flat = [] if "--until-flat" in words else ["--until-flat"]
    return shlex.join([*words, *flat, "--device", "cuda"])


def model_card(facts: dict[str, Any], name: str | None = None) -> str:
    """Return a Markdown page on weights, made of their metadata.

    Args:
        name: what the weights are shipped as, where that is not the network's name.
    """
    config, data = facts["config"], facts["data"]
    told = [k for k in TrainConfig.model_fields if k not in TOLD_ELSEWHERE and config.get(k) is not None]
    settings = ", ".join(f"{k} {config[k]}" for k in told)
    judged = min(config.get("validate_scenes") or data["val"], data["val"])
    held_out = "scenes and images" if data.get("real") else "synthetic scenes"
    return f"""# {name or facts["network"]}

Weights for `grasp-bench`, network `{facts["network"]}` with {facts["parameters"]:,} parameters, input
{facts["input"]} px. Architecture after: {facts["reference"]}.

## Training
{_begun(facts)}: {data["train"]} scenes of {", ".join(data["folders"])}{_kept(data)}
(fingerprint `{data["fingerprint"]}`), {facts["steps"]} steps, seed {facts["seed"]}; {settings}.{_took(facts)}

```
{facts["commands"]}{_calibration_command(facts)}
```

## Accuracy on {judged} held-out {held_out}
| measure | right | of | 95 % interval |
|---|---|---|---|
| best grasp agrees with the label maps (quality ≥ 0.5, 20°, width) | {_row(facts["accuracy"]["top1"])} |
| rectangle metric (30°, IoU > 0.25) | {_row(facts["accuracy"]["rectangle"])} |
{_held(facts)}{_calibrated(facts)}
## Limits
{_seen(facts)} Expects a camera looking down at a table, depth in metres, and a scene like
those it was trained on; figures above say nothing about other cameras. These are not the paper's
weights, which were never published.
"""


def _kept(data: dict[str, Any]) -> str:
    return f", {data['stored']}" if data.get("stored") else ""


def _took(facts: dict[str, Any]) -> str:
    seconds = facts.get("seconds")
    if not seconds:
        return ""
    why = {"flat": ", until it got no better", "minutes": ", when it was cut off by the clock"}
    device = f" on {facts['device']}" if facts.get("device") else ""
    told = f" It took {seconds / 60:.0f} minutes{device}{why.get(facts.get('ended', ''), '')}{_over(facts)}."
    if facts.get("ended") == "minutes":
        last = facts["commands"].splitlines()[-1]
        told += (
            f" To train it to its end on a GPU, give instead of the last line\n`{finishing_command(last)}`."
        )
    return told


def _over(facts: dict[str, Any]) -> str:
    """Say why a training took much longer than its clock, which allows for steps only as the rate falls."""
    most = facts["config"].get("max_minutes")
    if facts.get("ended") != "minutes" or not most or facts["seconds"] <= OVER * 60 * most:
        return ""
    return f" ({most:g} minutes, and the validations while the learning rate fell)"


def _held(facts: dict[str, Any]) -> str:
    held = facts["accuracy"].get("held", [0, 0])
    return f"| best grasp, as predicted, held in physics (other scenes) | {_row(held)} |\n" if held[1] else ""


def _calibrated(facts: dict[str, Any]) -> str:
    found = facts.get(KEY)
    if not found:
        return ""
    # metadata are stored in the order of their names, 12 before 3
    tried = ", ".join(f"{k} at {px} px" for px, k in sorted(found["held"].items(), key=_pixels))
    widening = found["widening_px"]
    fit = found["quality"]
    told = f"its quality does not tell whether a grasp holds ({found['grasps']} grasps)"
    if fit:
        law = f"expit({fit[0]} + {fit[1]} · quality)"
        told = f"a grasp holds with probability {law}, fitted to {found['grasps']} grasps"
    return (
        f"\nCalibrated in physics on {found['scenes']} other scenes: openings are {widening:g} px "
        f"wider than the network's own (best grasps that held: {tried}); "
        f"{told}.\n"
    )


def _pixels(held: tuple[str, int]) -> float:
    return float(held[0])


def _calibration_command(facts: dict[str, Any]) -> str:
    if KEY not in facts:
        return ""
    name, scenes = facts["network"], facts[KEY]["scenes"]
    return f"\ngrasp-bench calibrate {name} --weights runs/{name}/{name}.safetensors --scenes {scenes}"


def _begun(facts: dict[str, Any]) -> str:
    begun = facts.get("begun_with")
    start = f"Begun with {begun} and trained on" if begun else "Trained from scratch on"
    return f"{start} {'real images too' if facts['data'].get('real') else 'synthetic scenes only'}"


def _seen(facts: dict[str, Any]) -> str:
    real = facts["data"].get("real")
    return f"Real images seen: those of {', '.join(real)}." if real else "Never saw a real image."


def _row(count: list[int]) -> str:
    right, total = count
    if not total:
        return f"{right} | {total} | –"
    low, high = wilson(right, total)
    return f"{right} | {total} | {low:.1%} – {high:.1%}"
