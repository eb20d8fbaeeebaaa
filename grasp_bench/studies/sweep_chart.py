"""Success against a parameter, drawn: SVG for documents, and an interactive page.

Both put the values at equal distances, in the order given: parameters are swept over decades as often as over
even steps, and some are words.
"""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

from grasp_bench.errors import ResultsError
from grasp_bench.report.svg import start, text
from grasp_bench.studies.sweep import Point, Sweep

COLORS = ("#0b6e99", "#d1495b", "#5b8c5a", "#edae49", "#6d597a", "#33658a")
WIDTH, HEIGHT = 640, 360
LEFT, RIGHT, TOP, BOTTOM = 56, 16, 44, 52


def words(value: Any) -> str:
    """Return a value as an axis shows it."""
    return f"{value:g}" if isinstance(value, (int, float)) and not isinstance(value, bool) else str(value)


def as_svg(done: Sweep) -> str:
    """Draw a figure with one line a predictor, and bars for the 95 % Wilson intervals."""
    values = list(dict.fromkeys(words(p.value) for p in done.points))
    step = (WIDTH - LEFT - RIGHT) / len(values)

    def y(rate: float) -> float:
        return TOP + (1 - rate) * (HEIGHT - TOP - BOTTOM)

    parts = start(WIDTH, HEIGHT, f"Success against {done.parameter} ({done.scenario})")
    for percent in range(0, 101, 20):
        at = y(percent / 100)
        parts += [
            f'<line x1="{LEFT}" y1="{at:.1f}" x2="{WIDTH - RIGHT}" y2="{at:.1f}" stroke="#e3e3e3"/>',
            text(LEFT - 8, at + 4, f"{percent} %", "end"),
        ]
    for i, value in enumerate(values):
        own = value == words(done.own)
        parts.append(text(LEFT + (i + 0.5) * step, HEIGHT - BOTTOM + 20, value, "middle", bold=own))
    parts.append(text(LEFT + (WIDTH - LEFT - RIGHT) / 2, HEIGHT - 12, done.parameter, "middle"))
    for k, name in enumerate(done.predictors):
        color = COLORS[k % len(COLORS)]
        shift = 9 * (k - (len(done.predictors) - 1) / 2)
        points = [p for p in done.points if p.predictor == name]
        at = [LEFT + (values.index(words(p.value)) + 0.5) * step + shift for p in points]
        path = " ".join(f"{x:.1f},{y(p.rate):.1f}" for x, p in zip(at, points, strict=True))
        parts.append(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="1.5"/>')
        for x, p in zip(at, points, strict=True):
            parts += [
                f'<line x1="{x:.1f}" y1="{y(p.low):.1f}" x2="{x:.1f}" y2="{y(p.high):.1f}" '
                f'stroke="{color}" stroke-width="2" stroke-opacity="0.5"/>',
                f'<circle cx="{x:.1f}" cy="{y(p.rate):.1f}" r="4" fill="{color}">'
                f"<title>{escape(_hover(p))}</title></circle>",
            ]
        legend = LEFT + 150 * k
        parts += [f'<circle cx="{legend + 6}" cy="20" r="5" fill="{color}"/>', text(legend + 16, 24, name)]
    trials = {p.trials for p in done.points}
    count = f"n = {trials.pop()} a point" if len(trials) == 1 else "n as listed"
    parts.append(text(WIDTH - RIGHT, 24, f"{count}, 95 % intervals", "end"))
    return "\n".join([*parts, "</svg>", ""])


def _hover(p: Point) -> str:
    return (
        f"{p.predictor}, {words(p.value)}: {p.successes}/{p.trials} = {p.rate:.1%} "
        f"({p.low:.1%} – {p.high:.1%})"
    )


def as_html(done: Sweep) -> str:
    """Draw the same figure as an interactive page, which holds all of Plotly and loads nothing."""
    import plotly.graph_objects as go

    figure = go.Figure()
    for k, name in enumerate(done.predictors):
        points = [p for p in done.points if p.predictor == name]
        figure.add_scatter(
            x=[words(p.value) for p in points],
            y=[100 * p.rate for p in points],
            name=name,
            mode="lines+markers",
            marker_color=COLORS[k % len(COLORS)],
            text=[_hover(p) for p in points],
            hoverinfo="text",
            error_y={
                "type": "data",
                "symmetric": False,
                "array": [100 * (p.high - p.rate) for p in points],
                "arrayminus": [100 * (p.rate - p.low) for p in points],
            },
        )
    figure.update_layout(
        title=f"Success against {done.parameter} on {done.scenario}, seed {done.seed}; 95 % Wilson intervals",
        xaxis={"title": done.parameter, "type": "category"},
        yaxis={"title": "success [%]", "range": [0, 102]},
        template="plotly_white",
    )
    return figure.to_html(include_plotlyjs=True, full_html=True)


def save(done: Sweep, out: Path) -> list[Path]:
    """Write ``sweep-PARAMETER.json``, ``.csv``, ``.svg`` and ``.html``; their paths.

    Raises:
        ResultsError: when they cannot be written.
    """
    texts = {"json": done.as_json(), "csv": done.as_csv(), "svg": as_svg(done), "html": as_html(done)}
    paths = []
    for suffix, content in texts.items():
        path = out / f"sweep-{done.parameter}.{suffix}"
        try:
            path.write_text(content, encoding="utf-8")
        except OSError as error:
            raise ResultsError(f"{path} cannot be written ({error.strerror}).") from error
        paths.append(path)
    return paths
