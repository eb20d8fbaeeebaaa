"""Success over difficulty: how difficult an object a predictor still manages half of the time.

For runs on objects whose difficulty was measured (:mod:`grasp_bench.objects.difficulty`): the share of random
antipodal tries that fail, 0 to 100 %.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np

from grasp_bench.objects.catalog import Catalog
from grasp_bench.objects.difficulty import difficulty_of
from grasp_bench.report.tables import TextTable, rate_cells
from grasp_bench.runs.margins import Estimate
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate
from grasp_bench.system.arrays import Floats

DRAWS = 1000
"""Bootstrap samples of objects."""
LEAST_OBJECTS = 10
"""Objects that a curve needs."""
STEPS, CLOSE = 40, 1e-8
"""Newton steps at most, and the size of one at which a fit has come to an end."""
POINTS = tuple(float(x) for x in np.linspace(0, 1, 21))
"""Difficulties at which the curve is drawn."""
BANDS = (0.0, 0.1, 0.3, 0.6, 1.0)
"""Limits of the difficulties that the table puts together."""


@dataclass(frozen=True)
class Managed:
    """How a run's success falls with difficulty.

    Attributes:
        half: difficulty at which the fitted curve crosses one half, 0 to 1; cut to the difficulties that were
            tried, ``least`` to ``most``.
        least, most: least and greatest difficulty of the run's objects.
        curve: fitted success at :data:`POINTS`, intervals of each by bootstrap over objects.
        bands: success by difficulty, between :data:`BANDS`.
        objects: difficulty and success of each object.
    """

    half: Estimate
    least: float
    most: float
    curve: tuple[Estimate, ...]
    bands: tuple[Rate, ...]
    objects: Mapping[str, tuple[float, Rate]]

    @property
    def in_words(self) -> str:
        """The difficulty managed half of the time [%], marked where it lies beyond what was tried."""
        return told(self.half.value, self.least, self.most)

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "half": self.half.to_json(),
            "unit": "share of random antipodal tries that fail",
            "tried": [self.least, self.most],
            "curve": [
                {"difficulty": x, **point.to_json()} for x, point in zip(POINTS, self.curve, strict=True)
            ],
            "bands": [
                {"from": low, "to": high, **rate.to_json()}
                for (low, high), rate in zip(pairwise(BANDS), self.bands, strict=True)
            ],
            "objects": {name: {"difficulty": x, **rate.counts()} for name, (x, rate) in self.objects.items()},
        }


_shipped = cache(Catalog)


def told(value: float, least: float, most: float) -> str:
    """Tell a difficulty in per cent, as beyond the least or greatest that was tried if it is that."""
    beyond = "≥ " if value >= most else "≤ " if value <= least else ""
    return f"{beyond}{100 * value:.0f} %"


def managed(run: RunResults, catalog: Catalog | None = None) -> Managed | None:
    """Return how a run's success falls with difficulty; None where its objects have none, or are too few.

    Args:
        run: of single objects.
        catalog: tells the difficulties; the shipped one by default.
    """
    known = difficulties(run, catalog or _shipped())
    counts: dict[str, list[int]] = {}
    for record in run.records:
        if record.object not in known:
            return None
        count = counts.setdefault(record.object, [0, 0])
        count[0] += record.success
        count[1] += 1
    if len(counts) < LEAST_OBJECTS or run.info.cluttered:
        return None
    names = sorted(counts, key=lambda n: (known[n], n))
    x = np.array([known[n] for n in names])
    wins, trials = np.array([counts[n] for n in names], float).T
    drawn = np.random.default_rng(0).multinomial(len(x), np.full(len(x), 1 / len(x)), DRAWS).astype(float)
    fits = logistic(x, wins, trials, np.vstack([np.ones(len(x)), drawn]))
    half = np.clip(crossing(fits), x[0], x[-1])
    curves = expit(fits, np.array(POINTS))
    low, high = np.percentile(curves[1:], [2.5, 97.5], axis=0)
    bands = [(lo <= x) & ((x < hi) | (hi == BANDS[-1])) for lo, hi in pairwise(BANDS)]
    return Managed(
        Estimate(float(half[0]), *map(float, np.percentile(half[1:], [2.5, 97.5]))),
        float(x[0]),
        float(x[-1]),
        tuple(Estimate(float(c), float(a), float(b)) for c, a, b in zip(curves[0], low, high, strict=True)),
        tuple(Rate(int(wins[b].sum()), int(trials[b].sum())) for b in bands),
        {n: (known[n], Rate(*counts[n])) for n in names},
    )


def difficulties(run: RunResults, catalog: Catalog) -> dict[str, float]:
    """Return the difficulty of the run's objects by name, of those that have one and whose files are the
    catalogue's, measured with the run's gripper."""
    gripper = (run.info.scenario.get("robot") or {}).get("gripper")
    found = {}
    for name, files in run.info.objects.items():
        entry = catalog.entries.get(name)
        measured = None if entry is None or entry["files"] != files else difficulty_of(entry)
        if measured is not None and measured.gripper == gripper:
            found[name] = measured.failing
    return found


def logistic(x: Floats, wins: Floats, trials: Floats, weights: Floats) -> Floats:
    """Fit success = expit(a + b·x) once for each row of weights; returns (F, 2) of a and b.

    Of the penalised likelihood of D. Firth, “Bias reduction of maximum likelihood estimates”, Biometrika 80
    (1993) 27–38, which has a finite maximum where all succeed, too (G. Heinze and M. Schemper, Statistics in
    Medicine 21 (2002) 2409–2419). By Newton steps, all fits at once.

    Args:
        x: (N,) difficulty of each object.
        wins, trials: (N,) its successes and trials.
        weights: (F, N) how often each object counts.
    """
    from scipy.special import expit as sigmoid

    design = np.column_stack([np.ones_like(x), x - 0.5])
    fits = np.zeros((len(weights), 2))
    count, won = weights * trials, weights * wins
    for _ in range(STEPS):
        p = sigmoid(fits @ design.T)
        w = count * p * (1 - p)
        information = np.einsum("fn,ni,nj->fij", w, design, design) + 1e-9 * np.eye(2)
        leverage = w * np.einsum("ni,fij,nj->fn", design, np.linalg.inv(information), design)
        score = (won - count * p + leverage * (0.5 - p)) @ design
        step = np.linalg.solve(information, score[..., None])[..., 0]
        step *= np.minimum(1, 2 / np.maximum(np.abs(step).max(1, keepdims=True), 1e-12))
        fits += step
        if np.abs(step).max() < CLOSE:
            break
    return fits @ np.array([[1.0, 0.0], [-0.5, 1.0]])


def expit(fits: Floats, x: Floats) -> Floats:
    """Return the success (F, P) that fits (F, 2) tell at difficulties (P,)."""
    from scipy.special import expit as sigmoid

    return sigmoid(fits[:, :1] + fits[:, 1:] * x)


def crossing(fits: Floats) -> Floats:
    """Return where each fit (F, 2) crosses one half; ±∞ where success does not fall with difficulty."""
    a, b = fits.T
    falls = b < -1e-9
    with np.errstate(divide="ignore"):
        return np.where(falls, -a / np.where(falls, b, -1), np.where(a + 0.5 * b > 0, np.inf, -np.inf))


def difficulty_table(rows: Sequence[tuple[str, Managed]]) -> TextTable:
    """Return the table of named runs, the best first."""
    heads = [f"{100 * a:.0f}–{100 * b:.0f} %" for a, b in pairwise(BANDS)]
    rows = sorted(rows, key=lambda r: -r[1].half.value)
    cells = [
        [
            name,
            *rate_cells(Rate(sum(b.successes for b in m.bands), sum(b.trials for b in m.bands)))[:2],
            *(f"{b.successes}/{b.trials}" for b in m.bands),
            m.in_words,
            f"{told(m.half.low, m.least, m.most)} – {told(m.half.high, m.least, m.most)}",
        ]
        for name, m in rows
    ]
    return TextTable(
        "How difficult an object is lifted?",
        ("Run", "Grasped", "Rate", *heads, "Half", "95 % interval"),
        cells,
        note="Difficulty of an object: share of random antipodal tries on it that fail, measured when it was "
        "made. Half: the difficulty that is lifted half of the time, by a logistic fit of success over "
        "difficulty (Firth); ≥ and ≤: beyond the hardest and easiest objects tried. Intervals by bootstrap "
        "over objects.",
        numbers=range(1, len(heads) + 5),
    )
