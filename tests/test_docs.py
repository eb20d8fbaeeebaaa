"""The documentation: every relative link and anchor leads somewhere, every page is in the site."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
GENERATED = {
    "reference/api.md",
    "reference/commands.md",
    "reference/examples.md",
    "changelog.md",
    "contributing.md",
}
"""Pages that scripts/make_pages.py makes while the site is built."""
LINK = re.compile(r"!?\[[^\]]*\]\(<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\)")


BLOCK = re.compile(r"^( *)(```|~~~).*?^\1\2", re.DOTALL | re.MULTILINE)


def without_blocks(path: Path) -> str:
    """A page without its blocks of code."""
    return BLOCK.sub("", path.read_text(encoding="utf-8"))


def prose(path: Path) -> str:
    """A page without any code."""
    return re.sub(r"`[^`\n]*`", "", without_blocks(path))


def anchors(path: Path) -> set[str]:
    """The anchors of a page's headings, as Python-Markdown and GitHub make them."""
    found = set()
    for heading in re.findall(r"^#{1,6} +(.+?) *#*$", without_blocks(path), flags=re.MULTILINE):
        plain = re.sub(r"[`*]|\[([^\]]*)\]\([^)]*\)", lambda m: m[1] or "", heading)
        slug = re.sub(r"[^\w\s-]", "", plain, flags=re.ASCII).strip().lower()
        found.add(re.sub(r"[-\s]+", "-", slug))
    return found


@pytest.mark.skipif((ROOT / "PKG-INFO").is_file(), reason="an sdist holds no pictures and no runs")
@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_relative_links_and_anchors_exist(page: Path) -> None:
    wrong = []
    for target in LINK.findall(prose(page)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        there = page if not path else (page.parent / path).resolve()
        if there.is_relative_to(ROOT / "docs") and there.relative_to(ROOT / "docs").as_posix() in GENERATED:
            continue
        if not there.exists() or (anchor and there.suffix == ".md" and anchor not in anchors(there)):
            wrong.append(target)
    assert not wrong, f"{page.relative_to(ROOT)} links to what is not there: {wrong}"


def site() -> dict[str, Any]:
    """``mkdocs.yml``."""
    return yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))


def entries(nav: Any) -> list[str]:
    """All pages of the navigation, in order."""
    if isinstance(nav, str):
        return [nav]
    return [page for item in (nav.values() if isinstance(nav, dict) else nav) for page in entries(item)]


def test_every_page_is_in_the_navigation_once() -> None:
    listed = entries(site()["nav"])
    written = {p.relative_to(ROOT / "docs").as_posix() for p in (ROOT / "docs").rglob("*.md")}
    assert sorted(listed) == sorted(written | GENERATED)


def test_the_site_fetches_nothing() -> None:
    config = site()
    assert config["theme"]["font"] is False
    assert "extra_javascript" not in config
    assert not [s for s in config["extra_css"] if "//" in s]


def test_every_public_name_is_on_the_api_page(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mkdocs_gen_files", reason="the extra docs is not installed")
    monkeypatch.syspath_prepend(ROOT / "scripts")
    sys.modules.pop("make_pages", None)
    import make_pages

    import grasp_bench

    page = make_pages.api_page()
    for name in grasp_bench.__all__:
        assert f"::: grasp_bench.{grasp_bench._HOME[name]}.{name}\n" in page
    assert "## More" not in page  # a new public name has been given its place
    assert set(make_pages.PAGES) == GENERATED


def test_examples_are_numbered_from_one_and_say_what_they_do() -> None:
    numbered = sorted((ROOT / "examples").glob("[0-9][0-9]_*"))
    assert [int(p.name[:2]) for p in numbered] == list(range(1, len(numbered) + 1))
    for path in numbered:
        sources = [path] if path.is_file() else list(path.glob("*.py"))
        assert sources
        for source in sources:
            assert source.read_text(encoding="utf-8").startswith('"""')
