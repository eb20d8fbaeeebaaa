"""Examples, and the predictor of README, lift what they promise."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from grasp_bench.runs.results import RunResults

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
PROMISE = re.compile(r"lifts\s+(\d+) of (\d+)")
RUN = re.compile(r"grasp-bench run (--trials 20 --predictor (?:'[^']*'|[^\s`]+))")


def head(path: Path) -> str:
    """The docstring of an example."""
    return path.read_text(encoding="utf-8").split('"""')[1]


def lifted(options: list[str], folder: Path, out: Path, *path: Path) -> tuple[int, int]:
    """Run ``grasp-bench run`` in a folder, with others on the module path; successes and trials."""
    code = f"import sys; sys.path[:0] = {[str(p) for p in (folder, *path)]!r}; "
    code += "from grasp_bench.cli import app; app()"
    command = [sys.executable, "-c", code, "run", *options, "--workers", "1", "--quiet", "--out", str(out)]
    done = subprocess.run(command, cwd=folder, text=True, capture_output=True, timeout=900)
    assert done.returncode == 0, done.stderr
    rate = RunResults(out).lifted
    return rate.successes, rate.trials


PREDICTORS = (
    "01_my_predictor.py",
    "05_opencv_predictor.py",
    "06_server.py",
    "07_package/steepest_grasps.py",
    "09_pose_server.py",
    "10_tsdf_predictor.py",
)
OTHERS_WEIGHTS = ("08_published_maps.py",)
"""Examples that are nothing without weights which are not ours to give."""


@pytest.mark.parametrize("name", PREDICTORS)
def test_an_example_lifts_what_its_head_promises(name: str, tmp_path: Path) -> None:
    told = head(EXAMPLES / name)
    promised, command = PROMISE.search(told), RUN.search(told)
    assert promised, f"{name} promises no rate"
    assert command, f"{name} says no command"
    options = command[1].replace("python ", f"{sys.executable} ")
    options = options.replace("--predictor steepest", "--predictor steepest_grasps:Steepest")  # not installed
    found = lifted(shlex.split(options), EXAMPLES, tmp_path / "run", EXAMPLES / "07_package")
    assert found == (int(promised[1]), int(promised[2]))


def test_the_predictor_of_the_readme_lifts_what_is_said_there(tmp_path: Path) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    code = re.search(r"```python\n# my_module\.py\n(.*?)```", text, re.DOTALL)
    promised = re.search(r"(\d+) of the first (\d+) objects", text)
    assert code
    assert promised
    (tmp_path / "my_module.py").write_text(code[1])
    options = ["--trials", promised[2], "--predictor", "my_module:MyPredictor"]
    assert lifted(options, tmp_path, tmp_path / "run") == (int(promised[1]), int(promised[2]))


PAGES = ("README.md", "docs/getting-started.md", "docs/predictors.md", "docs/python.md")


@pytest.mark.parametrize("page", PAGES)
def test_the_first_predictor_of_a_page_keeps_to_the_protocol(page: str, tmp_path: Path) -> None:
    """Whoever copies it and checks it, as the page says next, is told of no break."""
    text = (ROOT / page).read_text(encoding="utf-8")
    code = next(block for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "class " in block)
    body = re.search(r"^((?:from|import) .*?\nclass .*?)(?=^\S|\Z)", code, re.DOTALL | re.MULTILINE)
    assert body
    (tmp_path / "mine.py").write_text(body[1])
    name = re.search(r"class (\w+)", body[1])
    assert name
    command = [sys.executable, "-m", "grasp_bench.cli", "predictors", "check", f"mine:{name[1]}"]
    done = subprocess.run(command, cwd=tmp_path, text=True, capture_output=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_example_promises_a_rate() -> None:
    for path in sorted(p for p in EXAMPLES.glob("*.py") if p.name not in OTHERS_WEIGHTS):
        assert PROMISE.search(head(path)), path.name
