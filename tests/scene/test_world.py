"""A world in motion: trajectories run whole are those run sample by sample."""

from __future__ import annotations

import numpy as np
import pytest

from grasp_bench.objects.catalog import Catalog
from grasp_bench.robot.ec66 import EC66
from grasp_bench.robot.trajectory import Trajectory, through
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scene.builder import compile_scene
from grasp_bench.scene.world import UnstableError, World
from grasp_bench.trials.placing import put_down

SCENARIO = load_scenario("table4")


def at_rest() -> World:
    """A mug on the table, and the arm at home."""
    mug = Catalog().load("coffee_mug")
    world = World(compile_scene(SCENARIO, mug), SCENARIO)
    put_down(world, mug, SCENARIO, np.random.default_rng(3))
    return world


def a_motion() -> Trajectory:
    """Some way down towards the table."""
    period = SCENARIO.physics.timestep * SCENARIO.physics.control_steps
    return through(
        [np.asarray(EC66.home), np.asarray(EC66.home) + [0.1, 0.1, 0.1, -0.1, 0.05, 0.2]], period, 0.5
    )


def test_a_motion_run_whole_gives_the_bits_of_one_run_sample_by_sample() -> None:
    watched, whole = at_rest(), at_rest()
    seen: list[int] = []
    watched.observer = lambda world: seen.append(world.steps)
    motion, jaws = a_motion(), np.linspace(0.04, 0.01, len(a_motion().positions))
    for world in (watched, whole):
        world.follow(motion, jaws)
        world.follow(motion, 0.01)
    assert watched.steps == whole.steps > 0
    assert len(seen) == 2 * len(motion.positions)
    for name in ("qpos", "qvel", "ctrl", "qacc_warmstart", "qfrc_actuator", "xpos", "time"):
        np.testing.assert_array_equal(getattr(watched.data, name), getattr(whole.data, name), err_msg=name)
    assert watched.data.ncon == whole.data.ncon > 0


def test_a_divergence_is_found_at_the_same_step() -> None:
    steps = []
    for observer in (None, lambda world: None):
        world = at_rest()
        world.observer = observer
        motion = a_motion()
        wild = motion.positions.copy()
        wild[len(wild) // 2 :] = np.nan
        with pytest.raises(UnstableError, match="MuJoCo warning"):
            world.follow(Trajectory(wild, motion.velocities), 0.04)
        steps.append(world.steps)
    assert steps[0] == steps[1] > 100
