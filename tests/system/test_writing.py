"""Files that are written whole or not at all, by one writer at a time."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from grasp_bench.errors import GraspBenchError
from grasp_bench.system.integrity import replacing, write_whole
from grasp_bench.system.locking import Lock

BUSY = GraspBenchError("somebody else writes")


def killed(path: Path, *lines: str) -> None:
    """Run lines of Python about ``path`` in a process that kills itself there."""
    code = "\n".join(["import os, pathlib, sys", "path = pathlib.Path(sys.argv[1])", *lines])
    assert subprocess.run([sys.executable, "-c", code, path]).returncode == -signal.SIGKILL


def test_what_cannot_be_written_to_its_end_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    write_whole(path, b"old")

    def fill() -> None:
        with replacing(path) as file:
            file.write(b"half of the new one")
            raise OSError("no space")

    with pytest.raises(OSError, match="no space"):
        fill()
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]


def test_a_kill_while_writing_leaves_the_old_file_and_hinders_nobody(tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    write_whole(path, b"old")
    killed(
        path,
        "from grasp_bench.system.integrity import replacing",
        "with replacing(path) as file:",
        "    file.write(b'half'); file.flush(); os.kill(os.getpid(), 9)",
    )
    assert path.read_bytes() == b"old"
    write_whole(path, b"new")
    assert path.read_bytes() == b"new"
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]


def test_a_pipe_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = subprocess.Popen(["cat", pipe], stdout=subprocess.PIPE)
    write_whole(pipe, b"through")
    assert reader.communicate(timeout=30)[0] == b"through"
    assert pipe.is_fifo()


def test_the_second_is_refused_until_the_first_is_done(tmp_path: Path) -> None:
    path = tmp_path / ".lock"
    with Lock(path, BUSY), pytest.raises(GraspBenchError, match="somebody else writes"):
        Lock(path, BUSY)
    assert not path.exists()
    Lock(path, BUSY).release()


def test_a_holder_that_was_killed_holds_nothing(tmp_path: Path) -> None:
    path = tmp_path / ".lock"
    killed(
        path,
        "from grasp_bench.system.locking import Lock",
        "held = Lock(path, ValueError())",
        "os.kill(os.getpid(), 9)",
    )
    assert path.exists()
    with Lock(path, BUSY):
        pass
    assert not path.exists()


def test_a_folder_that_takes_no_file_is_an_error_of_the_system(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match=r"Not a directory|File exists"):
        Lock(tmp_path / "file" / ".lock", BUSY)
