"""The HTML report as a file: what it holds, that nothing in it can run or be fetched, and its figures."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import math
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from html_runs import CLOSING, HOSTILE, two_runs, write_clutter, write_run

from grasp_bench.errors import GraspBenchError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.report import breakdown
from grasp_bench.report.html.page import write_html
from grasp_bench.report.html.trials import embed, rows_of
from grasp_bench.report.run import Run
from grasp_bench.report.trust import Trust
from grasp_bench.runs.folder import find_runs
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate


class Page(HTMLParser):
    """Elements of a page, and the text of its scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: dict[str, str] = {}
        self._script: str | None = None
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag == "script":
            self._script = dict(attrs).get("id") or "main"
            self.scripts[self._script] = ""

    def handle_endtag(self, tag: str) -> None:
        if tag == "script":
            self._script = None

    def handle_data(self, data: str) -> None:
        if self._script is not None:
            self.scripts[self._script] += data


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return two_runs(tmp_path_factory.mktemp("html"))


@pytest.fixture(scope="module")
def text(runs: Path) -> str:
    out = runs / "report.html"
    write_html(find_runs(runs), out, runs)
    return out.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text: str) -> Page:
    return Page(text)


def test_hostile_names_stay_text(text: str, page: Page) -> None:
    assert HOSTILE not in text
    assert CLOSING not in text
    assert {t for t, _ in page.elements if t in ("b", "img")} == {"b", "img"}  # the page's own
    assert all(a.get("src") is None for t, a in page.elements if t == "img")
    assert not any(name.startswith("on") for _, attributes in page.elements for name in attributes)
    data = json.loads(page.scripts["data"])
    assert any(t["object"] == HOSTILE for t in data["trials"])
    assert any(CLOSING in t.get("detail", "") for t in data["trials"])


def test_charts_show_hostile_names_as_text(page: Page) -> None:
    charts = json.loads(page.scripts["charts"])
    names = charts["outcomes"]["data"][0]["y"]
    assert names == ["it's &lt;b&gt;bold&lt;", "plain"]


def test_the_policy_allows_the_pages_own_scripts_only(page: Page) -> None:
    (policy,) = [
        a["content"]
        for t, a in page.elements
        if t == "meta" and a.get("http-equiv") == "Content-Security-Policy"
    ]
    assert policy is not None
    assert policy.startswith("default-src 'none'")
    plotly = gzip.decompress(base64.b64decode(page.scripts["plotly"]))
    for script in (page.scripts["main"].encode(), plotly):
        assert f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'" in policy
    assert b"</script" not in page.scripts["main"].encode()


def test_nothing_is_fetched(page: Page) -> None:
    for tag, attributes in page.elements:
        for name in ("src", "href", "srcset", "action", "data", "poster"):
            value = attributes.get(name)
            assert value is None or value.startswith(("#", "data:")), (tag, name, value)


def test_the_same_runs_give_the_same_file(runs: Path, text: str, tmp_path: Path) -> None:
    write_html(find_runs(runs), tmp_path / "again.html", runs)
    assert (tmp_path / "again.html").read_text(encoding="utf-8") == text


def test_table_4_and_the_runs_are_in_the_page_without_any_script(text: str) -> None:
    body = re.sub(r"<script.*?</script>", "", text, flags=re.S)
    for needed in ("168/180", "88.7 % – 96.1 %", "printed 92.0 %", "8/12", "6/12", "not directly comparable"):
        assert needed in body, needed


def test_failures_come_first_where_space_is_short(runs: Path, tmp_path: Path) -> None:
    folders = find_runs(runs)
    whole = write_html(folders, tmp_path / "whole.html", runs)
    bare = write_html(folders, tmp_path / "bare.html", runs, limit=0)
    limit = bare.size + round(0.8 * (whole.size - bare.size))
    small = write_html(folders, tmp_path / "small.html", runs, limit=limit)
    assert (whole.pictures, whole.left_out, bare.pictures) == (24, 0, 0)
    assert 0 < small.left_out < 24
    assert small.size <= limit
    page = Page((tmp_path / "small.html").read_text(encoding="utf-8"))
    kept = {int(k.split("-")[2]) for k in page.scripts if k.startswith("media-")}
    trials = json.loads(page.scripts["data"])["trials"]
    shown = [t["success"] for t in trials if t["run"] == 0 and t["trial"] in kept]
    assert kept
    failures = [t for t in trials if t["run"] == 0 and not t["success"]]
    assert not any(shown) or shown.count(False) == len(failures)


def test_an_episode_has_its_attempts_with_their_pictures(tmp_path: Path) -> None:
    folder = write_clutter(tmp_path / "clutter", [["success", "missed", "success"], ["success"]])
    whole = write_html([folder], tmp_path / "r.html", tmp_path)
    assert (whole.trials, whole.pictures, whole.left_out) == (2, 5, 0)
    text = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert HOSTILE not in text
    page = Page(text)
    pictures = {k: json.loads(v) for k, v in page.scripts.items() if k.startswith("media-")}
    assert {k: sorted(v) for k, v in pictures.items()} == {
        "media-0-0-0": ["sheet"],
        "media-0-0-1": ["clip", "sheet"],
        "media-0-0-2": ["sheet"],
        "media-0-1-0": ["sheet"],
    }
    stored = (folder / "media" / "00000-01.webp").read_bytes()
    assert base64.b64decode(pictures["media-0-0-1"]["sheet"]) == stored
    first, second = json.loads(page.scripts["data"])["trials"]
    assert [a["outcome"] for a in first["attempts"]] == ["success", "missed", "success"]
    assert first["attempts"][0]["removed"] == [HOSTILE]
    assert first["attempts"][1]["quality"] == 0.1
    assert (first["outcome"], first["cleared"], second["outcome"]) == ("missed", 2, "success")
    run = Run(folder)
    failed = [folder / "media" / f"00000-01{kind}.webp" for kind in ("", "-clip")]
    budget = sum(-(-p.stat().st_size // 3) * 4 for p in failed)
    few = embed([run], rows_of(0, run, {}, {}), budget)
    assert (sorted(few.media), few.left_out) == (["0-0-1"], 3)  # what failed comes first


def test_runs_without_a_trial_have_no_report(tmp_path: Path) -> None:
    with pytest.raises(GraspBenchError, match="None of the runs holds a trial"):
        write_html([write_run(tmp_path / "empty", "oracle", [])], tmp_path / "r.html")


def test_a_file_that_cannot_be_written_is_named(runs: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(GraspBenchError, match="cannot be written"):
        write_html(find_runs(runs), tmp_path / "file" / "r.html", runs)


# ---------------------------------------------------------------- figures behind it


@pytest.mark.parametrize(
    ("value", "label"),
    [
        (0.0, "< 50 g"),
        (0.05, "50–100 g"),
        (0.0999, "50–100 g"),
        (0.4, "≥ 400 g"),
        (3.0, "≥ 400 g"),
        (None, "unknown"),
    ],
)
def test_masses_fall_into_half_open_bins(value: float | None, label: str) -> None:
    labels = breakdown.bin_labels(breakdown.MASS_EDGES, 1000, "g")
    assert breakdown.bin_of(value, breakdown.MASS_EDGES, labels) == label


def test_every_trial_is_in_one_bin_of_each_breakdown(tmp_path: Path) -> None:
    catalog = Catalog()
    files = {n: catalog.entries[n]["files"] for n in ("apple", "coffee_mug")}
    run = Run(write_run(tmp_path / "a", "oracle", ["success", "missed", "success", "slipped"], objects=files))
    facts = breakdown.object_facts(run, catalog)
    apple = facts["apple"]
    assert (apple.family, apple.mass, apple.size) == ("food", 0.15, pytest.approx(0.07394))
    for kind in breakdown.breakdowns([run], [facts]):
        rates = kind.runs[0]
        assert set(rates) <= set(kind.labels)
        assert sum(r.trials for r in rates.values()) == 4
        assert sum(r.successes for r in rates.values()) == 2
    unknown = breakdown.breakdowns([run], [facts])[0].runs[0]["unknown"]
    assert unknown == Rate(1, 2)  # the two that no catalogue knows


def test_objects_of_another_version_have_no_known_mass(tmp_path: Path) -> None:
    run = Run(write_run(tmp_path / "a", "oracle", ["success"], objects={"apple": {"visual.glb": "other"}}))
    assert breakdown.object_facts(run, Catalog()) == {}


def made(tmp_path: Path, pairs: list[tuple[float | None, bool]]) -> Trust:
    folder = write_run(tmp_path / "q", "oracle", ["success" if s else "missed" for _, s in pairs])
    lines = [json.loads(line) for line in (folder / "trials.jsonl").read_text().splitlines()]
    for line, (quality, _) in zip(lines, pairs, strict=True):
        line["grasp"] = None if quality is None else line["grasp"] | {"quality": quality}
    (folder / "trials.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    return Trust.of(RunResults(folder), [])


def test_calibration_has_the_closed_form_error(tmp_path: Path) -> None:
    trust = made(
        tmp_path, [(0.8, True), (0.8, False), (0.25, False), (0.25, False), (1.0, True), (None, False)]
    )
    found = trust.calibration
    assert found is not None
    assert (found.held.trials, trust.without) == (5, 1)
    assert [(b.quality, b.held) for b in found.bins] == [
        (0.25, Rate(0, 2)),
        (0.8, Rate(1, 2)),
        (1.0, Rate(1, 1)),
    ]
    assert found.error == pytest.approx((2 * 0.25 + 2 * 0.3 + 0) / 5)
    assert found.brier == pytest.approx((0.04 + 0.64 + 2 * 0.0625 + 0) / 5)


def test_calibration_of_a_run_without_grasps_says_nothing(tmp_path: Path) -> None:
    assert made(tmp_path, [(None, False)]).calibration is None


def test_latency_is_of_all_trials(tmp_path: Path) -> None:
    found = breakdown.latency(Run(write_run(tmp_path / "a", "oracle", ["success"] * 3)))
    assert found.phases == {"predict": pytest.approx(0.06), "execute": pytest.approx(0.5)}
    assert found.predict is not None
    assert found.total is not None
    assert found.predict.median == pytest.approx(0.06)
    assert found.total.median == pytest.approx(0.56)
    assert math.isfinite(found.total.p95)
