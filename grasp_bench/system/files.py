"""Files of strangers, read with care: neither a pipe that never ends nor more than fits into memory."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from grasp_bench.errors import GraspBenchError

PICTURES = (".png", ".jpg", ".jpeg", ".webp")
"""Endings of pictures that are written."""
MOST_BYTES = 64 * 2**20
"""Largest file that is read as a whole."""


def read_text(path: Path, most: int = MOST_BYTES) -> str:
    """Return the content of a regular file of text in UTF-8.

    Raises:
        OSError: for a file that cannot be read, and for a folder, a named pipe or a device.
        ValueError: for one that is too large or not UTF-8.
    """
    # Without waiting: a pipe would be opened only when somebody writes into it.
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    with os.fdopen(handle, "rb") as file:
        kind = os.fstat(handle)
        if stat.S_ISDIR(kind.st_mode):
            raise IsADirectoryError(errno.EISDIR, "it is a folder", str(path))
        if not stat.S_ISREG(kind.st_mode):
            raise OSError(errno.EINVAL, "it is not a regular file", str(path))
        content = file.read(most + 1)
    if len(content) > most:
        raise ValueError(f"larger than {most:,} bytes")
    return content.decode("utf-8")


def prepare_picture(path: Path) -> None:
    """Look that a file is named like a picture, and make the folder that it goes to, if need be.

    Raises:
        GraspBenchError: for another ending.
        OSError: the folder cannot be made.
    """
    if path.suffix.lower() not in PICTURES:
        raise GraspBenchError(f"{path} is not named like a picture: end it in {', '.join(PICTURES)}.")
    path.parent.mkdir(parents=True, exist_ok=True)
