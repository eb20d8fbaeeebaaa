"""``scripts/measure_all.py``: what is measured, and its tables."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from grasp_bench.report.tables import markdown

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))
import measure_all
from measure_all import Measuring, planar, suite_names


def test_all_are_measured_where_they_differ() -> None:
    assert {"htc-grasp", "oracle", "random-10"} < set(planar(helped=True))
    assert set(planar(helped=True)) - set(planar(helped=False)) == {"random-10"}
    assert {"wide", "grid", "office"} < set(suite_names())
    assert not {"table4", "clutter", "graded", "as-predicted", "side-grasps"} & set(suite_names())


def test_every_part_has_a_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measure_all, "suite_names", lambda: ["noisy"])
    all_of = Measuring(["oracle", "displaced"], tmp_path, 1, lambda *_: None)
    ranked, worlds = markdown(all_of.rank(2)), markdown(all_of.physics(1, 1))
    assert "Who is better: 1–2" in ranked
    assert "oracle before displaced" in worlds
    assert "| oracle | 1/1 |" in markdown(all_of.suites(1))
