"""The paper's Table 4 with our runs beside it, and how their trials ended."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grasp_bench.report.clutter import attempts_in_words, clutter_table, in_words
from grasp_bench.report.difficulty import difficulty_table
from grasp_bench.report.firmness import FirmnessPair, compare_firmness, firmness_table, pairs_table
from grasp_bench.report.groups import Group, beside_the_paper, grouped, is_control
from grasp_bench.report.hands import Hands
from grasp_bench.report.help import Merit, merit_table, merits
from grasp_bench.report.paper import TABLE_4
from grasp_bench.report.summary import Summary, worst_objects
from grasp_bench.report.tables import RATE_HEAD, TextTable, rate_cells
from grasp_bench.report.trust import trust_table
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate

TITLE = "Table 4, re-measured"
ROBOTS = (
    "are real-robot results as printed in Table 4 of the HTC-Grasp paper: other "
    "robots, other objects, other success rules. They are not directly comparable with the simulated "
    "rows, nor with each other: their 95 % Wilson intervals all overlap, so no order can be "
    "claimed from them."
)
NOTE = f"Rows marked “paper” {ROBOTS} 110/120 is 91.7 %, where the paper prints 92.0 %."


@dataclass(frozen=True)
class Row:
    """A row of Table 4.

    Attributes:
        authors, system: who tried what.
        lifted: successes among trials.
        printed_rate: rate printed in the paper [%]; None for a run of ours.
        run: name of the run; None for a row of the paper.
        control: whether it is a control.
    """

    authors: str
    system: str
    lifted: Rate
    printed_rate: float | None = None
    run: str | None = None
    control: bool = False

    @property
    def name(self) -> str:
        """The system's name as tables show it."""
        return f"{self.system} (control)" if self.control else self.system

    @property
    def source(self) -> str:
        """``paper`` or ``simulation``."""
        return "paper" if self.run is None else "simulation"

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "authors": self.authors,
            "system": self.system,
            **self.lifted.to_json(),
            "printed_rate": self.printed_rate,
            "source": self.source,
            "run": self.run,
        }


PAPER = tuple(
    Row(row.authors, row.system, Rate(row.successes, row.trials), row.printed_rate) for row in TABLE_4
)


@dataclass(frozen=True)
class Report:
    """Figures of several runs, and of each predictor with and without the planner's help."""

    runs: tuple[Summary, ...]
    merits: tuple[Merit, ...] = ()
    pairs: tuple[FirmnessPair, ...] = ()
    hands: Hands | None = None

    @classmethod
    def of(cls, runs: Iterable[RunResults], root: Path | None = None) -> Report:
        """Return the report of all runs that hold a trial, named by their paths below ``root``."""
        begun = [run for run in runs if len(run)]
        summaries = tuple(Summary.of(run, root) for run in begun)
        return cls(summaries, tuple(merits(begun)), tuple(compare_firmness(begun)), Hands.of(begun))

    @property
    def rows(self) -> list[Row]:
        """Table 4: the paper's rows, and one for each run of the scenario that stands beside them."""
        return [*PAPER, *(row_of(r) for r in self.runs if beside_the_paper(r.info))]

    @property
    def groups(self) -> list[Group]:
        """The runs grouped by what they tried."""
        return grouped(self.runs)

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "note": NOTE,
            "runs": [run.to_json() for run in self.runs],
            "table4": [row.to_json() for row in self.rows],
            "merit": [merit.to_json() for merit in self.merits],
            "robots": None if self.hands is None else self.hands.to_json(),
            "firmer": [pair.to_json() for pair in self.pairs],
            "groups": [{"title": g.title, "runs": [self.runs[i].run for i in g.runs]} for g in self.groups],
        }

    def tables(self) -> list[TextTable]:
        """Return a table for each group of runs, one with the paper's rows, and how all runs ended."""
        groups = self.groups
        titled = next((g for g in groups if g.of_the_paper), None)
        order = [self.runs[i] for g in groups for i in g.runs]
        merit = [merit_table(self.merits)] if self.merits else []
        told = [(r.run, r.firmness) for r in self.runs if r.firmness is not None]
        firm = [firmness_table(told)] if told else []
        firm += [pairs_table([r.run for r in self.runs], self.pairs)] if self.pairs else []
        cleared = [(r.run, r.clutter) for r in self.runs if r.clutter is not None]
        firm += [clutter_table(cleared)] if cleared else []
        hard = [(r.run, r.managed) for r in self.runs if r.managed is not None]
        firm += [difficulty_table(hard)] if hard else []
        trust = [trust_table([(r.run, r.trust) for r in order])] if order else []
        tables = (self._table(g, g is titled) for g in groups)
        hands = [self.hands.table()] if self.hands is not None else []
        return [*tables, *hands, *merit, *firm, *trust, *map(endings, order)]

    def _table(self, group: Group, titled: bool) -> TextTable:
        runs = [self.runs[i] for i in group.runs]
        rows, sources = [row_of(r) for r in runs], [_source(r, group) for r in runs]
        for predictor, rate in group.pooled.items():
            rows.append(Row("grasp-bench", f"{predictor}, together", rate, run=""))
            sources.append("")
        if not titled:
            return table_4(rows, {"Source": sources}, group.title, "")
        sources = ["paper, real robot"] * len(PAPER) + sources
        return table_4([*PAPER, *rows], {"Source": sources}, f"{TITLE}: {group.title}")


def row_of(run: Summary) -> Row:
    """Return the row of a run."""
    predictor = run.info.predictor
    return Row("grasp-bench", predictor, run.lifted, run=run.run, control=is_control(predictor))


def _source(run: Summary, group: Group) -> str:
    """Return where a row comes from, with what its group's title does not say."""
    if group.alike:
        return run.run
    return f"{run.run}: {run.info.scenario_label}, seed {run.info.seed}"


def build_report(folders: Iterable[Path], root: Path | None = None) -> Report:
    """Return the report of the runs in ``folders``, named by their paths below ``root``."""
    return Report.of(map(RunResults, folders), root)


def table_4(
    rows: Sequence[Row],
    more: dict[str, list[str]],
    title: str = TITLE,
    note: str = NOTE,
    numbers: Sequence[int] = (),
) -> TextTable:
    """Return Table 4.

    Args:
        rows: the paper's rows, and ours below them.
        more: further columns by their heads, a cell for each row.
        title, note: text above and below the table.
        numbers: which of the further columns hold numbers.
    """
    head = ("Authors", "System", *RATE_HEAD, "Printed")
    cells = [
        [
            row.authors,
            row.name,
            *rate_cells(row.lifted),
            "" if row.printed_rate is None else f"{row.printed_rate:.1f} %",
            *(column[i] for column in more.values()),
        ]
        for i, row in enumerate(rows)
    ]
    return TextTable(
        title,
        (*head, *more),
        cells,
        note=note,
        numbers=(2, 3, 4, 5, *(len(head) + i for i in numbers)),
        paper=frozenset(i for i, row in enumerate(rows) if row.run is None),
    )


def endings(run: Summary) -> TextTable:
    """Return how the trials of a run ended."""
    partial = f", {run.missing} to go" if run.missing else ""
    info, trials = run.info, run.lifted.trials
    lead = ""
    if run.clutter is not None:
        lead = (
            f"Clutter, {run.clutter.episodes} tables: {in_words(run.clutter)}. Lifted, by the number of the "
            f"attempt: {attempts_in_words(run.clutter)}. Outcomes of whole tables:"
        )
    worst = ", ".join(f"{name} {o.successes}/{o.trials}" for name, o in worst_objects(run.by_object))
    return TextTable(
        f"{run.run}: {info.predictor} on {info.scenario_label}, seed {info.seed}, {info.renderer}{partial}",
        ("Outcome", "Trials", "Share"),
        [[outcome, str(count), f"{count / trials:.1%}"] for outcome, count in run.outcomes.items()],
        lead=lead,
        note=f"Hardest objects: {worst or 'none failed'}",
        numbers=(1, 2),
        level=3,
    )
