"""A replay in MuJoCo's own viewer, on a machine with a display."""

from __future__ import annotations

import os
import sys
import time

from grasp_bench.errors import GraspBenchError
from grasp_bench.replay.rebuild import Replay


def check_display() -> None:
    """Refuse where no window can be opened.

    Raises:
        GraspBenchError: naming the way that needs no display.
    """
    if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise GraspBenchError("There is no display for MuJoCo's viewer; --browser shows the trial in a web "
                              "browser, --video makes a film of it.")


def show(replay: Replay) -> None:
    """Play the trial again and again until the window is closed.

    Raises:
        GraspBenchError: when no window can be opened, or nothing moved.
    """
    check_display()
    import mujoco
    import mujoco.viewer

    world, moments = replay.done.world, replay.recording.moments
    if world is None or not moments:
        raise GraspBenchError(f"In trial {replay.done.record.trial} nothing moved "
                              f"({replay.done.record.outcome}); there is nothing to play.")
    data = mujoco.MjData(world.model)
    with mujoco.viewer.launch_passive(world.model, data) as window:
        while window.is_running():
            began, start = time.monotonic(), moments[0].time
            for m in moments:
                if not window.is_running():
                    return
                data.qpos[:], data.qvel[:], data.time = m.qpos, m.qvel, m.time
                mujoco.mj_forward(world.model, data)
                window.sync()
                time.sleep(max(0.0, m.time - start - (time.monotonic() - began)))
            time.sleep(1.0)
