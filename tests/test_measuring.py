"""``scripts/measure_all.py``: what is measured, its tables, and that a part that was cut off goes on."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from grasp_bench.report.tables import markdown
from grasp_bench.runs.results import RunResults

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))
import measure_all
from measure_all import SEEDS, Measuring, OutOfTime, evenly, planar, suite_names


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


def test_clutter_of_all(tmp_path: Path) -> None:
    text = markdown(Measuring(["displaced"], tmp_path, 1, lambda *_: None).clutter(1))
    (episode,) = (r.clutter for r in RunResults(tmp_path / "clutter" / "displaced").records)
    assert episode is not None
    lifted, tried = sum(a.success for a in episode.attempts), len(episode.attempts)
    assert f"| displaced | {lifted}/{tried} |" in text


def test_what_was_cut_off_goes_on(tmp_path: Path) -> None:
    count = 0

    def tick(*_: object) -> None:
        nonlocal count
        count += 1
        if count == 3:
            raise OutOfTime

    with pytest.raises(OutOfTime):
        Measuring(["oracle", "displaced"], tmp_path, 1, tick).rank(2)
    there = sum(len(RunResults(tmp_path / "rank" / n)) for n in ("oracle", "displaced"))
    assert there == 3
    fresh: list[object] = []
    Measuring(["oracle", "displaced"], tmp_path, 1, lambda name, record, before: fresh.append(before)).rank(2)
    assert fresh.count(True) == 3
    assert fresh.count(False) == 1


def test_rows_of_earlier_calls_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measure_all, "suite_names", lambda: ["noisy"])
    Measuring(["oracle"], tmp_path, 1, lambda *_: None).suites(1)
    text = markdown(Measuring(["displaced"], tmp_path, 1, lambda *_: None).suites(2))
    assert "| oracle | 1/1 |" in text
    assert "| displaced | 0/2 |" in text
    monkeypatch.setattr(measure_all, "suite_names", lambda: ["heavy"])
    other = markdown(Measuring(["displaced"], tmp_path, 1, lambda *_: None).suites(1))
    assert "oracle" not in other, "rows of other columns do not belong into this table"


def test_objects_at_equal_distances() -> None:
    assert evenly("abcdefg", 3) == ["a", "c", "e"]
    assert evenly("abc", 3) == evenly("abc", 9) == ["a", "b", "c"]


def test_five_seeds_with_help_and_without(tmp_path: Path) -> None:
    text = markdown(Measuring(["oracle", "displaced"], tmp_path, 1, lambda *_: None).seeds(1))
    assert len(list((tmp_path / "seeds").iterdir())) == 2 * len(SEEDS)
    assert text.count("1, 1, 1, 1, 1 | 5/5 | 100.0% | 56.6% – 100.0% |  |") == 2
    assert text.count("0, 0, 0, 0, 0 | 0/5 | 0.0% | 0.0% – 43.4% | 0.062 |") == 2, "1 / 2⁴"
