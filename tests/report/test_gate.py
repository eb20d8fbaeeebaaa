"""The gate: verdicts, exit codes, what is not comparable, and what it writes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree as Xml

import pytest
from made_up_runs import RUN, write_run

from grasp_bench.errors import GraspBenchError, ResultsError
from grasp_bench.report.gate import Checked, NotComparableError, Verdict, check
from grasp_bench.report.gate_text import as_junit, as_markdown, as_text, meaning
from grasp_bench.runs.jobs import Shard
from grasp_bench.scenario.reading import load_scenario

ROOT = Path(__file__).parents[2]


def compared(folder: Path, lost: int, gained: int, trials: int = 180, **options: object) -> Checked:
    """A baseline of which the first 20 trials failed, and a new run with so many lost and gained."""
    old = write_run(folder / "old", trials, lambda t: t >= 20)
    new = write_run(folder / "new", trials, lambda t: t < gained or t >= 20 + lost)
    return check(new, old, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("lost", "gained", "options", "verdict"),
    [
        (0, 0, {}, Verdict.NO_REGRESSION),
        (0, 20, {}, Verdict.NO_REGRESSION),
        (1, 0, {}, Verdict.NO_REGRESSION),
        (3, 0, {}, Verdict.INCONCLUSIVE),
        (4, 0, {}, Verdict.UNDERPOWERED),
        (5, 0, {}, Verdict.REGRESSION),
        (5, 1, {}, Verdict.UNDERPOWERED),
        (20, 5, {}, Verdict.REGRESSION),
        (15, 15, {}, Verdict.UNDERPOWERED),
        (5, 0, {"margin": 0.15}, Verdict.NO_REGRESSION),
        (5, 0, {"alpha": 0.01}, Verdict.UNDERPOWERED),
        (100, 0, {}, Verdict.REGRESSION),
        (0, 0, {"exact": True}, Verdict.IDENTICAL),
        (0, 1, {"exact": True}, Verdict.DIFFERENT),
    ],
)
def test_verdicts(tmp_path: Path, lost: int, gained: int, options: dict, verdict: Verdict) -> None:
    checked = compared(tmp_path, lost, gained, **options)
    assert checked.verdict is verdict
    assert checked.pairs == (lost, gained, 180)
    assert checked.successes == (160, 160 + gained - lost)
    assert checked.failed is (verdict in (Verdict.REGRESSION, Verdict.DIFFERENT))
    assert len(checked.changed) == lost + gained
    assert meaning(checked) in as_text(checked)
    assert json.loads(json.dumps(checked.to_json()))["verdict"] == str(verdict)


def test_a_drop_that_is_proven_but_small_passes_with_a_word(tmp_path: Path) -> None:
    checked = compared(tmp_path, 12, 2, trials=1500)
    assert checked.p_worse < 0.05
    assert checked.verdict is Verdict.NO_REGRESSION
    assert "A drop is proven, but it is smaller than the margin." in checked.notes


def test_few_trials_say_what_they_cannot_see(tmp_path: Path) -> None:
    checked = compared(tmp_path, 0, 0, trials=24)
    assert checked.verdict is Verdict.UNDERPOWERED
    assert "one of up to 10.1% is not excluded" in meaning(checked)
    assert f"About {checked.enough} trials would" in meaning(checked)
    assert checked.enough is not None
    enough = compared(tmp_path / "more", 0, 0, trials=checked.enough)
    assert enough.verdict is Verdict.NO_REGRESSION, "as many as it says"
    assert "no drop is proven in 80 of 100 cases" in as_text(checked)
    assert "one of 3.0% in 0" in as_text(checked)


def test_power_grows_with_trials(tmp_path: Path) -> None:
    small, large = (compared(tmp_path / str(n), 2, 2, trials=n) for n in (180, 1800))
    assert small.visible is not None
    assert large.visible is not None
    assert large.visible < small.visible
    assert small.power < large.power
    assert f"a drop of {small.visible:.1%} is proven in 80 of 100 cases" in as_text(small)


def test_another_detail_is_a_difference_only_where_records_must_be_the_same(tmp_path: Path) -> None:
    old = write_run(tmp_path / "old")
    new = write_run(tmp_path / "new", change=lambda r: r | {"lift_height": 0.1 + r["trial"] / 100})
    checked = check(new, old, exact=True)
    assert checked.verdict is Verdict.DIFFERENT
    assert [c.detail for c in checked.changed] == ["lift_height differs"] * 9
    assert check(new, old).changed == ()


# ---------------------------------------------------------------- what cannot be compared


@pytest.mark.parametrize(
    ("run", "words"),
    [
        ({"seed": 5}, r"the seed \(4 in the baseline, 5 in the new run\)"),
        ({"trials": 12}, r"the number of trials \(9 in the baseline, 12 in the new run\)"),
        ({"objects": {"mug": {}, "pan": {}, "cup": {}}}, r"their files \(mug\.object\.json only in"),
        ({"objects": dict(reversed(RUN["objects"].items()))}, "in another order"),
        (
            {"scenario": {"name": "table4", "gripper": {"force": 80.0}}},
            r"the scenario \(gripper\.force: 60\.0 in the baseline, 80\.0 in the new run\)",
        ),
    ],
)
def test_runs_of_other_trials_are_not_compared(tmp_path: Path, run: dict, words: str) -> None:
    old, new = write_run(tmp_path / "old"), write_run(tmp_path / "new", **run)
    with pytest.raises(NotComparableError, match=f"are not of the same trials: .*{words}"):
        check(new, old)


@pytest.mark.parametrize("which", ["old", "new"])
def test_unfinished_runs_are_not_compared(tmp_path: Path, which: str) -> None:
    old = write_run(tmp_path / "old", only=[0, 3] if which == "old" else None)
    new = write_run(tmp_path / "new", only=[0, 3] if which == "new" else None)
    with pytest.raises(NotComparableError, match=rf"{which} lacks 7 of 9 trials \(1, 2, 4, 5, 6, 7 …\)"):
        check(new, old)


@pytest.mark.parametrize("which", ["old", "new"])
def test_runs_of_a_race_are_not_tested_once_more(tmp_path: Path, which: str) -> None:
    old, new = (write_run(tmp_path / n, drawn=True if n == which else None) for n in ("old", "new"))
    with pytest.raises(NotComparableError, match=f"{which} is of a race, .*grasp-bench rank"):
        check(new, old)


def test_a_shard_is_not_compared_with_a_whole_run(tmp_path: Path) -> None:
    old, new = write_run(tmp_path / "old"), write_run(tmp_path / "new", shard=Shard(1, 3))
    with pytest.raises(NotComparableError, match="lacks 6 of 9 trials"):
        check(new, old)


def test_what_a_newer_scenario_names_at_its_default_is_the_same_trial(tmp_path: Path) -> None:
    whole = load_scenario("table4").model_dump(mode="json")
    old, new = write_run(tmp_path / "old"), write_run(tmp_path / "new", scenario=whole | {"name": "renamed"})
    assert check(new, old).pairs == (0, 0, 9)


def test_other_predictors_weights_and_versions_are_what_a_gate_compares(tmp_path: Path) -> None:
    old = write_run(tmp_path / "old")
    new = write_run(tmp_path / "new", predictor="mine", weights={"w": "ab" * 32}, versions={"mujoco": "3.18"})
    (note,) = check(new, old).notes
    assert note.startswith("Not the same in both: the predictor (oracle in the baseline, mine in the new")
    assert "mujoco: 3.17 in the baseline, 3.18 in the new run" in note


@pytest.mark.parametrize(
    "options",
    [
        {"margin": 0.0},
        {"margin": 1.0},
        {"margin": float("nan")},
        {"alpha": 0.0},
        {"alpha": 0.5},
        {"alpha": float("nan")},
    ],
)
def test_impossible_margins_and_levels_are_refused(tmp_path: Path, options: dict) -> None:
    with pytest.raises(GraspBenchError, match=f"--{next(iter(options))} must be between"):
        compared(tmp_path, 0, 0, **options)


def test_more_faults_of_the_harness_are_told(tmp_path: Path) -> None:
    old = write_run(tmp_path / "old")
    new = write_run(
        tmp_path / "new",
        wins=lambda t: t > 1,
        change=lambda r: r | ({} if r["success"] else {"outcome": "timeout"}),
    )
    checked = check(new, old)
    assert checked.faults == (0, 2)
    assert "2 trials of the new run ended in faults of the harness" in checked.notes[0]


# ---------------------------------------------------------------- what is written

HOSTILE = "<script>|x|\n](javascript:1) \x00\x1b[31m & \ud7ff `code`"


@pytest.fixture
def hostile(tmp_path: Path) -> Checked:
    """Two runs whose files were written by somebody with bad intentions."""
    objects = {HOSTILE: {"object.json": "ab"}}
    old = write_run(tmp_path / "old", objects=objects)
    new = write_run(
        tmp_path / "new",
        wins=lambda t: t > 4,
        objects=objects,
        predictor=HOSTILE,
        change=lambda r: r | {"detail": HOSTILE},
    )
    return check(new, old, exact=True)


def test_markdown_shows_names_as_they_are(hostile: Checked) -> None:
    text = as_markdown(hostile)
    assert "<script>" not in text
    table = [line for line in text.splitlines() if line.startswith("| 0 ")]
    assert table[0].replace("\\|", "").count("|") == 6
    assert "](" not in text.replace("\\](", "")


def test_junit_is_xml_whatever_the_names(hostile: Checked) -> None:
    suite = Xml.fromstring(as_junit(hostile)).find("testsuite")
    assert suite is not None
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("1", "1", "0")
    failure = suite.find("testcase/failure")
    assert failure is not None
    assert failure.get("type") == "different"


@pytest.mark.parametrize(
    ("lost", "failures", "skipped", "child"),
    [(0, "0", "0", None), (3, "0", "1", "skipped"), (30, "1", "0", "failure")],
)
def test_junit_tells_passed_skipped_and_failed(
    tmp_path: Path, lost: int, failures: str, skipped: str, child: str | None
) -> None:
    suite = Xml.fromstring(as_junit(compared(tmp_path, lost, 0))).find("testsuite")
    assert suite is not None
    assert (suite.get("failures"), suite.get("skipped")) == (failures, skipped)
    case = suite.find("testcase")
    assert case is not None
    assert [c.tag for c in case] == ([child] if child else [])


@pytest.mark.parametrize(("lost", "mark"), [(0, "✅"), (3, "⚠️"), (30, "❌")])
def test_the_summary_begins_with_the_verdict(tmp_path: Path, lost: int, mark: str) -> None:
    checked = compared(tmp_path, lost, 0)
    text = as_markdown(checked)
    assert text.startswith(f"### {mark} grasp-bench: {checked.verdict}\n")
    assert ("and 18 more" in text) is (lost == 30)


# ---------------------------------------------------------------- the command


def command(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "grasp_bench.cli", *map(str, arguments)],
        text=True,
        capture_output=True,
        timeout=120,
    )


def test_the_command_ends_with_0_1_and_2(tmp_path: Path) -> None:
    old = write_run(tmp_path / "old", 180)
    runs = {
        0: write_run(tmp_path / "same", 180),
        1: write_run(tmp_path / "worse", 180, lambda t: t > 9),
        2: write_run(tmp_path / "other", 180, seed=8),
    }
    junit, summary = tmp_path / "junit.xml", tmp_path / "summary.md"
    summary.write_text("before\n")
    for code, run in runs.items():
        done = command("check", run, "--baseline", old, "--junit", junit, "--markdown", summary)
        assert done.returncode == code, done.stderr
        assert "Traceback" not in done.stderr
    assert summary.read_text().startswith("before\n### ✅")
    assert "### ❌ grasp-bench: regression" in summary.read_text()
    assert Xml.parse(junit).getroot().tag == "testsuites"


def test_too_few_trials_have_an_exit_code_of_their_own(tmp_path: Path) -> None:
    old, new = write_run(tmp_path / "old", 24), write_run(tmp_path / "new", 24)
    for more in ([], ["--strict"]):
        done = command("check", new, "--baseline", old, "--json", *more)
        assert (done.returncode, json.loads(done.stdout)["verdict"]) == (3, "underpowered")


def test_inconclusive_passes_unless_strict(tmp_path: Path) -> None:
    old, new = (write_run(tmp_path / n, 180, lambda t, n=n: t > 2 or n == "old") for n in ("old", "new"))
    asked = ["check", new, "--baseline", old]
    assert command(*asked).returncode == 0
    done = command(*asked, "--strict", "--json")
    assert done.returncode == 1
    assert json.loads(done.stdout)["verdict"] == "inconclusive"


def test_a_missing_baseline_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ResultsError, match=r"holds no run\.json"):
        check(write_run(tmp_path / "new"), tmp_path)
