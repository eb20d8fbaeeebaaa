"""What workers, Ray and large runs cost: ``python benchmarks/scaling.py --write``.

The same run with one worker process, with as many as there are cores, with two and four times as many, and by
Ray where that is installed: seconds on the clock and of the processors, in turn. Then the bytes that a trial
leaves on disk, and what ``grasp-bench report`` takes for made-up runs. Prints Markdown; ``--write`` puts it
into ``docs/scaling.md`` and the figures into ``docs/scaling.json``. Takes about 3 minutes on 2 idle cores.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from harness_cost import write_part

from grasp_bench.runs.jobs import WHOLE
from grasp_bench.system.machine import cpu_name, usable_cores

ROOT = Path(__file__).resolve().parents[1]
FORMATS = ("json", "html")
RUN = "import json, sys, grasp_bench; grasp_bench.run(**json.loads(sys.argv[1]))"
"""By the Python API: the command would take no more workers than there are cores."""


def timed(command: list[str]) -> tuple[float, float]:
    """Seconds of wall and of processor time of a command."""
    before, start = os.times(), time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    wall, after = time.perf_counter() - start, os.times()
    return wall, sum(after[2:4]) - sum(before[2:4])


def run(trials: int, predictor: str, workers: int, out: Path, executor: str = "process") -> dict[str, Any]:
    """Do a run in a fresh process, and return what it took."""
    asked = {"trials": trials, "predictor": predictor, "workers": workers, "executor": executor}
    wall, busy = timed([sys.executable, "-c", RUN, json.dumps(asked | {"out": str(out), "progress": False})])
    return {"how": executor, "workers": workers, "wall": wall, "processor": busy}


def measure(trials: int, predictor: str, records: list[int]) -> dict[str, Any]:
    """Measure all, in turn."""
    cores = usable_cores()
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        run(trials, predictor, cores, home / "warm")  # compiles scenes that are not in the cache yet
        ways = [("process", n) for n in dict.fromkeys((1, cores, 2 * cores, 4 * cores))]
        if importlib.util.find_spec("ray"):
            ways.append(("ray", cores))
        runs = [run(trials, predictor, n, home / f"{how}-{n}", how) for how, n in ways]
        left = sum(p.stat().st_size for p in (home / "warm").rglob("*") if p.is_file())
        reports = []
        for count in records:
            folder = home / f"records-{count}"
            write_part(folder, count, WHOLE)
            took: dict[str, float] = {"records": count}
            for fmt in FORMATS:
                command = [sys.executable, "-m", "grasp_bench.cli", "report", str(folder), "--format", fmt]
                took[fmt], _ = timed([*command, "--out", str(home / f"report.{fmt}")])
            reports.append(took)
    return {
        "machine": f"{cores} of the cores of {cpu_name()}, load {os.getloadavg()[0]:.1f} at the end",
        "cores": cores,
        "trials": trials,
        "predictor": predictor,
        "runs": runs,
        "bytes_a_trial": left / trials,
        "reports": reports,
    }


def markdown(told: dict[str, Any]) -> str:
    """Return the figures as they stand in ``docs/scaling.md``."""
    usual = next(r["wall"] for r in told["runs"] if (r["how"], r["workers"]) == ("process", told["cores"]))
    lines = [
        f"{told['trials']} trials of `{told['predictor']}`, start-up included, on {told['machine']}.",
        "",
        "| how | workers | wall | processor | wall against a process a core |",
        "|---|---:|---:|---:|---:|",
        *(
            f"| {r['how']} | {r['workers']} | {r['wall']:.1f} s | {r['processor']:.1f} s | "
            f"{r['wall'] / usual:.2f} |"
            for r in told["runs"]
        ),
        "",
        f"A trial leaves {told['bytes_a_trial'] / 1000:.2f} kB on disk.",
    ]
    if not any(r["how"] == "ray" for r in told["runs"]):
        lines[-1] += " Ray was not installed."
    if told["reports"]:
        lines += [
            "",
            "| `grasp-bench report` of made-up records | " + " | ".join(FORMATS) + " |",
            "|---|" + "---:|" * len(FORMATS),
            *(
                f"| {r['records']:,} | " + " | ".join(f"{r[f]:.1f} s" for f in FORMATS) + " |"
                for r in told["reports"]
            ),
        ]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=120)
    parser.add_argument("--predictor", default="htc-grasp")
    parser.add_argument("--records", type=int, nargs="*", default=[1_000, 10_000, 100_000])
    parser.add_argument("--write", action="store_true", help="into docs/scaling.md and docs/scaling.json")
    args = parser.parse_args()
    told = measure(args.trials, args.predictor, args.records)
    print(markdown(told))
    if args.write:
        sys.path.insert(0, str(ROOT / "scripts"))
        from make_tables import replace

        docs = ROOT / "docs"
        (docs / "scaling.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        replace(docs / "scaling.md", "scaling", markdown(told))


if __name__ == "__main__":
    main()
