"""Merit, firmness and trust on the page: shown where runs have them, as the tables have them."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from html_browsing import BROWSER, PATIENCE, Opened, draw_charts, opening, until
from made_up_runs import write_run

from grasp_bench.report.html.page import write_html
from grasp_bench.report.table4 import build_report
from grasp_bench.runs.folder import find_runs
from grasp_bench.scenario.reading import load_scenario

TRIALS = 40
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True}


def of(name: str) -> dict[str, Any]:
    return load_scenario(name).model_dump(mode="json")


def measured(folder: Path, scenario: str, times: float, lost: int, **run: Any) -> Path:
    """A run that loses its first ``lost`` trials and bears ``times`` and more of the weight in the others."""

    def change(record: dict[str, Any]) -> dict[str, Any]:
        held = times * (1 + record["trial"] / 20) if record["success"] else 0.0
        grasp = {"x": 1.0, "y": 1.0, "angle": 0.0, "width": 9.0, "quality": 0.5 + record["trial"] / 100}
        helped = scenario == "graded"
        return record | {
            "grasp": grasp,
            "sim_steps": 3000,
            "rank": 0,
            "widening_mm": 8.0 if helped and record["trial"] % 4 == 0 else 0.0,
            "margin": {"force": 2 * held, "factor": held, "direction": "-jaws", "torque": 0.1},
        }

    objects = {f"thing{i:02}": {"object.json": str(i)} for i in range(TRIALS // 2)}
    settings = {"scenario": of(scenario), "objects": objects} | run
    return write_run(folder, TRIALS, lambda t: t >= lost, change=change, **settings)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("measures")
    for name, times, lost in (("firm", 8.0, 2), ("soft", 2.0, 4)):
        measured(root / name, "graded", times, lost, predictor=name)
        measured(root / f"{name}-alone", "graded-as-predicted", times, 5 * lost, predictor=name)
    write_run(root / "plain", TRIALS, predictor="plain", scenario=of("table4"))
    return root


@pytest.fixture(scope="module")
def report(folder: Path) -> Path:
    return write_html(find_runs(folder), folder / "report.html", folder).path


def without_scripts(path: Path) -> str:
    text = re.sub(r"<script.*?</script>|<style.*?</style>", "", path.read_text(encoding="utf-8"), flags=re.S)
    return " ".join(re.sub(r"<[^>]+>", " ", text).split())


def test_the_page_says_what_the_tables_say(folder: Path, report: Path) -> None:
    text, found = without_scripts(report), build_report(find_runs(folder), folder)
    merit = next(m for m in found.merits if m.predictor == "soft")
    assert merit.predicted is not None
    assert merit.pairs is not None
    assert merit.help is not None
    assert (merit.predicted.successes, merit.pairs.gained) == (20, 16)
    assert f"soft graded, seed 4 20/40 50.0 % 36/40 90.0 % {100 * merit.pairs.difference:+.1f} %" in text
    assert merit.help.wider == 10
    for run in found.runs:
        trust = run.trust
        assert f"{trust.picks.an_hour:.0f}" in text
        if run.firmness is None:
            continue
        assert trust.calibration is not None
        assert f"{trust.calibration.error:.3f} by chance {trust.calibration.by_chance:.3f}" in text
        held = run.firmness.held[5.0]
        low, high = held.interval
        assert f"{held.successes}/{held.trials} {low:.1%} – {high:.1%}".replace("%", " %") in text
        assert f"{run.firmness.area.low:.3f} – {run.firmness.area.high:.3f}" in text


def test_pages_of_runs_without_these_measures_have_no_such_sections(tmp_path: Path) -> None:
    write_run(tmp_path / "plain", predictor="plain", scenario={"name": "table4", "version": 1})
    text = write_html([tmp_path / "plain"], tmp_path / "r.html", tmp_path).path.read_text(encoding="utf-8")
    for part in ('id="merit"', 'id="firmness"', 'href="#merit"', 'href="#firmness"'):
        assert part not in text
    assert 'id="quality"' in text


def test_a_pair_reads_the_same_from_either_side(report: Path) -> None:
    text = report.read_text(encoding="utf-8")
    data = re.search(r'id="data">(.*?)</script>', text, re.S)
    assert data is not None
    content = json.loads(data[1])
    names = [r["name"] for r in content["runs"]]
    firm, soft = names.index("firm"), names.index("soft")
    (there,) = [row for row in content["firmer"][firm] if row[0] == soft]
    (back,) = [row for row in content["firmer"][soft] if row[0] == firm]
    assert there[1:3] == back[1:3] == [40, 20]
    assert float(there[3][:-1]) == pytest.approx(1 / float(back[3][:-1]), rel=0.02)
    low, high = map(float, there[4].split(" – "))
    other = [1 / float(x) for x in reversed(back[4].split(" – "))]
    assert (low, high) == (pytest.approx(other[0], abs=0.01), pytest.approx(other[1], abs=0.01))
    assert content["firmer"][names.index("plain")] == []
    success = next(t for t in content["trials"] if t["run"] == firm and t["trial"] == 8)
    assert (success["widening"], success["factor"], success["direction"]) == (8.0, 11.2, "-jaws")


# ---------------------------------------------------------------- in a browser

needs_browser = pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed (Debian: chromium)")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    sync_api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"], timeout=PATIENCE)
        yield started
        started.close()


@pytest.fixture
def opened(browser: Any, report: Path, request: pytest.FixtureRequest) -> Iterator[Opened]:
    with opening(browser, report, getattr(request, "param", {})) as found:
        yield found


def rows(page: Any, table: str) -> list[str]:
    shown = f"[...document.querySelectorAll('#{table} tr')].filter((r) => r.checkVisibility())"
    return page.evaluate(f"{shown}.map((r) => r.querySelector('th').textContent.trim().split(/\\s/)[0])")


@needs_browser
def test_the_sections_follow_the_choice_of_runs_and_the_reference(opened: Opened) -> None:
    page = opened.page
    page.click("#all-runs")
    draw_charts(page)
    page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    assert set(rows(page, "merits")) == {"firm", "soft"}
    assert set(rows(page, "held")) == {"firm", "soft", "firm-alone", "soft-alone"}
    bands = "document.querySelector('[data-chart=firmness]').data.filter((t) => t.meta.band)"
    assert page.evaluate(f"{bands}.length") == 4
    assert page.evaluate(f"{bands}.every((t) => /^#[0-9a-f]{{8}}$/.test(t.fillcolor))")
    page.select_option("#reference", label="soft")
    assert page.inner_text("#firm-reference") == "soft"
    force = page.inner_text("#firmer tr td >> nth=2")
    assert float(force[:-1]) > 2
    page.click("#no-runs")
    page.locator(".runs label", has_text="plain").first.click()
    assert rows(page, "held") == []
    assert page.locator("#no-held").is_visible()
    until(page, "document.querySelector('[data-chart=firmness]').data.length === 0")


@needs_browser
def test_a_run_has_the_same_colour_in_all_charts(opened: Opened) -> None:
    page = opened.page
    page.click("#all-runs")
    draw_charts(page)
    colours = page.evaluate(
        "Object.fromEntries(['firmness', 'coverage', 'by-mass'].map((c) => [c, Object.fromEntries("
        "document.querySelector(`[data-chart=${c}]`).data.filter((t) => !t.meta.band)"
        ".map((t) => [t.name, t.marker.color]))]))"
    )
    for name, colour in colours["firmness"].items():
        assert colours["coverage"][name] == colours["by-mass"][name] == colour
    assert len(set(colours["firmness"].values())) == 4


@needs_browser
@pytest.mark.parametrize("opened", [PHONE], indirect=True, ids=["phone"])
def test_on_a_phone_each_predictor_is_a_short_block(opened: Opened) -> None:
    page = opened.page
    page.click("#all-runs")
    draw_charts(page)
    page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    heights = page.evaluate("[...document.querySelectorAll('#merits tr')].map((r) => r.offsetHeight)")
    assert max(heights) < 230
    heads = "[...document.querySelectorAll('#merits td')].map((c) => getComputedStyle(c, '::before').content)"
    assert "Lifted alone" in page.evaluate(f"{heads}.join()")
