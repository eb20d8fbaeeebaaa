"""Pairs runs of two versions of the definition: ``python scripts/compare_versions.py EARLIER NOW``.

EARLIER and NOW hold the same runs, made with the two versions of grasp-bench:
``grasp-bench run --predictor NAME --seed N --out FOLDER/NAME-N``. Trials of the same seed, object and attempt
have the same pose in both versions; what a network sees of it has other noise.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from pathlib import Path

from grasp_bench.report.tables import TextTable, markdown, rate_cells
from grasp_bench.runs.folder import find_runs
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate, holm, mcnemar


def trials(root: Path) -> dict[str, dict[tuple[int, int], bool]]:
    """Whether each trial was a success, by predictor and by (seed, trial)."""
    found: dict[str, dict[tuple[int, int], bool]] = defaultdict(dict)
    for run in map(RunResults, find_runs(root)):
        found[run.predictor] |= {(run.info.seed, r.trial): r.success for r in run.records}
    return found


def compared(earlier: Path, now: Path) -> TextTable:
    """A row for each predictor that both folders hold, on the trials that both hold."""
    before, after = trials(earlier), trials(now)
    rows, p_values = [], []
    for name in sorted(set(before) & set(after)):
        common = sorted(set(before[name]) & set(after[name]))
        won = [(before[name][key], after[name][key]) for key in common]
        lost, gained = won.count((True, False)), won.count((False, True))
        p_values.append(mcnemar(lost, gained))
        old, new = (Rate(sum(pair[i] for pair in won), len(won)) for i in (0, 1))
        rows.append([name, f"{old.successes}/{old.trials}", *rate_cells(new), str(lost), str(gained)])
    for row, p, corrected in zip(rows, p_values, holm(p_values), strict=True):
        row += [f"{p:.2g}", f"{corrected:.2g}"]
    head = ("Predictor", "Version 1", "Version 2", "Rate", "95 % interval", "Lost", "Gained", "p", "p, Holm")
    return TextTable("", head, rows, numbers=range(1, len(head)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("earlier", type=Path)
    parser.add_argument("now", type=Path)
    arguments = parser.parse_args()
    print(markdown([compared(arguments.earlier, arguments.now)]))


if __name__ == "__main__":
    main()
