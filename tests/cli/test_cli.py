"""The command line: what it prints, what it refuses, and how it ends."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from conftest import Ended

from grasp_bench.errors import GraspBenchError
from grasp_bench.execution import runner, worker
from grasp_bench.predictors.names import parse
from grasp_bench.predictors.shipped import SHIPPED
from grasp_bench.scenario.sections import Scenario
from grasp_bench.system.machine import THREADS

CONTROLS = [name for name, entry in SHIPPED.items() if entry.kind == "control"]


@pytest.fixture
def shipped(toy_catalog: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets the three toys stand for the shipped objects."""
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets" / "objects").symlink_to(toy_catalog)
    monkeypatch.setattr("grasp_bench.objects.catalog.assets_dir", lambda: tmp_path / "assets")


@pytest.fixture
def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Does a run's trials in this process, one after the other; pools are tested with the runner."""
    for name in THREADS:
        monkeypatch.setenv(name, "1")

    class Sequential:
        def run(self, settings, jobs):
            worker.load((settings.predictor,))
            for job in jobs:
                yield from worker.do(settings, job)

    monkeypatch.setattr("grasp_bench.api.make_executor", lambda *_, **__: Sequential())
    for place in ("api", "execution.crew"):
        monkeypatch.setattr(f"grasp_bench.{place}.early_crew", lambda *_, **__: nullcontext())


@pytest.fixture(scope="session")
def quick(scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scenario file with a small image."""
    path = tmp_path_factory.mktemp("scenario") / "quick.yaml"
    path.write_text(json.dumps({"camera": scenario.camera.model_dump(mode="json")}))
    return path


# ---------------------------------------------------------------- starting


def test_help_imports_no_heavy_library() -> None:
    code = (
        "import sys; sys.argv = ['grasp-bench', '--help']\n"
        "from grasp_bench.cli import main\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code, end.code\n"
        "heavy = {'torch', 'mujoco', 'dm_control', 'mink', 'scipy', 'cv2', 'trimesh', 'pandas', 'numpy'}\n"
        "print('HEAVY', sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], text=True, capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "HEAVY []" in done.stdout
    for command in ("run", "report", "predictors", "objects"):
        assert command in done.stdout


def test_the_installed_command_starts() -> None:
    command = Path(sys.executable).with_name("grasp-bench")
    if not command.is_file():
        pytest.skip("grasp-bench is not installed beside this Python")
    done = subprocess.run([command, "predictors", "--json"], text=True, capture_output=True, timeout=60)
    assert [p["name"] for p in json.loads(done.stdout)] == list(SHIPPED)


@pytest.mark.parametrize("command", ["run", "report", "predictors", "objects", "objects list"])
def test_every_command_explains_itself(cli, command: str) -> None:
    ended = cli(f"{command} --help")
    assert ended.code == 0
    assert "Usage" in ended.out


def test_predictors_are_listed_for_people_and_machines(cli) -> None:
    listed = json.loads(cli("predictors --json").out)
    assert [p["name"] for p in listed] == list(SHIPPED)
    assert {p["kind"] for p in listed} == {"network", "control"}
    assert all(p["summary"] for p in listed)
    table = cli("predictors").out
    assert all(name in table for name in SHIPPED)
    assert "list[Grasp]" in table


def test_networks_are_listed_with_their_weights_and_training(cli) -> None:
    listed = {p["name"]: p for p in json.loads(cli("predictors --json").out)}
    told = listed["htc-grasp-1000"]
    assert len(told.pop("weights")["sha256"]) == 64
    assert told.pop("trained_on")["train"] == 9500
    assert told.pop("reference").startswith("HTC-Grasp: A Hybrid")
    assert told == {
        "name": "htc-grasp-1000",
        "kind": "network",
        "summary": "HTC-Grasp after 1,000 steps, to compare its ablations with",
        "parameters": 2_434_004,
        "input": "rgbd",
        "crop": 224,
        "steps": 1000,
        "seconds": 737,
        "paper_rows": {"Table 3": "EA + CA"},
    }
    assert listed["gg-cnn"]["input"] == "depth"
    assert listed["gg-cnn"]["paper_rows"] == {"Table 1": "GG-CNN", "Table 4": "GG-CNN"}
    assert list(listed["oracle"]) == ["name", "kind", "summary"]


@pytest.mark.parametrize("options", [[], ["--json"]])
def test_predictors_are_listed_without_torch(options: list[str]) -> None:
    code = (
        f"import sys; sys.argv = ['grasp-bench', 'predictors', *{options}]\n"
        "from grasp_bench.cli import main\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code, end.code\n"
        "print('HEAVY', sorted({'torch', 'mujoco', 'scipy', 'cv2'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], text=True, capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "HEAVY []" in done.stdout


@pytest.mark.usefixtures("shipped")
def test_the_shell_completes_names() -> None:
    from grasp_bench.cli import completion

    assert completion.predictors("o") == ["oracle", "oracle-6dof"]
    assert completion.scenarios("tab") == ["table4"]
    assert completion.objects("b") == ["bar", "block", "box"]
    assert completion.objects("pot,bl") == ["pot,block"]
    assert completion.objects("zzz") == []


def test_completion_reaches_the_shell(tmp_path: Path) -> None:
    code = "from grasp_bench.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code],
        text=True,
        capture_output=True,
        timeout=60,
        env=os.environ
        | {
            "_GRASP_BENCH_COMPLETE": "complete_bash",
            "COMP_CWORD": "3",
            "COMP_WORDS": "grasp-bench run --predictor ora",
        },
    )
    assert done.stdout.split() == ["oracle", "oracle-6dof"], done.stderr


@pytest.mark.parametrize("asked", [False, True])
def test_no_color_is_respected(cli, monkeypatch: pytest.MonkeyPatch, asked: bool) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")  # as on a terminal
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")
    if asked:
        monkeypatch.setenv("NO_COLOR", "1")
    colour = re.compile(r"\x1b\[(\d+;)*[39]\dm")
    assert bool(colour.search(cli("predictors").out)) is not asked


# ---------------------------------------------------------------- refusals: exit 2, one clear line


def refused(ended: Ended, *words: str) -> None:
    assert ended.code == 2
    assert ended.err.startswith("Error: ")
    assert "Traceback" not in ended.err
    for word in words:
        assert word in ended.err


@pytest.mark.usefixtures("shipped")
def test_an_unknown_object_is_refused_with_the_nearest(cli) -> None:
    refused(cli("run --objects blok --predictor oracle"), "'blok'", "Did you mean block", "pot")


@pytest.mark.usefixtures("shipped")
@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--predictor", "orakel", ["'orakel'", "Did you mean oracle", "my_module:MyPredictor"]),
        ("--predictor", "nowhere:Thing", ["'nowhere'", "was not found"]),
        ("--scenario", "tabel4", ["'tabel4'", "Did you mean table4"]),
        ("--scenario", "missing.yaml", ["missing.yaml does not exist"]),
        ("--renderer", "raycaster", ["'raycaster'", "Did you mean raycast", "osmesa"]),
        ("--objects", " , ", ["object"]),
    ],
)
def test_an_unknown_choice_is_refused_with_the_nearest(
    cli, option: str, value: str, words: list[str]
) -> None:
    refused(cli(f"run {option} '{value}'"), *words)
    assert not Path("results").exists()


@pytest.mark.skipif(os.environ["MUJOCO_GL"] != "off", reason="MUJOCO_GL was set before the tests started")
def test_opengl_is_refused_where_mujoco_runs_without(cli) -> None:
    refused(cli("run --renderer egl"), "MUJOCO_GL")


def test_a_folder_without_a_manifest_is_refused(cli, tmp_path: Path) -> None:
    refused(cli(f"run --objects {tmp_path} --predictor oracle"), "manifest.json", str(tmp_path))


@pytest.mark.parametrize(
    "line", ["run --trials 0", "run --trials many", "run --seed -1", "run --nonsense", "fly"]
)
def test_impossible_arguments_are_refused(cli, line: str) -> None:
    ended = cli(line)
    assert ended.code == 2
    assert "Traceback" not in ended.err


@pytest.mark.parametrize(
    ("line", "choices"),
    [
        ("evaluate --root . --dataset cornel", "'cornel' is not one of 'cornell', 'jacquard', 'synthetic'."),
        ("train --data . --out new --recipe papr", "'papr' is not one of 'own', 'paper'."),
    ],
)
def test_a_choice_that_is_none_is_refused_with_all_choices(cli, line: str, choices: str) -> None:
    ended = cli(line)
    told = " ".join(ended.err.replace("│", " ").split())
    assert ended.code == 2
    assert f"'{line.split()[-2]}': {choices}" in told, "and nothing of pydantic's between"


def test_an_unknown_report_format_is_refused_with_all_choices(cli) -> None:
    refused(cli("report . --format markdwon"), "Did you mean markdown", "json, markdown, table")


def test_a_report_on_nothing_is_refused(cli, tmp_path: Path) -> None:
    refused(cli("report nowhere"), "nowhere is not a folder")
    refused(cli(f"report {tmp_path}"), "No run in")


def test_an_interrupted_run_ends_with_130_and_says_how_to_go_on(
    cli, toy_catalog: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(runner, "carry_out", interrupted)
    ended = cli(f"run --objects {toy_catalog} --predictor oracle --out out")
    assert ended.code == 130
    assert "the same command goes on" in ended.err


# ---------------------------------------------------------------- runs and reports


def test_a_run_with_its_workers_is_measured_reported_and_resumed(
    cli, toy_catalog: Path, quick: Path, tmp_path: Path
) -> None:
    run = f"run --objects {toy_catalog} --trials 3 --predictor oracle --scenario {quick} --workers 1"
    ended = cli(run)
    assert ended.code == 0, ended.err
    assert "oracle lifted 3/3 = 100.0% (95 % interval 43.9% – 100.0%)" in ended.out
    folder = tmp_path / "results" / "oracle-quick-seed0"
    assert "results/oracle-quick-seed0" in ended.out
    before = (folder / "trials.jsonl").read_bytes()
    again = cli(run)
    assert again.code == 0
    assert "finished already" in again.out
    assert (folder / "trials.jsonl").read_bytes() == before

    assert "oracle" in cli("report").out  # looks into results/ by itself
    report = json.loads(cli("report results --format json").out)
    assert set(report) >= {"runs", "table4"}
    row = report["runs"][-1]
    assert (row["predictor"], row["successes"], row["trials"]) == ("oracle", 3, 3)
    assert report["table4"][-1]["source"] == "paper"  # another scenario is no row of it
    assert report["groups"] == [{"title": "quick, seed 0, 3 trials", "runs": ["oracle-quick-seed0"]}]
    assert "| oracle (control) | 3/3 |" in cli(f"report {folder} --format markdown").out
    assert cli(f"report {folder} --format json --out report.json").out == ""
    assert json.loads(Path("report.json").read_text())["runs"][0]["run"] == "oracle-quick-seed0"
    assert cli(f"report {folder} --out table.txt").code == 0
    assert "3/3" in Path("table.txt").read_text()
    refused(cli(f"report {folder} --format json --out no/such/folder.json"), "cannot be written")
    refused(cli(f"{run} --seed 1 --out {folder}"), "holds another run", "the seed")


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("control", CONTROLS)
def test_every_control_runs_and_scores_where_it_should(
    cli, toy_catalog: Path, quick: Path, control: str
) -> None:
    run = f"run --objects {toy_catalog} --trials 3 --predictor {control} --scenario {quick}"
    ended = cli(f"{run} --out out --json")
    assert ended.code == 0, ended.err
    figures = json.loads(ended.out)
    assert figures["trials"] == 3
    assert {"error", "timeout", "unstable"}.isdisjoint(figures["outcomes"])
    if control in ("oracle", "centroid", "antipodal"):
        assert figures["successes"] >= 2
    if control == "displaced":
        assert figures["successes"] == 0
    assert json.loads(cli("report out --format json").out)["runs"][-1]["predictor"] == control


@pytest.mark.usefixtures("in_process")
def test_a_run_with_faults_of_the_harness_exits_with_one_unless_allowed(cli, toy_catalog: Path) -> None:
    Path("falling.yaml").write_text("settling: {clearance: 0.2, timeout: 0.1}")
    run = (
        f"run --objects {toy_catalog} --trials 2 --predictor oracle --scenario falling.yaml --quiet --out out"
    )
    ended = cli(run)
    assert ended.code == 1
    assert "2 trials ended unstable" in ended.err
    assert ended.out == ""
    assert cli(f"{run} --max-errors 2").code == 0


@pytest.mark.usefixtures("in_process")
def test_a_predictor_of_ones_own_is_found_in_the_current_folder(cli, toy_catalog: Path, quick: Path) -> None:
    Path("my_own_module.py").write_text("class Mine:\n    def predict(self, image):\n        return []\n")
    ended = cli(f"run --objects {toy_catalog} --trials 1 --predictor my_own_module:Mine --scenario {quick}")
    assert ended.code == 0, ended.err
    assert Path("results/my_own_module-Mine-quick-seed0/trials.jsonl").is_file()
    assert "lifted 0/1" in ended.out


# ---------------------------------------------------------------- objects


@pytest.mark.usefixtures("shipped")
def test_objects_are_listed_and_shown(cli) -> None:
    listed = json.loads(cli("objects list --json").out)
    assert [o["name"] for o in listed] == ["bar", "block", "pot"]
    assert "3 objects in 3 categories" in cli("objects list").out
    some = json.loads(cli("objects list pot,box --json").out)
    assert [o["name"] for o in some] == ["pot", "block"]
    shown = json.loads(cli("objects show pot --json").out)
    assert shown["mass"] == 0.22
    assert shown["poses"][0]["grasps"] > 0
    assert "220 g, ceramic" in cli("objects show pot").out
    refused(cli("objects show pott"), "Did you mean pot")


@pytest.mark.usefixtures("shipped")
def test_objects_are_verified(cli) -> None:
    ended = cli("objects verify")
    assert ended.code == 0
    assert "3 of 3 objects are as the manifest says" in ended.out


def test_units_are_printed(cli: Callable[[str], Any]) -> None:
    """Rich takes brackets for markup; the heads of tables must keep theirs."""
    listed = cli("objects list").out
    assert "Mass [g]" in listed
    assert "Size [mm]" in listed


def test_output_that_is_not_unicode_and_too_many_workers_are_no_errors(
    toy_catalog: Path, tmp_path: Path
) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "grasp_bench.cli", "run", "--objects", str(toy_catalog), "--trials", "1"]
        + ["--predictor", "centroid", "--workers", "99", "--out", "out"],
        cwd=tmp_path,
        capture_output=True,
        env=os.environ | {"PYTHONIOENCODING": "ascii", "PYTHONPATH": str(Path(__file__).parents[2])},
    )
    assert done.returncode == 0, done.stderr
    assert b"99 workers would only wait" in done.stdout
    assert b"lifted" in done.stdout


def test_a_folder_that_is_not_there_is_not_an_unknown_object(cli: Callable[[str], Any]) -> None:
    ended = cli("run --objects ./my-objets")
    assert ended.code == 2
    assert "The folder ./my-objets of --objects does not exist" in ended.err


@pytest.mark.parametrize(
    "words",
    ["objects show banana --picture", "objects sheet", "data show syn --out", "data compare syn --out"],
)
def test_a_picture_is_named_like_one(cli: Callable[[str], Any], words: str) -> None:
    ended = cli(f"{words} b.txt")
    assert ended.code == 2
    assert "b.txt is not named like a picture: end it in .png, .jpg, .jpeg, .webp." in ended.err
    assert not Path("b.txt").exists()


@pytest.mark.parametrize(
    "words",
    [
        "run --objects mug --trials 1 --predictor oracle --out new",
        "rank oracle centroid --objects mug,banana --budget 2 --out new",
        "sweep --parameter gripper.force --values 30 --objects mug --predictor oracle --out new",
        "train --predictor gg-cnn --data nowhere --out new",
    ],
)
def test_a_seed_that_no_record_holds_is_refused_before_anything_is_done(
    cli: Callable[[str], Any], words: str
) -> None:
    ended = cli(f"{words} --seed {10**23}")
    assert ended.code == 2
    assert "9223372036854775807" in " ".join(ended.err.split())
    assert "Traceback" not in ended.err
    assert not Path("new").exists()


@pytest.mark.usefixtures("in_process")
def test_weights_of_ones_own_need_no_name(cli: Callable[[str], Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """They say themselves of which network they are; a network that is named must be that one."""
    file = SHIPPED["gg-cnn"].weights
    assert file is not None
    asked: list[str] = []

    def run(objects: object, trials: object, predictor: str, *_: object, **__: object) -> None:
        asked.append(predictor)
        raise GraspBenchError("enough")

    monkeypatch.setattr("grasp_bench.api.run", run)
    assert "enough" in cli(f"run --weights {file.path}").err
    assert "enough" in cli(f"run --predictor gg-cnn --weights {file.path}").err
    assert "enough" in cli("run").err
    assert asked == [str(file.path), f"gg-cnn@{file.path}", "htc-grasp"]
    assert parse(asked[0]).kind == "network"
