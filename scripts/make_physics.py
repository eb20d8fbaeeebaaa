"""Measures and draws what docs/physics.md shows of the self-tests: ``python scripts/make_physics.py``.

It measures everything (some minutes on two cores), writes docs/physics.json, and from that the table and the
figure; with ``checks``, ``trials`` or ``draw`` only that part.
"""

from __future__ import annotations

import argparse
import json
import os
from html import escape
from pathlib import Path

import numpy as np
from rich.progress import track

from grasp_bench.system.graphics import without_gl

without_gl()

from grasp_bench.doctor.physics.check import Check  # noqa: E402
from grasp_bench.doctor.physics.reference import Watched  # noqa: E402
from grasp_bench.doctor.physics.suite import QUICK, Trials, judged, markdown, trials  # noqa: E402
from grasp_bench.robot.ec66 import EC66  # noqa: E402
from grasp_bench.scenario.outcomes import Outcome  # noqa: E402
from grasp_bench.scenario.reading import load_scenario  # noqa: E402

DOCS = Path(__file__).parents[1] / "docs"
DATA = DOCS / "physics.json"
WIDTH, ROW, LEFT, RIGHT, TOP = 640, 26, 64, 20, 46


def measure(what: str) -> None:
    """Run the quick self-tests, or the reference trials, and keep the result in :data:`DATA`."""
    scenario = load_scenario("table4")
    if what == "checks":
        result = [c.to_json() for test in track(QUICK, "Self-tests") for c in test(scenario)]
    else:
        done = trials(scenario, os.cpu_count() or 1)
        result = [_plain(runs) for runs in (done.whole, done.half)]
    data = (json.loads(DATA.read_text()) if DATA.is_file() else {}) | {what: result}
    DATA.write_text(json.dumps(data, ensure_ascii=False, indent=0) + "\n")


def _plain(runs: list[Watched]) -> list[dict[str, object]]:
    return [
        {
            "object": w.object,
            "outcome": w.outcome,
            "success": w.success,
            "torque": np.round(w.torque, 2).tolist(),
            "velocity": np.round(w.velocity, 3).tolist(),
        }
        for w in runs
    ]


def load() -> tuple[list[Check], Trials | None]:
    """What was measured; no trials where they were not."""
    data = json.loads(DATA.read_text())
    checks = [Check(**{k: v for k, v in c.items() if k != "passed"}) for c in data["checks"]]
    if "trials" not in data:
        return checks, None
    whole, half = (
        [
            Watched(w["object"], Outcome(w["outcome"]), np.array(w["torque"]), np.array(w["velocity"]))
            for w in runs
        ]
        for runs in data["trials"]
    )
    done = Trials(whole, half)
    return [*checks, *judged(done)], done


def figure(done: Trials) -> str:
    """Greatest torque and speed of each joint in every trial, as shares of the limits, as SVG."""
    height = TOP + 2 * (6 * ROW + 44)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-size="13" '
        'font-family="system-ui, sans-serif" role="img">',
        "<title>Joint torques and speeds of all reference trials</title>",
        f'<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>',
    ]
    scale = (WIDTH - LEFT - RIGHT) / 1.0
    top = TOP
    for title, color, shares in (
        (
            "greatest torque of a trial, of the limit",
            "#0b6e99",
            np.array([w.torque for w in done.whole]) / EC66.torque_limits,
        ),
        (
            "greatest speed of a trial, of the limit",
            "#d1495b",
            np.array([w.velocity for w in done.whole]) / EC66.velocity_limits,
        ),
    ):
        parts.append(
            f'<text x="{LEFT}" y="{top - 24}" font-weight="bold" fill="#333333">{escape(title)}</text>'
        )
        for percent in range(0, 101, 20):
            x = LEFT + scale * percent / 100
            stroke = "#333333" if percent == 100 else "#e3e3e3"
            parts += [
                f'<line x1="{x:.1f}" y1="{top - 8}" x2="{x:.1f}" y2="{top + 6 * ROW}" stroke="{stroke}"/>',
                f'<text x="{x:.1f}" y="{top - 10}" text-anchor="middle" font-size="11" fill="#777777">'
                f"{percent} %</text>",
            ]
        for joint, name in enumerate(EC66.joints):
            y = top + (joint + 0.5) * ROW
            parts.append(
                f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end" fill="#333333">{name}</text>'
            )
            parts += [
                f'<line x1="{LEFT + scale * s:.1f}" y1="{y - 7:.1f}" x2="{LEFT + scale * s:.1f}" '
                f'y2="{y + 7:.1f}" stroke="{color}" stroke-opacity="0.35" stroke-width="1.5"/>'
                for s in shares[:, joint]
            ]
        top += 6 * ROW + 50
    return "\n".join([*parts, "</svg>", ""])


def draw() -> None:
    """Write table and figure."""
    from make_tables import replace

    checks, done = load()
    replace(DOCS / "physics.md", "checks", markdown(checks))
    if done is not None:
        (DOCS / "images" / "joint-loads.svg").write_text(figure(done), encoding="utf-8")


PARTS = ["checks", "trials", "draw"]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Measure and draw the self-tests of docs/physics.md.")
    parser.add_argument("what", nargs="*", choices=[*PARTS, []], help="all when left out")
    for what in parser.parse_args().what or PARTS:
        draw() if what == "draw" else measure(what)


if __name__ == "__main__":
    main()
