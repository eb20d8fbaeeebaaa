"""Would the order survive? A ranking repeated in other worlds that are as plausible."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from grasp_bench.errors import GraspBenchError
from grasp_bench.execution.together import run_together
from grasp_bench.report.tables import TextTable
from grasp_bench.runs.jobs import Settings, spread
from grasp_bench.runs.record import TrialRecord
from grasp_bench.studies.plausible import plausible
from grasp_bench.studies.rank import Contest, folder_name
from grasp_bench.system.arrays import Floats

AGAIN = 1000
"""How often trials are drawn again."""
OnTrial = Callable[[str, int, TrialRecord, bool], None]
"""Called with a predictor's name, the world's number, its record, and whether it was there before."""


@dataclass(frozen=True)
class Pair:
    """Two predictors that follow one another in the scenario's own world, and how they do in the others.

    Attributes:
        better, worse: their names.
        holds, tied, turned: number of other worlds in which the better one is ahead, level, behind.
    """

    better: str
    worse: str
    holds: int
    tied: int
    turned: int


@dataclass(frozen=True)
class Worlds:
    """Scores of predictors in several worlds, on the same trials.

    Attributes:
        scores: of each predictor (worlds, trials); the first world is the scenario itself.
        score: what a trial counts, in words.
    """

    scores: Mapping[str, Floats]
    score: str

    @property
    def trials(self) -> int:
        """Number of trials of each predictor in each world."""
        return next(iter(self.scores.values())).shape[1]

    @cached_property
    def means(self) -> dict[str, Floats]:
        """Mean scores (worlds,) of each predictor."""
        return {name: found.mean(1) for name, found in self.scores.items()}

    @property
    def order(self) -> list[str]:
        """Names by their mean score in the scenario's own world, best first."""
        return sorted(self.means, key=lambda n: -self.means[n][0])

    @property
    def taus(self) -> Floats:
        """Kendall's τ-b (others,) of the order in each other world with that in the scenario's own.

        1 is the same order, 0 none in common, −1 the reverse; NaN where all are level.
        M. G. Kendall, “The treatment of ties in ranking problems”, Biometrika 33 (1945) 239–251.
        """
        own, *others = np.array(list(self.means.values())).T
        return np.array([_tau(own, other) for other in others])

    @cached_property
    def chance(self) -> Floats:
        """τ of the orders that two sets of trials in the scenario's own world would give.

        Shape (:data:`AGAIN`,). Each set is drawn from those at hand with replacement, by itself, since the
        order at hand is one of chance, too.
        """
        own = np.array([found[0] for found in self.scores.values()])
        drawn = np.random.default_rng(0).integers(self.trials, size=(2, AGAIN, self.trials))
        first, second = own[:, drawn].mean(3).transpose(1, 2, 0)
        return np.array([_tau(a, b) for a, b in zip(first, second, strict=True)])

    @property
    def pairs(self) -> list[Pair]:
        """Neighbours in :attr:`order`."""
        found = []
        for better, worse in pairwise(self.order):
            ahead = np.sign(self.means[better] - self.means[worse])[1:]
            counts = (int((ahead == sign).sum()) for sign in (1, 0, -1))
            found.append(Pair(better, worse, *counts))
        return found

    def to_json(self) -> dict[str, Any]:
        """Return plain data; an undefined τ is None."""
        return {
            "trials": self.trials,
            "score": self.score,
            "means": {n: [float(v) for v in values] for n, values in self.means.items()},
            "kendall_tau": [None if np.isnan(t) else float(t) for t in self.taus],
            "kendall_tau_of_other_trials": _summary(self.chance),
            "neighbours": [vars(p) for p in self.pairs],
        }


def _tau(first: Floats, second: Floats) -> float:
    """Return Kendall's τ-b of two means of each predictor."""
    from scipy.stats import kendalltau

    return float(kendalltau(first, second).statistic)


def _summary(taus: Floats) -> dict[str, float] | None:
    """Return mean and 5th percentile; None where all are undefined."""
    known = taus[~np.isnan(taus)]
    return {"mean": float(known.mean()), "p5": float(np.percentile(known, 5))} if len(known) else None


def in_worlds(
    contest: Contest,
    worlds: int,
    trials: int,
    folder: Path,
    workers: int,
    on_trial: OnTrial = lambda name, world, record, there: None,
) -> Worlds:
    """Try all predictors of a contest on the same trials in its scenario and in ``worlds`` others.

    Trials are of ``trials`` different objects, drawn from the contest's by its seed, the same in all worlds.
    Each predictor has an ordinary run in ``folder/worldN``; the same call goes on where a stopped one ended.

    Raises:
        GraspBenchError: for more trials than objects, and for anything wrong with the inputs.
    """
    if trials > len(contest.objects):
        raise GraspBenchError(
            f"--physics-trials {trials} is more than there are objects ({len(contest.objects)}), each of "
            "which is tried once in a world."
        )
    rng = np.random.default_rng(np.random.SeedSequence([contest.seed, trials, len(contest.objects)]))
    chosen = sorted(rng.choice(len(contest.objects), trials, replace=False))
    jobs = spread([contest.objects[i] for i in chosen], trials)
    scores = {n: np.zeros((worlds + 1, trials)) for n in contest.predictors}
    for world in range(worlds + 1):
        scenario = plausible(contest.scenario, world, contest.seed)
        settings = Settings(
            scenario, contest.catalog.folder.resolve(), contest.predictors[0], contest.seed, "raycast"
        )
        folders = {n: folder / f"world{world}" / folder_name(n) for n in contest.predictors}

        def take(name: str, record: TrialRecord, there: bool, world: int = world) -> None:
            scores[name][world, record.trial] = contest.score.of(record)
            on_trial(name, world, record, there)

        run_together(settings, folders, jobs, workers, take)
    return Worlds(scores, contest.score.what)


def worlds_table(found: Worlds) -> TextTable:
    """Return a row for each pair of neighbours."""
    taus, others = found.taus, len(found.taus)
    known = taus[~np.isnan(taus)]
    rows: list[Sequence[str]] = []
    for p in found.pairs:
        first, second = (f"{found.means[n][0]:.1%}" for n in (p.better, p.worse))
        counts = map(str, (p.holds, p.tied, p.turned))
        rows.append([f"{p.better} before {p.worse}", f"{first} : {second}", *counts])
    tau = "undefined"
    if len(known):
        tau = f"from {known.min():.2f} to {known.max():.2f}, mean {known.mean():.2f}"
    if chance := _summary(found.chance):
        tau += (
            f". Two sets of as many trials in the scenario's own world agree by {chance['mean']:.2f} in the "
            f"mean, one time in twenty by less than {chance['p5']:.2f}"
        )
    return TextTable(
        f"Would the order survive? {others} other worlds",
        ("Neighbours", f"Mean {found.score}", "Holds", "Level", "Turned"),
        rows,
        note=f"Kendall's τ with the scenario's own order: {tau}. Worlds differ in friction, masses, centres "
        "of mass, time step, friction cone, pads, sensor and calibration; each predictor tried the same "
        f"{found.trials} trials in each. A pair that is nearly level turns by chance, too.",
        numbers=(2, 3, 4),
    )
