"""The self-check: of the machine and the installation, and of a finished run."""

from __future__ import annotations

import shutil
from importlib.metadata import version
from pathlib import Path

import pytest

from grasp_bench.doctor import environment
from grasp_bench.doctor.checks import Check, State, healthy
from grasp_bench.doctor.environment import check_environment, normalised
from grasp_bench.runner import PINNED


def by_name(checks: list[Check]) -> dict[str, Check]:
    return {c.name: c for c in checks}


@pytest.fixture
def small_shop(toy_catalog: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Assets of three toys and no weights, in place of the shipped ones; free to be damaged."""
    shutil.copytree(toy_catalog, tmp_path / "assets" / "objects")
    (tmp_path / "assets" / "weights").mkdir()
    for module in ("grasp_bench.objects.catalog", "grasp_bench.doctor.environment"):
        monkeypatch.setattr(f"{module}.assets_dir", lambda: tmp_path / "assets")
    return tmp_path / "assets"


def test_the_environment_is_described(small_shop: Path) -> None:
    checks = by_name(check_environment())
    assert healthy(list(checks.values()))
    assert set(checks) >= {"Python", "Machine", "Tested stack", "Renderers", "Model cache", "Objects",
                           "Weights"}
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
        small_shop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = environment.tested_versions() | {"mujoco": "3.99.0"}
    monkeypatch.setattr(environment, "tested_versions", lambda: wanted)
    checks = by_name(check_environment())
    assert checks["mujoco"].state is State.NOTE
    assert f"{version('mujoco')}, tested with 3.99.0" in checks["mujoco"].detail
    assert "byte-identical" in checks["mujoco"].detail
    assert healthy(list(checks.values()))


def test_a_local_build_of_the_tested_release_is_the_tested_one(
        small_shop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = environment.tested_versions() | {"mujoco": version("mujoco") + "+local"}
    monkeypatch.setattr(environment, "tested_versions", lambda: wanted)
    assert "mujoco" not in by_name(check_environment())


def test_a_cache_that_cannot_be_written_is_a_note(
        small_shop: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("GRASP_BENCH_CACHE", str(tmp_path / "file"))
    check = by_name(check_environment())["Model cache"]
    assert check.state is State.NOTE
    assert "compiles its scene anew" in check.detail
