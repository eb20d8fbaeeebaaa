"""Every command and path that README, docs and examples name: options exist, targets and files are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from written_commands import PLACEHOLDER, fault

ROOT = Path(__file__).parents[1]
PAGES = sorted(
    [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *(ROOT / "docs").rglob("*.md"),
        *ROOT.glob("examples/**/*.py"),
    ]
)
BLOCK = re.compile(r"^( *)```([\w-]*)[^\n]*\n(.*?)^\1```", re.DOTALL | re.MULTILINE)
SHELLS = ("", "bash", "console", "sh")
INLINE = re.compile(r"`([^` \n][^`\n]*)`")
COMMAND = re.compile(r"(?:^ *|&& |: |\$ )((?:grasp-bench |make |python (?:scripts|benchmarks|examples)/).*)")
TOP = ("assets", "benchmarks", "docs", "examples", "grasp_bench", "results", "scenarios", "scripts", "tests")
MADE = re.compile(
    r"results/(?:mine|new|old|whole|bench|gate|leaderboard|sweep|report\.html|[\w.-]*-seed\d+|(?:RUN|NAME)\b)|"
    r"docs/(?:reference|changelog|contributing)|grasp_bench/Grasp-v0"
)
"""Paths that users, or the building of the site, make; and the name of an environment."""


def commands(page: Path) -> list[str]:
    """The lines of ``grasp-bench``, ``make`` and ``python`` in a page's blocks, examples' heads and code."""
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".py":
        text = text.split('"""')[1]
        lines = text.splitlines()
    else:
        blocks = [re.sub(r"\\\n *", " ", b) for _, kind, b in BLOCK.findall(text) if kind in SHELLS]
        lines = [line for block in blocks for line in block.splitlines()]
        lines += INLINE.findall(BLOCK.sub("", text).replace("\n", " "))
    found = []
    for line in lines:
        found += COMMAND.findall(line)
    return [re.split(r" && | #| \||;|   +[a-z(]", line)[0].strip().rstrip("`.,):") for line in found]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_commands_are_such_as_exist(page: Path) -> None:
    wrong = {c: why for c in commands(page) if (why := fault(c))}
    assert wrong == {}


@pytest.mark.skipif((ROOT / "PKG-INFO").is_file(), reason="an sdist holds no pictures and no runs")
@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_paths_of_the_repository_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    named = set(re.findall(rf"(?<![\w/.:-])((?:{'|'.join(TOP)})/[\w./-]*\w/?)", text))
    rooms = [p.name for p in (ROOT / "grasp_bench").iterdir() if p.is_dir()]
    files = {f"grasp_bench/{f}" for f in re.findall(rf"`((?:{'|'.join(rooms)})/[\w/]+\.py)`", text)}
    wrong = [n for n in sorted(named | files) if not (ROOT / n).exists() and not MADE.match(n)]
    wrong = [n for n in wrong if not (page.parent / n).exists() and not PLACEHOLDER.search(n)]
    assert wrong == []


def test_the_test_sees_commands_and_finds_faults() -> None:
    found = [c for page in PAGES for c in commands(page)]
    assert len(found) > 100
    assert "grasp-bench report results/" in found
    assert fault("grasp-bench run --trails 3")
    assert fault("grasp-bench runn")
    assert fault("grasp-bench run --trials many")
    assert fault("make bnech")
    assert fault("python scripts/none.py")
    assert fault("grasp-bench run --objects all --trials 180") is None
