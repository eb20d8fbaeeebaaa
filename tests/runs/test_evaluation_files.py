"""Evaluations in files: read and written by one class, to the byte."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from grasp_bench.errors import ResultsError
from grasp_bench.runs.evaluation import Evaluation, Weights

FILES = sorted((Path(__file__).parents[2] / "results" / "evaluation").glob("*.json"))


def test_there_are_files() -> None:
    assert len(FILES) > 30


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_what_is_read_is_written_again_to_the_byte(path: Path, tmp_path: Path) -> None:
    result = Evaluation.read(path)
    result.write(tmp_path / "deep" / path.name)
    assert (tmp_path / "deep" / path.name).read_bytes() == path.read_bytes()
    assert not result.model_extra, "every key of today's files is a field"
    assert result.correct == sum(r.verdict == "correct" for r in result.records)


def test_a_key_that_nobody_knows_is_kept(tmp_path: Path) -> None:
    content = json.loads(FILES[0].read_text()) | {"note": "mine"}
    (tmp_path / "a.json").write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n")
    Evaluation.read(tmp_path / "a.json").write(tmp_path / "b.json")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"kind": "run"}, r"kind 'run', format 1"),
        ({"format": 2}, r"kind 'evaluation', format 2"),
        ({"dataset": "imagenet"}, r"dataset: Input should be 'cornell', 'jacquard' or 'synthetic'"),
        ({"verdicts": {"perfect": 3}}, r"verdicts\.perfect"),
        ({"correct": None}, r"correct: "),
    ],
)
def test_other_files_are_named_with_what_is_wrong(
    changes: dict[str, Any], reason: str, tmp_path: Path
) -> None:
    (tmp_path / "x.json").write_text(json.dumps(json.loads(FILES[0].read_text()) | changes))
    with pytest.raises(ResultsError, match=rf"x\.json is no result of .*\({reason}"):
        Evaluation.read(tmp_path / "x.json")


def test_weights_write_what_they_said_and_no_more() -> None:
    said = {"network": "gg-cnn", "begun_with": None, "data": {"folders": ["synth"]}, "seconds": 7}
    assert json.dumps(Weights.model_validate(said).model_dump(mode="json")) == json.dumps(said)
    assert not Weights.model_validate(said).saw_real_images
    assert Weights(trained={"steps": 1}).saw_real_images
    assert Weights.model_validate({"data": {"real": ["cornell"]}}).saw_real_images
