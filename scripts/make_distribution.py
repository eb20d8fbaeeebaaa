"""Sizes, masses and graspable directions of the objects beside YCB's.

``python scripts/make_distribution.py [YCB]``: with a folder of imported YCB scans (see
docs/import.md), their summary is measured anew; without, it is read from ``docs/ycb-summary.json``,
which holds five-number summaries and nothing else.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

import numpy as np

from grasp_bench.objects.catalog import Catalog

HERE = Path(__file__).parents[1] / "docs"
SUMMARY = HERE / "ycb-summary.json"
QUANTITIES = (
    ("longest", "longest side [mm]", True),
    ("middle", "middle side [mm]", True),
    ("shortest", "shortest side [mm]", True),
    ("mass", "mass [g]", True),
    ("graspable", "resting poses with a grasp, by probability [%]", False),
    ("directions", "distinct jaw directions", False),
)
APART = math.radians(30)
"""Jaw directions nearer than this are one."""
WIDTH, LEFT, ROW, BOX = 760, 40, 74, 14
COLORS = {"grasp-bench": "#00897b", "YCB": "#ff7043"}


def measure(catalog: Catalog) -> dict[str, list[float]]:
    """Minimum, quartiles and maximum of each quantity, over the objects of a catalog."""
    values: dict[str, list[float]] = {key: [] for key, _, _ in QUANTITIES}
    for name, entry in catalog.entries.items():
        poses = catalog.load(name).poses
        for key, side in zip(("shortest", "middle", "longest"), sorted(entry["extents"]), strict=True):
            values[key].append(1000 * side)
        values["mass"].append(1000 * entry["mass"])
        values["graspable"].append(
            100 * sum(p.probability for p in poses if p.grasps) / sum(p.probability for p in poses)
        )
        kept: list[np.ndarray] = []
        for axis in (g.axis for p in poses for g in p.grasps):
            if all(abs(axis @ other) < math.cos(APART) for other in kept):
                kept.append(axis)
        values["directions"].append(len(kept))
    return {k: np.round(np.percentile(v, [0, 25, 50, 75, 100]), 1).tolist() for k, v in values.items()}


def as_svg(rows: dict[str, dict[str, list[float]]], counts: dict[str, int]) -> str:
    """Box plots: whiskers to the extremes, box over the quartiles, a line at the median."""
    height = ROW * len(QUANTITIES) + 36
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-size="13" '
        'font-family="sans-serif"><rect width="100%" height="100%" fill="white"/>'
    ]
    for i, (source, color) in enumerate(COLORS.items()):
        parts.append(
            f'<rect x="{LEFT + 190 * i}" y="8" width="12" height="12" fill="{color}"/>'
            f'<text x="{LEFT + 18 + 190 * i}" y="19">{source} ({counts[source]} objects)</text>'
        )
    for row, (key, title, logarithmic) in enumerate(QUANTITIES):
        top = 36 + ROW * row
        low = min(r[key][0] for r in rows.values())
        high = max(r[key][4] for r in rows.values())

        def at(value: float, low: float = low, high: float = high, log: bool = logarithmic) -> float:
            share = math.log(value / low) / math.log(high / low) if log else (value - low) / (high - low)
            return LEFT + share * (WIDTH - 2 * LEFT)

        parts.append(f'<text x="{LEFT}" y="{top + 12}" font-weight="bold">{title}</text>')
        for line, (source, color) in enumerate(COLORS.items()):
            y = top + 18 + line * (BOX + 4)
            least, first, median, third, most = rows[source][key]
            parts.append(
                f'<path d="M{at(least):.1f} {y + BOX / 2}H{at(most):.1f}" stroke="{color}"/>'
                f'<rect x="{at(first):.1f}" y="{y}" width="{max(at(third) - at(first), 1):.1f}" '
                f'height="{BOX}" fill="{color}" fill-opacity="0.55"/>'
                f'<path d="M{at(median):.1f} {y}v{BOX}" stroke="black" stroke-width="2"/>'
            )
        parts.append(
            f'<text x="{LEFT}" y="{top + 64}" fill="#555">{low:g}</text>'
            f'<text x="{WIDTH - LEFT}" y="{top + 64}" fill="#555" text-anchor="end">{high:g}</text>'
        )
    return "\n".join([*parts, "</svg>", ""])


if __name__ == "__main__":
    ours = Catalog()
    if len(sys.argv) > 1:
        scans = Catalog(Path(sys.argv[1]))
        source = (
            "26 laser scans and measured masses of the YCB object and model set (Calli et al. 2015), "
            "imported with grasp-bench"
        )
        found = {"source": source, "count": len(scans.names), "five_numbers": measure(scans)}
        SUMMARY.write_text(json.dumps(found, indent=1) + "\n")
    ycb = json.loads(SUMMARY.read_text())
    both = {"grasp-bench": measure(ours), "YCB": ycb["five_numbers"]}
    counts = {"grasp-bench": len(ours.names), "YCB": ycb["count"]}
    (HERE / "images" / "distribution.svg").write_text(as_svg(both, counts))
    for key, title, _ in QUANTITIES:
        print(title, *(f"{s}: {r[key]}" for s, r in both.items()), sep="\n  ")
