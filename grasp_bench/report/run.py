"""A run: its results, and the reports made of them."""

from __future__ import annotations

import html
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grasp_bench.report.summary import Summary
from grasp_bench.report.table4 import Report
from grasp_bench.report.tables import markdown
from grasp_bench.runs.comparison import Comparison
from grasp_bench.runs.results import RunResults

if TYPE_CHECKING:
    from grasp_bench.report.notebook import TrialView


class Run(RunResults):
    """A run, finished or interrupted: its trials, rate and reports; see :class:`RunResults` for the results.

    Args:
        folder: folder with ``run.json`` and ``trials.jsonl``.

    Raises:
        ResultsError: for a folder that holds no run, or a damaged one.
    """

    @property
    def figures(self) -> dict[str, Any]:
        """All that a report says of this run, as plain data."""
        return Summary.of(self).to_json()

    def report(self) -> str:
        """Return Markdown: Table 4 of the paper with this run beside it, and how its trials ended."""
        return markdown(Report.of([self]).tables())

    def write_report(
        self, out: str | os.PathLike[str] | None = None, objects: str | os.PathLike[str] | None = None
    ) -> Path:
        """Write one HTML file with figures and all trials, that opens in any browser without a network.

        Args:
            out: file to write; ``report.html`` in the run's folder by default.
            objects: folder of the objects, if they are not the shipped ones.

        Returns:
            The file written.
        """
        from grasp_bench.report.html.page import write_html

        target = self.folder / "report.html" if out is None else Path(out)
        write_html([self.folder], target, self.folder, None if objects is None else Path(objects))
        return target

    def show(self, trial: int, attempt: int | None = None) -> TrialView:
        """Return a trial to be looked at: in a notebook its pictures and numbers, elsewhere text.

        Args:
            trial: its number.
            attempt: of an episode of clutter, which attempt; the last by default.

        Raises:
            ResultsError: for a trial or an attempt that the run does not hold.
        """
        from grasp_bench.report.notebook import TrialView

        return TrialView.of(self, trial, attempt)

    def compare(self, other: RunResults) -> Comparison:
        """Compare this run with ``other``, trial by trial; see :class:`Comparison`."""
        return Comparison.of(self, other)

    def __repr__(self) -> str:
        if not len(self):
            return f"<Run {self.folder}: {self.predictor}, no trial yet>"
        low, high = self.interval
        return (
            f"<Run {self.folder}: {self.predictor} lifted {self.successes}/{len(self)} = "
            f"{self.rate:.1%}, 95 % interval {low:.1%} – {high:.1%}>"
        )

    def _repr_html_(self) -> str:
        """Return what a notebook shows: how trials ended, and the failures in small."""
        from grasp_bench.report.notebook import failures

        head = f"<b>{html.escape(self.predictor)}</b> on {html.escape(self.info.scenario_label)}"
        if not len(self):
            return f"<p>{head}: no trial yet</p>"
        rows = "".join(
            f"<tr><td>{html.escape(o)}</td><td>{n}</td><td>{n / len(self):.1%}</td></tr>"
            for o, n in self.outcomes.items()
        )
        return (
            f"<p>{head}: {self.lifted}</p>"
            f"<table><tr><th>Outcome</th><th>Trials</th><th>Share</th></tr>{rows}</table>{failures(self)}"
        )
