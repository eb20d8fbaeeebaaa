"""Trials as Rerun recordings: what was seen, points, maps, grasp, motion and contact forces over time.

Rerun (https://rerun.io) is an optional viewer of logs of robots. Each trial of a recording is
an entity of its own, ``trial_00017``, on the timelines ``sim`` (seconds) and ``trial``; so is each attempt of
an episode, ``trial_00017/attempt_02``, on the timeline ``attempt``, too.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from grasp_bench.errors import GraspBenchError
from grasp_bench.media.clouds import point_cloud
from grasp_bench.media.meshes import Stage
from grasp_bench.media.recording import Recording
from grasp_bench.media.store import FOLDER, note_fault, stem
from grasp_bench.media.takes import Take
from grasp_bench.scenario.sections import Scenario
from grasp_bench.system import interrupts
from grasp_bench.trials.attempt import Trial

APPLICATION = "grasp-bench"
EVERY = 5
"""Samples of the motion from one logged state to the next."""


def import_rerun() -> Any:
    """Import Rerun, or raise GraspBenchError that says how to install it."""
    try:
        import rerun
    except ImportError as error:
        raise GraspBenchError("--rerun needs the Rerun SDK: pip install 'grasp-bench[rerun]'.") from error
    return rerun


@contextmanager
def writing(path: Path, recording_id: str | None = None) -> Iterator[Any]:
    """Open a Rerun stream into ``path``.

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


class RerunRecorder(Recording):
    """A recording of one try, written as its part of the run's Rerun log, ``media/00017.rrd``.

    Args:
        run: the run's folder.
        scenario: scenario of the trial.
        attempt: number of the try in its episode, None for a single trial.
    """

    def __init__(self, run: Path, scenario: Scenario, attempt: int | None = None) -> None:
        super().__init__(EVERY, touches=True)
        self._run, self._scenario, self._attempt = run, scenario, attempt

    def keep(self, done: Trial, predictor: Any) -> None:
        """Write the part, or a text file beside it that says why it could not be written."""
        number = done.record.trial
        part = self._run / FOLDER / f"{stem(number, self._attempt)}.rrd"
        try:
            take = Take.of(done, self, predictor, self._attempt)
            with writing(part, recording_id=str(self._run)) as stream:
                log_take(stream, take, self._scenario)
        except BaseException as error:  # a full disk, a foreign predictor's odd maps
            if interrupts.by_user(error):
                raise
            part.unlink(missing_ok=True)
            note_fault(self._run, number, error, self._attempt)


def join_parts(run: Path, out: Path) -> int:
    """Join the parts that a run's workers wrote into ``out``, remove them, and return their number.

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
    done = subprocess.run(
        [sys.executable, "-m", "rerun", "rrd", "merge", "-o", str(out), *map(str, parts)],
        capture_output=True,
        text=True,
    )
    if done.returncode != 0:
        raise GraspBenchError(
            f"{out} could not be joined from its {len(parts)} parts: {done.stderr.strip()[-300:]}"
        )


def log_take(stream: Any, take: Take, scenario: Scenario) -> None:
    """Log one try.

    Args:
        stream: a ``rerun.RecordingStream``.
        take: the try, recorded with touches for the forces.
        scenario: scenario of the trial.
    """
    rr = import_rerun()
    done, record = take.done, take.done.record
    root = f"trial_{record.trial:05}"
    stream.set_time("trial", sequence=record.trial)
    if take.attempt is not None:
        root += f"/attempt_{take.attempt:02}"
        stream.set_time("attempt", sequence=take.attempt)
    stream.set_time("sim", duration=0.0)
    text = f"{record.object}: {record.outcome}" + (f", {record.detail}" if record.detail else "")
    stream.log(f"{root}/outcome", rr.TextLog(text, level="INFO" if record.success else "WARN"))
    if done.image is None or done.world is None:
        return
    _log_image(rr, stream, root, take, scenario)
    _log_motion(rr, stream, root, take)


def _log_image(rr: Any, stream: Any, root: str, take: Take, scenario: Scenario) -> None:
    done, image, pose = take.done, take.done.image, scenario.camera.pose
    assert image is not None
    k = image.intrinsics
    camera = f"{root}/world/camera"
    stream.log(f"{root}/world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    stream.log(camera, rr.Transform3D(translation=pose.position, mat3x3=pose.rotation))
    stream.log(
        camera,
        rr.Pinhole(
            image_from_camera=k.matrix, resolution=[k.width, k.height], camera_xyz=rr.ViewCoordinates.RDF
        ),
    )
    stream.log(f"{camera}/rgb", rr.Image(image.rgb).compress(85))
    stream.log(f"{camera}/depth", rr.DepthImage(np.round(1000 * image.depth).astype(np.uint16), meter=1000.0))
    points, colors = point_cloud(image, pose, step=3)
    stream.log(f"{root}/world/points", rr.Points3D(points, colors=colors, radii=0.0008))
    if done.grasps:
        strips = [np.vstack([g.rectangle(), g.rectangle()[:1]]) for g in done.grasps]
        chosen = [g == done.record.grasp for g in done.grasps]
        stream.log(
            f"{camera}/rgb/grasps",
            rr.LineStrips2D(
                strips,
                colors=[(40, 220, 60) if c else (170, 170, 170) for c in chosen],
                labels=[f"quality {g.quality:.2f}" for g in done.grasps],
                show_labels=False,
            ),
        )
    if (maps := take.maps) is not None:
        for name, values in (("quality", maps.quality), ("angle", maps.angle), ("width", maps.width)):
            stream.log(f"{root}/maps/{name}", rr.DepthImage(values, colormap="inferno"))
    if done.plan is not None:
        grasp = done.plan.pose
        half = grasp.opening / 2 * grasp.rotation[:, 0]
        stream.log(
            f"{root}/world/grasp",
            rr.Arrows3D(
                origins=[grasp.position - 0.08 * grasp.rotation[:, 2], grasp.position, grasp.position],
                vectors=[0.08 * grasp.rotation[:, 2], half, -half],
                colors=[(40, 90, 240), (240, 40, 50), (240, 40, 50)],
            ),
        )


def _log_motion(rr: Any, stream: Any, root: str, take: Take) -> None:
    assert take.done.world is not None
    model, robot = take.done.world.model, take.done.world.robot
    stage = Stage(model)
    for number, mesh in enumerate(stage.meshes):
        stream.log(
            f"{root}/world/bodies/{mesh.body}/{number}",
            rr.Mesh3D(
                vertex_positions=mesh.vertices, triangle_indices=mesh.faces, albedo_factor=(*mesh.color, 255)
            ),
            static=True,
        )
    arm = [model.joint(robot.arm_prefix + name) for name in robot.arm.joints]
    q = [int(j.qposadr[0]) for j in arm]
    v = [int(j.dofadr[0]) for j in arm]
    fingers = [
        int(model.joint(robot.gripper_prefix + name).qposadr[0]) for name in robot.gripper.finger_joints
    ]
    for m in take.moments:
        stream.set_time("sim", duration=m.time - take.start)
        for body, (position, quaternion) in stage.poses(m.qpos).items():
            if body != 0:  # the world itself
                stream.log(
                    f"{root}/world/bodies/{body}",
                    rr.Transform3D(
                        translation=position, quaternion=rr.Quaternion(xyzw=np.roll(quaternion, -1))
                    ),
                )
        stream.log(f"{root}/joints/position", rr.Scalars(m.qpos[q]))
        stream.log(f"{root}/joints/velocity", rr.Scalars(m.qvel[v]))
        stream.log(
            f"{root}/gripper/opening", rr.Scalars([float(robot.gripper.positions(m.qpos[fingers]).sum())])
        )
        if m.touch is not None:
            stream.log(f"{root}/gripper/force", rr.Scalars([float(m.touch.left), float(m.touch.right)]))
