"""The figures of one run in a report."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grasp_bench.report.clutter import Clearing, by_frequency, summarise_clutter
from grasp_bench.report.difficulty import Managed, managed
from grasp_bench.report.firmness import Firmness, firmness
from grasp_bench.report.trust import Trust
from grasp_bench.runs.folder import load_timings
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate


@dataclass(frozen=True)
class Summary:
    """Figures of a run.

    Attributes:
        run: name of the run: its path below a folder of runs.
        info: settings of the run.
        lifted: successes among its trials.
        outcomes: number of trials by outcome, most frequent first.
        by_category, by_object: rates by name, sorted.
        timings: mean seconds of a trial by phase.
        clutter: figures of its episodes, if it cleared tables.
        trust: what it tells of its predictor's own word, and of its pace.
        firmness: how firmly it holds, if it measured that.
        managed: how its success falls with difficulty, if that of its objects is known.
    """

    run: str
    info: RunInfo
    lifted: Rate
    outcomes: dict[str, int]
    by_category: dict[str, Rate]
    by_object: dict[str, Rate]
    timings: dict[str, float]
    clutter: Clearing | None
    trust: Trust
    firmness: Firmness | None = None
    managed: Managed | None = None

    @classmethod
    def of(cls, results: RunResults, root: Path | None = None) -> Summary:
        """Return figures of a run, named by its path below ``root``.

        Raises:
            ResultsError: when it holds no trial yet.
        """
        folder, records = results.folder, results.records
        timings = load_timings(folder)
        phases = sorted({phase for t in timings for phase in t.seconds})
        episodes = [r.clutter for r in records if r.clutter is not None]
        return cls(
            folder.name if root in (None, folder) else folder.relative_to(root).as_posix(),
            results.info,
            results.lifted,
            by_frequency(r.outcome for r in records),
            _by(records, lambda r: r.category),
            _by(records, lambda r: r.object),
            {p: round(sum(t.seconds.get(p, 0.0) for t in timings) / len(timings), 5) for p in phases},
            summarise_clutter(episodes, len(records)) if results.info.cluttered else None,
            Trust.of(results, timings),
            firmness(results),
            managed(results),
        )

    @property
    def missing(self) -> int:
        """Number of trials that were planned and are not done yet."""
        return self.planned - self.lifted.trials

    @property
    def planned(self) -> int:
        """Number of trials that the run is to have; of a race's, which may end at any, those done."""
        return self.info.planned(self.lifted.trials)

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "clutter": None if self.clutter is None else self.clutter.to_json(),
            "run": self.run,
            "predictor": self.info.predictor,
            "scenario": self.info.scenario_name,
            "definition": self.info.definition,
            "seed": self.info.seed,
            "renderer": self.info.renderer,
            "weights": self.info.weights,
            "planned_trials": self.planned,
            **self.lifted.to_json(),
            "outcomes": self.outcomes,
            "by_category": {name: rate.counts() for name, rate in self.by_category.items()},
            "by_object": {name: rate.counts() for name, rate in self.by_object.items()},
            "timings": self.timings,
            "trust": self.trust.to_json(),
            "firmness": None if self.firmness is None else self.firmness.to_json(),
            "difficulty": None if self.managed is None else self.managed.to_json(),
        }


def _by(records: Sequence[TrialRecord], name: Callable[[TrialRecord], str]) -> dict[str, Rate]:
    """Return the rate of each group, sorted by name."""
    return dict(sorted(tally((name(r), r.success) for r in records).items()))


def tally(pairs: Iterable[tuple[str, bool]]) -> dict[str, Rate]:
    """Return the rate by label of (label, success) pairs."""
    counts: dict[str, list[int]] = {}
    for label, success in pairs:
        count = counts.setdefault(label, [0, 0])
        count[0] += success
        count[1] += 1
    return {label: Rate(k, n) for label, (k, n) in counts.items()}


def worst_objects(by_object: Mapping[str, Rate], count: int = 10) -> list[tuple[str, Rate]]:
    """Return the objects that failed most, first those that failed every time and were tried most."""
    failed = [(name, rate) for name, rate in by_object.items() if rate.successes < rate.trials]
    return sorted(failed, key=lambda o: (o[1].rate, -o[1].trials, o[0]))[:count]
