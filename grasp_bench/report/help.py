"""Whose merit is a rate? What was lifted as predicted, what with the planner's help, and the difference."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from grasp_bench.report.tables import TextTable
from grasp_bench.runs.comparison import scenes
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Pairs, Rate, mcnemar, paired_interval

NOTICEABLE = 0.05
"""A widening of less than this is rounding [mm]."""
TITLE = "Whose merit is it?"
NOTE = (
    "As predicted: only the predictor's best grasp, at its own centre, angle and width. Assisted: the "
    "planner may pass over grasps and opens the jaws as wide as the fingers need. Difference: assisted minus "
    "as predicted on the trials of both, with Tango's 95 % interval and McNemar's exact p. Other, "
    "wider: trials of the assisted run in which the planner did so; alone: those lifted without either."
)


@dataclass(frozen=True)
class Help:
    """Help that the planner gave in the trials of one run.

    Attributes:
        trials: number of trials.
        known: those whose records say what help was given; records of earlier versions do not.
        other: trials in which another grasp than the best was carried out.
        wider: trials in which the jaws opened wider than predicted.
        alone: trials that were lifted with the best grasp at its own width.
    """

    trials: int
    known: int
    other: int
    wider: int
    alone: int

    @classmethod
    def of(cls, records: Sequence[TrialRecord]) -> Help:
        """Count the help in all trials on single objects; an episode of clutter counts as none."""
        known = [r for r in records if r.widening_mm is not None]
        wider = [(r.widening_mm or 0) > NOTICEABLE for r in known]
        other = [bool(r.rank) for r in known]
        alone = sum(r.success and not (w or o) for r, w, o in zip(known, wider, other, strict=True))
        return cls(len(records), len(known), sum(other), sum(wider), alone)

    def to_json(self) -> dict[str, int]:
        """Return plain data."""
        return dict(vars(self))


@dataclass(frozen=True)
class Merit:
    """One predictor under both protocols.

    Attributes:
        runs: positions of its runs in the list.
        predictor, scenario, seed: what was tried where; the scenario is the assisted run's if there is one.
        predicted, assisted: rates of the two runs; None for one that there is not.
        pairs: of the trials of both, lost and gained by the help; None where there is one run only.
        help: what the assisted run says of the help given; None without such a run.
    """

    runs: tuple[int, ...]
    predictor: str
    scenario: str
    seed: int
    predicted: Rate | None
    assisted: Rate | None
    pairs: Pairs | None
    help: Help | None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Tango's 95 % score interval of the difference assisted − as predicted."""
        return None if self.pairs is None else paired_interval(self.pairs)

    @property
    def p_value(self) -> float | None:
        """McNemar's exact two-sided p-value that the help changes nothing."""
        return None if self.pairs is None else mcnemar(self.pairs.lost, self.pairs.gained)

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "predictor": self.predictor,
            "scenario": self.scenario,
            "seed": self.seed,
            "as_predicted": None if self.predicted is None else self.predicted.to_json(),
            "assisted": None if self.assisted is None else self.assisted.to_json(),
            "pairs": None if self.pairs is None else self.pairs._asdict(),
            "difference": None if self.pairs is None else self.pairs.difference,
            "interval95": None if self.interval is None else list(self.interval),
            "p_value": self.p_value,
            "help": None if self.help is None else self.help.to_json(),
        }


def merits(runs: Sequence[RunResults]) -> list[Merit]:
    """Return what is known of each predictor under both protocols, in the order of the runs.

    Two runs belong together when nothing but the protocol differs: the same predictor, weights, seed,
    renderer and scenario, whatever it is called and whether or not it measures margins. Of several alike the
    one counts that says what help was given, and then the longest. Trials are paired by object and attempt.
    Left out are runs of clutter, of earlier versions, and assisted ones that have no counterpart and whose
    records do not say what help was given.
    """
    found: dict[str, dict[bool, int]] = {}
    for i, run in enumerate(runs):
        if len(run) and not (run.info.cluttered or run.info.outdated):
            both = found.setdefault(_conditions(run.info), {})
            before = both.get(assisted(run.info))
            if before is None or _tells(run) > _tells(runs[before]):
                both[assisted(run.info)] = i
    told = []
    for both in found.values():
        helped, alone = (runs[both[k]] if k in both else None for k in (True, False))
        given = None if helped is None else Help.of(helped.records)
        if alone is None and (given is None or not given.known):
            continue
        named = helped or alone
        assert named is not None
        told.append(
            Merit(
                tuple(sorted(both.values())),
                named.predictor,
                named.info.scenario_name,
                named.info.seed,
                None if alone is None else alone.lifted,
                None if helped is None else helped.lifted,
                None if alone is None or helped is None else _pairs(alone, helped),
                given,
            )
        )
    return told


def _tells(run: RunResults) -> tuple[bool, int]:
    return Help.of(run.records).known > 0, len(run)


def assisted(info: RunInfo) -> bool:
    """Return whether the planner helped in a run; it did in all of earlier versions."""
    execution = info.scenario.get("execution")
    protocol = execution.get("protocol") if isinstance(execution, dict) else execution
    return protocol != "as-predicted"


def merit_table(found: Sequence[Merit]) -> TextTable:
    """Return the table of both protocols and the difference."""
    head = ("Predictor", "As predicted", "Assisted", "Difference", "p", "Other", "Wider", "Alone")
    return TextTable(TITLE, head, [_cells(m) for m in found], note=NOTE, numbers=(1, 2, 4, 5, 6, 7))


def _cells(merit: Merit) -> list[str]:
    def rate(lifted: Rate | None) -> str:
        return "–" if lifted is None else f"{lifted.successes}/{lifted.trials}"

    given = (
        [""] * 3 if merit.help is None else [str(getattr(merit.help, k)) for k in ("other", "wider", "alone")]
    )
    difference = p = ""
    if merit.pairs is not None and merit.interval is not None and merit.p_value is not None:
        low, high = merit.interval
        difference = f"{merit.pairs.difference:+.1%} ({100 * low:+.1f} – {100 * high:+.1f})"
        p = f"{merit.p_value:.2g}"
    return [merit.predictor, rate(merit.predicted), rate(merit.assisted), difference, p, *given]


def _conditions(info: RunInfo) -> str:
    """Return text that is the same for two runs that differ in nothing but the protocol."""
    scenario = info.comparable().scenario
    left_out = ("name", "description", "execution", "margin")
    rest = {k: v for k, v in scenario.items() if k not in left_out}
    same = [info.predictor, info.implementation, info.weights, info.seed, info.renderer, rest]
    return json.dumps(same, sort_keys=True)


def _pairs(alone: RunResults, helped: RunResults) -> Pairs | None:
    """Return the trials of both, lost and gained by the help; None where they have none in common."""
    first, second = (
        {scene: record.success for scene, record in scenes(run).items()} for run in (alone, helped)
    )
    common = first.keys() & second.keys()
    lost = sum(first[k] and not second[k] for k in common)
    gained = sum(second[k] and not first[k] for k in common)
    return Pairs(lost, gained, len(common)) if common else None
