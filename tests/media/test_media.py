"""Pictures and clips of trials: what is drawn, that it changes no record, and what it costs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grasp_bench.camera import RgbdImage
from grasp_bench.errors import UnknownNameError
from grasp_bench.execution import worker
from grasp_bench.grasps import Grasp, GraspMaps
from grasp_bench.media import store
from grasp_bench.media.cost import describe_cost
from grasp_bench.media.film import Filmer, View, side_view, with_sky
from grasp_bench.media.modes import MODES, check_mode
from grasp_bench.media.pictures import NO_DEPTH, RED, TILE, crop_for, depth, proposed, seen
from grasp_bench.media.recording import Recording
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.predictors import load_predictor
from grasp_bench.runs.jobs import Job, Settings
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.rendering import raycast
from grasp_bench.trials.attempt import Trial
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell


@pytest.fixture(scope="module")
def watched(scenario: Scenario, models: dict[str, ObjectModel]) -> tuple[Trial, Recording]:
    """An oracle's trial on the block, every 50th sample of it kept."""
    recording = Recording(50, touches=True)
    done = run_trial(
        Workcell(scenario),
        models["block"],
        load_predictor("oracle"),
        trial=0,
        attempt=0,
        seed=3,
        observer=recording,
    )
    return done, recording


@pytest.fixture(scope="module")
def image(scenario: Scenario) -> RgbdImage:
    """A red square on grey, nearer than what is around it, and a hole in the depth."""
    intrinsics = scenario.camera.intrinsics
    rgb = np.full((240, 320, 3), 90, np.uint8)
    measured = np.full((240, 320), 0.55, np.float32)
    rgb[100:140, 140:180] = (200, 20, 20)
    measured[100:140, 140:180] = 0.5
    measured[0:60] = 0
    return RgbdImage(rgb, measured, intrinsics)


def test_records_are_the_same_with_and_without_media(
    toy_catalog: Path, scenario: Scenario, tmp_path: Path
) -> None:
    lines = {}
    for predictor in ("oracle", "displaced"):
        for mode in MODES:
            run = tmp_path / f"{predictor}-{mode}"
            settings = Settings(scenario, toy_catalog, predictor, 0, "raycast", media=mode, folder=run)
            worker.load((predictor,))
            (answer,) = worker.do(settings, Job(4, "block", 1))
            record = answer.record
            lines[predictor, mode] = record.line()
            assert ("media" in answer.timings.seconds) == (mode != "none")
            media = store.find(run, 4)
            assert (media.sheet is not None) == (mode != "none")
            assert (media.clip is not None) == store.wanted(mode, record.success)
        assert len({lines[predictor, mode] for mode in MODES}) == 1
    assert '"outcome": "success"' in lines["oracle", "none"]
    assert '"outcome": "missed"' in lines["displaced", "none"]


def test_sheets_and_clips_are_small_and_move(
    watched: tuple[Trial, Recording], scenario: Scenario, tmp_path: Path
) -> None:
    done, recording = watched
    recorder = store.PictureRecorder(tmp_path, "all", scenario)
    recorder.moments, recorder.touches = recording.moments, recording.touches
    recorder.keep(done, load_predictor("oracle"))
    media = store.find(tmp_path, 0)
    assert media.sheet is not None
    assert media.clip is not None
    assert Image.open(media.sheet).size == (2 * TILE, 2 * TILE)
    clip = Image.open(media.clip)
    frames = getattr(clip, "n_frames", 1)  # equal ones are stored once
    assert clip.size == store.CLIP_SIZE
    assert 15 < frames <= len(recording.moments) + 1
    first = np.asarray(clip.convert("RGB")).astype(int)
    clip.seek(frames - 1)
    assert np.abs(np.asarray(clip.convert("RGB")).astype(int) - first).max() > 60
    assert media.sheet.stat().st_size < 40_000
    assert media.clip.stat().st_size < 100_000
    assert store.faults(tmp_path) == {}


def test_what_goes_wrong_is_written_down_and_told(
    watched: tuple[Trial, Recording], scenario: Scenario, tmp_path: Path
) -> None:
    class Odd:
        last_maps = "not maps"

    store.PictureRecorder(tmp_path, "failures", scenario).keep(watched[0], Odd())
    assert list(store.faults(tmp_path)) == [0]
    (tmp_path / "timings.jsonl").write_text('{"trial": 0, "execute": 3.0, "media": 1.0}\n')
    told = describe_cost(tmp_path)
    assert "1.00 s a trial, 25% of its time (mean of 1 trials)" in told
    assert "Those of 1 trials could not be made; trial 0: AttributeError" in told


def test_an_unknown_choice_names_the_valid_ones() -> None:
    with pytest.raises(UnknownNameError, match="failures"):
        check_mode("failure")


# ---------------------------------------------------------------- recording and film


def test_a_recording_keeps_every_nth_sample_and_the_touches(watched: tuple[Trial, Recording]) -> None:
    done, recording = watched
    assert done.world is not None
    times = np.diff([m.time for m in recording.moments])
    assert times == pytest.approx(50 * 0.004)
    touches = [m.touch for m in recording.moments]
    assert touches[0] is not None
    assert touches[-1] is not None
    assert not touches[0].held
    assert touches[-1].held
    assert recording.moments[0].qpos.shape == (done.world.model.nq,)


def test_casting_only_what_moves_gives_the_whole_picture(
    watched: tuple[Trial, Recording], scenario: Scenario
) -> None:
    done, recording = watched
    assert done.world is not None
    with Filmer(done.world.model, scenario, (96, 72)) as filmer:
        for moment in (recording.moments[0], recording.moments[-1]):
            quick = filmer.shoot(moment.qpos)
            intrinsics, directions = filmer._rays
            assert (intrinsics.width, intrinsics.height) == (96, 72)
            whole = raycast(done.world.model, filmer._data, side_view(scenario).pose.position, directions)
            np.testing.assert_array_equal(quick, with_sky(whole))


def test_a_view_is_that_of_mujocos_free_camera() -> None:
    pose = View((0.4, 0.1, 0.2), distance=2.0, azimuth=90.0, elevation=-30.0).pose
    # Azimuth 90° looks along y; 30° from above, 2 m away.
    assert pose.position == pytest.approx([0.4, 0.1 - 2 * np.cos(np.pi / 6), 0.2 + 1.0])
    assert pose.rotation[:, 2] == pytest.approx([0, np.cos(np.pi / 6), -0.5])


# ---------------------------------------------------------------- pictures


def test_the_crop_holds_the_grasp_wherever_it_is(image: RgbdImage) -> None:
    middle = crop_for(image, [])
    assert (middle.side, middle.x, middle.y) == (224, 48, 8)
    far = Grasp(300.0, 120.0, 0.0, 30.0)
    crop = crop_for(image, [far])
    corners = crop.place(far).rectangle()
    assert corners.min() >= 0
    assert corners.max() <= TILE
    assert not crop.cut(image.rgb)[:10].any()  # above the image there is nothing


def test_the_grasp_is_drawn_where_it_is(image: RgbdImage) -> None:
    grasp = Grasp(160.0, 120.0, 0.0, 60.0)
    crop = crop_for(image, [grasp])
    plain, drawn = seen(image, crop, None), seen(image, crop, grasp)
    changed = np.argwhere((plain != drawn).any(-1))
    shown = crop.place(grasp)
    assert changed.mean(0) == pytest.approx([shown.y - 0.5, shown.x - 0.5], abs=1)
    assert np.ptp(changed[:, 1]) == pytest.approx(60, abs=6)
    fingers = np.argwhere((drawn == RED).all(-1))
    assert np.abs(np.abs(fingers[:, 1] - shown.x) - 30).max() <= 2


def test_depth_is_bright_near_and_purple_where_it_is_missing(image: RgbdImage) -> None:
    crop = crop_for(image, [])
    picture = depth(image, crop, None)
    assert tuple(picture[5, 5]) == NO_DEPTH
    assert picture[112, 112, 0] > picture[200, 20, 0] + 100


def test_heat_lies_where_the_maps_say(image: RgbdImage) -> None:
    crop = crop_for(image, [])
    quality = np.zeros((100, 100), np.float32)
    quality[30:40, 60:70] = 1.0
    empty = np.zeros_like(quality)
    hot = proposed(image, crop, [], None, GraspMaps(quality, empty, empty, empty), (110, 70))
    cold = proposed(image, crop, [], None, GraspMaps(empty, empty, empty, empty), (110, 70))
    rows, columns = np.nonzero((hot != cold).any(-1))
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (92, 101, 122, 131)


def test_predictors_without_maps_get_their_proposals_drawn(image: RgbdImage) -> None:
    crop = crop_for(image, [])
    grasps = [Grasp(160.0, 120.0, 0.0, 40.0), Grasp(140.0, 100.0, 1.0, 30.0)]
    plain = proposed(image, crop, [], None, None)
    one = proposed(image, crop, grasps[:1], grasps[0], None)
    both = proposed(image, crop, grasps, grasps[0], None)
    assert (plain != one).any(-1).sum() < (plain != both).any(-1).sum()
