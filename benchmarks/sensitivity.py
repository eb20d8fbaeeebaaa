"""How far the success rate depends on what nobody knows exactly: ``python benchmarks/sensitivity.py``.

Sweeps friction, grip force, depth noise, calibration error, time step and number of convex pieces for
HTC-Grasp and the oracle, on every third object once. Writes figures to docs/images, numbers to
docs/sensitivity.csv and tables between the markers of docs/physics.md. Takes about 25 core-minutes;
resumes in ``sweeps/sensitivity`` when killed.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from grasp_bench.objects.catalog import Catalog
from grasp_bench.results import find_runs, load_trials
from grasp_bench.scenario import load_scenario
from grasp_bench.sweeps.chart import as_svg, words
from grasp_bench.sweeps.study import Sweep, sweep

ROOT = Path(__file__).resolve().parents[1]
PREDICTORS = ("oracle", "htc-grasp")
STUDY = {
    "calibration.position_mm": (0, 2, 5, 10),
    "gripper.friction_scale": (0.25, 0.5, 1.0),
    "sensor.axial_sigma": (0.0005, 0.002, 0.008),
    "gripper.force": (20, 60, 120),
    "physics.max_hulls": (1, 4, 0),
    "physics.timestep": (0.001, 0.002, 0.004),
    "calibration.rotation_deg": (0, 0.5, 1, 2),
}


def study(folder: Path, workers: int) -> list[Sweep]:
    """All sweeps; the scenario's own value is run once and shared."""
    objects = Catalog().names[::3]
    base = load_scenario("table4")
    done = []
    for parameter, values in STUDY.items():
        done.append(sweep(parameter, values, base, folder, predictors=PREDICTORS, objects=objects,
                          workers=workers, progress=lambda words, record, _: print(
                              f"\r{words}: trial {record['trial']:3d}", end="", file=sys.stderr)))
    return done


def as_markdown(done: list[Sweep]) -> str:
    """A table and a figure for each parameter."""
    lines = []
    for one in done:
        lines += [f"### `{one.parameter}`", "", f"![Success against {one.parameter}]"
                  f"(images/sensitivity-{one.parameter}.svg)", "",
                  "| Predictor | Value | Lifted | 95 % interval | Lost / gained | p |",
                  "| --- | ---: | ---: | --- | ---: | ---: |"]
        for p in one.points:
            own = words(p.value) == words(one.own)
            paired = ("", "") if own or p.p is None else (f"{p.lost} / {p.gained}", f"{p.p:.2g}")
            lines.append(f"| {p.predictor} | {words(p.value)}{' (reference)' if own else ''} | "
                         f"{p.successes}/{p.trials} = {p.rate:.1%} | {p.low:.1%} – {p.high:.1%} | "
                         f"{paired[0]} | {paired[1]} |")
        lines.append("")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=ROOT / "sweeps" / "sensitivity")
    arguments = parser.parse_args()
    done = study(arguments.folder, arguments.workers)
    docs = ROOT / "docs"
    for one in done:
        (docs / "images" / f"sensitivity-{one.parameter}.svg").write_text(as_svg(one), encoding="utf-8")
    rows = [one.as_csv().splitlines() for one in done]
    lines = [rows[0][0], *(line for table in rows for line in table[1:])]
    (docs / "sensitivity.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    sys.path.insert(0, str(docs))
    from make_tables import replace  # pyright: ignore[reportMissingImports]

    replace(docs / "physics.md", "sensitivity", as_markdown(done))
    trials = sum(len(load_trials(f)) for f in find_runs(arguments.folder))
    print(f"\n{trials} trials; docs/physics.md, docs/sensitivity.csv and docs/images written.")


if __name__ == "__main__":
    main()
