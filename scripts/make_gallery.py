"""Makes the clips of docs/gallery-of-trials.md from the reference runs: ``make_gallery.py [NAME …]``."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from grasp_bench.system.graphics import without_gl
from grasp_bench.system.machine import THREADS

for name in THREADS:  # as in the runs' workers
    os.environ.setdefault(name, "1")
without_gl()  # before anything imports MuJoCo

from grasp_bench.replay.rebuild import rebuild  # noqa: E402
from grasp_bench.replay.video import write_film  # noqa: E402

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images" / "gallery"
TRIALS = {
    "success": ("htc-grasp", 37),
    "approach_collision": ("gr-convnet", 12),
    "missed": ("htc-grasp", 171),
    "slipped": ("gg-cnn", 135),
    "dropped": ("htc-grasp", 57),
    "displaced": ("displaced", 37),
}
SIZE = (336, 252)


def main(names: list[str]) -> None:
    IMAGES.mkdir(parents=True, exist_ok=True)
    for name in names:
        run, trial = TRIALS[name]
        replay = rebuild(ROOT / "results" / "reference" / run, trial)
        if replay.record.outcome != replay.stored.outcome:
            raise SystemExit(f"{name}: trial {trial} of {run} no longer ends as recorded: {replay.differs}")
        write_film(replay, IMAGES / f"{name}.webp", SIZE)
        size = (IMAGES / f"{name}.webp").stat().st_size
        print(name, replay.record.object, replay.record.outcome, size)


if __name__ == "__main__":
    main(sys.argv[1:] or list(TRIALS))
