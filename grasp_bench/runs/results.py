"""The results of a run as a Python object."""

from __future__ import annotations

import os
from collections import Counter
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from grasp_bench.errors import ResultsError
from grasp_bench.runs.folder import load_records, load_run, load_timings
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.record import NESTED, TrialRecord
from grasp_bench.runs.statistics import Rate
from grasp_bench.scenario.outcomes import HARNESS_FAULTS

if TYPE_CHECKING:
    import pandas as pd


class RunResults:
    """The results of a run, read from its folder when first asked for.

    Args:
        folder: folder with ``run.json`` and ``trials.jsonl``.

    Attributes:
        folder: path of the folder.
        info: the content of ``run.json``: predictor, whole scenario, seed, versions, hashes.

    Raises:
        ResultsError: for a folder that holds no run, or a damaged one.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)
        self.info: RunInfo = load_run(self.folder)

    @property
    def predictor(self) -> str:
        """Name or Python path of the predictor."""
        return self.info.predictor

    @cached_property
    def records(self) -> list[TrialRecord]:
        """Records of all trials, in trial order."""
        return load_records(self.folder)

    @cached_property
    def trials(self) -> pd.DataFrame:
        """One row a trial, in trial order.

        Columns as in docs/results-format.md, the nested ones spread: ``grasp_x``, ``grasp_y``,
        ``grasp_width`` [px], ``grasp_angle`` [rad], ``grasp_quality``, ``pose_position`` (3) [m],
        ``pose_rotation`` (3 × 3), ``pose_opening`` [m], ``tcp_error_position`` [m],
        ``tcp_error_angle`` [rad]; None or NaN where a trial did not come that far.
        """
        import pandas as pd

        table = pd.DataFrame([record.to_json() for record in self.records])
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

        return pd.DataFrame([timings.to_json() for timings in load_timings(self.folder)])

    def __len__(self) -> int:
        return len(self.records)

    @property
    def successes(self) -> int:
        """Number of successful trials."""
        return sum(record.success for record in self.records)

    @property
    def lifted(self) -> Rate:
        """Successes among trials; harness faults count as failures.

        Raises:
            ResultsError: when there is no trial yet.
        """
        self.check_not_empty()
        return Rate(self.successes, len(self))

    @property
    def rate(self) -> float:
        """Successes over trials.

        Raises:
            ResultsError: when there is no trial yet.
        """
        return self.lifted.rate

    @property
    def interval(self) -> tuple[float, float]:
        """95 % Wilson score interval of the rate.

        Raises:
            ResultsError: when there is no trial yet.
        """
        return self.lifted.interval

    @property
    def outcomes(self) -> dict[str, int]:
        """Number of trials by outcome, most frequent first."""
        return {str(o): n for o, n in Counter(r.outcome for r in self.records).most_common()}

    @property
    def faults(self) -> int:
        """Trials that ended unstable, in a timeout or an error: the harness's fault or a crash."""
        return sum(self.outcomes.get(o, 0) for o in HARNESS_FAULTS)

    def check_not_empty(self) -> None:
        """Raise ResultsError when there is no trial yet."""
        if not len(self):
            raise ResultsError(f"{self.folder} holds no finished trial yet; run the same command again.")
