"""Where weights come from: as metadata inside them, and as a page to read beside them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from grasp_bench.learning.data.opening import open_collection
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.learning.training.dataset import SceneSet
from grasp_bench.learning.training.loop import Trained
from grasp_bench.learning.training.sources import Source
from grasp_bench.networks import info, input_kind, parameter_count
from grasp_bench.runs.statistics import wilson


def provenance(
    trained: Trained, config: TrainConfig, scenes: SceneSet, data: Sequence[Source]
) -> dict[str, Any]:
    """JSON-able facts on a run."""
    accuracy = trained.accuracy
    return {
        "network": config.network,
        "reference": info(config.network).reference,
        "parameters": parameter_count(trained.network),
        "input": f"{input_kind(config.network, config.input)} {info(config.network).crop}",
        "begun_with": config.init,
        "steps": config.steps,
        "seed": config.seed,
        "config": config.model_dump(),
        "data": {
            "folders": [s.folder.name for s in data],
            "real": [s.folder.name for s in data if is_real(s)],
            "fingerprint": scenes.fingerprint,
            "train": len(scenes.train),
            "val": len(scenes.val),
        },
        "commands": "\n".join([*(_made(s) for s in data), _trained(config, data)]),
        "accuracy": {
            "top1": [accuracy.hits, accuracy.scenes],
            "rectangle": [accuracy.correct, accuracy.labelled],
        },
    }


def is_real(source: Source) -> bool:
    """Whether a folder is a copy of Cornell or Jacquard, and not of generated scenes."""
    return not (source.folder / "index.jsonl").is_file()


def _made(source: Source) -> str:
    """The command that makes a data set, as far as the folder tells."""
    folder = source.folder
    if is_real(source):
        return f"# {folder.name}: a copy of {open_collection(folder).describe().split(' in ')[0]}"
    try:
        made = json.loads((folder / "config.json").read_text())
        scenes = len((folder / "index.jsonl").read_text().splitlines())
        return (
            f"grasp-bench data synth --scenes {scenes} --seed {made['seed']} "
            f"--tries {made['config']['tries']} --out {folder.name}"
        )
    except (OSError, ValueError, KeyError):
        return f"# {folder.name}: not made by `grasp-bench data synth`"


def _trained(config: TrainConfig, data: Sequence[Source]) -> str:
    """The command of the training, without what is as by default."""
    usual = TrainConfig(network=config.network).model_dump()
    options = [
        f"--{k.replace('_', '-')} {v}"
        for k, v in config.model_dump().items()
        if v != usual[k]
        and k
        in (
            "steps",
            "batch",
            "lr",
            "seed",
            "warmup",
            "geometry_weight",
            "positive_weight",
            "ema",
            "precision",
            "input",
        )
    ]
    folders = " ".join(f"--data {s.folder.name}" + (f":{s.weight:g}" if s.weight else "") for s in data)
    return (
        f"grasp-bench train --predictor {config.network} {folders} {' '.join(options)} "
        f"--out runs/{config.network}"
    )


def model_card(facts: dict[str, Any]) -> str:
    """Markdown page on weights, made of their metadata."""
    config, data = facts["config"], facts["data"]
    settings = ", ".join(
        f"{k} {config[k]}"
        for k in (
            "batch",
            "lr",
            "warmup",
            "cosine",
            "masked",
            "geometry_weight",
            "positive_weight",
            "ema",
            "augment",
        )
    )
    return f"""# {facts["network"]}

Weights for `grasp-bench`, network `{facts["network"]}` with {facts["parameters"]:,} parameters, input
{facts["input"]} px. Architecture after: {facts["reference"]}.

## Training
{_begun(facts)}: {data["train"]} scenes of {", ".join(data["folders"])}
(fingerprint `{data["fingerprint"]}`), {facts["steps"]} steps, seed {facts["seed"]}; {settings}.{_took(facts)}

```
{facts["commands"]}
```

## Accuracy on {data["val"]} held-out synthetic scenes
| measure | right | of | 95 % interval |
|---|---|---|---|
| best grasp agrees with the label maps (quality ≥ 0.5, 20°, width) | {_row(facts["accuracy"]["top1"])} |
| rectangle metric (30°, IoU > 0.25) | {_row(facts["accuracy"]["rectangle"])} |

## Limits
{_seen(facts)} Expects a camera looking down at a table, depth in metres, and a scene like
those it was trained on; figures above say nothing about other cameras. These are not the paper's
weights, which were never published.
"""


def _took(facts: dict[str, Any]) -> str:
    seconds = facts.get("seconds")
    return f" It took {seconds / 60:.0f} minutes." if seconds else ""


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
