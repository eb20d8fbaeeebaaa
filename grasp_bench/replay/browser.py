"""A replay in a web browser, by viser: robot, object and camera in 3-D, what was seen, a time slider."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from grasp_bench.errors import GraspBenchError
from grasp_bench.media.clouds import point_cloud
from grasp_bench.media.meshes import body_pose, shown_meshes
from grasp_bench.media.pictures import crop_for, proposed, seen
from grasp_bench.replay.rebuild import Replay
from grasp_bench.replay.story import story

if TYPE_CHECKING:
    import viser

RATE = 30.0
"""States shown a second."""


def import_viser() -> Any:
    """The library.

    Raises:
        GraspBenchError: when it is not installed, saying how to get it.
    """
    try:
        import viser
    except ImportError as error:
        raise GraspBenchError("--browser needs viser: pip install 'grasp-bench[viewer]'.") from error
    return viser


class BrowserReplay:
    """The scene of a replay on a viser server.

    Args:
        replay: of a trial that was seen at least.
        server: where to show it.

    Raises:
        GraspBenchError: for a trial that ended before there was an image.
    """

    def __init__(self, replay: Replay, server: viser.ViserServer) -> None:
        done = replay.done
        if done.world is None or done.image is None:
            raise GraspBenchError(f"Trial {done.record.trial} ended before there was an image "
                                  f"({done.record.outcome}); there is nothing to show.")
        self.server = server
        self._model, self._data = done.world.model, mujoco.MjData(done.world.model)
        self.moments = [(m.time, m.qpos) for m in replay.recording.moments]
        self.moments.append((float(done.world.data.time), done.world.data.qpos.copy()))
        self._bodies = self._add_meshes()
        self._add_camera(replay)
        self._add_panel(replay)
        self.show(0)

    @property
    def duration(self) -> float:
        """Simulated seconds from the first state to the last."""
        return self.moments[-1][0] - self.moments[0][0]

    def _add_meshes(self) -> dict[int, Any]:
        scene = self.server.scene
        scene.set_up_direction("+z")
        frames: dict[int, Any] = {}
        for number, mesh in enumerate(shown_meshes(self._model)):
            if mesh.body not in frames:
                frames[mesh.body] = scene.add_frame(f"/bodies/{mesh.body}", show_axes=False)
            scene.add_mesh_simple(f"/bodies/{mesh.body}/{number}", mesh.vertices, mesh.faces,
                                  color=mesh.color, flat_shading=True)
        return frames

    def _add_camera(self, replay: Replay) -> None:
        image, pose = replay.done.image, replay.scenario.camera.pose
        assert image is not None
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, pose.rotation.ravel())
        small = np.ascontiguousarray(image.rgb[::2, ::2])
        self._frustum = self.server.scene.add_camera_frustum(
            "/camera", fov=image.intrinsics.vertical_fov, scale=0.12, image=small, wxyz=quaternion,
            aspect=image.intrinsics.width / image.intrinsics.height, position=pose.position)
        points, colors = point_cloud(image, pose)
        self._cloud = self.server.scene.add_point_cloud("/points", points.astype(np.float32), colors,
                                                        point_size=0.0015)

    def _add_panel(self, replay: Replay) -> None:
        gui, done = self.server.gui, replay.done
        assert done.image is not None
        self.slider = gui.add_slider("Time [s]", 0.0, max(self.duration, 0.01), 0.01, 0.0)
        self.playing = gui.add_checkbox("Play", True)
        self.speed = gui.add_slider("Speed", 0.1, 4.0, 0.1, 1.0)
        cloud = gui.add_checkbox("Point cloud", True)
        frustum = gui.add_checkbox("Camera", True)
        self.slider.on_update(lambda _: self.show_time(self.slider.value))
        cloud.on_update(lambda _: setattr(self._cloud, "visible", cloud.value))
        frustum.on_update(lambda _: setattr(self._frustum, "visible", frustum.value))
        record = done.record
        crop = crop_for(done.image, [] if record.grasp is None else [record.grasp])
        maps = getattr(replay.predictor, "last_maps", None)
        origin = getattr(replay.predictor, "crop_origin", (0, 0))
        gui.add_image(seen(done.image, crop, record.grasp), "Seen")
        gui.add_image(proposed(done.image, crop, done.grasps, record.grasp, maps, origin), "Proposed")
        gui.add_markdown("\n\n".join(_plain(line) for line in story(replay)))

    def show_time(self, seconds: float) -> None:
        """Show the state ``seconds`` after the first."""
        times = [t for t, _ in self.moments]
        self.show(max(0, int(np.searchsorted(times, times[0] + seconds + 1e-9, side="right")) - 1))

    def show(self, index: int) -> None:
        """Show the state at a position in :attr:`moments`."""
        self._data.qpos[:] = self.moments[index][1]
        mujoco.mj_kinematics(self._model, self._data)
        with self.server.atomic():
            for body, frame in self._bodies.items():
                frame.position, frame.wxyz = body_pose(self._data, body)

    def play(self, stop: threading.Event) -> None:
        """Move the slider on while it is asked for, from the start again after the end; until ``stop``."""
        while not stop.wait(1 / RATE):
            if not self.playing.value:
                continue
            ahead = self.slider.value + self.speed.value / RATE
            self.slider.value = ahead if ahead <= self.duration + 1.0 else 0.0
            self.show_time(min(self.slider.value, self.duration))


def _plain(text: str) -> str:
    """Text that Markdown shows as it is: names may hold anything."""
    return "".join(f"\\{c}" if c in r"\`*_{}[]()<>#+-.!|&~$:" else c for c in text)


def serve(replay: Replay, port: int = 8080, host: str = "127.0.0.1") -> None:
    """Show the replay on a web page of this machine until Ctrl-C.

    Raises:
        GraspBenchError: when viser is missing, or there is nothing to show.
    """
    server = import_viser().ViserServer(host=host, port=port, label="grasp-bench", verbose=False)
    stop = threading.Event()
    try:
        shown = BrowserReplay(replay, server)
        print(f"Open http://{host}:{server.get_port()} in a browser; Ctrl-C ends.", flush=True)
        threading.Thread(target=shown.play, args=(stop,), daemon=True).start()
        while True:
            time.sleep(3600)
    finally:
        stop.set()
        server.stop()
