"""The log of a run: ``log.jsonl``, and TensorBoard's format where that is installed."""

from __future__ import annotations

import json
from pathlib import Path

from grasp_bench.system.integrity import write_whole


class RunLog:
    """Appends one JSON object a line to ``folder/log.jsonl``.

    Args:
        folder: where ``log.jsonl`` is kept.
        step: number of steps done; lines of later steps, left by a killed run, are dropped.
    """

    def __init__(self, folder: Path, step: int) -> None:
        path = folder / "log.jsonl"
        lines = path.read_text().splitlines() if path.is_file() else []
        write_whole(path, "".join(line + "\n" for line in lines if _step(line) <= step).encode())
        self._file = path.open("a")
        self._board = None
        try:
            from torch.utils.tensorboard import SummaryWriter
        except ImportError:
            return
        self._board = SummaryWriter(str(folder / "tensorboard"), purge_step=step)

    def write(self, step: int, **values: float | int | str) -> None:
        """Write one line; numbers go to TensorBoard too."""
        self._file.write(json.dumps({"step": step, **values}) + "\n")
        self._file.flush()
        if self._board is not None:
            for name, value in values.items():
                if isinstance(value, int | float):
                    self._board.add_scalar(name, value, step)

    def close(self) -> None:
        """Close the files."""
        self._file.close()
        if self._board is not None:
            self._board.close()


def _step(line: str) -> float:
    try:
        return json.loads(line)["step"]
    except (ValueError, KeyError, TypeError):
        return float("inf")
