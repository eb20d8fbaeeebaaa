"""The HTML report of some thirty committed runs in a browser: what is chosen, compared, drawn and listed."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from committed import RESULTS, committed_runs
from html_browsing import Opened, draw_charts, opening, until

from grasp_bench.report.html.page import write_html
from grasp_bench.runs.folder import find_runs, load_records

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True}
FIRST = [f"reference/{name}" for name in ("htc-grasp", "htc-grasp-tta", "redmon-multigrasp", "gr-convnet")]


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("many") / "results"
    for folder in committed_runs():
        shutil.copytree(folder, root / folder.relative_to(RESULTS))
    return write_html(find_runs(root), root / "report.html", root).path


@pytest.fixture
def opened(browser: Any, report: Path, request: pytest.FixtureRequest) -> Iterator[Opened]:
    with opening(browser, report, getattr(request, "param", {})) as found:
        yield found


def chosen(page: Any) -> list[str]:
    """Names of the chosen runs, in the order of the tables."""
    return page.evaluate(
        "() => { const { runs } = JSON.parse(document.getElementById('data').textContent);"
        "return [...document.querySelectorAll('.pick:checked')].map((b) => runs[b.value].name); }"
    )


def test_a_few_runs_are_chosen_and_the_choice_is_in_the_address(opened: Opened) -> None:
    page = opened.page
    assert chosen(page) == FIRST
    runs = committed_runs()
    trials = sum(len(load_records(run)) for run in runs)
    assert page.inner_text("#chosen") == f"4 of {len(runs)} runs shown below"
    assert page.inner_text("#count").startswith(f"720 of {trials} trials")
    page.click("#no-runs")
    assert page.inner_text("#count").startswith(f"0 of {trials} trials")
    for name in ("oracle (control)", "random (control)"):
        page.locator(".runs label", has_text=name).first.click()
    page.select_option("#reference", label="reference/oracle")
    page.select_option("#outcome", "=missed")
    address = page.evaluate("location.hash")
    opened.go(address)
    assert chosen(page) == ["reference/oracle", "reference/random"]
    assert page.locator("#outcome").input_value() == "=missed"
    assert page.evaluate("document.getElementById('reference').selectedOptions[0].text") == "reference/oracle"
    assert set(page.locator("#list .outcome").all_inner_texts()) == {"missed"}
    page.click("#list a >> nth=0")
    page.wait_for_selector("#trial:not([hidden])")
    page.keyboard.press("Escape")
    page.wait_for_selector("#overview:not([hidden])")
    assert page.evaluate("location.hash") == address
    page.click("#first-choice")
    assert chosen(page) == FIRST


def test_groups_are_by_scenario_best_first_and_controls_last(opened: Opened) -> None:
    groups = opened.page.evaluate(
        "[...document.querySelectorAll('details.group')].map((g) => [g.querySelector('h3').textContent,"
        "g.open, [...g.querySelectorAll('.simulation')].map((r) => [r.classList.contains('control'),"
        "parseFloat(r.querySelector('.rate').textContent)]), g.querySelectorAll('.paper').length])"
    )
    assert [g[0] for g in groups] == [
        "Table 4, re-measured: table4, development seed 0, 180 trials",
        "table4, development seed 0, 24 trials",
        "table4, seeds 5 to 9, 180 trials each",
        "11 scenarios, seed 0, 180 trials each",
    ]
    assert [(g[1], g[3]) for g in groups] == [(True, 5), (False, 0), (False, 0), (False, 0)]
    for title, _, rows, _ in groups:
        of_a_predictor = [rows[:5], rows[5:]] if "seeds 5 to 9" in title else [rows]
        assert all(found == sorted(found, key=lambda r: (r[0], -r[1])) for found in of_a_predictor)
    assert "together htc-grasp-tta 870/900 = 96.7 %, htc-grasp 869/900 = 96.6 %" in " ".join(
        opened.page.inner_text("#runs").split()
    )


def test_charts_have_at_most_eight_series(opened: Opened) -> None:
    page = opened.page
    page.click("#all-runs")
    draw_charts(page)
    counts = page.evaluate(
        "Object.fromEntries([...document.querySelectorAll('.chart')]"
        ".map((c) => [c.dataset.chart, c.data.length]))"
    )
    assert counts.pop("calibration") == 9  # and the line
    assert counts.pop("coverage") == 16  # a band and a line each
    assert counts.pop("outcomes") <= 10
    assert counts.pop("seconds") <= 8
    assert set(counts.values()) == {8}
    rows = "new Set(document.querySelector('[data-chart=outcomes]').data.flatMap((t) => t.y)).size"
    assert page.evaluate(rows) == 8
    assert f"{len(committed_runs()) - 8} more" in page.inner_text("[data-note=outcomes]")
    page.click("#first-choice")
    until(page, "document.querySelector('[data-chart=by-mass]').data.length === 4")
    colours = "document.querySelector('[data-chart=by-mass]').data.map((t) => t.marker.color)"
    assert len(set(page.evaluate(colours))) == 4


def test_one_reference_is_compared_with_the_runs_that_share_its_trials(opened: Opened) -> None:
    page = opened.page
    cells = "[...document.querySelectorAll('#pairs tr')].map((r) => [...r.cells].map((c) => c.textContent))"
    rows = page.evaluate(cells)
    assert len(rows) == 36
    assert [r for r in rows if r[0] == "gg-cnn"] == [["gg-cnn", "180", "170", "8", "2", "0", "0.11", "1"]]
    assert [r for r in rows if r[0] == "baseline/oracle"] == [
        ["baseline/oracle", "24", "24", "0", "0", "0", "1", "–"]
    ]
    page.select_option("#reference", label="seeds/htc-grasp-seed5")
    assert [r[:4] for r in page.evaluate(cells)] == [["htc-grasp-tta-seed5", "180", "170", "1"]]
    page.select_option("#reference", label="suites/htc-grasp-office")
    assert page.locator("#no-pairs").is_visible()
    assert page.locator("#pairs tr").count() == 0


def test_trials_without_pictures_are_a_table_with_the_objects_pictures(opened: Opened) -> None:
    page = opened.page
    assert page.locator("#grid").is_hidden()
    assert page.locator("#list tr").count() == 60
    assert page.locator("#list img.thumb").count() == 60
    until(page, "[...document.querySelectorAll('#list img')].every((i) => i.naturalWidth === 64)")
    outcomes = page.locator("#list .outcome").all_inner_texts()
    failed = [o != "success" for o in outcomes]
    assert failed == sorted(failed, reverse=True)
    assert sum(failed) == 11


def test_controls_failures_come_last(opened: Opened) -> None:
    page = opened.page
    page.locator(".runs label", has_text="displaced (control)").click()
    assert "displaced" not in " ".join(page.locator("#list .of").all_inner_texts())
    while not page.locator("#after").is_disabled():
        page.click("#after")
    assert set(page.locator("#list .outcome").all_inner_texts()) <= {"missed", "ik_failed"}


@pytest.mark.parametrize("opened", [PHONE], indirect=True, ids=["phone"])
def test_on_a_phone_no_row_is_tall_and_the_page_is_not_endless(opened: Opened) -> None:
    page = opened.page
    draw_charts(page)
    assert page.evaluate("document.documentElement.scrollHeight") < 420 * len(committed_runs())
    page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    tall = page.evaluate(
        "[...document.querySelectorAll('tr')].filter((r) => r.checkVisibility())"
        ".map((r) => [r.offsetHeight, r.textContent.slice(0, 60)]).filter(([h]) => h > 130)"
    )
    assert tall == []
    table = "Math.max(...[...document.querySelectorAll('.runs tr')].map((r) => r.offsetHeight))"
    assert page.evaluate(table) <= 80
    bars = page.evaluate("[...document.querySelectorAll('.runs .interval')].map((b) => b.offsetWidth)")
    assert len({b for b in bars if b}) == 1  # one scale
    assert max(bars) > 150


def test_the_title_of_a_trial_has_no_frame(opened: Opened) -> None:
    opened.go("#reference/htc-grasp/151")
    page = opened.page
    page.keyboard.press("ArrowRight")
    until(page, "document.activeElement.id === 'trial-title'")
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "none"
