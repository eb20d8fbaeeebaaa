"""Draw and list what all networks were trained with, of ``results/training/*.json``, for the documentation.

``python scripts/make_curves.py``: each file is the ``training.json`` that ``grasp-bench train`` leaves in its
folder, named after what is shipped; ``NAME-part1`` is the first part of a training that NAME ended. Writes
``docs/images/learning-{pflop,minutes,steps}.svg``, and a table with steps, hours, seed, data and what ended
each into docs/train.md.
"""

import dataclasses
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from make_tables import replace

from grasp_bench.learning.training.card import finishing_command
from grasp_bench.report.tables import TextTable, markdown
from grasp_bench.studies.curve_chart import Cost, Curve, as_svg

ROOT = Path(__file__).parents[1]
PART = re.compile(r"(.+)-part(\d+)")
"""Name of the file of a training from whose weights another of the same network went on."""
CONTINUED = ", part "
"""Between a network and the number of such a training, where it is listed."""
ENDED = {"flat": "flat", "minutes": "cut off by the clock", "steps": "steps given"}
HEAD = ("Network", "Seed", "Steps × batch", "Hours", "PFLOP", "Scenes", "Ended", "Held at the end")


def main(root: Path = ROOT) -> None:
    files = sorted((root / "results" / "training").glob("*.json"))
    if not files:
        raise SystemExit(f"{root / 'results' / 'training'} holds no training.json of a network.")
    trainings = {named(path): json.loads(path.read_text(encoding="utf-8")) for path in files}
    curves = [dataclasses.replace(Curve.read(path), name=named(path)) for path in files]
    pictures = []
    for cost in get_args(Cost):
        path = root / "docs" / "images" / f"learning-{cost.lower()}.svg"
        path.write_text(as_svg(curves, cost), encoding="utf-8")
        pictures.append(f"![Held-out grasps that hold against {cost} of training](images/{path.name})")
        print(path)
    replace(root / "docs" / "train.md", "trainings", "\n\n".join([listed(trainings), *pictures]))


def named(path: Path) -> str:
    """Name a training as its file is named, since a network may have had several."""
    part = PART.fullmatch(path.stem)
    return part[1] + CONTINUED + part[2] if part else path.stem


def listed(trainings: Mapping[str, dict[str, Any]]) -> str:
    """A row for each training, best first, and below the commands that finish those cut off by the clock.

    Args:
        trainings: what each ``training.json`` holds, by the training's name.
    """

    def held(training: tuple[str, dict[str, Any]]) -> float:
        good, tried = training[1]["accuracy"]["held"]
        return good / tried if tried else 0.0

    rows, unfinished = [], []
    for name, facts in sorted(trainings.items(), key=held, reverse=True):
        data, (good, tried) = facts["data"], facts["accuracy"]["held"]
        begun = f", begun with {facts['begun_with'].split()[0]}" if facts["begun_with"] else ""
        rows.append(
            [
                name,
                str(facts["seed"]),
                f"{facts['steps']:,} × {facts['config']['batch']}",
                f"{facts['seconds'] / 3600:.2f}",
                f"{facts['flops'] / 1e15:.2f}",
                f"{data['train']:,} of {', '.join(data['folders'])}{begun}",
                ENDED[facts["ended"]],
                f"{good}/{tried}" if tried else "",
            ]
        )
        # a part has gone on since, from where it was cut off
        if facts["ended"] == "minutes" and CONTINUED not in name:
            unfinished.append(finishing_command(facts["commands"].splitlines()[-1]))
    text = markdown([TextTable("", HEAD, rows, numbers=(1, 2, 3, 4, 7))]).strip()
    if unfinished:
        commands = "\n".join(unfinished)
        text += f"\n\nTo the end of those that the clock cut off, on a GPU:\n\n```\n{commands}\n```"
    return text


if __name__ == "__main__":
    main()
