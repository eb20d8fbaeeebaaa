"""The last lines of a run: how its trials ended, why most that failed did, and what to try."""

from __future__ import annotations

import re
import shlex
from collections import Counter

from grasp_bench.predictors.shipped import SHIPPED
from grasp_bench.runs.folder import ERRORS
from grasp_bench.runs.results import RunResults
from grasp_bench.system.texts import legible


def ending(run: RunResults) -> list[str]:
    """Return lines on a run that holds a trial: its outcomes, the commonest reason, where to look next."""
    lines = ["Outcomes: " + ", ".join(f"{outcome} {count}" for outcome, count in run.outcomes.items()) + "."]
    failed = [r for r in run.records if not r.success]
    # The same reason with other numbers in it is the same reason.
    kinds = Counter((r.outcome, re.sub(r"[0-9]+", "#", r.detail)) for r in failed if r.detail)
    if kinds:
        (outcome, kind), count = kinds.most_common(1)[0]
        example = next(r for r in failed if r.outcome == outcome and re.sub(r"[0-9]+", "#", r.detail) == kind)
        words = legible(" ".join(example.detail.split()), 300)
        which = "Most failures" if 2 * count > len(failed) else "Commonest failure"
        lines.append(f"{which} ({count} of {len(failed)}): {outcome}: {words} (trial {example.trial})")
    if (run.folder / ERRORS).is_file():
        lines.append(f"Tracebacks of the predictor: {run.folder / ERRORS}")
    if not run.successes:
        lines.append(_hint(run))
    return lines


def _hint(run: RunResults) -> str:
    name, folder = shlex.quote(run.predictor), shlex.quote(str(run.folder))
    hint = "Nothing was lifted. "
    if not run.predictor.startswith("__main__:") and run.predictor not in SHIPPED:
        hint += (
            f"`grasp-bench predictors check {name}` finds the usual slips: x and y exchanged, degrees, "
            "fractions, metres. "
        )
    return hint + f"`grasp-bench report {folder} --format html` shows every trial."
