"""A replay in a web browser, by viser: robot, object and camera in 3-D, the image, a time slider."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from grasp_bench.errors import GraspBenchError
from grasp_bench.media.clouds import on_table, point_cloud
from grasp_bench.media.meshes import Stage
from grasp_bench.media.takes import Take
from grasp_bench.replay.rebuild import Replay
from grasp_bench.replay.story import story

if TYPE_CHECKING:
    import viser

RATE = 30.0
"""States shown a second."""
EYE = (-0.75, -0.55, 0.75)
"""First viewpoint of a page relative to the table's middle, over the arm's shoulder [m]."""
PAUSE = 1.0
"""Simulated seconds for which the end of a try is shown."""


def import_viser() -> Any:
    """Import viser, or raise GraspBenchError that says how to install it."""
    try:
        import viser
    except ImportError as error:
        raise GraspBenchError("--browser needs viser: pip install 'grasp-bench[viewer]'.") from error
    return viser


class BrowserReplay:
    """The scene of a replay on a viser server.

    Args:
        replay: a trial that has an image, or an episode, of which the attempts with an image are shown.
        server: viser's server.

    Attributes:
        takes: the tries that can be shown.
        stage: bodies of the try that is shown now.

    Raises:
        GraspBenchError: for a trial that ended before there was an image.
    """

    def __init__(self, replay: Replay, server: viser.ViserServer) -> None:
        self.takes = replay.seen()
        self.server, self._scenario = server, replay.scenario
        server.scene.set_up_direction("+z")
        server.on_client_connect(self.aim)
        self._lock = threading.RLock()
        self._add_panel(replay)
        self.load(0)

    def aim(self, client: viser.ClientHandle) -> None:
        """Let a page look at the table's middle, from near."""
        middle = np.array([*self._scenario.table.center, 0.0])
        with client.atomic():
            client.camera.up_direction = (0.0, 0.0, 1.0)
            client.camera.position = middle + EYE
            client.camera.look_at = middle

    @property
    def take(self) -> Take:
        """The try that is shown now."""
        return self.takes[self._number]

    @property
    def duration(self) -> float:
        """Simulated time from the first state that is shown to the last [s]."""
        return self.take.moments[-1].time - self.take.start

    def load(self, number: int) -> None:
        """Show another of :attr:`takes`, from its start."""
        with self._lock:
            self._number = number
            self.stage = Stage(self.take.done.world.model)  # pyright: ignore[reportOptionalMemberAccess]
            for name in ("/bodies", "/camera", "/points"):
                self.server.scene.remove_by_name(name)
            self._bodies = self._add_meshes()
            self._add_camera()
            shown = self.take.pictures()
            self._seen.image, self._proposed.image = shown["seen"], shown["proposed"]
            self._times = np.array([m.time for m in self.take.moments]) - self.take.start
            self.slider.max = max(self.duration, 0.01)
            self.slider.value = 0.0
            self.show(0)

    def _add_meshes(self) -> dict[int, Any]:
        scene = self.server.scene
        frames: dict[int, Any] = {}
        for number, mesh in enumerate(self.stage.meshes):
            if mesh.body not in frames:
                frames[mesh.body] = scene.add_frame(f"/bodies/{mesh.body}", show_axes=False)
            scene.add_mesh_simple(
                f"/bodies/{mesh.body}/{number}",
                mesh.vertices,
                mesh.faces,
                color=mesh.color,
                flat_shading=True,
            )
        return frames

    def _add_camera(self) -> None:
        image, pose = self.take.done.image, self._scenario.camera.pose
        assert image is not None
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, pose.rotation.ravel())
        small = np.ascontiguousarray(image.rgb[::2, ::2])
        self._frustum = self.server.scene.add_camera_frustum(
            "/camera",
            fov=image.intrinsics.vertical_fov,
            scale=0.12,
            image=small,
            wxyz=quaternion,
            aspect=image.intrinsics.width / image.intrinsics.height,
            position=pose.position,
            visible=self.frustum.value,
        )
        points, colors = point_cloud(image, pose)
        kept = on_table(points, self._scenario.table)
        self._cloud = self.server.scene.add_point_cloud(
            "/points",
            points[kept].astype(np.float32),
            colors[kept],
            point_size=0.0015,
            visible=self.cloud.value,
        )

    def _add_panel(self, replay: Replay) -> None:
        gui = self.server.gui
        self.attempt = None
        if len(self.takes) > 1:
            names = [f"{t.attempt}: {t.done.record.object}, {t.done.record.outcome}" for t in self.takes]
            self.attempt = gui.add_dropdown("Attempt", names, names[0])
            self.attempt.on_update(lambda event: self.load(names.index(event.target.value)))
        self.slider = gui.add_slider("Time [s]", 0.0, 1.0, 0.01, 0.0)
        self.playing = gui.add_checkbox("Play", True)
        self.speed = gui.add_slider("Speed", 0.1, 4.0, 0.1, 1.0)
        self.cloud = gui.add_checkbox("Point cloud", True)
        self.frustum = gui.add_checkbox("Camera", True)
        self.slider.on_update(lambda _: self.show_time(self.slider.value))
        self.cloud.on_update(lambda _: setattr(self._cloud, "visible", self.cloud.value))
        self.frustum.on_update(lambda _: setattr(self._frustum, "visible", self.frustum.value))
        shown = self.takes[0].pictures()
        self._seen = gui.add_image(shown["seen"], "Seen")
        self._proposed = gui.add_image(shown["proposed"], "Proposed")
        gui.add_markdown("\n\n".join(_plain(line) for line in story(replay)))

    def show_time(self, seconds: float) -> None:
        """Show the state ``seconds`` after the first."""
        with self._lock:
            self.show(max(0, int(np.searchsorted(self._times, seconds + 1e-9, side="right")) - 1))

    def show(self, index: int) -> None:
        """Show the state at position ``index`` among the moments of the try."""
        with self._lock, self.server.atomic():
            for body, (position, quaternion) in self.stage.poses(self.take.moments[index].qpos).items():
                self._bodies[body].position, self._bodies[body].wxyz = position, quaternion

    def step(self, seconds: float) -> None:
        """Move the slider on; the end of an attempt is followed by the next one, the last by the first."""
        with self._lock:
            ahead = self.slider.value + seconds
            if ahead <= self.duration + PAUSE or self.attempt is None:
                self.slider.value = ahead if ahead <= self.duration + PAUSE else 0.0
            else:
                self.attempt.value = self.attempt.options[(self._number + 1) % len(self.takes)]

    def play(self, stop: threading.Event) -> None:
        """Move on while the box "Play" is ticked, until ``stop``."""
        while not stop.wait(1 / RATE):
            if self.playing.value:
                self.step(self.speed.value / RATE)


def _plain(text: str) -> str:
    """Return text that Markdown shows as it is: names may hold anything."""
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
