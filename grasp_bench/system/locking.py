"""One writer at a time: a lock file beside what is written, gone with its holder."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from filelock import FileLock, Timeout


class Lock:
    """A lock file that is held until :meth:`release`, or the end of the block that it guards.

    The system frees it when its holder dies, however that happens; a file that is left over locks nothing.

    Args:
        path: the lock file, deleted at the end.
        busy: raised where another process holds it.

    Raises:
        OSError: the file cannot be made.
    """

    def __init__(self, path: Path, busy: Exception) -> None:
        self._path, self._lock = path, FileLock(path)
        try:
            self._lock.acquire(timeout=0)
        except Timeout as error:
            raise busy from error

    def __enter__(self) -> Lock:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def release(self) -> None:
        """Let others write."""
        with suppress(OSError):
            self._path.unlink(missing_ok=True)
        self._lock.release()
