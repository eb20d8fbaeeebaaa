"""The report's charts as Plotly figures, without colours: the page sets those of its theme.

A trace's ``meta`` says what it is, by which the page colours and picks: ``{"run": 2}`` is of that run alone,
``{"outcome": "missed"}`` and ``{"phase": 1}`` hold a value for each run, in the order of the runs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, TypeVar

import numpy as np
import plotly.graph_objects as go

from grasp_bench.report.breakdown import Breakdown, Latency
from grasp_bench.report.difficulty import POINTS, Managed
from grasp_bench.report.firmness import Firmness
from grasp_bench.report.summary import Summary
from grasp_bench.report.trust import Calibration
from grasp_bench.runs.statistics import Rate
from grasp_bench.scenario.outcomes import Outcome

T = TypeVar("T")
OUTCOMES = [str(o) for o in Outcome]


def _figure(traces: list[Any], height: int, **layout: Any) -> dict[str, Any]:
    """Return plain data that the page's script hands to Plotly."""
    figure = go.Figure(traces)
    legend = {"orientation": "h", "yanchor": "bottom", "y": 1.0, "x": 0, "traceorder": "normal"}
    figure.update_layout(
        template=None, height=height, margin={"l": 8, "r": 8, "t": 8, "b": 8}, legend=legend, **layout
    )
    figure.update_xaxes(automargin=True)
    figure.update_yaxes(automargin=True)
    data = figure.to_plotly_json()
    data["layout"].pop("template", None)
    return data


def _labels(names: list[str]) -> list[str]:
    """Return names without HTML tags, of which Plotly would read some."""
    return [n.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;") for n in names]


def _rates(rows: Sequence[Rate | None]) -> dict[str, Any]:
    """Return percentages with their Wilson intervals as error bars, and k/n for the hover text."""

    def part(get: Any) -> list[float | None]:
        return [None if r is None else round(100 * get(r), 3) for r in rows]

    return {
        "y": part(lambda r: r.rate),
        "error_y": {
            "type": "data",
            "symmetric": False,
            "thickness": 1.5,
            "width": 3,
            "array": part(lambda r: r.interval[1] - r.rate),
            "arrayminus": part(lambda r: r.rate - r.interval[0]),
        },
        "customdata": [None if r is None else f"{r.successes}/{r.trials}" for r in rows],
    }


def outcomes(runs: Sequence[Summary], names: list[str]) -> dict[str, Any]:
    """Draw how the trials of each run ended, in per cent."""
    names = _labels(names)
    traces = []
    for outcome in [o for o in OUTCOMES if any(o in r.outcomes for r in runs)]:
        counts = [r.outcomes.get(outcome, 0) for r in runs]
        traces.append(
            go.Bar(
                name=_labels([outcome])[0],
                y=names,
                orientation="h",
                meta={"outcome": outcome},
                x=[100 * c / r.lifted.trials for c, r in zip(counts, runs, strict=True)],
                customdata=[f"{c}/{r.lifted.trials}" for c, r in zip(counts, runs, strict=True)],
                hovertemplate="%{y}: %{fullData.name} %{customdata} (%{x:.1f} %)<extra></extra>",
            )
        )
    return _figure(
        traces,
        130 + 34 * len(runs),
        barmode="stack",
        bargap=0.35,
        xaxis={"title": "share of trials [%]", "range": [0, 100]},
        yaxis={"autorange": "reversed"},
    )


def success_by(kind: Breakdown, names: list[str]) -> dict[str, Any]:
    """Draw the success rate of each run by one property of the trials."""
    shown = _labels(kind.labels)
    traces = []
    for i, (row, name) in enumerate(zip(kind.runs, _labels(names), strict=True)):
        traces.append(
            go.Scatter(
                name=name,
                x=shown,
                mode="markers",
                marker={"size": 8},
                meta={"run": i},
                offsetgroup=str(i),
                hovertemplate="%{fullData.name}, %{x}: %{customdata} = %{y:.1f} %<extra></extra>",
                **_rates([row.get(label) for label in kind.labels]),
            )
        )
    return _figure(
        traces,
        340,
        scattermode="group",
        scattergap=0.4,
        xaxis={"type": "category", "categoryorder": "array", "categoryarray": shown},
        yaxis={"title": "success [%]", "range": [-4, 104]},
    )


def calibration(rows: Sequence[Calibration | None], names: list[str]) -> dict[str, Any]:
    """Draw predicted quality against success, with the line on which predictions would be probabilities."""
    traces: list[Any] = [
        go.Scatter(
            name="calibrated",
            x=[0, 1],
            y=[0, 100],
            mode="lines",
            line={"dash": "dot", "width": 1.5},
            meta={"line": True},
            hoverinfo="skip",
        )
    ]
    for i, row, name in _told(rows, names):
        traces.append(
            go.Scatter(
                name=name,
                x=[round(b.quality, 4) for b in row.bins],
                mode="lines+markers",
                marker={"size": 8},
                line={"width": 1},
                meta={"run": i},
                hovertemplate="%{fullData.name}: quality %{x:.2f}, %{customdata} = %{y:.1f} %<extra></extra>",
                **_rates([b.held for b in row.bins]),
            )
        )
    return _figure(
        traces,
        380,
        xaxis={"title": "predicted quality, mean of a bin", "range": [-0.02, 1.02]},
        yaxis={"title": "success [%]", "range": [-4, 104]},
    )


def risk_coverage(rows: Sequence[Calibration | None], names: list[str]) -> dict[str, Any]:
    """Draw the success among the most confident grasps over their share: the risk–coverage curve."""
    traces: list[Any] = []
    for i, row, name in _told(rows, names):
        shares = [100 * share for share in row.coverage]
        rates = [(r.interval[0], r.rate, r.interval[1]) for r in row.coverage.values()]
        hover = "surest %{x:.0f} %, %{customdata} = %{y:.1f} %"
        counts = [f"{r.successes}/{r.trials}" for r in row.coverage.values()]
        traces += _banded(i, name, shares, rates, hover, counts)
    return _figure(
        traces,
        380,
        xaxis={"title": "most confident share of the grasps [%]", "range": [0, 103]},
        yaxis={"title": "success [%]", "range": [-4, 104]},
    )


def firmness(rows: Sequence[Firmness | None], names: list[str]) -> dict[str, Any]:
    """Draw the share of trials that bear a multiple of the weight over it, with bands as intervals."""
    traces: list[Any] = []
    for i, row, name in _told(rows, names):
        at = [round(p.factor, 4) for p in row.curve]
        shares = [(p.share.low, p.share.value, p.share.high) for p in row.curve]
        traces += _banded(i, name, at, shares, "%{y:.1f} % bear %{x:.3g}× the weight")
    ticks = [0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 256]
    return _figure(
        traces,
        380,
        xaxis={
            "title": "force on what is held, as a multiple of its weight",
            "type": "log",
            "range": [float(np.log10(ticks[0])), float(np.log10(ticks[-1]))],
            "tickvals": ticks,
            "ticktext": [f"{t:g}×" for t in ticks],
        },
        yaxis={"title": "trials that still hold [%]", "range": [-4, 104]},
    )


def over_difficulty(rows: Sequence[Managed | None], names: list[str]) -> dict[str, Any]:
    """Draw fitted success over difficulty with bands as intervals, and a point for each object."""
    traces: list[Any] = []
    for i, row, name in _told(rows, names):
        shares = [(c.low, c.value, c.high) for c in row.curve]
        traces += _banded(i, name, [100 * x for x in POINTS], shares, "difficulty %{x:.0f} %, %{y:.1f} %")
        traces.append(
            go.Scatter(
                name=name,
                x=[round(100 * x, 2) for x, _ in row.objects.values()],
                y=[round(100 * r.rate, 2) for _, r in row.objects.values()],
                mode="markers",
                marker={"size": 5, "opacity": 0.5},
                meta={"run": i},
                legendgroup=str(i),
                showlegend=False,
                customdata=[f"{n} {r.successes}/{r.trials}" for n, (_, r) in row.objects.items()],
                hovertemplate="%{fullData.name}: %{customdata}, difficulty %{x:.0f} %<extra></extra>",
            )
        )
    return _figure(
        traces,
        380,
        xaxis={"title": "difficulty: random antipodal tries that fail [%]", "range": [-2, 102]},
        yaxis={"title": "success [%]", "range": [-4, 104]},
    )


def _banded(
    run: int,
    name: str,
    at: list[float],
    rates: Sequence[tuple[float, float, float]],
    hover: str,
    counts: list[str] | None = None,
) -> list[Any]:
    """Return the traces of a run's curve: the band between the lower and upper limits, and the middle."""
    low, middle, high = ([round(100 * value, 2) for value in values] for values in zip(*rates, strict=True))
    band = go.Scatter(
        name=name,
        x=at + at[::-1],
        y=high + low[::-1],
        mode="lines",
        line={"width": 0},
        fill="toself",
        meta={"run": run, "band": True},
        legendgroup=str(run),
        showlegend=False,
        hoverinfo="skip",
    )
    curve = go.Scatter(
        name=name,
        x=at,
        y=middle,
        mode="lines",
        line={"width": 2},
        meta={"run": run},
        legendgroup=str(run),
        customdata=counts,
        hovertemplate="%{fullData.name}: " + hover + "<extra></extra>",
    )
    return [band, curve]


def _told(rows: Sequence[T | None], names: list[str]) -> Iterator[tuple[int, T, str]]:
    """Yield position, figures and label of each run that has such figures."""
    for i, (row, name) in enumerate(zip(rows, _labels(names), strict=True)):
        if row is not None:
            yield i, row, name


def seconds(rows: Sequence[Latency], names: list[str]) -> dict[str, Any]:
    """Draw the mean wall time of each phase, stacked for each run."""
    phases = list(dict.fromkeys(p for row in rows for p in row.phases))
    shown = _labels(names)
    traces = [
        go.Bar(
            name=_labels([p])[0],
            y=shown,
            x=[row.phases.get(p) for row in rows],
            orientation="h",
            meta={"phase": i},
            hovertemplate="%{y}: %{fullData.name} %{x:.3f} s<extra></extra>",
        )
        for i, p in enumerate(phases)
    ]
    return _figure(
        traces,
        130 + 34 * len(rows),
        barmode="stack",
        bargap=0.35,
        xaxis={"title": "mean seconds a trial", "rangemode": "tozero"},
        yaxis={"autorange": "reversed"},
    )
