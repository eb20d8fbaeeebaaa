"""What a study of failures tells: a sentence, a table, examples with their pages, and plain data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from grasp_bench.errors import GraspBenchError
from grasp_bench.report.tables import TextTable
from grasp_bench.studies.why.attribution import UNEXPLAINED, Explanation, named
from grasp_bench.studies.why.explain import Study

EXAMPLES = 2
"""Trials that are named for each cause in the terminal."""
IN_SENTENCE = 4
"""Causes in the sentence that sums up."""


class Pages:
    """Addresses of trials' pages in an HTML report.

    Args:
        folder: the run's folder.
        page: the report; the one that `grasp-bench report FOLDER --format html` writes by default.

    Raises:
        GraspBenchError: for a report that is not in the run's folder or above it.
    """

    def __init__(self, folder: Path, page: Path | None = None) -> None:
        self.page = page or folder / "report.html"
        inside, root = folder.resolve(), self.page.parent.resolve()
        if not inside.is_relative_to(root):
            raise GraspBenchError(
                f"{self.page} is no report of {folder}: it lies beside that folder, not in it or above it."
            )
        self._run = folder.name if inside == root else inside.relative_to(root).as_posix()

    def of(self, trial: int) -> str:
        """Return the address of a trial's page."""
        return f"{self.page}#{quote(self._run, safe=_AS_BROWSERS)}/{trial}"


_AS_BROWSERS = "!'()*~"
"""What encodeURIComponent leaves as it is, beside letters, digits and ``-_.``."""


def sentence(study: Study) -> str:
    """Return the study in one sentence: ``41 % of your losses are width, 22 % calibration.``"""
    count = len(study.explained)
    if not study.failed:
        return f"None of {study.done} trials failed: there is nothing to explain."
    if not count:
        return f"None of {study.failed} failures could be explained."
    titles = _titles(study)
    parts = [
        f"{share / count:.0%}".replace("%", " %") + f"{' of your losses are' if i == 0 else ''} {titles[key]}"
        for i, (key, share) in enumerate(list(study.shares.items())[:IN_SENTENCE])
    ]
    return ", ".join(parts) + f" ({count} of {study.failed} failures explained)."


def tables(study: Study) -> list[TextTable]:
    """Return what the failures fall to, and what is not told."""
    count, titles = len(study.explained), _titles(study)
    instead = {c.key: c.instead for c in study.causes} | {
        UNEXPLAINED: "no one or two of these changes save the trial"
    }
    rows = []
    for key, share in study.shares.items():
        own = [e for e in study.explained if study.first(e) == key]
        shown = [titles[key], f"{share:.1f}", f"{share / count:.0%}", f"{len(own)}/{count}", instead[key]]
        rows.append(shown)
    gaps = " ".join(notes(study))
    if not rows:
        return [TextTable(sentence(study), (), [], lead=gaps)]
    return [
        TextTable(
            f"Why trials of {study.folder.name} failed",
            ("Lost to", "Failures", "Share", "Named first", "Saved where"),
            rows,
            lead=sentence(study),
            note="Failures: each counts 1, shared evenly among the first sets of changes that save it, and "
            f"among the causes of a set. Named first: the cause with the greatest share. {gaps}".strip(),
            numbers=(1, 2, 3),
        )
    ]


def examples(study: Study, pages: Pages) -> list[str]:
    """Return a line for each of some trials: how it ended, what saves it, and the address of its page."""
    return [
        f"Trial {e.trial}, {e.object}, {e.outcome}: {_sets(study, e)}\n  {pages.of(e.trial)}"
        for key in study.shares
        for e in _examples(study, key)
    ]


def notes(study: Study) -> list[str]:
    """Return what the study does not tell, in sentences."""
    said = []
    if study.done < study.planned:
        said.append(f"The run is not finished: {study.done} of {study.planned} trials are done.")
    for why in dict.fromkeys(study.left_out.values()):
        trials = [t for t, words in study.left_out.items() if words == why]
        shown = ", ".join(map(str, trials[:5])) + (" …" if len(trials) > 5 else "")
        said.append(f"Left out: {len(trials)} (trial {shown}): {why}.")
    if study.rounded:
        said.append(
            f"{len(study.rounded)} trials came out as recorded only within rounding, as on another processor."
        )
    if study.broken:
        shown = ", ".join(map(str, list(study.broken)[:5])) + (" …" if len(study.broken) > 5 else "")
        said.append(
            f"{sum(study.broken.values())} replays of {len(study.broken)} trials ({shown}) could not be "
            "done, and count as not saved."
        )
    if study.damaged:
        said.append(f"{study.damaged} damaged lines of the replays' file were passed over.")
    return said


def to_json(study: Study, pages: Pages) -> dict[str, Any]:
    """Return plain data."""
    count = len(study.explained)
    return {
        "format": 1,
        "kind": "why",
        "run": str(study.folder),
        "predictor": study.run.predictor,
        "scenario": study.run.scenario_name,
        "trials": study.done,
        "planned": study.planned,
        "failures": study.failed,
        "explained": count,
        "causes": [
            {
                "key": key,
                "lost_to": _titles(study)[key],
                "failures": round(share, 6),
                "share": round(share / count, 6),
                "named_first": sum(study.first(e) == key for e in study.explained),
            }
            for key, share in study.shares.items()
        ],
        "explanations": [
            {
                "trial": e.trial,
                "object": e.object,
                "outcome": e.outcome,
                "first": study.first(e),
                "sets": named(e.sets),
                "credit": {k: round(v, 6) for k, v in e.credit.items()},
                "replays": e.replays,
                "page": pages.of(e.trial),
            }
            for e in study.explained
        ],
        "left_out": {str(trial): why for trial, why in study.left_out.items()},
        "within_rounding": list(study.rounded),
        "broken_replays": {str(trial): count for trial, count in study.broken.items()},
    }


def _titles(study: Study) -> dict[str, str]:
    return {c.key: c.loss for c in study.causes} | {UNEXPLAINED: "none of these"}


def _examples(study: Study, key: str) -> list[Explanation]:
    """Return trials of which a cause is named first, those that fall to it most first."""
    own = [e for e in study.explained if study.first(e) == key]
    return sorted(own, key=lambda e: (-e.credit[key], e.trial))[:EXAMPLES]


def _sets(study: Study, explanation: Explanation) -> str:
    titles = _titles(study)
    said: Sequence[str] = [" and ".join(titles[k] for k in keys) for keys in named(explanation.sets)]
    return "saved without " + ", or ".join(said) if said else "none of these"
