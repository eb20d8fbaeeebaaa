"""Finished (or interrupted) runs as Python objects: their trials, rate and report, and two compared."""

from __future__ import annotations

import html
import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grasp_bench.errors import ResultsError
from grasp_bench.runs.folder import iter_timings, load_run, load_trials
from grasp_bench.scenario.outcomes import HARNESS_FAULTS

if TYPE_CHECKING:
    import pandas as pd

NESTED = {
    "grasp": ("x", "y", "angle", "width", "quality"),
    "pose": ("position", "rotation", "opening"),
    "tcp_error": ("position", "angle"),
}
"""Records inside a trial's record, which the table of trials spreads over columns."""


class Run:
    """A run's results, read from its folder when first asked for.

    Args:
        folder: with ``run.json`` and ``trials.jsonl``.

    Attributes:
        folder: where it lies.
        info: the content of ``run.json``: predictor, whole scenario, seed, versions, hashes.

    Raises:
        ResultsError: for a folder that holds no run, or a damaged one.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)
        self.info: dict[str, Any] = load_run(self.folder)

    @property
    def predictor(self) -> str:
        """Name or Python path of the predictor."""
        return self.info["predictor"]

    @cached_property
    def trials(self) -> pd.DataFrame:
        """One row a trial, in trial order.

        Columns as in docs/results-format.md, the nested ones spread: ``grasp_x``, ``grasp_y``,
        ``grasp_width`` [px], ``grasp_angle`` [rad], ``grasp_quality``, ``pose_position`` (3) [m],
        ``pose_rotation`` (3 × 3), ``pose_opening`` [m], ``tcp_error_position`` [m],
        ``tcp_error_angle`` [rad]; None or NaN where a trial did not come that far.
        """
        table = load_trials(self.folder)
        for column, keys in NESTED.items():
            if column in table:
                for key in keys:
                    table[f"{column}_{key}"] = [
                        v.get(key) if isinstance(v, dict) else None for v in table[column]
                    ]
        return table.drop(columns=[c for c in NESTED if c in table])

    @cached_property
    def timings(self) -> pd.DataFrame:
        """Seconds that each trial spent in each phase, one row a trial."""
        import pandas as pd

        return pd.DataFrame(sorted(iter_timings(self.folder), key=lambda t: t["trial"]))

    def __len__(self) -> int:
        return len(self.trials)

    @property
    def successes(self) -> int:
        """Number of successful trials."""
        return int(self.trials["success"].sum()) if len(self) else 0

    @property
    def rate(self) -> float:
        """Successes over trials; harness faults count as failures.

        Raises:
            ResultsError: when there is no trial yet.
        """
        self._not_empty()
        return self.successes / len(self)

    @property
    def interval(self) -> tuple[float, float]:
        """95 % Wilson score interval of the rate.

        Raises:
            ResultsError: when there is no trial yet.
        """
        from grasp_bench.runs.statistics import wilson

        self._not_empty()
        return wilson(self.successes, len(self))

    @property
    def outcomes(self) -> dict[str, int]:
        """How many trials ended in which way, most frequent first."""
        return {str(k): int(v) for k, v in self.trials["outcome"].value_counts().items()} if len(self) else {}

    @property
    def faults(self) -> int:
        """Trials that ended unstable, in a timeout or an error: the harness's fault or a crash."""
        return sum(self.outcomes.get(o, 0) for o in HARNESS_FAULTS)

    @property
    def figures(self) -> dict[str, Any]:
        """All that a report says of this run, as plain data."""
        from grasp_bench.report.table4 import summarise

        figures = summarise(self.folder)
        if figures is None:
            self._not_empty()
        assert figures is not None
        return figures

    def report(self) -> str:
        """Markdown: Table 4 of the paper with this run beside it, and how its trials ended."""
        from grasp_bench.report.table4 import build_report
        from grasp_bench.report.text import as_markdown

        return as_markdown(build_report([self.folder], self.folder))

    def write_report(
        self, out: str | os.PathLike[str] | None = None, objects: str | os.PathLike[str] | None = None
    ) -> Path:
        """One HTML file with figures and all trials, that opens in any browser without a network.

        Args:
            out: the file; ``report.html`` in the run's folder by default.
            objects: folder of the objects, if they are not the shipped ones.

        Returns:
            The file written.
        """
        from grasp_bench.report.html.page import write_html

        target = self.folder / "report.html" if out is None else Path(out)
        write_html([self.folder], target, self.folder, None if objects is None else Path(objects))
        return target

    def compare(self, other: Run) -> Comparison:
        """This run against ``other``, trial by trial; see :class:`Comparison`."""
        return Comparison.of(self, other)

    def _not_empty(self) -> None:
        if not len(self):
            raise ResultsError(f"{self.folder} holds no finished trial yet; run the same command again.")

    def __repr__(self) -> str:
        if not len(self):
            return f"<Run {self.folder}: {self.predictor}, no trial yet>"
        low, high = self.interval
        return (
            f"<Run {self.folder}: {self.predictor} lifted {self.successes}/{len(self)} = "
            f"{self.rate:.1%}, 95 % interval {low:.1%} – {high:.1%}>"
        )

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        head = f"<b>{html.escape(self.predictor)}</b> on {html.escape(self.info['scenario']['name'])}"
        if not len(self):
            return f"<p>{head}: no trial yet</p>"
        low, high = self.interval
        rows = "".join(
            f"<tr><td>{html.escape(o)}</td><td>{n}</td><td>{n / len(self):.1%}</td></tr>"
            for o, n in self.outcomes.items()
        )
        return (
            f"<p>{head}: {self.successes}/{len(self)} = {self.rate:.1%} "
            f"(95 % interval {low:.1%} – {high:.1%})</p>"
            f"<table><tr><th>Outcome</th><th>Trials</th><th>Share</th></tr>{rows}</table>"
        )


@dataclass(frozen=True)
class Comparison:
    """Two runs on the same trials, counted pairwise.

    Attributes:
        first, second: names of the predictors.
        both, first_only, second_only, neither: trials in which they succeeded.
        p_value: of McNemar's exact two-sided test: how often two equally good predictors would
            differ this much on these trials.
        differing: names of the objects on which exactly one succeeded, in trial order.
    """

    first: str
    second: str
    both: int
    first_only: int
    second_only: int
    neither: int
    p_value: float
    differing: tuple[str, ...]

    @classmethod
    def of(cls, first: Run, second: Run) -> Comparison:
        """Compare two runs whose trials have the same numbers, objects and seeds.

        Raises:
            ResultsError: when they do not, naming the first trial that differs.
        """
        from grasp_bench.runs.statistics import mcnemar

        keys = ["trial", "object", "seed"]
        for run in (first, second):
            run._not_empty()
        a, b = (r.trials[keys].reset_index(drop=True) for r in (first, second))
        if len(a) != len(b) or not a.equals(b):
            n = min(len(a), len(b))
            apart = (a[:n] != b[:n]).any(axis=1)
            where = int(apart.idxmax()) if apart.any() else n
            raise ResultsError(
                f"{first.folder} and {second.folder} did not try the same: they differ from "
                f"trial {where} on ({len(a)} and {len(b)} trials). Run both with the same "
                "objects, trials and seed."
            )
        one = first.trials["success"].to_numpy(bool)
        two = second.trials["success"].to_numpy(bool)
        only, other = int((one & ~two).sum()), int((two & ~one).sum())
        return cls(
            first.predictor,
            second.predictor,
            int((one & two).sum()),
            only,
            other,
            int((~one & ~two).sum()),
            mcnemar(only, other),
            tuple(first.trials["object"][one != two]),
        )

    @property
    def trials(self) -> int:
        """Number of pairs."""
        return self.both + self.first_only + self.second_only + self.neither

    @property
    def difference(self) -> float:
        """Rate of the first minus rate of the second."""
        return (self.first_only - self.second_only) / self.trials

    def __str__(self) -> str:
        return (
            f"On {self.trials} common trials {self.first} alone succeeded in {self.first_only} and "
            f"{self.second} alone in {self.second_only} ({self.difference:+.1%}, McNemar's exact "
            f"p = {self.p_value:.2g})."
        )
