"""A predictor behind a command that the harness starts, one process a worker.

Each worker has its own, so that a crash or a hang costs one trial, as it does within a worker: a
server that died or gave no answer in time is started again for the next trial. To share one server
between all workers, start it yourself and give its address.
"""

from __future__ import annotations

import fcntl
import os
import shlex
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import IO, Any

import numpy as np
from filelock import FileLock, Timeout

from grasp_bench.camera import RgbdImage
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp, GraspPose
from grasp_bench.predictors import guardian
from grasp_bench.predictors.remote import ANSWER_SECONDS, RemotePredictor, UnansweredError

START_SECONDS = 120.0
"""How long a server may take until it answers ``GET /info``."""
PLACE = "{port}"
"""Where a command is given its port."""
_LOG_BYTES = 2**20  # what a server prints is kept for messages only


class CommandPredictor:
    """Starts a server, asks it for grasps, and stops it.

    Args:
        command: split as a shell would, but run without one; ``{port}`` is replaced by a free port
            of 127.0.0.1, at which the server must listen.
        start_seconds: greatest time until the server answers.
        seconds: greatest time for one image.

    Raises:
        PredictorError: for a command that cannot be started or that does not answer in time, with
            the end of what it printed.
    """

    def __init__(
        self, command: str, start_seconds: float = START_SECONDS, seconds: float = ANSWER_SECONDS
    ) -> None:
        self._words = split(command)
        self._start_seconds, self._seconds = start_seconds, seconds
        self._process: subprocess.Popen[bytes] | None = None
        self._start()

    def begin(self, rng: np.random.Generator) -> None:
        """Take the trial's random stream, and start the server if it does not run."""
        if self._process is None or self._process.poll() is not None:
            self.close()
            self._start()
        if os.fstat(self._log.fileno()).st_size > _LOG_BYTES:
            os.ftruncate(self._log.fileno(), 0)
        self._remote.begin(rng)

    def predict(self, image: RgbdImage) -> list[Grasp | GraspPose]:
        """Ask the server for grasps.

        Raises:
            PredictorError: where there is no usable answer, saying why.
        """
        if self._process is None:
            self._start()
        try:
            return self._remote.predict(image)
        except UnansweredError as error:
            died = self._exit_code(patience=0.5)
            said = self._said()
            self.close()
            if died is not None:
                raise PredictorError(f"the predictor's process died (exit code {died}){said}") from error
            raise

    def info(self) -> dict[str, Any]:
        """Return what the server says of itself."""
        return self._remote.info()

    def close(self) -> None:
        """Stop the server; the next prediction starts another."""
        if self._process is None:
            return
        process, self._process = self._process, None
        assert process.stdin is not None
        process.stdin.close()  # the guardian stops the server when this ends
        try:
            process.wait(2 * guardian.GRACE + 5)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        self._remote.close()
        self._log.close()
        self._reserved.release()

    def _start(self) -> None:
        port, self._reserved = _reserve_port()
        self._log: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115
        fcntl.fcntl(self._log.fileno(), fcntl.F_SETFL, os.O_APPEND)  # so that it can be cut while in use
        words = [word.replace(PLACE, str(port)) for word in self._words]
        # -I -S: neither the environment nor site packages matter to the guardian.
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", guardian.__file__, *words],
            stdin=subprocess.PIPE,
            stdout=self._log,
            stderr=self._log,
            start_new_session=True,
        )
        self._remote = RemotePredictor(f"http://127.0.0.1:{port}", "the predictor's process", self._seconds)
        try:
            self._wait_until_ready()
        except BaseException:
            self.close()
            raise

    def _wait_until_ready(self) -> None:
        deadline = time.monotonic() + self._start_seconds
        while True:
            code = self._exit_code()
            if code is not None:
                raise PredictorError(
                    f"The command {shlex.join(self._words)!r} ended before it answered "
                    f"(exit code {code}){self._said()}"
                )
            try:
                self._remote.info(seconds=1.0)
                return
            except UnansweredError as error:
                if time.monotonic() > deadline:
                    raise PredictorError(
                        f"The command {shlex.join(self._words)!r} did not answer GET /info at the port it "
                        f"was given within {self._start_seconds:g} s{self._said()}"
                    ) from error
                time.sleep(0.05)

    def _exit_code(self, patience: float = 0.0) -> int | None:
        assert self._process is not None
        try:
            return self._process.wait(patience)
        except subprocess.TimeoutExpired:
            return None

    def _said(self) -> str:
        """Return the last of what the server printed, for a message."""
        size = os.fstat(self._log.fileno()).st_size
        tail = os.pread(self._log.fileno(), 2000, max(0, size - 2000)).decode(errors="replace")
        lines = [line for line in tail.splitlines() if line.strip()][-3:]
        return f"; it printed: {' | '.join(lines)[-500:]}" if lines else ""


def split(command: str) -> list[str]:
    """Split a command into words.

    Raises:
        PredictorError: for one without a program that exists or without a place for the port.
    """
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise PredictorError(f"The command {command!r} cannot be split into words ({error}).") from error
    if not words or not any(PLACE in word for word in words):
        raise PredictorError(
            f"The command {command.strip()!r} has no place for the port: write {PLACE} "
            f"where its server takes it, e.g. 'cmd: python my_server.py --port {PLACE}'."
        )
    if shutil.which(words[0]) is None:
        raise PredictorError(f"The program {words[0]!r} of the predictor's command was not found.")
    return words


def _reserve_port() -> tuple[int, FileLock]:
    """Find a free port, and lock it so that no other worker takes it before the server does."""
    folder = Path(tempfile.gettempdir()) / f"grasp-bench-ports-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    for _ in range(100):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        lock = FileLock(folder / str(port))
        try:
            lock.acquire(timeout=0)
            return port, lock
        except Timeout:
            continue
    raise PredictorError("No free port was found for the predictor's process.")
