"""Brief tries say what a try to the end says, and leave doubtful grasps to it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from grasp_bench.learning.data import synthetic
from grasp_bench.learning.data.random_shapes import assemble
from grasp_bench.learning.data.random_solids import convex
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.brief import BriefTries
from grasp_bench.scene.floating import QUICK, FloatingGripper, compile_floating
from grasp_bench.workshop.shapes import box


@pytest.fixture
def settled(table4: Scenario) -> FloatingGripper:
    """A block of 120 × 30 × 40 mm along world x at (0.5, 0)."""
    block = assemble(np.random.default_rng(1), [[convex(box(120, 30, 40))]], "box")
    gripper = FloatingGripper(compile_floating(table4, [block]), table4)
    q = gripper.object_q[0]
    gripper.data.qpos[q : q + 3] = 0.5, 0.0, 0.0205
    assert gripper.settle(1.0)
    return gripper


def never(*_: Any) -> None:
    raise AssertionError("tried to its end")


@pytest.mark.parametrize(
    ("x", "y", "yaw", "holds"),
    [
        pytest.param(0.50, 0.0, np.pi / 2, True, id="across its middle"),
        pytest.param(0.50, 0.2, np.pi / 2, False, id="beside it"),
        pytest.param(0.50, 0.0, 0.0, False, id="fingers inside it"),
    ],
)
def test_clear_cases_are_not_tried_to_the_end(
    settled: FloatingGripper, monkeypatch: pytest.MonkeyPatch, x: float, y: float, yaw: float, holds: bool
) -> None:
    tries = BriefTries(settled)
    monkeypatch.setattr(settled, "attempt", never)
    assert tries.holds(np.array([x, y, 0.012]), yaw, 0.05) is holds


def test_a_doubtful_grasp_is_tried_to_the_end_as_if_alone(
    settled: FloatingGripper, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The fingers reach over the end of the block by half a millimetre: it swings out of them when lifted."""
    state, grasp = settled.state(), (np.array([0.5695, 0.0, 0.012]), np.pi / 2, 0.05)
    alone = settled.attempt(state, *grasp, QUICK)
    options = str(settled.model.opt)
    settled.data.qpos[:], settled.data.qvel[:] = state
    tries, seen = BriefTries(settled), []
    really = settled.attempt
    monkeypatch.setattr(settled, "attempt", lambda *a: seen.append(really(*a)) or seen[-1])
    tries.holds(*grasp)
    assert seen == [alone]
    assert not alone.held
    assert str(settled.model.opt) == options


def test_brief_tries_agree_with_tries_to_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[tuple[bool, bool]] = []

    class Both(BriefTries):
        def holds(self, tip: np.ndarray, yaw: float, opening: float) -> bool:
            brief = super().holds(tip, yaw, opening)
            said.append((brief, self._gripper.attempt(self._state, tip, yaw, opening, QUICK).held))
            return brief

    monkeypatch.setattr(synthetic, "BriefTries", Both)
    for index in range(8):
        synthetic.make_scene(3, index, synthetic.SynthConfig())
    brief, full = np.array(said).T
    assert len(full) >= 150
    assert 0.3 < full.mean() < 0.95
    assert (brief == full).mean() >= 0.98
