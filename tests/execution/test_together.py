"""Several predictors on the same trials: the bytes of a run of each alone, whatever one of them does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import grasp_bench as gb
from grasp_bench.execution.protocol import Round
from grasp_bench.execution.together import can_share, run_together, try_together
from grasp_bench.objects.catalog import Catalog
from grasp_bench.runs.jobs import Settings, spread
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.sections import Scenario

OBJECTS = ["bar", "block", "pot"]
NAMES = ("htc-grasp", "random", "oracle", "antipodal")


@pytest.fixture
def settings(scenario: Scenario, toy_catalog: Path) -> Settings:
    return Settings(scenario, toy_catalog, "oracle", 3, "raycast")


def test_runs_together_are_the_bytes_of_each_alone_and_resume(
    settings: Settings, scenario: Scenario, toy_catalog: Path, tmp_path: Path
) -> None:
    jobs = spread(OBJECTS, 5)
    folders = {name: tmp_path / name for name in NAMES}
    seen: list[tuple[str, int, bool]] = []
    run_together(settings, folders, jobs, 2, lambda name, r, resumed: seen.append((name, r.trial, resumed)))
    assert sorted(seen) == sorted((n, t, False) for n in NAMES for t in range(5))
    for name in NAMES:
        alone = gb.run(
            toy_catalog, 5, name, scenario, seed=3, out=tmp_path / "alone" / name, workers=1, progress=False
        )
        for file in ("trials.jsonl", "run.json"):
            assert (folders[name] / file).read_bytes() == (alone.folder / file).read_bytes()
    whole = (folders["oracle"] / "trials.jsonl").read_text().splitlines(keepends=True)
    (folders["oracle"] / "trials.jsonl").write_text("".join(whole[:2]))
    seen.clear()
    run_together(settings, folders, jobs, 1, lambda name, r, resumed: seen.append((name, r.trial, resumed)))
    assert [s for s in seen if not s[2]] == [("oracle", t, False) for t in (2, 3, 4)]
    assert (folders["oracle"] / "trials.jsonl").read_text() == "".join(whole)


def test_one_that_hangs_or_dies_costs_no_other_its_trial(settings: Settings) -> None:
    quick = replace(settings, scenario=settings.scenario.model_copy(update={"trial_timeout": 25.0}))
    bad = "fake_predictors:ByColour"
    assert not can_share(bad)  # by name; given it all the same, nothing is lost
    rounds = [Round(i, name, 0, (bad, "oracle")) for i, name in enumerate(["block", "pot", "bar"])]
    ended = try_together(quick, [bad, "oracle"], rounds, Catalog(settings.objects), 2)
    found = {(t.round.object, t.predictor): t.record.outcome for t in ended}
    assert found == {
        ("block", bad): Outcome.TIMEOUT,
        ("pot", bad): Outcome.ERROR,
        ("bar", bad): Outcome.NO_GRASP,
        **{(name, "oracle"): Outcome.SUCCESS for name in OBJECTS},
    }


def test_rounds_may_depend_on_what_was_yielded(settings: Settings) -> None:
    racing = ["oracle", "displaced"]

    def rounds():
        for trial in range(60):
            if len(racing) < 2:
                return
            yield Round(trial, "block", trial, tuple(racing))

    done = 0
    for tried in try_together(settings, ["oracle", "displaced"], rounds(), Catalog(settings.objects), 1):
        done += 1
        if tried.predictor == "displaced" and len(racing) == 2:
            assert not tried.record.success
            racing.remove("displaced")
    assert done <= 2 * (1 + 2)


@pytest.mark.parametrize(
    ("name", "shares"),
    [
        ("htc-grasp", True),
        ("http://127.0.0.1:1", True),
        ("cmd: serve {port}", True),
        ("my_module:Mine", False),
    ],
)
def test_other_peoples_code_keeps_a_process_of_its_own(name: str, shares: bool) -> None:
    assert can_share(name) is shares
