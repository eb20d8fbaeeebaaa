"""Does `grasp-bench why` name a fault that was planted? A calibration error, a turned angle, narrow jaws.

    python benchmarks/why_proof.py [--predictor htc-grasp] [--objects 180] [--seed 0]

A predictor's trials are done as predicted, and again with a fault planted. Of the failures that the fault
adds (the trial succeeds without it), the share is printed whose first cause is the fault; docs/why.md has the
figures. Takes some minutes; nothing is left on the disk.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from grasp_bench import api
from grasp_bench.camera import RgbdImage
from grasp_bench.grasps import Grasp, wrap_angle
from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors import load_predictor
from grasp_bench.predictors.protocol import Predictor, begin
from grasp_bench.runs.folder import load_records
from grasp_bench.runs.statistics import Rate
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.studies.why.explain import explain

FAULTS: dict[str, dict[str, Any]] = {
    "calibration": {"calibration_mm": 10.0},
    "angle": {"turn": math.radians(30)},
    "width": {"narrow": 0.6},
}
"""What is planted, by the cause that should be named."""


class Faulty:
    """A predictor with a fault of its own: all angles turned, or all widths too small."""

    def __init__(self, inner: Predictor, turn: float = 0.0, narrow: float = 1.0) -> None:
        self._inner, self._turn, self._narrow = inner, turn, narrow

    def begin(self, rng: np.random.Generator) -> None:
        """Give the trial's random stream on."""
        begin(self._inner, rng)

    def predict(self, image: RgbdImage) -> list[Grasp]:
        """Return the predictor's grasps with the fault."""
        return [
            replace(g, angle=wrap_angle(g.angle + self._turn), width=self._narrow * g.width)
            for g in self._inner.predict(image)
            if isinstance(g, Grasp)
        ]


def main() -> None:
    """Plant every fault, and print how often it is named."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--predictor", default="htc-grasp")
    parser.add_argument("--objects", type=int, default=180, help="how many, spread evenly over the catalogue")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    scenario, names = load_scenario("as-predicted"), Catalog().names
    names = [names[i * len(names) // args.objects] for i in range(args.objects)]
    inner = load_predictor(args.predictor)
    with tempfile.TemporaryDirectory() as folder:
        sound = Path(folder) / "sound"
        _run(Faulty(inner), names, scenario, args.seed, sound)
        lifted = {r.trial for r in load_records(sound) if r.success}
        print(f"{args.predictor}, as predicted, {len(names)} objects: {len(lifted)} lifted")
        for cause, fault in FAULTS.items():
            planted = scenario
            error = fault.get("calibration_mm")
            if error:
                calibration = scenario.calibration.model_copy(update={"position_mm": error})
                planted = scenario.model_copy(update={"calibration": calibration})
            predictor = Faulty(inner, **{k: v for k, v in fault.items() if k != "calibration_mm"})
            out = Path(folder) / cause
            _run(predictor, names, planted, args.seed, out)
            start = time.perf_counter()
            study = explain(out, predictor=predictor)
            each = (time.perf_counter() - start) / max(len(study.explained), 1)
            added = [e for e in study.explained if e.trial in lifted]
            named = [e for e in added if study.first(e) == cause]
            rate = Rate(len(named), len(added))
            low, high = rate.interval
            others = sorted({study.first(e) for e in added} - {cause})
            print(
                f"{cause}: named first in {len(named)}/{len(added)} = {rate.rate:.1%} of the failures it "
                f"adds ({low:.1%} to {high:.1%}), of {study.failed} in all; {each:.2f} s a failure"
                + (f"; otherwise {', '.join(others)}" if others else "")
            )


def _run(predictor: Faulty, names: list[str], scenario: Any, seed: int, out: Path) -> None:
    api.run(names, len(names), predictor, scenario, seed=seed, out=out, progress=False)


if __name__ == "__main__":
    main()
