"""Run folders of a few made-up trials, with small pictures, for the tests of the HTML report."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from grasp_bench.scenario.reading import load_scenario

HOSTILE = "<script>alert(1)</script>"
CLOSING = "</script><img src=x onerror=alert(2)>"
OBJECTS = ("apple", "coffee_mug", HOSTILE, 'pliers\' "best" & co')
OUTCOMES = ("success", "missed", "success", "slipped", "success", "no_grasp")


def record(number: int, outcome: str, **changes: Any) -> dict[str, Any]:
    """A line of ``trials.jsonl``."""
    made: dict[str, Any] = {
        "trial": number,
        "object": OBJECTS[number % len(OBJECTS)],
        "category": "things",
        "seed": 0,
        "outcome": outcome,
        "success": outcome == "success",
        "detail": "" if outcome == "success" else f"because {CLOSING}",
        "grasp": {
            "x": 300.5,
            "y": 240.5,
            "angle": 0.5,
            "width": 40.0,
            "quality": round(0.1 + number % 9 / 10, 2),
        },
        "pose": {"position": [0.5, 0.0, 0.01], "rotation": np.eye(3).tolist(), "opening": 0.05},
        "rank": 0,
        "tcp_error": {"position": 0.0002, "angle": 0.001},
        "lift_height": 0.2 if outcome == "success" else 0.0,
        "contact_force": 60.0,
        "sim_steps": 3000,
    }
    if outcome == "no_grasp":
        made |= dict.fromkeys(("grasp", "pose", "rank", "tcp_error"))
    return made | changes


def write_run(
    folder: Path, predictor: str, outcomes: list[str], pictures: bool = False, **changes: Any
) -> Path:
    """A run folder with a trial for each outcome."""
    folder.mkdir(parents=True)
    run = {
        "format": 1,
        "predictor": predictor,
        "scenario": load_scenario("table4").model_dump(mode="json"),
        "seed": 0,
        "trials": len(outcomes),
        "objects": {},
        "weights": None,
        "versions": {},
        "renderer": "raycast",
    } | changes
    (folder / "run.json").write_text(json.dumps(run))
    (folder / "trials.jsonl").write_text(
        "".join(json.dumps(record(i, o)) + "\n" for i, o in enumerate(outcomes))
    )
    timings = [{"trial": i, "predict": 0.05 + 0.01 * i, "execute": 0.5} for i in range(len(outcomes))]
    (folder / "timings.jsonl").write_text("".join(json.dumps(t) + "\n" for t in timings))
    if pictures:
        (folder / "media").mkdir()
        for i in range(len(outcomes)):
            image = Image.new("RGB", (64, 64), (20 * i % 255, 90, 160))
            image.save(folder / "media" / f"{i:05}.webp")
            image.save(
                folder / "media" / f"{i:05}-clip.webp",
                save_all=True,
                duration=100,
                append_images=[Image.new("RGB", (64, 64), "red")],
            )
    return folder


def episode(number: int, outcomes: list[str]) -> dict[str, Any]:
    """A line of ``trials.jsonl`` of clutter, an attempt for each outcome; its lead has a hostile name."""
    objects = [HOSTILE, *(f"thing {i}" for i in range(1, len(outcomes)))]
    attempts = [
        {
            "attempt": i,
            **{k: v for k, v in record(number, o, object=objects[i]).items() if k not in ("trial", "seed")},
            "removed": [objects[i]] * (o == "success"),
        }
        for i, o in enumerate(outcomes)
    ]
    cleared = outcomes.count("success")
    ended = "success" if cleared == len(outcomes) else [o for o in outcomes if o != "success"][-1]
    return record(
        number,
        ended,
        object=HOSTILE,
        grasp=None,
        pose=None,
        rank=None,
        tcp_error=None,
        clutter={"objects": objects, "cleared": cleared, "attempts": attempts},
    )


def write_clutter(folder: Path, episodes: list[list[str]]) -> Path:
    """A run folder of episodes with a picture of each attempt, and a clip of those that failed."""
    write_run(
        folder, "oracle", [], scenario=load_scenario("clutter").model_dump(mode="json"), trials=len(episodes)
    )
    (folder / "trials.jsonl").write_text(
        "".join(json.dumps(episode(i, e)) + "\n" for i, e in enumerate(episodes))
    )
    (folder / "media").mkdir()
    for i, outcomes in enumerate(episodes):
        for k, outcome in enumerate(outcomes):
            image = Image.new("RGB", (64 + 8 * k, 64), (20 * i % 255, 90, 160))
            image.save(folder / "media" / f"{i:05}-{k:02}.webp")
            if outcome != "success":
                image.save(folder / "media" / f"{i:05}-{k:02}-clip.webp")
    return folder


def two_runs(root: Path, trials: int = 12) -> Path:
    """A folder of two runs on the same trials, one with a hostile name and pictures."""
    first = [OUTCOMES[i % len(OUTCOMES)] for i in range(trials)]
    write_run(root / "plain", "oracle", ["success" if o == "missed" else o for o in first])
    write_run(root / "it's <b>bold<", f"mod:{HOSTILE}", first, pictures=True)
    return root
