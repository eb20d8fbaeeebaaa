"""The self-check: of the machine and the installation, and of a finished run."""

from __future__ import annotations

import json
import re
import shutil
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from grasp_bench.doctor import environment
from grasp_bench.doctor.checks import Check, State, healthy
from grasp_bench.doctor.environment import check_environment, normalised
from grasp_bench.doctor.rerun import Rerun, rerun
from grasp_bench.errors import ResultsError
from grasp_bench.execution.describe import PINNED
from grasp_bench.execution.here import Here
from grasp_bench.execution.runner import run
from grasp_bench.predictors.controls import Antipodal
from grasp_bench.runs.jobs import Settings, spread
from grasp_bench.scenario.sections import Scenario


def by_name(checks: list[Check]) -> dict[str, Check]:
    return {c.name: c for c in checks}


@pytest.fixture
def small_shop(toy_catalog: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Assets of three toys and no weights, in place of the shipped ones; free to be damaged."""
    shutil.copytree(toy_catalog, tmp_path / "assets" / "objects")
    (tmp_path / "assets" / "weights").mkdir()
    for module in ("grasp_bench.objects.catalog", "grasp_bench.networks.store"):
        monkeypatch.setattr(f"{module}.assets_dir", lambda: tmp_path / "assets")
    return tmp_path / "assets"


def test_the_environment_is_described(small_shop: Path) -> None:
    checks = by_name(check_environment())
    assert healthy(list(checks.values()))
    assert set(checks) >= {
        "Python",
        "Machine",
        "Tested stack",
        "Renderers",
        "Model cache",
        "Objects",
        "Weights",
    }
    assert "cores of" in checks["Machine"].detail
    assert "raycast" in checks["Renderers"].detail
    assert checks["Objects"].detail.startswith("3,")
    assert checks["Weights"].state is State.NOTE


def test_a_changed_mesh_is_found(small_shop: Path) -> None:
    (small_shop / "objects" / "pot" / "visual.glb").write_bytes(b"glTF")
    check = by_name(check_environment())["Objects"]
    assert check.state is State.BAD
    assert "visual.glb differs from the manifest" in check.detail


def test_a_missing_manifest_is_found(small_shop: Path) -> None:
    (small_shop / "objects" / "manifest.json").unlink()
    assert by_name(check_environment())["Objects"].state is State.BAD


def test_changed_weights_are_found(small_shop: Path) -> None:
    weights = small_shop / "weights"
    (weights / "manifest.json").write_text('{"htc-grasp.safetensors": "00"}')
    (weights / "htc-grasp.safetensors").write_bytes(b"other")
    check = by_name(check_environment())["Weights"]
    assert check.state is State.BAD
    assert "SHA-256" in check.detail


def test_the_tested_stack_names_everything_that_can_change_a_result() -> None:
    tested = environment.tested_versions()
    assert {normalised(name) for name in PINNED} - set(tested) == {"grasp-bench"}


def test_another_version_is_a_note_that_says_what_it_means(
    small_shop: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wanted = environment.tested_versions() | {"mujoco": "3.99.0"}
    monkeypatch.setattr(environment, "tested_versions", lambda: wanted)
    checks = by_name(check_environment())
    assert checks["mujoco"].state is State.NOTE
    assert f"{version('mujoco')}, tested with 3.99.0" in checks["mujoco"].detail
    assert "byte-identical" in checks["mujoco"].detail
    assert healthy(list(checks.values()))


def test_a_local_build_of_the_tested_release_is_the_tested_one(
    small_shop: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wanted = environment.tested_versions() | {"mujoco": version("mujoco") + "+local"}
    monkeypatch.setattr(environment, "tested_versions", lambda: wanted)
    assert "mujoco" not in by_name(check_environment())


def test_a_cache_that_cannot_be_written_is_a_note(
    small_shop: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("GRASP_BENCH_CACHE", str(tmp_path / "file"))
    check = by_name(check_environment())["Model cache"]
    assert check.state is State.NOTE
    assert "compiles its scene anew" in check.detail


# ---------------------------------------------------------------- a finished run


@pytest.fixture(scope="module")
def finished(toy_catalog: Path, scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of seven trials on one bar, pot or block."""
    out = tmp_path_factory.mktemp("doctor") / "run"
    settings = Settings(scenario, toy_catalog, "antipodal", 1, "raycast")
    run(settings, spread(["bar", "block", "pot"], 7), out, 1, executor=Here(Antipodal()))
    return out


def again(folder: Path, toy_catalog: Path, trials: int = 2) -> Rerun:
    return rerun(folder, trials, Here(Antipodal()), toy_catalog)


@pytest.fixture
def copied(finished: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(finished, tmp_path / "run"))


def edit(folder: Path, **changed: Any) -> None:
    run = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(run | changed))


def test_a_run_repeats_byte_for_byte(finished: Path, toy_catalog: Path) -> None:
    found = again(finished, toy_catalog, 3)
    assert (found.repeated, found.tried) == (3, 3)
    assert [c.state for c in found.checks] == [State.OK, State.OK]
    assert found.checks[-1].detail == "3 of 3 gave the same bytes again"


def test_an_edited_record_is_found_and_nothing_explains_it(copied: Path, toy_catalog: Path) -> None:
    text = (copied / "trials.jsonl").read_text()
    (copied / "trials.jsonl").write_text(re.sub(r'"sim_steps": \d+', '"sim_steps": 7', text))
    found = again(copied, toy_catalog)
    assert found.repeated == 0
    verdict = found.checks[-1]
    assert verdict.state is State.BAD
    assert "2 of 2 differ, 0 in their outcome; nothing explains it" in verdict.detail
    assert "sim_steps" in verdict.detail


@pytest.mark.parametrize(
    ("changed", "name", "words"),
    [
        ({"versions": {"mujoco": "3.1"}}, "Versions", "mujoco: 3.1 then, .* now.*MuJoCo and its kin promise"),
        ({"weights": {"w": "ab"}}, "Weights", "another network"),
        ({"cpu": "other"}, "Cpu", "other then.*last digits depend on the processor"),
        ({"objects": {"bar": {}, "block": {}, "pot": {}}}, "Objects", "other shapes or masses"),
    ],
)
def test_what_is_not_as_it_was_is_told_with_its_meaning(
    copied: Path, toy_catalog: Path, changed: dict[str, Any], name: str, words: str
) -> None:
    edit(copied, **changed)
    found = by_name(again(copied, toy_catalog, 1).checks)
    assert found[name].state is State.NOTE
    assert re.search(words, found[name].detail)
    assert found["Trials"].state is State.OK


def test_another_seed_does_not_repeat(copied: Path, toy_catalog: Path) -> None:
    edit(copied, seed=2)
    found = again(copied, toy_catalog)
    assert found.repeated == 0
    assert "seed" in found.checks[-1].detail or "outcome" in found.checks[-1].detail


def test_objects_that_are_not_there_are_asked_for(copied: Path, toy_catalog: Path) -> None:
    edit(copied, objects={"bar": {}, "blocks": {}, "pot": {}})
    with pytest.raises(ResultsError, match=r"name their folder with --objects.*Did you mean block"):
        again(copied, toy_catalog)


def test_a_run_without_trials_cannot_be_repeated(copied: Path, toy_catalog: Path) -> None:
    (copied / "trials.jsonl").write_text("")
    with pytest.raises(ResultsError, match="holds no trial that could be repeated"):
        again(copied, toy_catalog)


def test_mixed_up_files_are_refused(copied: Path, toy_catalog: Path) -> None:
    text = (copied / "trials.jsonl").read_text()
    (copied / "trials.jsonl").write_text(text.replace('"object": "bar"', '"object": "pot"'))
    with pytest.raises(ResultsError, match="its files were mixed up"):
        again(copied, toy_catalog, 7)
