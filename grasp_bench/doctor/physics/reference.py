"""The oracle's trials, watched: loads of the joints, and what half the time step changes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pebble import ProcessPool

from grasp_bench.doctor.physics.check import Check, below
from grasp_bench.objects.catalog import Catalog
from grasp_bench.objects.fitted import graspable
from grasp_bench.predictors import load_predictor
from grasp_bench.robot.arm import Arm
from grasp_bench.robot.ec66 import EC66
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.world import World
from grasp_bench.system.spawning import SpawnContext
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Watched:
    """One trial.

    Attributes:
        object: name of what was tried.
        outcome: how the trial ended.
        torque: (N,) greatest torque of each joint's motor, servo and gravity compensation [N m].
        velocity: (N,) greatest speed of each joint [rad/s].
    """

    object: str
    outcome: Outcome
    torque: Floats
    velocity: Floats

    @property
    def success(self) -> bool:
        """Whether the object was lifted, carried and held."""
        return self.outcome is Outcome.SUCCESS


def halved(scenario: Scenario) -> Scenario:
    """Return the scenario with half the time step, and as many commands a second."""
    physics = scenario.physics
    return scenario.model_copy(
        update={
            "physics": physics.model_copy(
                update={"timestep": physics.timestep / 2, "control_steps": 2 * physics.control_steps}
            )
        }
    )


_cell: dict[str, Any] = {}


def _start(scenario: Scenario) -> None:
    _cell.update(cell=Workcell(scenario), catalog=Catalog(), predictor=load_predictor("oracle"))


def _watch(trial: int, name: str, seed: int) -> Watched:
    torque, velocity = np.zeros((2, len(_cell["cell"].planner.robot.arm.joints)))

    def observe(world: World) -> None:
        np.maximum(torque, np.abs(world.joint_torques), out=torque)
        np.maximum(velocity, np.abs(world.joint_velocities), out=velocity)

    model = _cell["catalog"].load(name)
    record = run_trial(
        _cell["cell"], model, _cell["predictor"], trial=trial, attempt=0, seed=seed, observer=observe
    ).record
    return Watched(name, record.outcome, torque, velocity)


def watch(
    scenario: Scenario,
    objects: list[str] | None = None,
    seed: int = 0,
    workers: int = 2,
    progress: Callable[[], None] = lambda: None,
) -> list[Watched]:
    """Do the oracle's trial of each object, watched at every command.

    Args:
        scenario: scenario of the trials.
        objects: names; all that the gripper can grasp when None.
        seed: seed of the run.
        workers: number of processes.
        progress: called after each trial.
    """
    every = Catalog().names
    chosen = objects or graspable(Catalog(), every, scenario.robot.loaded.gripper)[0]
    with ProcessPool(workers, initializer=_start, initargs=(scenario,), context=SpawnContext()) as pool:
        futures = [pool.submit(_watch, None, every.index(name), name, seed) for name in chosen]
        results = []
        for future in futures:
            results.append(future.result())
            progress()
    return results


def loads(watched: list[Watched], arm: Arm = EC66) -> list[Check]:
    """Check joint torques and velocities against an arm's limits, as shares of them [%]."""
    torque = np.max([w.torque for w in watched], axis=0) / arm.torque_limits
    velocity = np.max([w.velocity for w in watched], axis=0) / arm.velocity_limits
    source = "limits of the maker's URDF" if arm is EC66 else f"limits of {arm.title}"
    return [
        below(
            f"greatest joint torque of {len(watched)} trials, of its limit",
            100 * float(torque.max()),
            100.0,
            "%",
            f"{source}; joint {int(torque.argmax()) + 1}",
        ),
        below(
            f"greatest joint velocity of {len(watched)} trials, of its limit",
            100 * float(velocity.max()),
            100.0,
            "%",
            f"{source}; joint {int(velocity.argmax()) + 1}",
        ),
    ]


def time_step(whole: list[Watched], half: list[Watched]) -> Check:
    """Check the share of trials [%] whose success half the time step changes; the same trials in both."""
    changed = [a.object for a, b in zip(whole, half, strict=True) if a.success != b.success]
    names = f": {', '.join(changed)}" if changed else ""
    return below(
        f"trials whose success half the time step changes ({len(changed)}/{len(whole)})",
        100 * len(changed) / len(whole),
        2.0,
        "%",
        f"converged physics: none{names}",
    )
