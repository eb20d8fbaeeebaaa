"""Learning curves in one figure."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

from grasp_bench.errors import ResultsError
from grasp_bench.studies.curve_chart import Curve, as_svg

SVG = "{http://www.w3.org/2000/svg}"


def training(path: Path, network: str, held: list[int], ended: str = "flat", seed: int = 0) -> Path:
    points = [
        {"step": 10 * i, "seconds": 60.0 * i, "held": h, "tried": 20, "hits": 0, "scenes": 0}
        for i, h in enumerate(held, 1)
    ]
    facts = {"network": network, "seed": seed, "steps": 10 * len(held), "ended": ended, "curve": points}
    path.write_text(json.dumps(facts | {"flops": 1e16 * len(held)}))
    return path


def test_curves_are_read_and_drawn(tmp_path: Path) -> None:
    good = Curve.read(training(tmp_path / "a.json", "gg-cnn", [5, 10, 20]))
    assert good.along("PFLOP") == [(10, 0.25), (20, 0.5), (30, 1.0)]
    assert good.along("minutes")[-1] == (3, 1.0)
    assert good.along("steps")[0] == (10, 0.25)
    cut = Curve.read(training(tmp_path / "b.json", "fcgn", [1, 2], "minutes", seed=3))
    picture = ElementTree.fromstring(as_svg([cut, good], "PFLOP"))
    lines = [e.attrib["points"].split() for e in picture.iter(f"{SVG}polyline")]
    assert [len(line) for line in lines] == [3, 2], "the better first"
    heights = [float(p.split(",")[1]) for p in lines[0]]
    assert heights == sorted(heights, reverse=True)
    assert [e.attrib["fill"] for e in picture.iter(f"{SVG}circle")][1] == "#ffffff", "cut off by the clock"
    names = [e for e in picture.iter(f"{SVG}text") if e.text in ("gg-cnn", "fcgn, seed 3")]
    assert len(names) == 2
    assert abs(float(names[0].attrib["y"]) - float(names[1].attrib["y"])) >= 14


def test_what_is_no_curve_is_named(tmp_path: Path) -> None:
    (tmp_path / "x.json").write_text("{}")
    with pytest.raises(ResultsError, match=r"x\.json is no training\.json"):
        Curve.read(tmp_path / "x.json")
    with pytest.raises(ResultsError, match="--held-out"):
        as_svg([], "steps")
