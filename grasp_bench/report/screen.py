"""A folder of runs on one screen: the run made last beside others, its failures, where to look next."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from grasp_bench.report.compare import SharedTrials
from grasp_bench.report.groups import DEVELOPED_ON, Group, grouped, is_control, leading, made_last
from grasp_bench.report.summary import Summary
from grasp_bench.report.table4 import PAPER, TITLE, Report, row_of
from grasp_bench.report.tables import RATE_HEAD, TextTable, rate_cells
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate

LINES = 25
"""Lines that the table may take, its head among them."""
HEAD = 6
"""Lines of its title, its head, which may be wrapped, and its rules."""
NAME = 28
"""Characters of a row's name."""
CONTROLS = 2
"""Controls that have a line at least."""
REASONS = 6
"""Ways to fail that are told with a reason."""
NAMES = 3
"""Objects, or predictors, that are named in a line."""
ROBOTS = "Rows of the paper are real robots with other objects: not comparable, and their intervals overlap."


def screen(folders: Sequence[Path], root: Path) -> list[TextTable]:
    """Return what to print of the runs in ``folders``, named by their paths below ``root``."""
    runs = [run for run in map(RunResults, folders) if len(run)]
    report = Report.of(runs, root)
    if not runs:
        return report.tables()
    names = [r.run for r in report.runs]
    mine = made_last(runs, names)
    lead, *rest = grouped(report.runs, mine)
    shown = leading([lead, *rest])
    table, left = _table(report.runs, runs, lead, shown, mine)
    rest = [g for g in rest if set(g.runs) - set(shown)]
    notes = [*_left(left), *(_folded(g, report.runs) for g in rest)]
    found = [table]
    if report.hands is not None:
        found.append(report.hands.table())
    if notes:
        found.append(TextTable("Also here", (), (), lead="\n".join(notes)))
    if mine is not None:
        found.append(_failures(runs[mine], report.runs[mine]))
    found.append(TextTable("Where to look next", (), (), lead="\n".join(_next(root, runs, mine))))
    return found


def _table(
    summaries: Sequence[Summary], runs: Sequence[RunResults], lead: Group, shown: list[int], mine: int | None
) -> tuple[TextTable, list[Summary]]:
    """Return the table, and the runs that it has no line for."""
    paper = PAPER if lead.of_the_paper else ()
    most = LINES - HEAD - len(paper)
    kept = _kept(shown, {i for i in shown if is_control(summaries[i].info.predictor)}, most, mine)
    pairs = {} if mine is None else {v.run: v for v in SharedTrials(runs).against(mine)}
    rows = [[_short(f"{row.system} (paper)"), *rate_cells(row.lifted), ""] for row in paper]
    for i in kept:
        run = summaries[i]
        p = "" if i not in pairs else f"{pairs[i].pairs.p_value:.2g}"
        mark = "▶ " if i == mine else "  "
        rows.append([mark + _short(row_of(run).name), *rate_cells(run.lifted), "yours" if i == mine else p])
    title = f"{TITLE}: {lead.title}" if lead.of_the_paper else lead.title
    note = ROBOTS if paper else ""
    if lead.of_the_paper and DEVELOPED_ON in lead.seeds:
        note += f" Seed {DEVELOPED_ON} was developed on: fresh seeds give the figures to quote."
    if any(i in pairs for i in kept):
        note += " p: McNemar's exact test against your run, on the trials in common."
    if {*kept} - {*lead.runs}:
        note += f" Others tried {_other(summaries[kept[-1]])}."
    head = ("System", *RATE_HEAD, "p")
    marked = frozenset(len(paper) + kept.index(i) for i in kept if i == mine)
    table = TextTable(
        title,
        head,
        rows,
        note=note.strip(),
        numbers=(1, 2, 3, 4),
        paper=frozenset(range(len(paper))),
        marked=marked,
    )
    return table, [summaries[i] for i in shown if i not in kept]


def _kept(shown: list[int], controls: set[int], most: int, mine: int | None) -> list[int]:
    """Choose ``most`` of the runs that are shown, in their order: mine, and the best of either kind.

    Without a control beside them the others' rates say little.
    """
    own = [i for i in shown if i not in controls]
    beside = sorted(controls, key=lambda i: (i != mine, shown.index(i)))
    places = most - min(CONTROLS, len(beside))
    if mine in own[places:]:
        own = [*own[: places - 1], mine]
    kept = {*own[:places]}
    kept.update(beside[: most - len(kept)])
    return [i for i in shown if i in kept]


def _other(run: Summary) -> str:
    return f"{run.planned} trials with seed {run.info.seed}"


def _short(name: str) -> str:
    return name if len(name) <= NAME else f"{name[: NAME - 1]}…"


def _left(runs: Sequence[Summary]) -> Iterator[str]:
    if runs:
        counted = _listed([f"{r.info.predictor} {_counts(r)}" for r in runs])
        yield f"{len(runs)} more of these trials: {counted}"


def _folded(group: Group, runs: Sequence[Summary]) -> str:
    """Return a group as one line."""
    members = [runs[i] for i in group.runs]
    if group.pooled:
        return (
            f"{group.title}: {_listed([f'{p} {_with_interval(rate)}' for p, rate in group.pooled.items()])}"
        )
    if group.scenario is None:
        best, worst = members[0], min(members, key=lambda r: r.lifted.rate)
        who = dict.fromkeys(r.info.predictor for r in members)
        return (
            f"{group.title}: {_listed(list(who))} {worst.lifted.rate:.1%} ({worst.info.scenario_label}) to "
            f"{best.lifted.rate:.1%} ({best.info.scenario_label})"
        )
    return f"{group.title}: {_listed([f'{r.info.predictor} {_counts(r)}' for r in members])}"


def _counts(run: Summary) -> str:
    return f"{run.lifted.successes}/{run.lifted.trials}"


def _with_interval(rate: Rate) -> str:
    counts, share, interval = rate_cells(rate)
    return f"{counts} = {share} ({interval})"


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - NAMES} more" if len(names) > NAMES else ""
    return ", ".join(names[:NAMES]) + more


def _failures(run: RunResults, told: Summary) -> TextTable:
    """Return how the trials of a run failed: each outcome with its commonest reason and some objects."""
    failed = [r for r in run.records if not r.success]
    by = Counter(r.outcome for r in failed).most_common()
    rows = [
        [str(outcome), str(count), _reason([r for r in failed if r.outcome is outcome])]
        for outcome, count in by
    ]
    title = f"{told.info.predictor} failed in {len(failed)} of {len(run)} trials"
    missing = f"; {told.missing} of {told.planned} are still to be done" if told.missing > 0 else ""
    return TextTable(
        title + missing,
        ("Outcome", "Trials", "Why, and at what") if rows else (),
        rows[:REASONS],
        numbers=(1,),
    )


def _reason(failed: Sequence[TrialRecord]) -> str:
    """Return the reason that most of some trials have, numbers apart, and the first objects."""
    plain = Counter(re.sub(r"-?\d+(\.\d+)?", "#", r.detail) for r in failed)
    most = plain.most_common(1)[0][0]
    first = next(r for r in failed if re.sub(r"-?\d+(\.\d+)?", "#", r.detail) == most)
    objects = list(dict.fromkeys(r.object for r in failed))
    return f"{first.detail + ': ' if first.detail else ''}{_listed(objects)}"


def _next(root: Path, runs: Sequence[RunResults], mine: int | None) -> Iterator[str]:
    """Yield what to do now: what for, and the command."""
    yield f"Pictures, charts and every trial:\n  grasp-bench report {root} --format html"
    failed = None if mine is None else next((r for r in runs[mine].records if not r.success), None)
    if mine is None:
        yield "A run of your own beside these:\n  grasp-bench run --objects all --trials 180"
    elif failed is not None:
        film = f"grasp-bench replay {runs[mine].folder} --trial {failed.trial} --video trial.gif"
        yield f"One of the failures as a film:\n  {film}"
    if len(runs) > 1:
        yield f"How the trials of every run ended:\n  grasp-bench report {root} --all"
