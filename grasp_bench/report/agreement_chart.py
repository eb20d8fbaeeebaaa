"""Success in physics against accuracy on real images as SVG: a point a predictor, with its intervals."""

from __future__ import annotations

from html import escape
from math import floor

from grasp_bench.report.agreement import Agreement
from grasp_bench.report.svg import start, text
from grasp_bench.runs.statistics import Rate

COLORS = ("#0b6e99", "#d1495b", "#5b8c5a", "#b07a00", "#6d597a", "#33658a", "#8a5a44", "#444444")
WIDTH, PANEL, LEFT, TOP, BOTTOM, LINE = 640, 420, 64, 46, 56, 20


def as_svg(found: Agreement) -> str:
    """Draw both rates from 0 to 100 %, or from the tenth below the least, with a numbered legend below."""
    points = found.points
    from_x, from_y = _start([p.physics for p in points]), _start([p.real for p in points])
    height = TOP + PANEL + BOTTOM + LINE * ((len(points) + 1) // 2) + 8

    def x(rate: float) -> float:
        return LEFT + (rate - from_x) / (1 - from_x) * (WIDTH - LEFT - 24)

    def y(rate: float) -> float:
        return TOP + (1 - rate) / (1 - from_y) * PANEL

    title = f"Physics ({found.scenario}) and real images ({found.dataset}, {found.protocol})"
    parts = [
        *start(WIDTH, height, title),
        text(LEFT, 20, f"Pearson {found.pearson}, MMRV {found.mmrv}"),
        text(LEFT + (WIDTH - LEFT) / 2, TOP + PANEL + 42, f"lifted in {found.scenario}", "middle"),
        f'<text transform="translate(16 {TOP + PANEL / 2}) rotate(-90)" text-anchor="middle" fill="#333333">'
        f"right on {escape(found.dataset)}, {escape(found.protocol)}</text>",
    ]
    for tenth in range(11):
        rate = tenth / 10
        if rate >= from_x:
            parts += [
                _line(x(rate), TOP, x(rate), TOP + PANEL),
                text(x(rate), TOP + PANEL + 18, f"{rate:.0%}", "middle"),
            ]
        if rate >= from_y:
            parts += [
                _line(LEFT, y(rate), WIDTH - 24, y(rate)),
                text(LEFT - 8, y(rate) + 4, f"{rate:.0%}", "end"),
            ]
    for i, p in enumerate(points):
        color = COLORS[i % len(COLORS)]
        (left, right), (low, high) = p.physics.interval, p.real.interval
        at, up = x(p.physics.rate), y(p.real.rate)
        bars = (x(max(left, from_x)), up, x(right), up), (at, y(max(low, from_y)), at, y(high))
        parts += [_line(*bar, color, 'stroke-opacity="0.35" stroke-width="2"') for bar in bars]
        hover = f"{p.predictor}: {p.physics} in physics, {p.real} on images"
        column, row = i % 2, i // 2
        lx, ly = LEFT + column * (WIDTH - LEFT) / 2, TOP + PANEL + BOTTOM + 12 + LINE * row
        parts += [
            f'<circle cx="{at:.1f}" cy="{up:.1f}" r="5" fill="{color}">'
            f"<title>{escape(hover)}</title></circle>",
            text(at + 7, up - 6, str(i + 1)),
            f'<circle cx="{lx:.1f}" cy="{ly - 4:.1f}" r="5" fill="{color}"/>',
            text(lx + 10, ly, f"{i + 1} {p.predictor}"),
        ]
    return "\n".join([*parts, "</svg>", ""])


def _start(rates: list[Rate]) -> float:
    return max(0.0, floor(10 * min(r.rate for r in rates) - 0.5) / 10)


def _line(x1: float, y1: float, x2: float, y2: float, color: str = "#e3e3e3", more: str = "") -> str:
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{color}" {more}/>'
