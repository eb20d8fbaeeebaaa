"""Learning curves of many networks in one figure: held-out success against what the training cost so far."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Literal, Self

from grasp_bench.errors import ResultsError
from grasp_bench.report.svg import start

Cost = Literal["PFLOP", "minutes", "steps"]
WIDTH, HEIGHT = 760, 420
LEFT, RIGHT, TOP, BOTTOM = 52, 170, 28, 48
APART = 14
"""Least distance of two names [px]."""
COLOURS = ("#0b6e99", "#d1495b", "#5b8c5a", "#edae49", "#6d597a", "#33658a", "#8d6b94", "#b08968")


@dataclass(frozen=True)
class Curve:
    """One training.

    Attributes:
        name: network and seed.
        points: (steps, minutes, PFLOP, share held) of each validation with tries in physics.
        ended: what ended it: 'flat', 'minutes' (the clock) or 'steps'.
    """

    name: str
    points: Sequence[tuple[float, float, float, float]]
    ended: str

    @classmethod
    def read(cls, path: Path) -> Self:
        """Read a ``training.json``; ResultsError when it is none."""
        try:
            facts = json.loads(path.read_text(encoding="utf-8"))
            a_step = facts["flops"] / facts["steps"] / 1e15
            points = [
                (p["step"], p["seconds"] / 60, p["step"] * a_step, p["held"] / p["tried"])
                for p in facts["curve"]
                if p.get("tried")
            ]
            name = facts["network"] + (f", seed {facts['seed']}" if facts["seed"] else "")
            return cls(name, points, facts["ended"])
        except (OSError, ValueError, KeyError, TypeError, ZeroDivisionError) as error:
            raise ResultsError(f"{path} is no training.json of `grasp-bench train` ({error!r}).") from error

    def along(self, cost: Cost) -> list[tuple[float, float]]:
        """Return (cost, share held) of each validation."""
        which = ("steps", "minutes", "PFLOP").index(cost)
        return [(p[which], p[3]) for p in self.points]


def as_svg(curves: Sequence[Curve], cost: Cost) -> str:
    """Draw curves over the logarithm of their cost; a training cut off by the clock ends in an open ring.

    Raises:
        ResultsError: when no curve has a point.
    """
    drawn = [c for c in curves if c.points]
    if not drawn:
        raise ResultsError("No training has held-out tries; give `grasp-bench train` --held-out 200.")
    costs = [x for c in drawn for x, _ in c.along(cost) if x > 0]
    low, high = math.floor(math.log10(min(costs))), math.ceil(math.log10(max(costs) * 1.001))

    def x(value: float) -> float:
        share = (math.log10(max(value, 10.0**low)) - low) / max(high - low, 1)
        return LEFT + share * (WIDTH - LEFT - RIGHT)

    def y(share: float) -> float:
        return TOP + (1 - share) * (HEIGHT - TOP - BOTTOM)

    parts = start(WIDTH, HEIGHT, f"Held-out grasps that hold against {cost} of training", 12)
    right = WIDTH - RIGHT
    for percent in range(0, 101, 20):
        at = y(percent / 100)
        parts.append(f'<path d="M{LEFT} {at:.1f}H{right}" stroke="#dddddd"/>')
        parts.append(f'<text x="{LEFT - 6}" y="{at + 4:.1f}" text-anchor="end">{percent} %</text>')
    for power in range(low, high + 1):
        at = x(10.0**power)
        parts.append(f'<path d="M{at:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#eeeeee"/>')
        parts.append(
            f'<text x="{at:.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">{10.0**power:g}</text>'
        )
    middle = (LEFT + right) / 2
    parts.append(f'<text x="{middle}" y="{HEIGHT - 10}" text-anchor="middle">{cost} of training</text>')
    least = TOP
    for number, curve in enumerate(sorted(drawn, key=lambda c: -c.points[-1][3])):
        colour = COLOURS[number % len(COLOURS)]
        places = [(x(a), y(b)) for a, b in curve.along(cost)]
        line = " ".join(f"{a:.1f},{b:.1f}" for a, b in places)
        end, fill = places[-1], "#ffffff" if curve.ended == "minutes" else colour
        name = max(end[1] + 4, least)
        least = name + APART
        parts += [
            f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"/>',
            f'<circle cx="{end[0]:.1f}" cy="{end[1]:.1f}" r="3.5" fill="{fill}" stroke="{colour}"/>',
            f'<text x="{right + 8}" y="{name:.1f}" fill="{colour}">{escape(curve.name)}</text>',
        ]
    return "\n".join([*parts, "</svg>"]) + "\n"
