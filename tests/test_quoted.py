"""What README and documentation quote: figures are those of the runs, and words are true of them."""

from __future__ import annotations

import re
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType

import pytest
from committed import RESULTS
from PIL import Image

from grasp_bench.doctor.bound import check_bound
from grasp_bench.doctor.checks import State
from grasp_bench.media.store import CLIP_SIZE
from grasp_bench.report.accuracy import ablation_table, accuracy_table
from grasp_bench.report.since import since_table
from grasp_bench.report.table4 import build_report
from grasp_bench.report.tables import escaped, markdown
from grasp_bench.runs.folder import find_runs, load_run
from grasp_bench.studies.bench_table import compare, read_evaluations, run_folders, tables

ROOT = Path(__file__).parents[1]
KINDS = ("as-predicted", "baseline", "graded", "reference", "seeds", "seeds-as-predicted", "suites")
FRONT = ("README.md", "docs/index.md", "docs/leaderboard.md", "docs/results.md")

pytestmark = pytest.mark.skipif(
    (ROOT / "PKG-INFO").is_file(), reason="an sdist holds no pictures and no runs"
)


def text(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def between(page: str, marker: str) -> str:
    """What ``scripts/make_tables.py`` wrote into a page."""
    found = re.search(rf"<!-- {marker} -->\n(.*?)<!-- /{marker} -->", text(page), re.DOTALL)
    assert found, f"{page} has no marker {marker}"
    return found[1].strip()


@pytest.fixture(scope="module")
def make_tables() -> ModuleType:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "scripts")
        sys.modules.pop("make_tables", None)
        import make_tables

    return make_tables


# ---------------------------------------------------------------- the figure to quote


@pytest.mark.parametrize("page", FRONT)
def test_the_figure_to_quote_is_that_of_fresh_seeds(page: str, make_tables: ModuleType) -> None:
    assert between(page, "headline") == make_tables.headline()
    seeds = {
        load_run(run).seed for kind in ("seeds", "seeds-as-predicted") for run in find_runs(RESULTS / kind)
    }
    assert seeds == {5, 6, 7, 8, 9}, "planner and networks were developed on 0 to 4"


@pytest.mark.parametrize("page", [p for p in FRONT if p != "docs/index.md"])
def test_seed_0_is_marked_as_the_development_seed(page: str) -> None:
    told = " ".join(text(page).split())
    assert re.search(r"Seed 0[^.]*\*\*development seed|\*\*Seed 0[^.]*development seed\*\*", told)


def test_the_table_of_readme_is_that_of_the_runs(make_tables: ModuleType) -> None:
    reference = RESULTS / "reference"
    merits = build_report([*find_runs(reference), *find_runs(RESULTS / "as-predicted")]).merits
    table, *_ = build_report(find_runs(reference), reference).tables()
    assert between("README.md", "table4") == markdown([make_tables.with_predicted(table, merits)]).strip()


def test_the_leaderboard_is_that_of_the_runs_and_of_shipped_weights(make_tables: ModuleType) -> None:
    assert between("docs/leaderboard.md", "leaderboard") == make_tables.leaderboard().strip()


def test_misprints_and_later_detectors_are_told_where_the_papers_tables_are() -> None:
    page = text("docs/results.md")
    for table in (accuracy_table("cornell", []), accuracy_table("jacquard", []), ablation_table([])):
        assert escaped(table.note) in page
    for row in since_table().rows:
        assert f"| {' | '.join(map(escaped, row))} |" in page


def test_published_accuracy_stands_beside_what_was_measured() -> None:
    evaluations = read_evaluations(RESULTS / "evaluation")
    found = tables(compare(run_folders(RESULTS / "reference")), evaluations)
    (published,) = (table for table in found if table.title.startswith("Published"))
    assert markdown([published]).strip() in text("docs/results.md")


def test_other_counts_of_180_in_prose_are_named_as_what_they_are() -> None:
    """A perfect score on the development seed is the oracle's at most, outside of the tables."""
    for page in ("README.md", "docs/index.md", "docs/getting-started.md"):
        prose = re.sub(r"^\|.*$", "", text(page), flags=re.MULTILINE)
        assert "180/180" not in prose, page


# ---------------------------------------------------------------- controls


@pytest.mark.parametrize(
    ("page", "marker"),
    [
        ("README.md", "table4"),
        ("docs/leaderboard.md", "leaderboard"),
        ("docs/results.md", "measured"),
        ("docs/results.md", "merit"),
    ],
)
def test_what_the_planner_does_alone_stands_in_every_table(page: str, marker: str) -> None:
    rows = [line for line in between(page, marker).splitlines() if line.startswith("|")]
    assert any("random-10" in row for row in rows)


def test_what_is_called_an_upper_bound_is_one() -> None:
    for kind in ("reference", "as-predicted"):
        (check,) = check_bound(RESULTS / kind / "oracle")
        assert check.state is State.OK, check.detail


def test_the_questions_say_that_the_planner_helps_to_choose() -> None:
    faq = " ".join(text("docs/faq.md").split())
    assert "of a predictor's first ten it takes the first in which the fingers get deep" in faq
    assert "only the best grasp" not in faq.lower()
    readme = " ".join(text("README.md").split())
    assert "the planner carries out the first with which the fingers get deep enough" in readme


def test_the_rules_say_why_a_row_needs_a_process_of_its_own() -> None:
    rules = " ".join(text("docs/leaderboard.md").split())
    assert "caller's frame" in rules
    assert "a process of its own" in rules


# ---------------------------------------------------------------- runs and pictures


def test_committed_runs_are_of_one_clean_tree_and_one_environment() -> None:
    runs = [run for kind in KINDS for run in find_runs(RESULTS / kind)]
    assert len(runs) > 50
    infos = {str(run.relative_to(RESULTS)): load_run(run) for run in runs}
    assert [name for name, i in infos.items() if not i.git or i.git.endswith("-dirty")] == []
    # Of grasp-bench itself `git` tells which it was.
    stacks = {
        str((i.environment, {k: v for k, v in i.versions.items() if k != "grasp-bench"}))
        for i in infos.values()
    }
    assert len(stacks) == 1


def test_it_is_said_which_runs_are_of_another_processor() -> None:
    runs = [load_run(run) for kind in KINDS for run in find_runs(RESULTS / kind)]
    (usual, _), *others = Counter(run.cpu for run in runs).most_common()
    (said,) = re.findall(r"\*\*Two processors\.\*\*.*?\n\n", text("docs/results.md"), re.DOTALL)
    assert usual in said
    assert all(cpu in said for cpu, _ in others)
    assert set(re.findall(r"`([\w-]+)`", said.partition("Intel")[0])) == {
        run.predictor for run in runs if run.cpu != usual
    }


def test_pictures_are_large_enough_to_be_read() -> None:
    with Image.open(ROOT / "docs" / "images" / "trial.gif") as film:
        assert film.width >= 640
        assert getattr(film, "n_frames", 1) > 10
    assert "(docs/images/trial.gif)" in text("README.md")
    assert CLIP_SIZE[0] >= 320
