"""Agreement of physics and real images: SIMPLER's measures, their intervals, the table and the picture."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from support.made_up_runs import write_run
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.errors import ResultsError
from grasp_bench.report.agreement import agreement, mmrv, pearson
from grasp_bench.report.agreement_chart import as_svg
from grasp_bench.runs.evaluation import Evaluation, Record
from grasp_bench.runs.results import RunResults

RESULTS = Path(__file__).resolve().parents[2] / "results"
NAMES = ("a", "b", "c", "d")
TEMPLATE = RESULTS / "evaluation" / "cornell-htc-grasp-zero-shot-strict.json"


def evaluated(name: str, right: int, images: int = 40) -> Evaluation:
    """An evaluation with the first ``right`` images right."""
    records = [
        Record(
            fold=1,
            image=f"{i:03d}",
            object=None,
            verdict="correct" if i < right else "elsewhere",
            iou=0.5,
            milliseconds=1.0,
            cpu_milliseconds=1.0,
            labels=1,
            dropped=0,
        )
        for i in range(images)
    ]
    facts = {"predictor": name, "records": records, "correct": right, "images": images}
    return Evaluation.read(TEMPLATE).model_copy(update=facts)


def runs(folder: Path, wins: dict[str, int], **more: Any) -> list[RunResults]:
    """A run a predictor, the first trials won."""
    objects = {f"object{i:02d}": {"object.json": "x"} for i in range(30)}
    return [
        RunResults(write_run(folder / n, 30, lambda t, k=k: t < k, objects=objects, predictor=n, **more))
        for n, k in wins.items()
    ]


def test_measures_by_hand() -> None:
    real = np.array([0.2, 0.5, 0.9])
    assert mmrv(np.array([0.1, 0.2, 0.3]), real) == 0.0
    # The first two exchanged: each of them is at most 0.3 out of order, the third is right with both.
    assert mmrv(np.array([0.2, 0.1, 0.3]), real) == pytest.approx((0.3 + 0.3 + 0) / 3)
    # Turned round: the largest gaps are 0.7, 0.4 and 0.7.
    assert mmrv(np.array([0.3, 0.2, 0.1]), real) == pytest.approx((0.7 + 0.4 + 0.7) / 3)
    assert pearson(np.array([0.1, 0.2, 0.3]), np.array([0.2, 0.4, 0.6])) == pytest.approx(1)
    assert pearson(np.array([0.1, 0.2, 0.3]), np.array([0.6, 0.4, 0.2])) == pytest.approx(-1)
    assert np.isnan(pearson(np.array([0.1, 0.1, 0.1]), real))


def test_orders_that_agree_and_that_do_not(tmp_path: Path) -> None:
    tried = runs(tmp_path, dict(zip(NAMES, (8, 15, 21, 28), strict=True)))
    alike = agreement(tried, [evaluated(n, k) for n, k in zip(NAMES, (10, 20, 28, 38), strict=True)])
    turned = agreement(tried, [evaluated(n, k) for n, k in zip(NAMES, (38, 28, 20, 10), strict=True)])
    assert alike.pearson.value > 0.99
    assert alike.mmrv.value == 0
    assert turned.pearson.value < -0.99
    assert turned.mmrv.value > 0.4
    for found in (alike, turned):
        for measure in (found.pearson, found.mmrv):
            assert measure.low <= measure.high
            assert measure.low - 0.01 <= measure.value <= measure.high + 0.01
    assert [p.predictor for p in alike.points] == ["d", "c", "b", "a"]
    assert alike == agreement(
        tried[::-1], [evaluated(n, k) for n, k in zip(NAMES, (10, 20, 28, 38), strict=True)]
    )


def test_intervals_narrow_with_more_images(tmp_path: Path) -> None:
    tried = runs(tmp_path, dict(zip(NAMES, (8, 21, 15, 28), strict=True)))
    few = agreement(tried, [evaluated(n, k, 20) for n, k in zip(NAMES, (6, 9, 12, 17), strict=True)])
    many = agreement(tried, [evaluated(n, 20 * k, 400) for n, k in zip(NAMES, (6, 9, 12, 17), strict=True)])
    assert many.mmrv.high - many.mmrv.low < few.mmrv.high - few.mmrv.low


def test_what_cannot_be_compared(tmp_path: Path) -> None:
    tried = runs(tmp_path / "a", {"a": 8, "b": 15, "c": 20})
    images = [evaluated(n, 10) for n in "abc"]
    with pytest.raises(ResultsError, match=r"only 2 predictors .*\(a, b\).* Measure more of: c, x"):
        agreement(tried, [*images[:2], evaluated("x", 3)])
    with pytest.raises(ResultsError, match="a has more than one evaluation"):
        agreement(tried, [*images, images[0]])
    with pytest.raises(ResultsError, match="runs of several scenarios: office, table4"):
        agreement([*tried, *runs(tmp_path / "b", {"d": 3}, scenario={"name": "office"})], images)
    with pytest.raises(ResultsError, match="nothing there to take a data set from"):
        agreement(tried, [])


def test_command_prints_and_draws(tmp_path: Path) -> None:
    runs(tmp_path / "runs", {"a": 8, "b": 15, "c": 20, "only_tried": 9})
    folder = tmp_path / "images"
    for n, k in (("a", 10), ("b", 25), ("c", 31)):
        evaluated(n, k).write(folder / f"{n}.json")
    shutil.copy(RESULTS / "evaluation" / "cornell-htc-grasp-5-folds-strict.json", folder)  # is left out
    svg = tmp_path / "new" / "agreement.svg"
    words = ["agree", str(tmp_path / "runs"), "--evaluations", str(folder)]
    shown = CliRunner().invoke(app, [*words, "--out", str(svg)])
    assert shown.exit_code == 0, shown.output
    assert "only_tried" in shown.output
    assert "Pearson" in shown.output
    texts = [e.text for e in ElementTree.parse(svg).iter("{http://www.w3.org/2000/svg}text")]
    assert {"1 c", "2 b", "3 a"} <= set(texts)
    found = json.loads(CliRunner().invoke(app, [*words, "--json"]).output)
    assert found["pearson"]["value"] > 0.9
    assert found["left_out"] == ["only_tried"]
    wrong = CliRunner().invoke(app, [*words, "--dataset", "cornel"])
    assert wrong.exit_code != 0
    assert "cornell" in str(wrong.exception)


def test_picture_shows_names_as_text(tmp_path: Path) -> None:
    tried = runs(tmp_path, {"<b>&": 8, "b": 15, "c": 20})
    svg = as_svg(agreement(tried, [evaluated(n, 10 + i) for i, n in enumerate(("<b>&", "b", "c"))]))
    assert "3 <b>&" in [e.text for e in ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")]
