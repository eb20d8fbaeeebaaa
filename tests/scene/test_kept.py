"""Objects at rest that are kept: the same world and picture to the bit, and only what was asked for."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.predictors.controls import Antipodal, Oracle
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.seeding import Purpose, Streams
from grasp_bench.scene import kept
from grasp_bench.scene.rendering import Picture
from grasp_bench.scene.world import UnstableError, World
from grasp_bench.system import cache
from grasp_bench.trials.clock import Clock
from grasp_bench.trials.trial import own_table, run_trial
from grasp_bench.trials.workcell import Workcell


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of its own."""
    monkeypatch.setenv("GRASP_BENCH_CACHE", str(tmp_path))
    return cache.folder()


def entries(kind: str) -> set[Path]:
    return {e.path for e in cache.entries() if e.path.suffix == kind}


def at_rest(cell: Workcell, model: ObjectModel, seed: int = 0, attempt: int = 0) -> tuple[World, Picture]:
    """A trial's table at rest, and its perfect picture."""
    streams = Streams(seed, model.name, attempt)
    table = own_table(cell, model, streams)
    world = table.build()
    table.settle(world)
    sensor = streams(Purpose.SENSOR)
    taken = table.take(world, cell.camera, cell.scenario, sensor, Clock(), changing=world.object_body)
    return world, taken[0]


def assert_same(first: World, second: World) -> None:
    """All that the physics holds is the same to the bit, after some more steps, too."""
    assert first.steps == second.steps
    for _ in range(2):
        for name in ("time", "qpos", "qvel", "ctrl", "qacc", "qacc_warmstart", "xpos", "xmat", "geom_xpos",
                     "geom_xmat", "site_xpos", "qfrc_constraint", "efc_force", "cvel"):  # fmt: skip
            one, other = (np.asarray(getattr(world.data, name)) for world in (first, second))
            np.testing.assert_array_equal(one, other, err_msg=name)
        one, other = (np.asarray(world.data.contact.dist) for world in (first, second))
        np.testing.assert_array_equal(one, other, err_msg="contacts")
        for world in (first, second):
            world.step(25)


def test_the_world_and_the_picture_are_those_made_anew(
    table4: Scenario, models: dict[str, ObjectModel]
) -> None:
    cell = Workcell(table4)
    made, seen = at_rest(cell, models["bar"], seed=3)
    assert (len(entries(kept.REST)), len(entries(kept.SEEN))) == (1, 1)
    found, again = at_rest(Workcell(table4), models["bar"], seed=3)
    assert (len(entries(kept.REST)), len(entries(kept.SEEN))) == (1, 1)
    for one, other in zip(seen, again, strict=True):
        np.testing.assert_array_equal(one, other)
    assert_same(made, found)


def test_what_is_kept_is_used(
    table4: Scenario, models: dict[str, ObjectModel], monkeypatch: pytest.MonkeyPatch
) -> None:
    cell = Workcell(table4)
    at_rest(cell, models["bar"])
    refuse: Callable[..., None] = lambda *_: pytest.fail("made again")  # noqa: E731
    monkeypatch.setattr(World, "settle", refuse)
    monkeypatch.setattr(type(cell.camera), "_look", refuse)
    at_rest(cell, models["bar"])


@pytest.mark.parametrize("name", ["bar", "pot"])
def test_records_are_the_same_cold_warm_and_without(
    table4: Scenario, models: dict[str, ObjectModel], name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lines() -> list[str]:
        cell = Workcell(table4)
        return [run_trial(cell, models[name], make(), seed=2).record.line() for make in (Oracle, Antipodal)]

    cold, warm = lines(), lines()
    assert entries(kept.REST)
    monkeypatch.setenv(cache.LIMIT, "0")
    cache.clear()
    assert lines() == cold == warm
    assert not cache.entries()


@pytest.mark.parametrize(
    "damage",
    [lambda b: b[:-1], lambda b: b[:-9] + bytes([b[-9] ^ 1]) + b[-8:], lambda b: b"", lambda b: b"x" * 99],
)
def test_a_damaged_entry_is_made_again(
    table4: Scenario, models: dict[str, ObjectModel], damage: Callable[[bytes], bytes]
) -> None:
    cell = Workcell(table4)
    made, seen = at_rest(cell, models["bar"])
    whole = {path: path.read_bytes() for path in entries(kept.REST) | entries(kept.SEEN)}
    for path, content in whole.items():
        path.write_bytes(damage(content))
        assert path.read_bytes() != content
    found, again = at_rest(cell, models["bar"])
    assert {path: path.read_bytes() for path in whole} == whole
    np.testing.assert_array_equal(seen.depth, again.depth)
    assert_same(made, found)


@pytest.mark.parametrize(
    ("section", "changes"),
    [
        ("settling", {"linear_speed": 0.5}),
        ("table", {"friction": 0.3}),
        ("physics", {"timestep": 0.001}),
        ("objects", {"mass_scale": 2.0}),
        ("gripper", {"friction_scale": 0.5}),
    ],
)
def test_another_scenario_has_rests_of_its_own(
    table4: Scenario, models: dict[str, ObjectModel], section: str, changes: dict[str, float]
) -> None:
    at_rest(Workcell(table4), models["bar"])
    part = getattr(table4, section).model_copy(update=changes)
    at_rest(Workcell(table4.model_copy(update={section: part})), models["bar"])
    assert len(entries(kept.REST)) == 2


def test_other_trials_objects_robots_and_code_have_rests_of_their_own(
    table4: Scenario, models: dict[str, ObjectModel], monkeypatch: pytest.MonkeyPatch
) -> None:
    cell = Workcell(table4)
    at_rest(cell, models["bar"])
    at_rest(cell, models["bar"], seed=1)
    at_rest(cell, models["bar"], attempt=1)
    at_rest(cell, models["block"])
    assert len(entries(kept.REST)) == 4
    for change in ((mujoco, "__version__", "0"), (np, "__version__", "0"), (kept, "_CODE", ("world",))):
        kept._fixed_digest.cache_clear()
        with monkeypatch.context() as patch:
            patch.setattr(*change)
            kept._fixed_digest()
            at_rest(cell, models["bar"])
    kept._fixed_digest.cache_clear()
    assert len(entries(kept.REST)) == len(entries(kept.SEEN)) == 7


def test_another_camera_has_pictures_of_its_own(table4: Scenario, models: dict[str, ObjectModel]) -> None:
    at_rest(Workcell(table4), models["bar"])
    x, y, z = table4.camera.position
    moved = type(table4.camera).model_validate(table4.camera.model_dump() | {"position": (x, y, z + 0.01)})
    at_rest(Workcell(table4.model_copy(update={"camera": moved})), models["bar"])
    assert len(entries(kept.SEEN)) == 2


def test_what_never_rests_is_not_kept(table4: Scenario, models: dict[str, ObjectModel]) -> None:
    restless = table4.settling.model_copy(update={"timeout": 0.1, "still_time": 5.0})
    cell = Workcell(table4.model_copy(update={"settling": restless}))
    for _ in range(2):
        with pytest.raises(UnstableError, match="was not at rest"):
            at_rest(cell, models["bar"])
    assert not entries(kept.REST)
