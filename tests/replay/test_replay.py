"""Replay: a recorded trial done again is the same to the bit, and can be told and shown."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
import sys
import threading
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from grasp_bench.camera import CameraPose, Intrinsics, RgbdImage
from grasp_bench.errors import GraspBenchError, ResultsError
from grasp_bench.execution.here import Here
from grasp_bench.execution.runner import run
from grasp_bench.media.clouds import point_cloud
from grasp_bench.media.meshes import Stage
from grasp_bench.media.recording import Moment
from grasp_bench.media.store import find
from grasp_bench.predictors import load_predictor
from grasp_bench.predictors.controls import Displaced
from grasp_bench.replay import video, viewer
from grasp_bench.replay.rebuild import Replay, rebuild
from grasp_bench.replay.rerender import missing, rerender
from grasp_bench.replay.story import _contact, story
from grasp_bench.runs.jobs import Settings, spread
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.touch import Touch
from grasp_bench.system.machine import THREADS


@pytest.fixture(scope="module")
def folder(toy_catalog: Path, scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of three trials, one on each toy; the last object's second attempt would be trial 5."""
    out = tmp_path_factory.mktemp("replay") / "run"
    settings = Settings(scenario, toy_catalog.resolve(), "displaced", 5, "raycast")
    run(settings, spread(["bar", "block", "pot"], 4), out, 1, executor=Here(load_predictor("displaced")))
    return out


@pytest.fixture(scope="module")
def again(folder: Path, toy_catalog: Path) -> Replay:
    """Trial 3, the second attempt on the bar."""
    return rebuild(folder, 3, toy_catalog)


@pytest.fixture
def changed(folder: Path, tmp_path: Path) -> Callable[..., Path]:
    """A copy of the run with something else in a trial's record or in run.json."""

    def make(trial: int | None = None, **values: Any) -> Path:
        copy = tmp_path / "copy"
        shutil.copytree(folder, copy, dirs_exist_ok=True)
        if trial is None:
            path = copy / "run.json"
            path.write_text(json.dumps(json.loads(path.read_text()) | values))
        else:
            path = copy / "trials.jsonl"
            lines = [json.loads(line) for line in path.read_text().splitlines()]
            lines = [r | values if r["trial"] == trial else r for r in lines]
            path.write_text("".join(json.dumps(r, ensure_ascii=False) + "\n" for r in lines))
        return copy

    return make


def test_a_trial_done_again_is_the_same_to_the_bit(again: Replay) -> None:
    assert again.identical
    assert (again.differs, again.causes) == ([], [])
    assert again.stored.object == "bar"
    assert [t.done.record.trial for t in again.takes] == [3]


def test_what_differs_is_named_with_what_may_have_caused_it(
    changed: Callable[..., Path], toy_catalog: Path
) -> None:
    copy = changed(1, outcome="slipped", sim_steps=1)
    written = json.loads((copy / "run.json").read_text())
    written["versions"]["mujoco"] = "3.1"
    (copy / "run.json").write_text(json.dumps(written))
    found = rebuild(copy, 1, toy_catalog)
    assert not found.identical
    assert found.differs[0] == 'outcome: "slipped" in the record, "missed" now'
    assert any(d.startswith("sim_steps: 1 in the record") for d in found.differs)
    assert len(found.differs) == 2
    assert any("mujoco" in c and "3.1" in c for c in found.causes)


def test_the_predictor_is_closed(folder: Path, toy_catalog: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[bool] = []
    monkeypatch.setattr(Displaced, "close", lambda self: closed.append(True), raising=False)
    assert rebuild(folder, 0, toy_catalog).identical
    assert closed == [True]


def test_a_shipped_predictor_is_no_cause(changed: Callable[..., Path], toy_catalog: Path) -> None:
    found = rebuild(changed(0, sim_steps=1), 0, toy_catalog)
    assert len(found.differs) == 1
    assert found.causes == []


def test_another_predictor_of_the_same_name_is_a_cause(
    changed: Callable[..., Path], toy_catalog: Path
) -> None:
    changed(0, sim_steps=1)
    copy = changed(
        predictor="fake_predictors:ByColour", implementation={"files": {"fake_predictors.py": "ab"}}
    )
    found = rebuild(copy, 3, toy_catalog, trust=True)
    assert any("the predictor's files" in cause and "fake_predictors.py" in cause for cause in found.causes)


def test_a_trial_that_is_not_there_is_named(folder: Path, toy_catalog: Path) -> None:
    with pytest.raises(ResultsError, match="no trial 17; it holds 4, 0 to 3"):
        rebuild(folder, 17, toy_catalog)


def test_a_record_of_another_object_is_refused(changed: Callable[..., Path], toy_catalog: Path) -> None:
    with pytest.raises(ResultsError, match="is of pot in its record and of block in run"):
        rebuild(changed(1, object="pot"), 1, toy_catalog)


def test_the_command_verifies_tells_and_ends_with_1_where_it_differs(
    folder: Path,
    changed: Callable[..., Path],
    toy_catalog: Path,
    cli: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in THREADS:
        monkeypatch.setenv(name, "1")
    options = f"--trial 0 --objects {toy_catalog}"
    code, out, err = cli(f"replay {folder} {options}")
    assert (code, err) == (0, "")
    assert "Verified: the record is the same to the bit." in out
    code, out, err = cli(f"replay {changed(0, lift_height=0.5)} {options}")
    assert code == 1
    assert "lift_height: 0.5 in the record, 0.0 now" in err
    assert "Verified" not in out
    code, out, err = cli(f"replay {changed(0, lift_height=0.00005)} {options}")
    assert (code, err) == (0, "")
    assert "Verified: the record is the same within rounding.\n  lift_height: 5e-05 in the record, 0.0" in out
    code, _, err = cli(f"replay {folder} {options} --video film.doc")
    assert (code, "not .doc" in err) == (2, True)


# ---------------------------------------------------------------- told


def test_the_story_goes_from_the_picture_to_the_end(again: Replay) -> None:
    told = story(again)
    assert [line.split(":")[0] for line in told] == [
        "Trial 3",
        "Seen",
        "Proposed",
        "Planned",
        "Reached",
        "Held",
        "Ended",
    ]
    assert told[-2] == "Held: never; no finger touched it."
    assert told[-1] == "Ended: missed, the fingers closed without holding the object."


def moments(*forces: tuple[float, float]) -> list[Moment]:
    return [Moment(float(i), np.zeros(1), np.zeros(1), Touch(a, b, ())) for i, (a, b) in enumerate(forces)]


@pytest.mark.parametrize(
    ("forces", "told"),
    [
        ([(0, 0), (5, 6), (5, 6)], "Held: by both fingers from 1.00 s to the end at 2.00 s."),
        (
            [(0, 0), (5, 6), (5, 0)],
            "Held: by both fingers from 1.00 s to 1.00 s, when the right finger lost it.",
        ),
        ([(5, 6), (5, 6), (0, 0)], "Held: by both fingers from 0.00 s to 1.00 s, when both fingers lost it."),
        ([(0, 0), (5, 0)], "Held: never by both fingers; one touched it from 1.00 s on."),
        ([(0, 0)], "Held: never; no finger touched it."),
    ],
)
def test_who_lost_the_object_is_told(forces: list[tuple[float, float]], told: str) -> None:
    assert _contact(moments(*forces)) == [told]


# ---------------------------------------------------------------- shown


@pytest.mark.parametrize("name", ["film.gif", "film.webp"])
def test_films_without_any_extra(again: Replay, tmp_path: Path, name: str) -> None:
    out = tmp_path / name
    count = video.write_film(again, out, (160, 120))
    film = Image.open(out)
    assert film.size == (160, 120)
    assert 10 < getattr(film, "n_frames", 1) <= count


def test_films_by_ffmpeg(again: Replay, tmp_path: Path) -> None:
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    out = tmp_path / "film.mp4"
    count = video.write_film(again, out, (160, 120))
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(out))
    assert frames == count
    assert seconds == pytest.approx(count / 25, abs=0.1)


def test_films_of_unknown_kinds_name_the_known(tmp_path: Path) -> None:
    with pytest.raises(GraspBenchError, match=r"films end in .mp4.*not .avi"):
        video.check_kind(tmp_path / "film.avi")


def test_a_missing_ffmpeg_is_told_with_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    with pytest.raises(GraspBenchError, match=r"grasp-bench\[video\]"):
        video.check_kind(Path("film.mp4"))
    assert video.check_kind(Path("film.webp")) > 0


def test_the_viewer_needs_a_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(GraspBenchError, match="--browser"):
        viewer.check_display()


def test_a_web_page_shows_every_state(again: Replay) -> None:
    viser = pytest.importorskip("viser")
    from grasp_bench.replay.browser import BrowserReplay

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    server = viser.ViserServer(host="127.0.0.1", port=port, verbose=False)
    try:
        shown = BrowserReplay(again, server)
        with urllib.request.urlopen(f"http://127.0.0.1:{server.get_port()}/", timeout=60) as answer:
            assert answer.status == 200
        assert again.takes[0].done.world is not None
        hand = again.takes[0].done.world.model.body("arm/gripper/gripper").id
        shown.show_time(0.0)
        before = np.array(shown._bodies[hand].position)
        shown.show_time(shown.duration)
        after = np.array(shown._bodies[hand].position)
        assert np.linalg.norm(after - before) > 0.02
        assert after == pytest.approx(again.takes[0].done.world.data.xpos[hand], abs=1e-3)
        stop = threading.Event()
        shown.slider.value = 0.0
        playing = threading.Thread(target=shown.play, args=(stop,))
        playing.start()
        while shown.slider.value == 0.0:
            assert playing.is_alive()
        stop.set()
        playing.join()
    finally:
        server.stop()


def test_a_rerun_recording_holds_pictures_points_joints_and_forces(again: Replay, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    from grasp_bench.media.rerun_log import log_take, merge, writing

    parts = [tmp_path / "a.rrd", tmp_path / "b.rrd"]
    for part in parts:
        with writing(part, "one") as stream:
            log_take(stream, again.takes[0], again.scenario)
    merge(parts, tmp_path / "all.rrd")
    assert (tmp_path / "all.rrd").stat().st_size > parts[0].stat().st_size
    printed = subprocess.run(
        [sys.executable, "-m", "rerun", "rrd", "print", str(tmp_path / "all.rrd")],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    for entity in (
        "world/camera/rgb",
        "world/camera/depth",
        "world/points",
        "world/grasp",
        "joints/position",
        "joints/velocity",
        "gripper/force",
        "gripper/opening",
    ):
        assert f"/trial_00003/{entity} " in printed, entity


def test_recordings_that_cannot_be_joined_are_told(tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    from grasp_bench.media.rerun_log import merge

    with pytest.raises(GraspBenchError, match="could not be joined from its 1 parts"):
        merge([tmp_path / "missing.rrd"], tmp_path / "all.rrd")


@pytest.mark.parametrize(
    ("module", "call", "extra"),
    [
        ("viser", "grasp_bench.replay.browser:import_viser", "viewer"),
        ("rerun", "grasp_bench.media.rerun_log:import_rerun", "rerun"),
    ],
)
def test_missing_extras_are_told_with_the_remedy(
    monkeypatch: pytest.MonkeyPatch, module: str, call: str, extra: str
) -> None:
    from importlib import import_module

    monkeypatch.setitem(__import__("sys").modules, module, None)
    home, _, name = call.partition(":")
    with pytest.raises(GraspBenchError, match=rf"grasp-bench\[{extra}\]"):
        getattr(import_module(home), name)()


# ---------------------------------------------------------------- pictures afterwards


def test_pictures_are_made_again_for_trials_that_end_as_recorded(
    changed: Callable[..., Path], toy_catalog: Path
) -> None:
    copy = changed(2, sim_steps=1)
    before = (copy / "trials.jsonl").read_bytes()
    assert sorted(missing(copy, "failures")) == [0, 1, 2, 3]
    done = rerender(copy, "failures", toy_catalog, workers=1)
    assert (done.made, done.differing, done.failed) == (3, (2,), {})
    assert find(copy, 0).sheet is not None
    assert find(copy, 0).clip is not None
    assert find(copy, 2).sheet is None
    assert (copy / "trials.jsonl").read_bytes() == before
    assert sorted(missing(copy, "failures")) == [2]


# ---------------------------------------------------------------- geometry


def test_points_lie_where_the_depth_says() -> None:
    intrinsics = Intrinsics.from_fov(64, 48, np.pi / 2)
    depth = np.full((48, 64), 0.5, np.float32)
    depth[10, 20] = 0
    image = RgbdImage(np.zeros((48, 64, 3), np.uint8), depth, intrinsics)
    pose = CameraPose.look_at((0.5, 0, 0.5), (0.5, 0, 0), (1, 0, 0))
    points, colors = point_cloud(image, pose, step=1)
    assert points.shape == colors.shape == (64 * 48 - 1, 3)
    assert np.abs(points[:, 2]).max() < 1e-9
    # At 0.5 m with 90° the picture is 1 m wide; its rows run along x.
    assert np.ptp(points[:, 1]) == pytest.approx(63 / 64)


def test_meshes_lie_where_mujoco_has_its_geoms(again: Replay) -> None:
    assert again.takes[0].done.world is not None
    model, data = again.takes[0].done.world.model, again.takes[0].done.world.data
    stage = Stage(model)
    found = stage.meshes
    assert {model.body(m.body).name for m in found} >= {"world", "object"}
    ours = [m for m in found if model.body(m.body).name == "object"]
    import mujoco

    body = model.body("object").id
    position, quaternion = stage.poses(data.qpos)[body]
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, quaternion)
    lowest = min(((m.vertices @ rotation.reshape(3, 3).T + position)[:, 2]).min() for m in ours)
    assert lowest == pytest.approx(0, abs=2e-3)  # missed, so it still stands on the table
