"""What is kept and shown of the attempts of an episode: pictures, clips, replays, films and logs."""

from __future__ import annotations

import json
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from grasp_bench import api
from grasp_bench.camera import RgbdImage
from grasp_bench.errors import ResultsError
from grasp_bench.execution.here import Here
from grasp_bench.execution.runner import run
from grasp_bench.grasps import Grasp, GraspMaps
from grasp_bench.media import store
from grasp_bench.media.cost import describe_cost
from grasp_bench.media.recording import Recording
from grasp_bench.media.takes import Take
from grasp_bench.predictors import load_predictor
from grasp_bench.predictors.controls import Oracle
from grasp_bench.replay import video
from grasp_bench.replay.rebuild import Replay, rebuild
from grasp_bench.replay.rerender import missing, rerender
from grasp_bench.replay.story import story
from grasp_bench.report.html.page import write_html
from grasp_bench.runs.jobs import MEDIA_TIME, Settings, spread
from grasp_bench.runs.record import TrialRecord
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.sections import Clutter, Scenario
from grasp_bench.trials.attempt import Trial
from grasp_bench.trials.clock import Clock

NAMES = ["pot", "bar"]
"""Not in the manifest's order: episodes are led in this one."""


@pytest.fixture(scope="module")
def crowd(scenario: Scenario) -> Scenario:
    """Two objects, two failures allowed."""
    small = Clutter(fewest=2, most=2, workspace=(0.08, 0.08), failures=2)
    return scenario.model_copy(
        update={
            "clutter": small,
            "objects": scenario.objects.model_copy(update={"names": dict.fromkeys(NAMES, "")}),
        }
    )


def clear(crowd: Scenario, objects: Path, out: Path, **kept: Any) -> Path:
    """A run of an episode led by the pot, both of whose attempts miss."""
    settings = Settings(crowd, objects.resolve(), "displaced", 4, "raycast", folder=out, **kept)
    run(settings, spread(NAMES, 1), out, 1, executor=Here(load_predictor("displaced")))
    return out


@pytest.fixture(scope="module")
def plain(crowd: Scenario, toy_catalog: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One of which nothing is kept but its record."""
    return clear(crowd, toy_catalog, tmp_path_factory.mktemp("plain") / "run")


@pytest.fixture(scope="module")
def again(plain: Path, toy_catalog: Path) -> Replay:
    return rebuild(plain, 0, toy_catalog)


def names_in(folder: Path) -> list[str]:
    return sorted(p.name for p in (folder / store.FOLDER).iterdir())


def test_each_attempt_is_kept_and_changes_no_record(
    plain: Path, crowd: Scenario, toy_catalog: Path, tmp_path: Path
) -> None:
    out = clear(crowd, toy_catalog, tmp_path / "run", media="failures")
    assert (out / "trials.jsonl").read_bytes() == (plain / "trials.jsonl").read_bytes()
    assert names_in(out) == ["00000-00-clip.webp", "00000-00.webp", "00000-01-clip.webp", "00000-01.webp"]
    first, second = (store.find(out, 0, k).sheet for k in (0, 1))
    assert first is not None
    assert second is not None
    assert Image.open(first).size == (2 * store.TILE, 2 * store.TILE)
    assert first.read_bytes() != second.read_bytes()
    assert "pictures of 2 attempts and 2 clips" in describe_cost(out)
    written = write_html([out], tmp_path / "r.html")
    assert (written.trials, written.pictures) == (1, 4)
    store.remove(out, 0)
    assert names_in(out) == []


def test_clips_are_of_the_attempts_that_failed(crowd: Scenario, toy_catalog: Path, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    log = tmp_path / "all.rrd"
    finished = api.run(
        toy_catalog, 1, Oracle(), crowd, out=tmp_path / "run", progress=False, media="failures", rerun=log
    )
    assert log.stat().st_size > 10_000
    assert not list((finished.folder / store.FOLDER).glob("*.rrd"))
    (line,) = (finished.folder / "trials.jsonl").read_text().splitlines()
    assert finished.info.tried == ["bar", "block", "pot"]  # what was asked for, not what the scenario names
    attempts = json.loads(line)["clutter"]["attempts"]
    assert any(a["success"] for a in attempts)
    for number, attempt in enumerate(attempts):
        media = store.find(finished.folder, 0, number)
        assert media.sheet is not None
        assert (media.clip is not None) == (not attempt["success"])


def test_pictures_may_take_their_time_for_each_object(crowd: Scenario, toy_catalog: Path) -> None:
    settings = Settings(crowd, toy_catalog, "oracle", 0, "raycast", media="all")
    assert settings.time_limit == crowd.trial_timeout + 2 * MEDIA_TIME


def test_faults_name_the_attempt(tmp_path: Path) -> None:
    (tmp_path / store.FOLDER).mkdir()
    store.note_fault(tmp_path, 3, ValueError("odd"), 2)
    store.note_fault(tmp_path, 4, ValueError("odd"))
    assert store.faults(tmp_path) == {3: "attempt 2: ValueError: odd", 4: "ValueError: odd"}


def test_maps_of_an_earlier_picture_are_not_those_of_a_failed_predictor() -> None:
    zeros = np.zeros((2, 2), np.float32)

    class Network:
        last_maps = GraspMaps(zeros, zeros, zeros, zeros)
        crop_origin = (3, 4)

        def predict(self, image: RgbdImage) -> list[Grasp]:
            return []

    for outcome, maps in ((Outcome.ERROR, None), (Outcome.NO_GRASP, Network.last_maps)):
        done = Trial(TrialRecord(trial=0, object="bar", category="tools", seed=0, outcome=outcome), Clock())
        take = Take.of(done, Recording(), Network(), 1)
        assert take.maps is maps
        assert (take.origin, take.attempt, take.moments) == ((3, 4), 1, [])


# ---------------------------------------------------------------- replays


def test_an_episode_done_again_is_the_same_to_the_bit(again: Replay) -> None:
    assert again.identical
    assert again.differs == []
    assert again.record.object == "pot"
    assert again.run.tried == NAMES
    assert [t.attempt for t in again.takes] == [0, 1]
    told = story(again)
    assert [line.split(":")[0] for line in told] == [
        "Trial 0",
        "On the table",
        *("Attempt 0", "Seen", "Proposed", "Planned", "Reached", "Held", "Ended"),
        *("Attempt 1", "Seen", "Proposed", "Planned", "Reached", "Held", "Ended"),
        "Table",
    ]
    assert "2 of 2 objects left" in told[-1]


def test_one_attempt_alone_is_shown_and_the_whole_verified(
    plain: Path, toy_catalog: Path, tmp_path: Path
) -> None:
    text = (plain / "trials.jsonl").read_text()
    changed = tmp_path / "changed"
    changed.mkdir()
    (changed / "run.json").write_bytes((plain / "run.json").read_bytes())
    record = json.loads(text)
    record["clutter"]["attempts"][0]["sim_steps"] = 1
    (changed / "trials.jsonl").write_text(json.dumps(record) + "\n")
    found = rebuild(changed, 0, toy_catalog, attempt=1)
    assert [t.attempt for t in found.takes] == [1]
    assert not found.identical
    assert len(found.differs) == 1
    assert found.differs[0].startswith("attempt 0, sim_steps: 1 in the record, ")
    assert not any(line.startswith("Attempt 0") for line in story(found))


def test_an_attempt_that_is_not_there_is_named(plain: Path, toy_catalog: Path) -> None:
    with pytest.raises(ResultsError, match="no attempt 2; it has 2, 0 to 1"):
        rebuild(plain, 0, toy_catalog, attempt=2)


def test_a_film_shows_one_attempt_after_the_other(again: Replay, tmp_path: Path) -> None:
    out = tmp_path / "film.webp"
    count = video.write_film(again, out, (96, 72))
    frames = list(video._frames(again, 12.5, (96, 72), opengl=False))
    assert count == len(frames)
    apart = [int(np.abs(a.astype(int) - b).max()) for a, b in pairwise(frames)]
    still = [i for i, d in enumerate(apart) if d == 0]
    assert len(still) >= 2 * 12  # both ends stay a second
    middle = next(i for i in range(still[0], len(apart)) if apart[i])
    assert middle < len(frames) - 20  # and something moves between them


def test_a_log_has_an_entity_for_each_attempt(again: Replay, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    from grasp_bench.media.rerun_log import log_take, writing

    with writing(tmp_path / "one.rrd") as stream:
        for take in again.takes:
            log_take(stream, take, again.scenario)
    printed = subprocess.run(
        [sys.executable, "-m", "rerun", "rrd", "print", str(tmp_path / "one.rrd")],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    for number in (0, 1):
        for entity in ("world/camera/rgb", "gripper/force"):
            assert f"/trial_00000/attempt_{number:02}/{entity} " in printed


def test_pictures_of_attempts_are_made_afterwards(plain: Path, toy_catalog: Path, tmp_path: Path) -> None:
    folder = tmp_path / "copy"
    folder.mkdir()
    for name in ("run.json", "trials.jsonl"):
        (folder / name).write_bytes((plain / name).read_bytes())
    assert sorted(missing(folder, "failures")) == [0]
    done = rerender(folder, "failures", toy_catalog, workers=1)
    assert (done.made, done.differing, done.failed) == (1, (), {})
    assert names_in(folder) == ["00000-00-clip.webp", "00000-00.webp", "00000-01-clip.webp", "00000-01.webp"]
    assert missing(folder, "failures") == {}
    (folder / store.FOLDER / "00000-01.webp").unlink()
    assert sorted(missing(folder, "failures")) == [0]
