"""Rows of the leaderboard: runs of the reference scenario that are consistent, checked one by one.

A checked folder proves that its files agree with each other and with the shipped benchmark, not
that they were measured; ``grasp-bench doctor`` reruns trials of it to see that.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from grasp_bench.errors import GraspBenchError, ResultsError, ScenarioError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.names import parse
from grasp_bench.predictors.shipped import SHIPPED
from grasp_bench.report.tables import Markdown, TextTable, escaped, markdown, rate_cells
from grasp_bench.runs.folder import TRIALS
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.lines import read_lines
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.system.files import read_text
from grasp_bench.system.texts import legible_all
from grasp_bench.system.yaml_text import read_yaml

ABOUT = "about.yaml"
SCENARIO = "table4"
SEED = 0
HEAD = ("Predictor", "Authors", "Lifted", "Rate", "95 % interval", "Harness faults", "Trained on")


class About(BaseModel):
    """Who made the predictor and what it was trained on: ``about.yaml`` beside the run.

    Attributes:
        name, authors: as they appear in the table.
        trained_on: data sets, and how much of them; ``nothing`` for a method that learns nothing.
        link: paper, code or model card.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(min_length=1, max_length=60)
    authors: str = Field(min_length=1, max_length=120)
    trained_on: str = Field(min_length=1, max_length=300)
    link: str = Field(default="", max_length=300, pattern=r"^(https?://[^\s<>|\"`\\]+)?$")


@dataclass(frozen=True)
class Check:
    """One condition of a row, and whether a run meets it."""

    what: str
    fault: str = ""

    @property
    def passed(self) -> bool:
        """Whether there is no fault."""
        return not self.fault


@dataclass(frozen=True)
class Row:
    """A run in the table.

    Attributes:
        about: name, authors, training.
        control: whether it is one of the benchmark's own bounds.
        lifted: successes among its trials.
        faults: number of trials that ended unstable, in a timeout or an error; failures, too.
    """

    about: About
    control: bool
    lifted: Rate
    faults: int


def read_about(folder: Path, run: RunInfo) -> About:
    """Read ``about.yaml``; of a shipped predictor without one, return what is known of it.

    Raises:
        ResultsError: when it is missing for any other predictor, or not as it must be.
    """
    path = folder / ABOUT
    if not path.is_file():
        if (shipped := SHIPPED.get(run.predictor)) is None:
            raise ResultsError(f"{path} is missing: say name, authors, trained_on and, if there is one, link")
        trained = "nothing" if shipped.weights is None else f"see {shipped.weights.card}"
        return About(name=run.predictor, authors="grasp-bench", trained_on=trained)
    try:
        return About.model_validate(legible_all(read_yaml(read_text(path))))
    except OSError as error:
        raise ResultsError(f"{path} cannot be read ({error.strerror})") from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the file"
        raise ResultsError(f"{path}: {where}: {first['msg']}") from error
    except ValueError as error:
        raise ResultsError(f"{path} is not valid YAML: {error}") from error


def check(folder: Path) -> list[Check]:
    """Check all conditions of a row, in the order of docs/leaderboard.md.

    Raises:
        ResultsError: when the folder holds no run, or one that cannot be read.
    """
    run = RunResults(folder).info
    records = read_lines(folder / TRIALS)
    return [
        Check("about.yaml names predictor, authors and training data", _about_fault(folder, run)),
        Check(f"the scenario is {SCENARIO}, seed {SEED}, ray caster", _setting_fault(run)),
        Check("the objects are the shipped ones, unchanged", _objects_fault(run)),
        Check("every trial is there, once and in order", _trials_fault(run, records)),
        Check("every record agrees with itself", _record_fault(records)),
        Check("the shipped weights are unchanged", _weights_fault(run)),
        Check("the predictor had a process of its own, or is shipped", _process_fault(run)),
    ]


def load_row(folder: Path) -> Row:
    """Return the row of a run; ResultsError names the first condition that it does not meet."""
    for condition in check(folder):
        if not condition.passed:
            raise ResultsError(f"{folder} cannot be a row: {condition.fault}.")
    run = RunResults(folder)
    shipped = SHIPPED.get(run.predictor)
    control = shipped is not None and shipped.kind == "control"
    return Row(read_about(folder, run.info), control, run.lifted, run.faults)


def _cells(row: Row) -> list[str]:
    about, name = row.about, escaped(row.about.name)
    if about.link:
        name = f"[{name}](<{about.link}>)"
    if row.control:
        name = f"*{name}* (control)"
    return [Markdown(name), about.authors, *rate_cells(row.lifted), str(row.faults), about.trained_on]


def as_markdown(rows: list[Row]) -> str:
    """Return the leaderboard as a Markdown table: contestants by rate, then the controls.

    The order of rows whose intervals overlap means nothing: it is that of the counts.
    """
    ordered = sorted(rows, key=lambda r: (r.control, -r.lifted.rate, r.about.name))
    return markdown([TextTable("", HEAD, list(map(_cells, ordered)), numbers=(2, 3, 4, 5))]).rstrip()


def _about_fault(folder: Path, run: RunInfo) -> str:
    try:
        read_about(folder, run)
    except ResultsError as error:
        return str(error)
    return ""


def _setting_fault(run: RunInfo) -> str:
    try:
        given = run.parsed().model_dump()
    except ScenarioError as error:
        return str(error)
    expected = load_scenario(SCENARIO).model_dump()
    differing = [k for k in expected if k != "description" and expected[k] != given[k]]
    if differing:
        return f"its scenario differs from {SCENARIO} in {', '.join(differing)}"
    if run.seed != SEED:
        return f"its seed is {run.seed}, not {SEED}"
    if run.renderer != "raycast":
        return f"its images were made by {run.renderer!r}, not by raycast"
    return ""


def _objects_fault(run: RunInfo) -> str:
    catalog = Catalog()
    shipped = {name: catalog.entries[name]["files"] for name in catalog.names}
    given = run.objects
    missing = [n for n in shipped if n not in given]
    if missing:
        return f"{len(missing)} of {len(shipped)} objects were not tried, such as {missing[0]}"
    if list(given) != list(shipped):
        return "the objects were not tried in the manifest's order"
    changed = [n for n in shipped if given[n] != shipped[n]]
    return f"{len(changed)} objects differ from the shipped ones, such as {changed[0]}" if changed else ""


def _trials_fault(run: RunInfo, records: list[TrialRecord]) -> str:
    names, planned = list(run.objects), run.trials
    if not names or planned % len(names):
        return f"{planned} trials cannot be spread evenly over {len(names)} objects"
    if [r.trial for r in records] != list(range(planned)):
        return (
            f"it holds {len(records)} of {planned} trials, or not in order; the same command again "
            "finishes it"
        )
    wrong = [r.trial for r in records if (r.object, r.seed) != (names[r.trial % len(names)], run.seed)]
    return f"trial {wrong[0]} names another object or seed than the run" if wrong else ""


def _record_fault(records: list[TrialRecord]) -> str:
    lift = load_scenario(SCENARIO).success.minimum_lift
    for r in records:
        held = r.grasp and r.pose and r.lift_height >= lift and r.contact_force > 0 and r.sim_steps > 0
        if r.success and not held:
            return f"trial {r.trial} is a success without grasp, lift or contact force"
    return ""


def _process_fault(run: RunInfo) -> str:
    try:
        apart = parse(run.predictor).apart
    except GraspBenchError:  # an installed package's, not installed here
        apart = False
    if apart is None or (apart and run.apart is True):
        return ""
    return (
        "within the harness's process a predictor can read the truth from its caller's frame; run it by "
        "'cmd: grasp-bench serve NAME --port {port}' or at an address"
    )


def _weights_fault(run: RunInfo) -> str:
    shipped = SHIPPED.get(run.predictor)
    if shipped is None or (weights := shipped.weights) is None:
        return ""
    given = (run.weights or {}).get(weights.name)
    return "" if given == weights.digest else f"it ran with other weights than the shipped {weights.name}"
