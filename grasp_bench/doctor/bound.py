"""Whether the oracle's run is an upper bound: it lifts nearly everything, and no run of its trials more."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from grasp_bench.doctor.checks import Check, State
from grasp_bench.report.compare import SharedTrials
from grasp_bench.runs.info import RUN
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults

ORACLE = "oracle"
BEYOND = ("oracle-6dof",)
"""Controls that may lift what no grasp from above can, and so more than the oracle."""
LEAST_RATE = 899 / 900
"""What an upper bound lifts on single objects."""


def check_bound(folder: Path) -> list[Check]:
    """Check a run against those in the same folder of runs, if it is the oracle's; else return nothing."""
    run = RunResults(folder)
    if run.predictor != ORACLE or not len(run):
        return []
    beside = (RunResults(p.parent) for p in sorted(folder.resolve().parent.glob(f"*/{RUN}")))
    return [upper_bound(run, (other for other in beside if other.predictor not in BEYOND))]


def upper_bound(oracle: RunResults, others: Iterable[RunResults]) -> Check:
    """Check that a run of the oracle lifts at least 899 of 900, and at least as much as any other run.

    Args:
        oracle: the run.
        others: runs to hold it against; those of other trials are passed over.
    """
    apart = [run for run in others if len(run) and run.folder.resolve() != oracle.folder.resolve()]
    shared = SharedTrials([oracle, *apart])
    rivals = [(run, both) for i, run in enumerate(apart, 1) if (both := shared.common(0, i))]
    lifted = oracle.lifted
    better = [
        run.predictor
        for run, both in rivals
        if sum(_lifted(theirs) for _, theirs in both) > sum(_lifted(ours) for ours, _ in both)
    ]
    held = f"the oracle lifts {lifted.successes} of {lifted.trials}"
    if better:
        return Check("Upper bound", State.BAD, f"{held}, and {', '.join(better)} more of the same trials")
    against = f" and at least as much as {len(rivals)} others of these trials" if rivals else ""
    if lifted.rate < LEAST_RATE and not oracle.info.cluttered:
        lost = ", ".join(r.object for r in oracle.records if not r.success)
        return Check("Upper bound", State.NOTE, f"{held}{against}; no bound for {lost}")
    return Check("Upper bound", State.OK, f"{held}{against}: it is one")


def _lifted(record: TrialRecord) -> int:
    """Return how many objects a trial lifted; an episode of clutter may lift many."""
    return int(record.success) if record.clutter is None else record.clutter.cleared
