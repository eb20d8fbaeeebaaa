"""How far the success rate depends on what nobody knows exactly: ``python benchmarks/sensitivity.py``.

Sweeps friction, grip force, depth noise, calibration error, time step and number of convex pieces for
HTC-Grasp and the oracle, on every third object once. Writes figures to docs/images, numbers to
docs/sensitivity.csv and the section Sensitivity of docs/physics.md. Takes about 25 core-minutes; resumes
in ``sweeps/sensitivity`` when killed.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from grasp_bench.objects.catalog import Catalog
from grasp_bench.runs.folder import find_runs, load_records
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.studies.sweep import Sweep, sweep
from grasp_bench.studies.sweep_chart import as_svg, words

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


LEVEL = 0.05
MEANING = {
    "calibration.position_mm": "camera beside its nominal place, mm",
    "gripper.friction_scale": "factor on the friction at the pads",
    "sensor.axial_sigma": "depth noise near by, m",
    "gripper.force": "grip force, N",
    "physics.max_hulls": "convex pieces of an object at most; 0 for all",
    "physics.timestep": "time step, s",
    "calibration.rotation_deg": "camera turned against its nominal pose, °",
}


def study(folder: Path, workers: int, only: list[str]) -> list[Sweep]:
    """The sweeps asked for; the scenario's own value is run once and shared."""
    objects = Catalog().names[::3]
    base = load_scenario("table4")
    done = []
    for parameter, values in STUDY.items():
        if only and parameter not in only:
            continue
        done.append(
            sweep(
                parameter,
                values,
                base,
                folder,
                predictors=PREDICTORS,
                objects=objects,
                workers=workers,
                progress=lambda words, record, _: print(
                    f"\r{words}: trial {record['trial']:3d}", end="", file=sys.stderr
                ),
            )
        )
    return done


def conclusion(done: Sweep) -> str:
    """What the paired trials of one sweep say, in a sentence for each predictor."""
    said = []
    for name in done.predictors:
        points = [p for p in done.points if p.predictor == name]
        own = next(p for p in points if words(p.value) == words(done.own))
        apart = [p for p in points if p.p is not None and p.p < LEVEL]
        found = "".join(
            f"{words(p.value)} differs ({p.successes}/{p.trials}, −{p.lost}/+{p.gained}, p = {p.p:.2g}); "
            for p in apart
        )
        rest = "the other values cannot be told from it" if apart else "no value can be told from it"
        if len(apart) == len(points) - 1:
            rest = "no value is like it"
        said.append(f"`{name}` {own.successes}/{own.trials} at {words(done.own)}: {found}{rest}")
    return ". ".join(said) + "."


def as_markdown(done: list[Sweep]) -> str:
    """What was done, what follows, and a table and a figure for each parameter."""
    count = {p.trials for one in done for p in one.points}
    trials = ", ".join(map(str, sorted(count)))
    lines = [
        "How far does the result depend on what nobody knows exactly? `python benchmarks/sensitivity.py`",
        "varies one value of `table4` at a time, for `oracle` and for `htc-grasp` with the weights shipped",
        f"here, on every third object once: n = {trials} a point, the same objects in the same places with",
        "the same random numbers. Intervals are 95 % Wilson. As trials are paired, those lost (−) and",
        "gained (+) against the reference, with the exact McNemar test, show what intervals hide;",
        "p-values are not corrected for the number of comparisons. Numbers:",
        "[sensitivity.csv](sensitivity.csv).",
        "",
        f"Values that differ from the reference at p < {LEVEL:g}:",
        "",
        *(f"- **`{one.parameter}`** ({MEANING[one.parameter]}): {conclusion(one)}" for one in done),
        "",
        "What to conclude: a parameter whose values cannot be told apart, over a range that surely holds the",
        "true one, does not decide the result at this n. One whose values differ must be known for the robot",
        "in question before its success rate is compared with a simulated one.",
        "",
    ]
    for one in done:
        lines += [
            f"### `{one.parameter}`",
            "",
            f"![Success against {one.parameter}](images/sensitivity-{one.parameter}.svg)",
            "",
            "| Predictor | Value | Lifted | 95 % interval | − / + | p |",
            "| --- | ---: | ---: | --- | ---: | ---: |",
        ]
        for p in one.points:
            own = words(p.value) == words(one.own)
            paired = ("", "") if own or p.p is None else (f"{p.lost} / {p.gained}", f"{p.p:.2g}")
            lines.append(
                f"| {p.predictor} | {words(p.value)}{' (reference)' if own else ''} | "
                f"{p.successes}/{p.trials} = {p.rate:.1%} | {p.low:.1%} – {p.high:.1%} | "
                f"{paired[0]} | {paired[1]} |"
            )
        lines.append("")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=ROOT / "sweeps" / "sensitivity")
    parser.add_argument("--only", nargs="*", default=[], choices=list(STUDY), help="these parameters")
    arguments = parser.parse_args()
    done = study(arguments.folder, arguments.workers, arguments.only)
    docs = ROOT / "docs"
    for one in done:
        (docs / "images" / f"sensitivity-{one.parameter}.svg").write_text(as_svg(one), encoding="utf-8")
    rows = [one.as_csv().splitlines() for one in done]
    lines = [rows[0][0], *(line for table in rows for line in table[1:])]
    (docs / "sensitivity.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    sys.path.insert(0, str(ROOT / "scripts"))
    from make_tables import replace

    page = docs / "physics.md"
    text = page.read_text(encoding="utf-8")
    if "<!-- sensitivity -->" not in text:
        text = f"{text.rstrip()}\n\n## Sensitivity\n\n<!-- sensitivity -->\n<!-- /sensitivity -->\n"
        page.write_text(text, encoding="utf-8")
    replace(page, "sensitivity", as_markdown(done))
    trials = sum(len(load_records(f)) for f in find_runs(arguments.folder))
    print(f"\n{trials} trials; docs/physics.md, docs/sensitivity.csv and docs/images written.")


if __name__ == "__main__":
    main()
