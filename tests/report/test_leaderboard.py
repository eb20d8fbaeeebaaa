"""Rows of the leaderboard: what is fit for one, and what is found out."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from grasp_bench.errors import ResultsError
from grasp_bench.grasps import Grasp, GraspPose
from grasp_bench.objects.catalog import Catalog
from grasp_bench.report.leaderboard import About, Row, as_markdown, check, load_row
from grasp_bench.runs.record import TcpError, TrialRecord
from grasp_bench.runs.statistics import Rate
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.system.integrity import sha256
from grasp_bench.system.paths import assets_dir

ABOUT = {"name": "Mine", "authors": "Jane Doe", "trained_on": "nothing"}


def made_up_trial(number: int, name: str, category: str) -> dict[str, Any]:
    """A record as a run writes it: every sixth trial closes on nothing."""
    won = number % 6 != 0
    outcome = Outcome.SUCCESS if won else Outcome.MISSED
    return TrialRecord(
        trial=number,
        object=name,
        category=category,
        seed=0,
        outcome=outcome,
        grasp=Grasp(320.0, 240.0, 0.1, 40.0),
        pose=GraspPose.top_down([0.5, 0.0, 0.01], 0.1, 0.06),
        rank=0,
        tcp_error=TcpError(1e-4, 1e-4),
        lift_height=0.2 * won,
        contact_force=60.0 * won,
        sim_steps=3000,
    ).to_json()


@pytest.fixture
def row(tmp_path: Path) -> Path:
    """A folder as someone might hand it in; its records are made up."""
    folder = tmp_path / "row"
    folder.mkdir()
    catalog = Catalog()
    run = {
        "format": 1,
        "predictor": "cmd: grasp-bench serve my_module:Mine --port {port}",
        "apart": True,
        "seed": 0,
        "trials": len(catalog.names),
        "scenario": load_scenario("table4").model_dump(mode="json"),
        "weights": None,
        "versions": {"mujoco": "3.17.0"},
        "renderer": "raycast",
        "objects": {n: catalog.entries[n]["files"] for n in catalog.names},
    }
    (folder / "run.json").write_text(json.dumps(run))
    records = [made_up_trial(i, n, catalog.entries[n]["category"]) for i, n in enumerate(catalog.names)]
    (folder / "trials.jsonl").write_text("".join(json.dumps(r) + "\n" for r in records))
    (folder / "about.yaml").write_text(yaml.safe_dump(ABOUT))
    return folder


def edit_run(folder: Path, change: Callable[[dict[str, Any]], object]) -> None:
    run = json.loads((folder / "run.json").read_text())
    change(run)
    (folder / "run.json").write_text(json.dumps(run))


def edit_trials(folder: Path, change: Callable[[list[dict[str, Any]]], object]) -> None:
    records = [json.loads(line) for line in (folder / "trials.jsonl").read_text().splitlines()]
    change(records)
    (folder / "trials.jsonl").write_text("".join(json.dumps(r) + "\n" for r in records))


def fault(folder: Path) -> str:
    faults = [c.fault for c in check(folder) if not c.passed]
    assert len(faults) == 1, faults
    with pytest.raises(ResultsError, match="cannot be a row"):
        load_row(folder)
    return faults[0]


def test_a_sound_run_is_a_row(row: Path) -> None:
    assert [c.fault for c in check(row)] == [""] * 7
    made = load_row(row)
    assert (made.about.name, made.control, made.lifted, made.faults) == ("Mine", False, Rate(150, 180), 0)


@pytest.mark.parametrize(
    ("changes", "sound"),
    [
        ({"predictor": "my_module:Mine", "apart": False}, False),
        ({"predictor": "my_module:Mine", "apart": True}, False),
        ({"predictor": "cmd: serve {port}", "apart": None}, False),
        ({"predictor": "no-such-predictor"}, False),
        ({"predictor": "http://127.0.0.1:8000"}, True),
        ({"predictor": "oracle", "apart": None}, True),
    ],
)
def test_a_row_comes_from_a_process_of_its_own(changes: dict[str, Any], sound: bool, row: Path) -> None:
    edit_run(row, lambda run: run.update(changes))
    if sound:
        assert all(c.passed for c in check(row))
    else:
        assert "can read the truth from its caller's frame" in fault(row)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda run: run.update(seed=3), "its seed is 3, not 0"),
        (lambda run: run.update(renderer="egl"), "made by 'egl'"),
        (lambda run: run["scenario"]["gripper"].update(force=100.0), "differs from table4 in gripper"),
        (lambda run: run["scenario"]["sensor"].update(axial_sigma=0.0), "differs from table4 in sensor"),
        (lambda run: run["scenario"].update(cheat=1), "'cheat'"),
        (lambda run: run["objects"].pop("coffee_mug"), "1 of 180 objects were not tried, such as coffee_mug"),
        (lambda run: run["objects"]["coffee_mug"].update({"object.json": "0" * 64}), "such as coffee_mug"),
        (lambda run: run.update(objects=dict(reversed(run["objects"].items()))), "in the manifest's order"),
    ],
)
def test_a_run_of_something_else_is_found_out(row: Path, change: Callable, words: str) -> None:
    edit_run(row, change)
    assert words in "; ".join(c.fault for c in check(row) if not c.passed)


def winning(records: list[dict[str, Any]]) -> dict[str, Any]:
    return next(r for r in records if r["success"])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda records: records.pop(17), "it holds 179 of 180 trials"),
        (lambda records: records.reverse(), "not in order"),
        (lambda records: records[4].update(object="apple"), "trial 4 names another object"),
        (lambda records: records[4].update(seed=9), "trial 4 names another object or seed"),
        (lambda records: winning(records).update(grasp=None), "success without grasp"),
        (lambda records: winning(records).update(lift_height=0.02), "success without grasp, lift"),
        (lambda records: winning(records).update(contact_force=0.0), "or contact force"),
    ],
)
def test_trials_that_were_left_out_or_changed_are_found_out(row: Path, change: Callable, words: str) -> None:
    edit_trials(row, change)
    assert words in fault(row)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda records: records.append(records[0]), "trial 0 is in it a second time"),
        (
            lambda records: next(r for r in records if not r["success"]).update(success=True),
            "'success' is True",
        ),
        (lambda records: winning(records).update(outcome="lifted"), "'outcome' must be one of"),
    ],
)
def test_records_that_no_run_writes_are_refused_by_their_line(
    row: Path, change: Callable, words: str
) -> None:
    edit_trials(row, change)
    with pytest.raises(ResultsError, match=r"trials\.jsonl, line \d+ is damaged") as caught:
        check(row)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, r"about.yaml is missing: say name, authors, trained_on"),
        ("name: [", "is not valid YAML"),
        ("name: Mine", "authors: Field required"),
        (yaml.safe_dump(ABOUT | {"rate": 1.0}), "rate: Extra inputs"),
        (yaml.safe_dump(ABOUT | {"link": "javascript:alert(1)"}), "link: String should match"),
        (yaml.safe_dump(ABOUT | {"trained_on": ""}), "trained_on: String should have at least 1"),
        ("!!python/object/apply:os.system [true]", "is not valid YAML"),
    ],
)
def test_a_row_says_who_and_trained_on_what(row: Path, content: str | None, words: str) -> None:
    (row / "about.yaml").unlink()
    if content is not None:
        (row / "about.yaml").write_text(content)
    assert words in fault(row)


def test_a_shipped_predictor_needs_no_about_but_its_own_weights(row: Path) -> None:
    (row / "about.yaml").unlink()
    weights = "htc-grasp.safetensors"
    digest = sha256(assets_dir() / "weights" / weights)
    edit_run(row, lambda run: run.update(predictor="htc-grasp", weights={weights: digest}))
    assert load_row(row).about.trained_on == "see assets/weights/htc-grasp.md"
    edit_run(row, lambda run: run.update(predictor="oracle", weights=None))
    assert load_row(row).control


def test_other_weights_are_found_out(row: Path) -> None:
    edit_run(row, lambda run: run.update(predictor="htc-grasp", weights={"htc-grasp.safetensors": "0" * 64}))
    assert "other weights" in fault(row)


def test_rows_are_ordered_by_rate_controls_last_and_what_people_wrote_is_escaped() -> None:
    def made(name: str, won: int, control: bool = False, link: str = "") -> Row:
        about = About(name=name, authors="A <b>bold</b> | team", trained_on="nothing", link=link)
        return Row(about, control, Rate(won, 180), 0)

    table = as_markdown(
        [
            made("weak", 10),
            made("oracle", 180, control=True),
            made("strong [x](y)", 170, link="https://example.org/a(b)"),
        ]
    )
    lines = table.splitlines()[2:]
    assert [won for line in lines for won in re.findall(r"\d+/180", line)] == ["170/180", "10/180", "180/180"]
    assert lines[0].startswith("| [strong \\[x\\](y)](<https://example.org/a(b)>) | A &lt;b&gt;bold")
    assert "\\| team" in lines[0]
    assert "*oracle* (control)" in lines[2]
