"""The HTML report in a real browser: filters, sorting, a trial's page, keyboard, contrast, no request."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from html_browsing import PATIENCE, Opened, draw_charts, opening, until
from html_runs import HOSTILE, two_runs, write_clutter

from grasp_bench.report.html.page import write_html
from grasp_bench.runs.folder import find_runs

TRIALS = 150


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = two_runs(tmp_path_factory.mktemp("browser"), TRIALS)
    return write_html(find_runs(root), root / "report.html", root).path


@pytest.fixture
def opened(browser: Any, report: Path, request: pytest.FixtureRequest) -> Iterator[Opened]:
    with opening(browser, report, getattr(request, "param", {})) as found:
        yield found


def test_all_charts_are_drawn_and_follow_the_theme(opened: Opened) -> None:
    page = opened.page
    assert draw_charts(page) >= 7
    text = "getComputedStyle(document.querySelector('.chart text')).fill"
    light = page.evaluate(text)
    assert page.locator("html").get_attribute("data-theme") == "light"
    page.click("#theme")
    until(page, "[...document.querySelectorAll('.chart')].every(b => b.dataset.drawn === 'dark')")
    assert page.evaluate(text) != light
    assert page.locator("#theme").inner_text() == "Light"


def test_filters_narrow_the_grid_and_reset_restores_it(opened: Opened) -> None:
    page = opened.page
    assert page.inner_text("#count") == "300 of 300 trials, 175 of them succeeded"
    page.select_option("#outcome", "*")
    assert page.inner_text("#count") == "125 of 300 trials, 0 of them succeeded"
    page.select_option("#run", label="plain")
    assert page.inner_text("#count") == "50 of 300 trials, 0 of them succeeded"
    page.select_option("#outcome", "=slipped")
    assert page.inner_text("#count") == "25 of 300 trials, 0 of them succeeded"
    page.fill("#search", "pliers")
    assert set(opened.names()) == {'pliers\' "best" & co'}
    page.fill("#search", "nothing is called so")
    assert page.inner_text("#count") == "0 of 300 trials, 0 of them succeeded"
    page.click("button[type=reset]")
    until(page, "document.getElementById('count').textContent.startsWith('300 of 300')")


def test_failures_come_first_and_any_column_sorts_both_ways(opened: Opened) -> None:
    page = opened.page
    assert "success" not in page.locator("#grid .outcome").all_inner_texts()
    page.select_option("#sort", "object")
    names = opened.names()
    assert names[0] == HOSTILE or names[0] == "apple"
    page.click("#direction")
    assert opened.names()[0].startswith("pliers")
    page.select_option("#sort", "quality")  # still descending
    shown = page.locator("#grid .detail:last-child").all_inner_texts()
    quality = [float(t.rsplit(" ", 1)[1]) for t in shown]
    assert quality == sorted(quality, reverse=True)
    assert quality[0] == 0.9
    page.click("#direction")
    assert float(page.locator("#grid .detail:last-child").first.inner_text().rsplit(" ", 1)[1]) == 0.1


def test_the_grid_is_paged(opened: Opened) -> None:
    page = opened.page
    assert page.locator("#grid li").count() == 60
    assert page.inner_text("#page") == "Page 1 of 5"
    assert page.locator("#before").is_disabled()
    page.click("#after")
    assert page.inner_text("#page") == "Page 2 of 5"
    for _ in range(3):
        page.click("#after")
    assert page.locator("#after").is_disabled()
    assert page.locator("#grid li").count() == 60


def test_pictures_are_decoded_when_they_come_into_view(opened: Opened) -> None:
    page = opened.page
    assert page.locator("#grid img").count() == 0
    page.locator("#grid li").first.scroll_into_view_if_needed()
    page.wait_for_selector("#grid img")
    until(page, "document.querySelector('#grid img').naturalWidth === 64")
    assert 0 < page.locator("#grid img").count() < 60


def test_a_trial_has_a_page_with_pictures_numbers_and_the_other_runs(opened: Opened) -> None:
    page = opened.page
    page.select_option("#run", label="it's <b>bold<")
    page.click("#grid a >> nth=0")
    page.wait_for_selector("#trial:not([hidden])")
    assert page.inner_text("#trial-title") == "coffee_mug: trial 1 of it's <b>bold<"
    assert "missed: because </script>" in page.inner_text("#trial-outcome")
    until(page, "document.querySelector('.sheet img').naturalWidth === 64")
    until(page, "document.querySelector('.clip').naturalWidth === 64")
    numbers = page.inner_text(".numbers")
    assert "300.5 px" in numbers
    assert "28.65°" in numbers
    assert page.inner_text("#replay") == "grasp-bench replay 'it'\\''s <b>bold<' --trial 1 --video trial.gif"
    page.click("#others a")
    until(page, "document.getElementById('trial-title').textContent.endsWith('of plain')")
    assert page.inner_text(".no-media") == "No picture of this trial is in this file."
    page.click("#back")
    page.wait_for_selector("#overview:not([hidden])")


def test_an_episodes_page_shows_its_attempts_one_after_the_other(browser: Any, tmp_path: Path) -> None:
    folder = write_clutter(tmp_path / "clutter", [["success", "missed", "success"]])
    report = write_html([folder], tmp_path / "r.html", tmp_path).path
    page = browser.new_page()
    page.set_default_timeout(PATIENCE)
    complaints: list[str] = []
    page.on("console", lambda m: complaints.append(m.text) if m.type in ("error", "warning") else None)
    page.on("pageerror", lambda e: complaints.append(str(e)))
    page.goto(report.as_uri() + "#clutter/0")
    until(page, "document.documentElement.dataset.ready")
    assert page.locator(".try-title").all_inner_texts() == [
        f"Attempt 0: {HOSTILE}",
        "Attempt 1: thing 1",
        "Attempt 2: thing 2",
    ]
    until(page, "[...document.querySelectorAll('.sheet img')].every((i) => i.naturalWidth > 0)")
    widths = "[...document.querySelectorAll('.sheet img')].map((i) => i.naturalWidth)"
    assert page.evaluate(widths) == [64, 72, 80]
    assert page.locator(".clip-figure:visible").count() == 1
    outcomes = page.locator(".try-outcome").all_inner_texts()
    assert outcomes[0] == f"success; taken away: {HOSTILE}"
    assert outcomes[1].startswith("missed: because")
    assert page.locator(".numbers").count() == 3
    assert "Taken away: 2 of 3" in page.inner_text("#on-table")
    assert page.locator("#replay-attempt").is_visible()
    page.click("#back")
    page.fill("#search", "thing 2")
    assert page.inner_text("#count").startswith("1 of 1")
    page.locator("#grid li").first.scroll_into_view_if_needed()
    page.wait_for_selector("#grid img")
    until(page, "document.querySelector('#grid img').naturalWidth === 80")  # a failed table's last attempt
    assert complaints == []
    page.close()


def test_a_trials_page_has_an_address_of_its_own(opened: Opened) -> None:
    opened.go("#it's%20%3Cb%3Ebold%3C/3")
    assert opened.page.inner_text("#trial-title").startswith("pliers")
    opened.go("#plain/2")
    assert opened.page.inner_text("#trial-title") == f"{HOSTILE}: trial 2 of plain"
    opened.go("#plain/99999")
    assert opened.page.locator("#overview").is_visible()


def test_the_discordant_trials_are_listed(opened: Opened) -> None:
    page = opened.page
    page.click("#compare summary")
    links = page.locator("#compare .trial-links a")
    assert links.count() == 25
    links.first.click()
    page.wait_for_selector("#trial:not([hidden])")
    assert page.inner_text("#trial-outcome .outcome") == "missed"


def test_everything_works_from_the_keyboard(opened: Opened) -> None:
    page = opened.page
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    page.keyboard.press("/")
    until(page, "document.activeElement.id === 'search'")
    page.keyboard.type("slipped plain")
    on_a_trial = "document.activeElement.matches('#grid a, #list a')"
    until(page, "document.getElementById('count').textContent.startsWith('25 of')")
    for _ in range(40):
        page.keyboard.press("Tab")
        if page.evaluate(on_a_trial):
            break
    assert page.evaluate(on_a_trial)
    outline = "getComputedStyle(document.activeElement).outlineStyle"
    assert page.evaluate(outline) != "none"
    page.keyboard.press("Enter")
    until(page, "document.activeElement.id === 'trial-title'")
    first = page.inner_text("#trial-title")
    page.keyboard.press("ArrowRight")
    until(page, "t => document.getElementById('trial-title').textContent !== t", arg=first)
    page.keyboard.press("ArrowLeft")
    until(page, "t => document.getElementById('trial-title').textContent === t", arg=first)
    page.keyboard.press("Escape")
    page.wait_for_selector("#overview:not([hidden])")
    until(page, on_a_trial)


CONTRAST = """() => {
  const parse = (c) => (c.match(/[\\d.]+/g) ?? [0, 0, 0, 0]).map(Number);
  const channel = (v) => { v /= 255; return v <= .03928 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4; };
  const light = ([r, g, b]) => .2126 * channel(r) + .7152 * channel(g) + .0722 * channel(b);
  const ground = (e) => {
    for (let at = e; at; at = at.parentElement) {
      const c = parse(getComputedStyle(at).backgroundColor);
      if (c.length === 3 || c[3] === 1) return c;
    }
    return [255, 255, 255];
  };
  const bad = [];
  let seen = 0;
  for (const e of document.querySelectorAll('body *')) {
    const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
    if (!own || !e.checkVisibility() || ['SCRIPT', 'STYLE', 'NOSCRIPT'].includes(e.tagName)) continue;
    const style = getComputedStyle(e);
    const svg = e.namespaceURI.endsWith('svg');
    const text = parse(svg ? style.fill : style.color);
    const [a, b] = [light(text), light(ground(e))].sort((x, y) => y - x);
    const ratio = (a + .05) / (b + .05);
    seen += 1;
    if (ratio < 4.5) bad.push(`${e.tagName} ${e.textContent.slice(0, 30)} ${ratio}`);
  }
  return { seen, bad };
}"""


@pytest.mark.parametrize(
    "opened", [{"color_scheme": "light"}, {"color_scheme": "dark"}], indirect=True, ids=["light", "dark"]
)
def test_text_contrasts_as_wcag_asks_for(opened: Opened) -> None:
    page = opened.page
    draw_charts(page)
    for address in ("", "#it's%20%3Cb%3Ebold%3C/1"):
        page.evaluate("a => { location.hash = a; }", address)
        page.evaluate("document.querySelectorAll('details').forEach(d => { d.open = true; })")
        until(page, "a => document.getElementById('trial').hidden === (a === '')", arg=address)
        found = page.evaluate(CONTRAST)
        assert found["seen"] > 20
        assert found["bad"] == []


def test_marks_contrast_with_what_they_lie_on(opened: Opened) -> None:
    contrast = """() => {
      const channel = (v) => { v /= 255; return v <= .03928 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4; };
      const light = (hex) => [1, 3, 5].map((i) => channel(parseInt(hex.slice(i, i + 2), 16)))
        .reduce((sum, v, i) => sum + v * [.2126, .7152, .0722][i], 0);
      const names = ['--mark', '--paper', ...[...Array(8).keys()].map((i) => `--run-${i}`),
        ...JSON.parse(document.getElementById('data').textContent).outcomes.map((o) => `--${o}`)];
      const style = getComputedStyle(document.documentElement);
      const value = (n) => light(style.getPropertyValue(n).trim());
      return names.flatMap((n) => ['--page', '--card'].map((b) => {
        const [x, y] = [value(n), value(b)].sort((p, q) => q - p);
        return [n, b, (x + .05) / (y + .05)]; })).filter(([, , r]) => !(r >= 3)); }"""
    assert opened.page.evaluate(contrast) == []
    opened.page.click("#theme")
    assert opened.page.evaluate(contrast) == []


@pytest.mark.parametrize(
    "opened", [{"viewport": {"width": 360, "height": 740}, "has_touch": True}], indirect=True, ids=["phone"]
)
def test_a_phone_needs_no_sideways_scrolling(opened: Opened) -> None:
    page = opened.page
    width = "document.documentElement.scrollWidth"
    draw_charts(page)
    page.evaluate("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    assert page.evaluate(width) <= 360
    page.evaluate('location.hash = "#it\'s%20%3Cb%3Ebold%3C/1"')
    page.wait_for_selector("#trial:not([hidden])")
    assert page.evaluate(width) <= 360


@pytest.mark.parametrize("opened", [{"reduced_motion": "reduce"}], indirect=True, ids=["reduced-motion"])
def test_clips_wait_where_motion_is_not_wanted(opened: Opened) -> None:
    opened.go("#it's%20%3Cb%3Ebold%3C/1")
    page = opened.page
    assert page.locator(".clip").get_attribute("src") is None
    page.click(".play")
    assert str(page.locator(".clip").get_attribute("src")).startswith("blob:")


def test_images_have_texts_and_controls_have_names(opened: Opened) -> None:
    page = opened.page
    page.locator("#grid li").first.scroll_into_view_if_needed()
    page.wait_for_selector("#grid img")
    assert page.locator("#grid img:not([alt])").count() == 0
    unnamed = """() => [...document.querySelectorAll('button, select, input, a')].filter((e) =>
      !(e.textContent.trim() || e.getAttribute('aria-label') || e.closest('label'))).length"""
    assert page.evaluate(unnamed) == 0
    assert page.evaluate("document.querySelectorAll('h1').length") == 1
