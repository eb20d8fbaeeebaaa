"""A new run against a baseline, pair by pair: the same trials of both, and a verdict.

Verdicts, and what they mean:

- ``no regression``: a drop of the margin or more is excluded at level α (non-inferiority, by the
  lower limit of Tango's score interval for paired rates);
- ``regression``: that is not so, and a drop is proven at level α (McNemar's exact test, one-sided);
- ``underpowered``: neither, and so many trials would rarely have excluded a drop had nothing changed: it is
  the number of trials that is to be mended;
- ``inconclusive``: neither, though the trials would have done: something may have changed;
- ``identical`` and ``different``: with ``exact``, where every record must be the same.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import StrEnum
from itertools import zip_longest
from pathlib import Path
from typing import Any

from grasp_bench.errors import GraspBenchError
from grasp_bench.runs.differences import listed
from grasp_bench.runs.info import Group
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import (
    Pairs,
    mcnemar,
    mcnemar_worse,
    non_inferiority,
    paired_interval,
    power_of_drop,
    trials_to_exclude,
    visible_drop,
)

PLACES = ("in the baseline", "in the new run")


class Verdict(StrEnum):
    """Result of a comparison."""

    NO_REGRESSION = "no regression"
    REGRESSION = "regression"
    UNDERPOWERED = "underpowered"
    INCONCLUSIVE = "inconclusive"
    IDENTICAL = "identical"
    DIFFERENT = "different"


class NotComparableError(GraspBenchError):
    """Two runs whose rates say nothing about each other."""


@dataclass(frozen=True)
class Changed:
    """A trial that one of the two runs won and the other did not, or whose record differs."""

    trial: int
    object: str
    before: str
    after: str
    detail: str


@dataclass(frozen=True)
class Checked:
    """A comparison.

    Attributes:
        new, baseline: folders of the runs.
        pairs: trials lost, gained, and in all.
        successes, faults: successes and harness faults, each in the baseline and in the new run.
        margin, alpha: drop that would matter, and level of the tests.
        interval: Tango's interval of the difference new − old, with confidence 1 − 2 α.
        p_worse, p_two_sided: McNemar's exact one-sided p-value of a drop, and two-sided p-value.
        p_margin: p-value of a drop of the margin or more; at most α excludes it.
        changed: trials that were lost or gained; with ``exact``, those whose records differ.
        power: chance to prove a drop as large as the margin, with as many trials won as here.
        visible: drop that is proven in 80 of 100 cases; None where none is.
        visible_unrelated: the same, had the two runs nothing to do with each other.
        needed: trials that would exclude a drop of the margin in 80 of 100 cases, were the shares of trials
            lost and gained the true ones; None where none would.
        enough: trials that would do so had nothing changed, as many trials differing in each direction.
        notes: what is worth knowing, in words.
    """

    verdict: Verdict
    new: Path
    baseline: Path
    pairs: Pairs
    successes: tuple[int, int]
    margin: float
    alpha: float
    interval: tuple[float, float]
    p_worse: float
    p_two_sided: float
    p_margin: float
    faults: tuple[int, int]
    changed: tuple[Changed, ...]
    power: float
    visible: float | None
    visible_unrelated: float | None
    needed: int | None
    enough: int | None
    notes: tuple[str, ...]

    @property
    def failed(self) -> bool:
        """Whether this is a regression, or records are not the same."""
        return self.verdict in (Verdict.REGRESSION, Verdict.DIFFERENT)

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return asdict(self) | {
            "new": str(self.new),
            "baseline": str(self.baseline),
            "pairs": self.pairs._asdict(),
            "difference": self.pairs.difference,
        }


def check(
    new: Path, baseline: Path, margin: float = 0.03, alpha: float = 0.05, exact: bool = False
) -> Checked:
    """Compare two runs of the same trials.

    Args:
        new, baseline: folders of the runs.
        margin: drop of the rate that would matter, in (0, 1).
        alpha: level of both tests, in (0, 0.5).
        exact: demand identical records.

    Raises:
        NotComparableError: when the runs are not of the same trials, saying why.
        ResultsError: when a folder cannot be read.
        GraspBenchError: for an impossible margin or alpha.
    """
    if not 0 < margin < 1:
        raise GraspBenchError(f"--margin must be between 0 and 1, e.g. 0.03 for 3 points, not {margin:g}.")
    if not 0 < alpha < 0.5:
        raise GraspBenchError(f"--alpha must be between 0 and 0.5, e.g. 0.05, not {alpha:g}.")
    old, now = RunResults(baseline), RunResults(new)
    check_same_trials(old, now)
    both = list(zip(old.records, now.records, strict=True))
    lost = sum(b.success and not a.success for b, a in both)
    gained = sum(a.success and not b.success for b, a in both)
    n = len(both)
    pairs = Pairs(lost, gained, n)
    successes, faults = (old.successes, now.successes), (old.faults, now.faults)
    changed = tuple(
        Changed(b.trial, b.object, b.outcome, a.outcome, _why(b, a, exact))
        for b, a in both
        if (a.line() != b.line() if exact else a.success is not b.success)
    )
    interval = paired_interval(pairs, 1 - 2 * alpha)
    p_worse, p_margin = mcnemar_worse(lost, gained), non_inferiority(pairs, margin)
    if exact:
        verdict = Verdict.DIFFERENT if changed else Verdict.IDENTICAL
    elif p_margin <= alpha:
        verdict = Verdict.NO_REGRESSION
    else:
        verdict = Verdict.REGRESSION if p_worse <= alpha else Verdict.INCONCLUSIVE
    unchanged = (lost + gained) / n / 2
    enough = trials_to_exclude(margin, unchanged, unchanged, alpha)
    if verdict is Verdict.INCONCLUSIVE and enough is not None and n < enough:
        verdict = Verdict.UNDERPOWERED
    rate, share = successes[0] / n, gained / n
    drop = min(margin, rate)
    return Checked(
        verdict,
        new,
        baseline,
        pairs,
        successes,
        margin,
        alpha,
        interval,
        p_worse,
        mcnemar(lost, gained),
        p_margin,
        faults,
        changed,
        power=power_of_drop(n, drop, min(share, 1 - rate, rate - drop), alpha),
        visible=visible_drop(n, rate, share, alpha),
        visible_unrelated=visible_drop(n, rate, None, alpha),
        needed=trials_to_exclude(margin, lost / n, share, alpha),
        enough=enough,
        notes=tuple(notes_on(old, now, p_worse <= alpha and verdict is Verdict.NO_REGRESSION)),
    )


def check_same_trials(baseline: RunResults, new: RunResults) -> None:
    """Raise NotComparableError unless two runs are whole and of the same trials."""
    other = f"{new.folder} and {baseline.folder} are not of the same trials"
    if found := baseline.info.comparable().differences(new.info.comparable(), Group.TRIALS, places=PLACES):
        raise NotComparableError(
            f"{other}: {listed(found)}. Run both with the same scenario, objects, trials and seed."
        )
    for run in (baseline, new):
        if run.info.drawn:
            raise NotComparableError(
                f"{run.folder} is of a race, which ended when it could tell: a test for a fixed number of "
                "trials would be too sure of it. Go by what `grasp-bench rank` said, or make a run of each "
                "with `grasp-bench run`."
            )
        planned = range(run.info.trials)
        if missing := sorted(set(planned) - {r.trial for r in run.records}):
            shown = ", ".join(map(str, missing[:6])) + (" …" if len(missing) > 6 else "")
            raise NotComparableError(
                f"{run.folder} lacks {len(missing)} of {len(planned)} trials ({shown}); "
                "finish it with the command that began it, or merge its shards."
            )
    tried = ([(r.trial, r.object) for r in run.records] for run in (baseline, new))
    for old, now in zip_longest(*tried):
        if old != now:
            raise NotComparableError(f"{other}: they differ from trial {(old or now or (0,))[0]} on.")
    if not len(baseline):
        raise NotComparableError(f"{baseline.folder} holds no trial.")


def _why(before: TrialRecord, after: TrialRecord, exact: bool) -> str:
    if not exact:
        return after.detail if before.success else before.detail
    old, now = before.to_json(), after.to_json()
    keys = [k for k in {**old, **now} if old.get(k) != now.get(k)]
    return f"{', '.join(keys)} differ{'s' if len(keys) == 1 else ''}"


def notes_on(old: RunResults, new: RunResults, small: bool) -> list[str]:
    """Return what is worth knowing of two runs; ``small``: a drop is proven that is no matter."""
    notes, faults = [], (old.faults, new.faults)
    if found := old.info.differences(new.info, Group.MAKING, Group.ORIGIN, places=PLACES):
        notes.append(f"Not the same in both: {listed(found).rsplit(' differ', 1)[0]}.")
    if faults[1] > faults[0]:
        notes.append(
            f"{faults[1]} trials of the new run ended in faults of the harness, {faults[0]} of the "
            "baseline; they count as failures, so look at them before the rate."
        )
    if small:
        notes.append("A drop is proven, but it is smaller than the margin.")
    return notes
