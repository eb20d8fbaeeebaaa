"""Ways in for predictors of one's own: packages and modules, and what identifies them."""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from grasp_bench.cli import main
from grasp_bench.errors import PredictorError, ResultsError, UnknownNameError
from grasp_bench.execution.runner import run
from grasp_bench.predictors import load_predictor, sources
from grasp_bench.predictors.identity import describe, identify
from grasp_bench.predictors.names import installed
from grasp_bench.predictors.shipped import SHIPPED
from grasp_bench.predictors.use import in_use
from grasp_bench.runs.jobs import Settings, spread
from grasp_bench.system.integrity import sha256

MODULE = """
from {package}helpers import grasps
class Mine:
    def predict(self, image): return grasps()
    def close(self): print("closed")
"""


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder on Python's path, from which packages can be made to look installed."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(folder)
    monkeypatch.chdir(tmp_path)
    before = set(sys.modules)
    yield folder
    for name in set(sys.modules) - before:
        if name.startswith(("mine", "yours", "helpers")):
            del sys.modules[name]
    importlib.invalidate_caches()


def install(site: Path, distribution: str, entries: str, version: str = "1.0") -> None:
    info = site / f"{distribution}-{version}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: {version}\n")
    (info / "entry_points.txt").write_text(f"[grasp_bench.predictors]\n{entries}\n")
    (info / "RECORD").write_text("mine.py,,\nhelpers.py,,\n")
    importlib.invalidate_caches()


def write(folder: Path, package: str = "", helpers: str = "def grasps(): return []") -> None:
    (folder / "mine.py").write_text(MODULE.format(package=package))
    (folder / "helpers.py").write_text(helpers)


def command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *words: str
) -> tuple[Any, str, str]:
    monkeypatch.setattr("sys.argv", ["grasp-bench", *words])
    monkeypatch.setenv("COLUMNS", "200")
    with pytest.raises(SystemExit) as caught:
        main()
    printed = capsys.readouterr()
    return caught.value.code or 0, printed.out, printed.err


# ---------------------------------------------------------------- packages


def test_a_packages_predictor_is_listed_suggested_and_loaded_by_its_name(
    site: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write(site)
    install(site, "my-grasps", "mine = mine:Mine")
    assert list(installed()) == ["mine"]
    assert "mine" not in sys.modules, "listing imports nothing"
    _, out, _ = command(monkeypatch, capsys, "predictors", "--json")
    assert json.loads(out)[-1] == {"name": "mine", "kind": "package", "summary": "mine:Mine of my-grasps 1.0"}
    assert "mine:Mine of my-grasps 1.0" in command(monkeypatch, capsys, "predictors")[1]
    with pytest.raises(UnknownNameError, match="Did you mean mine"):
        load_predictor("minee")
    assert type(load_predictor("mine")).__name__ == "Mine"


def test_a_shipped_name_means_the_shipped_predictor_and_the_listing_says_so(
    site: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write(site)
    install(site, "sly", "centroid = mine:Mine")
    assert type(load_predictor("centroid")).__module__ == "grasp_bench.predictors.controls"
    assert "hidden by the shipped centroid, use mine:Mine" in command(monkeypatch, capsys, "predictors")[1]


def test_two_packages_that_offer_one_name_are_not_guessed_between(site: Path) -> None:
    install(site, "first", "mine = mine:Mine")
    install(site, "second", "mine = yours:Yours")
    with pytest.raises(PredictorError, match=r"mine:Mine and yours:Yours\. Name the one you mean"):
        load_predictor("mine")


def test_a_package_that_cannot_be_imported_harms_the_one_who_uses_it(site: Path) -> None:
    (site / "mine.py").write_text("raise SystemExit('no licence')")
    install(site, "broken", "mine = mine:Mine")
    assert "mine" in installed()
    with pytest.raises(PredictorError, match=r"'mine' of predictor.* cannot be imported: SystemExit: no l"):
        load_predictor("mine")


# ---------------------------------------------------------------- what identifies a predictor


def test_shipped_predictors_are_identified_by_version_and_weights_alone() -> None:
    assert identify("random") is None
    assert identify("centroid") is None


def test_a_module_is_identified_by_its_file_and_its_neighbours(
    site: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write(site)
    before = identify("mine:Mine")
    assert before is not None
    assert list(before) == ["files"]
    assert list(before["files"]) == ["helpers.py", "mine.py"]
    printed = capfd.readouterr()
    assert (printed.out, printed.err) == ("", "closed\n"), "in a process of its own"
    assert identify("mine:Mine") == before
    write(site, helpers="def grasps(): return [1]")
    after = identify("mine:Mine")
    assert after is not None
    assert after["files"]["mine.py"] == before["files"]["mine.py"]
    assert after["files"]["helpers.py"] != before["files"]["helpers.py"]


def test_a_neighbour_that_vanishes_does_not_count_but_the_predictors_own_file_must_be_there(
    site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(site)

    def vanishing(name: str) -> Callable[[Path], str]:
        def read(path: Path) -> str:
            if path.name == name:  # between being found and being read
                path.unlink()
            return sha256(path)

        return read

    monkeypatch.setattr(sources, "sha256", vanishing("helpers.py"))
    with in_use("mine:Mine") as used:
        facts = describe("mine:Mine", used)
    assert list(facts["files"]) == ["mine.py"]
    monkeypatch.setattr(sources, "sha256", vanishing("mine.py"))
    with pytest.raises(PredictorError, match=r"mine\.py, a file of mine, cannot be read"):
        describe("mine:Mine", used)


def test_a_module_of_a_package_is_identified_by_the_packages_files(site: Path) -> None:
    (site / "mine").mkdir()
    (site / "mine" / "__init__.py").touch()
    write(site / "mine", package="mine.")
    facts = identify("mine.mine:Mine")
    assert facts is not None
    assert list(facts["files"]) == ["mine/__init__.py", "mine/helpers.py", "mine/mine.py"]


def test_an_installed_package_is_identified_by_its_version_too(site: Path) -> None:
    write(site)
    install(site, "my-grasps", "mine = mine:Mine", version="2.3")
    facts = identify("mine")
    assert facts is not None
    assert facts["distribution"] == "my-grasps 2.3"


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("1 / 0", "ZeroDivisionError: division"),
        ("return {'a': float('nan')}", "ValueError: Out of range"),
        ("return {'a': {1, 2}}", "TypeError: Object of type set"),
        ("return self", "TypeError: Object of type Mine"),
        ("exit()", "SystemExit"),
    ],
)
def test_an_info_that_fails_is_refused(site: Path, body: str, reason: str) -> None:
    (site / "mine.py").write_text(
        f"class Mine:\n    def predict(self, image): pass\n    def info(self): {body}\n"
    )
    with pytest.raises(PredictorError, match=f"info.. of mine:Mine failed or is not JSON: {reason}"):
        identify("mine:Mine")


def test_a_run_is_not_resumed_with_a_changed_predictor(
    site: Path, scenario, toy_catalog: Path, tmp_path: Path
) -> None:
    write(site)
    settings = Settings(scenario, toy_catalog, "mine:Mine", 0, "raycast")
    out = tmp_path / "out"
    run(settings, spread(["bar"], 1), out, 1)
    described = json.loads((out / "run.json").read_text())
    assert set(described["implementation"]["files"]) == {"mine.py", "helpers.py"}
    assert run(settings, spread(["bar"], 1), out, 1).added == 0
    write(site, helpers="def grasps(): return [1]")
    with pytest.raises(ResultsError, match=r"the predictor's files.*helpers\.py.* differ"):
        run(settings, spread(["bar"], 1), out, 1)


# ---------------------------------------------------------------- the check as a command


def test_check_prints_a_table_and_exits_with_one_for_a_break(
    site: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from grasp_bench.doctor import conformance

    monkeypatch.setattr(
        conformance,
        "rendered_scene",
        lambda: conformance.Sample("small", conformance.plain_samples()[0].image),
    )
    write(site, helpers="def grasps(): return [(1, 2)]")
    code, out, _ = command(monkeypatch, capsys, "predictors", "check", "mine:Mine")
    assert code == 1
    assert "grasp 0 is a tuple, not a grasp_bench.Grasp" in out
    assert "closed" not in out, "what it prints goes to standard error"
    code, out, _ = command(monkeypatch, capsys, "predictors", "check", "random", "--json")
    assert code == 0
    assert json.loads(out)["passed"] is True
    code, _, err = command(monkeypatch, capsys, "predictors", "check", "oracle")
    assert code == 2
    assert "needs the simulator's truth" in err
    code, _, err = command(monkeypatch, capsys, "predictors", "check", "randon")
    assert code == 2
    assert "Did you mean random" in err
    assert "random" in SHIPPED
