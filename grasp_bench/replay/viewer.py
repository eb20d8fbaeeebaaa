"""A replay in MuJoCo's own viewer, on a machine with a display."""

from __future__ import annotations

import os
import sys
import time
from typing import Any

import mujoco

from grasp_bench.errors import GraspBenchError
from grasp_bench.media.takes import Take
from grasp_bench.replay.rebuild import Replay

PAUSE = 1.0
"""Seconds for which the end is shown."""


def check_display() -> None:
    """Raise GraspBenchError where no window can be opened, naming what needs no display."""
    if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise GraspBenchError(
            "There is no display for MuJoCo's viewer; --browser shows the trial in a web "
            "browser, --video makes a film of it."
        )


def show(replay: Replay) -> None:
    """Play the trial again and again until the window is closed.

    A window shows one world, and each attempt of an episode has its own: they are played once each, in
    one window after the other.

    Raises:
        GraspBenchError: when no window can be opened, or nothing moved.
    """
    check_display()
    import mujoco.viewer

    takes = [t for t in replay.takes if t.moved]
    if not takes:
        raise GraspBenchError(
            f"In trial {replay.record.trial} nothing moved "
            f"({replay.record.outcome}); there is nothing to play."
        )
    for take in takes:
        world = take.done.world
        assert world is not None
        data = mujoco.MjData(world.model)
        with mujoco.viewer.launch_passive(world.model, data) as window:
            while play(window, take, world.model, data):
                if len(takes) > 1:
                    break
            else:
                return


def play(window: Any, take: Take, model: mujoco.MjModel, data: mujoco.MjData) -> bool:
    """Play a take once, in real time, and return whether the window is still open."""
    began = time.monotonic()
    for m in take.moments:
        if not window.is_running():
            return False
        data.qpos[:], data.qvel[:], data.time = m.qpos, m.qvel, m.time
        mujoco.mj_forward(model, data)
        window.sync()
        time.sleep(max(0.0, m.time - take.start - (time.monotonic() - began)))
    time.sleep(PAUSE)
    return window.is_running()
