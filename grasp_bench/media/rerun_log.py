"""Trials as Rerun recordings: what was seen, points, maps, grasp, motion and contact forces over time.

Rerun (https://rerun.io) is an optional viewer of logs of robots. Each trial of a recording is
an entity of its own, ``trial_00017``, on the timelines ``sim`` (seconds) and ``trial``.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from grasp_bench.errors import GraspBenchError
from grasp_bench.media.clouds import point_cloud
from grasp_bench.media.meshes import body_pose, shown_meshes
from grasp_bench.media.recording import Moment, Recording, moment
from grasp_bench.media.store import FOLDER, note_fault
from grasp_bench.scenario import Scenario
from grasp_bench.scene.builder import ARM_PREFIX, GRIPPER_PREFIX
from grasp_bench.scene.ec66 import JOINT_NAMES
from grasp_bench.scene.world import World
from grasp_bench.trial import Trial

APPLICATION = "grasp-bench"
EVERY = 5
"""Samples of the motion from one logged state to the next."""


def import_rerun() -> Any:
    """The library.

    Raises:
        GraspBenchError: when it is not installed, saying how to get it.
    """
    try:
        import rerun
    except ImportError as error:
        raise GraspBenchError("--rerun needs the Rerun SDK: pip install 'grasp-bench[rerun]'.") from error
    return rerun


@contextmanager
def writing(path: Path, recording_id: str | None = None) -> Iterator[Any]:
    """A Rerun stream into ``path``.

    Raises:
        GraspBenchError: when the SDK is missing, or the file cannot be written.
    """
    rr = import_rerun()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    except OSError as error:
        raise GraspBenchError(f"{path} cannot be written ({error.strerror}).") from error
    stream = rr.RecordingStream(APPLICATION, recording_id=recording_id)
    stream.save(str(path))
    try:
        yield stream
    finally:
        stream.flush()
        stream.disconnect()


class RerunRecorder:
    """Writes one trial's part of a run's recording, ``media/00017.rrd``.

    Args:
        run: the run's folder.
        scenario: of the trial.
    """

    def __init__(self, run: Path, scenario: Scenario) -> None:
        self._run, self._scenario = run, scenario
        self._recording = Recording(EVERY, touches=True)

    def __call__(self, world: World) -> None:
        """Called after every sample of the arm's motion."""
        self._recording(world)

    def keep(self, done: Trial, predictor: Any) -> None:
        """Write the part; what goes wrong is written into a text file beside."""
        number = done.record.trial
        part = self._run / FOLDER / f"{number:05}.rrd"
        try:
            with writing(part, recording_id=str(self._run)) as stream:
                log_trial(stream, done, self._recording, self._scenario, predictor)
        except Exception as error:  # a full disk, a foreign predictor's odd maps
            part.unlink(missing_ok=True)
            note_fault(self._run, number, error)


def join_parts(run: Path, out: Path) -> int:
    """Join the parts that a run's workers wrote into ``out``, and remove them.

    Returns:
        How many trials there were.

    Raises:
        GraspBenchError: when Rerun cannot join them; the parts are kept.
    """
    parts = sorted((run / FOLDER).glob("*.rrd"))
    if parts:
        merge(parts, out)
        for part in parts:
            part.unlink()
    return len(parts)


def merge(parts: Sequence[Path], out: Path) -> None:
    """Join recordings of one run into ``out``.

    Raises:
        GraspBenchError: when Rerun cannot do it.
    """
    done = subprocess.run([sys.executable, "-m", "rerun", "rrd", "merge", "-o", str(out), *map(str, parts)],
                          capture_output=True, text=True)
    if done.returncode != 0:
        raise GraspBenchError(f"{out} could not be joined from its {len(parts)} parts: "
                              f"{done.stderr.strip()[-300:]}")


def log_trial(stream: Any, done: Trial, recording: Recording, scenario: Scenario, predictor: Any) -> None:
    """Log one trial.

    Args:
        stream: a ``rerun.RecordingStream``.
        done: the trial.
        recording: of its motion, with touches for the forces.
        scenario: of the trial.
        predictor: that was asked; its maps are logged if it has any.
    """
    rr = import_rerun()
    record = done.record
    root = f"trial_{record.trial:05}"
    stream.set_time("trial", sequence=record.trial)
    stream.set_time("sim", duration=0.0)
    text = f"{record.object}: {record.outcome}" + (f", {record.detail}" if record.detail else "")
    stream.log(f"{root}/outcome", rr.TextLog(text, level="INFO" if record.success else "WARN"))
    if done.image is None or done.world is None:
        return
    _log_image(rr, stream, root, done, scenario, predictor)
    _log_motion(rr, stream, root, done, [*recording.moments, moment(done.world, recording.touches)],
                record.trial)


def _log_image(rr: Any, stream: Any, root: str, done: Trial, scenario: Scenario, predictor: Any) -> None:
    image, pose = done.image, scenario.camera.pose
    assert image is not None
    k = image.intrinsics
    camera = f"{root}/world/camera"
    stream.log(f"{root}/world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    stream.log(camera, rr.Transform3D(translation=pose.position, mat3x3=pose.rotation))
    stream.log(camera, rr.Pinhole(image_from_camera=k.matrix, resolution=[k.width, k.height],
                                  camera_xyz=rr.ViewCoordinates.RDF))
    stream.log(f"{camera}/rgb", rr.Image(image.rgb).compress(85))
    stream.log(f"{camera}/depth", rr.DepthImage(np.round(1000 * image.depth).astype(np.uint16), meter=1000.0))
    points, colors = point_cloud(image, pose, step=3)
    stream.log(f"{root}/world/points", rr.Points3D(points, colors=colors, radii=0.0008))
    if done.grasps:
        strips = [np.vstack([g.rectangle(), g.rectangle()[:1]]) for g in done.grasps]
        chosen = [g == done.record.grasp for g in done.grasps]
        stream.log(f"{camera}/rgb/grasps", rr.LineStrips2D(
            strips, colors=[(40, 220, 60) if c else (170, 170, 170) for c in chosen],
            labels=[f"quality {g.quality:.2f}" for g in done.grasps], show_labels=False))
    maps = getattr(predictor, "last_maps", None)
    if maps is not None:
        for name, values in (("quality", maps.quality), ("angle", maps.angle), ("width", maps.width)):
            stream.log(f"{root}/maps/{name}", rr.DepthImage(values, colormap="inferno"))
    if done.plan is not None:
        grasp = done.plan.pose
        half = grasp.opening / 2 * grasp.rotation[:, 0]
        stream.log(f"{root}/world/grasp", rr.Arrows3D(
            origins=[grasp.position - 0.08 * grasp.rotation[:, 2], grasp.position, grasp.position],
            vectors=[0.08 * grasp.rotation[:, 2], half, -half],
            colors=[(40, 90, 240), (240, 40, 50), (240, 40, 50)]))


def _log_motion(rr: Any, stream: Any, root: str, done: Trial, moments: Sequence[Moment], trial: int) -> None:
    assert done.world is not None
    model = done.world.model
    bodies: set[int] = set()
    for number, mesh in enumerate(shown_meshes(model)):
        bodies.add(mesh.body)
        stream.log(f"{root}/world/bodies/{mesh.body}/{number}", rr.Mesh3D(
            vertex_positions=mesh.vertices, triangle_indices=mesh.faces,
            albedo_factor=(*mesh.color, 255)), static=True)
    data = mujoco.MjData(model)
    arm = [model.joint(ARM_PREFIX + name) for name in JOINT_NAMES]
    q = [int(j.qposadr[0]) for j in arm]
    v = [int(j.dofadr[0]) for j in arm]
    fingers = [int(model.joint(f"{GRIPPER_PREFIX}{s}_finger_joint").qposadr[0]) for s in ("left", "right")]
    start = moments[0].time
    for m in moments:
        stream.set_time("sim", duration=m.time - start)
        stream.set_time("trial", sequence=trial)
        data.qpos[:] = m.qpos
        mujoco.mj_kinematics(model, data)
        for body in sorted(bodies - {0}):
            position, quaternion = body_pose(data, body)
            stream.log(f"{root}/world/bodies/{body}", rr.Transform3D(
                translation=position, quaternion=rr.Quaternion(xyzw=np.roll(quaternion, -1))))
        stream.log(f"{root}/joints/position", rr.Scalars(m.qpos[q]))
        stream.log(f"{root}/joints/velocity", rr.Scalars(m.qvel[v]))
        stream.log(f"{root}/gripper/opening", rr.Scalars([float(m.qpos[fingers].sum())]))
        if m.touch is not None:
            stream.log(f"{root}/gripper/force", rr.Scalars([float(m.touch.left), float(m.touch.right)]))
