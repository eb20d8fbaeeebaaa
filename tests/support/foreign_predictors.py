"""Predictors that do what foreign code may do; found by workers as ``foreign_predictors:NAME``."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

from grasp_bench.camera import RgbdImage
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp


class StrangeError(BaseException):
    """Cannot be unpickled: two arguments to make it, one in its ``args``."""

    def __init__(self, first: object, second: object) -> None:
        super().__init__(first)


class MuteError(Exception):
    """Has no words."""

    def __str__(self) -> str:
        raise SystemExit("not even this")


class Text(str):
    """A text that other processes do not know."""


def _raise(error: BaseException) -> Any:
    raise error


ENDS = {
    "interrupt": lambda: _raise(KeyboardInterrupt()),
    "cancelled": lambda: _raise(asyncio.CancelledError()),
    "exit 0": lambda: sys.exit(0),
    "exit text": lambda: sys.exit("no licence"),
    "generator exit": lambda: _raise(GeneratorExit()),
    "stop": lambda: _raise(StopIteration(3)),
    "strange": lambda: _raise(StrangeError(1, 2)),
    "mute": lambda: _raise(MuteError()),
    "group": lambda: _raise(BaseExceptionGroup("many", [KeyboardInterrupt(), ValueError("x")])),
    "memory": lambda: _raise(MemoryError()),
    "recursion": lambda: _raise(RecursionError("too deep")),
    "timeout": lambda: _raise(TimeoutError("mine")),
    "surrogate": lambda: _raise(ValueError(b"caf\xe9.npy".decode("utf-8", "surrogateescape"))),
    "long": lambda: _raise(PredictorError("shape mismatch: " + "x" * 2_000_000)),
    "long name": lambda: _raise(type("E" * 2_000_000, (Exception,), {})("y")),
    "escapes": lambda: _raise(ValueError("\x1b[2J\x07\0gone\u202e")),
    "foreign text": lambda: _raise(ValueError(Text("a text of mine"))),
    "bytes": lambda: _raise(ValueError(b"\xff" * 10)),
    "odd args": lambda: _raise(ValueError(np.zeros((3, 3)), None)),
    "unicode error": lambda: b"\xff".decode(),
    "named type": lambda: type("A" * 2_000_000, (), {})(),
    "huge number": lambda: [Grasp(10**5000, 1, 0, 40)],
    "huge width": lambda: [Grasp(20, 20, 0, 1e308)],
    "huge angle": lambda: [Grasp(20, 20, 1e300, 40)],
    "infinity": lambda: [Grasp(float("inf"), 20, 0, 40)],
    "text as number": lambda: [Grasp("1", 20, 0, 40)],  # pyright: ignore[reportArgumentType]
    "complex": lambda: [Grasp(1j, 20, 0, 40)],  # pyright: ignore[reportArgumentType]
    "recursive": lambda: (lambda a: a.append(a) or a)([]),
    "number of ill will": lambda: [Grasp(IllWill(), 20, 0, 40)],  # pyright: ignore[reportArgumentType]
    "class of ill will": lambda: IllClass(),
    "endless": lambda: EndlessList([1]),
    "generator": lambda: (g for g in ()),
    "none": lambda: None,
}
"""Ways to end a prediction that are all an error of the trial."""


class IllWill:
    """A number that ends the process when it is read."""

    def __float__(self) -> float:
        raise SystemExit(0)

    def __repr__(self) -> str:
        raise KeyboardInterrupt


class IllClass:
    """Lies about its class."""

    @property
    def __class__(self) -> type:
        raise KeyboardInterrupt


class EndlessList(list[Any]):
    """A list that never ends when it is walked through, and does not say how long it is."""

    def __iter__(self) -> Any:
        while True:
            yield "more"

    def __len__(self) -> int:
        raise KeyboardInterrupt


class Ends:
    """Ends its predictions one after the other as :data:`ENDS` says."""

    def __init__(self) -> None:
        self.left = list(ENDS)

    def predict(self, image: RgbdImage) -> list[Grasp]:
        return ENDS[self.left.pop(0)]()


class Leaves:
    """Leaves its process with status 0."""

    def predict(self, image: RgbdImage) -> list[Grasp]:
        os._exit(0)


class LeavesWhenMade:
    """Leaves its process with status 0 when it is made."""

    def __init__(self) -> None:
        os._exit(0)


class HangsWhenMade:
    """Is never made."""

    def __init__(self) -> None:
        while True:
            time.sleep(1)


class Maps:
    """Has maps that end the process."""

    def predict(self, image: RgbdImage) -> list[Grasp]:
        return [Grasp(20, 20, 0, 40)]

    @property
    def last_maps(self) -> None:
        raise SystemExit(0)


class Closes:
    """Is no trouble until it is closed."""

    def predict(self, image: RgbdImage) -> list[Grasp]:
        return []

    def close(self) -> None:
        raise SystemExit(0)


class ClosesNever(Closes):
    """Does not end when it is closed, and ignores a polite end."""

    def __init__(self) -> None:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)

    def close(self) -> None:
        time.sleep(1e6)


class Thread(Closes):
    """Leaves a thread that never ends, and a child that keeps its pipes."""

    def __init__(self) -> None:
        threading.Thread(target=time.sleep, args=(1e6,)).start()


class Moves(Closes):
    """Goes elsewhere, and meddles with the process."""

    def __init__(self) -> None:
        Path("elsewhere").mkdir(exist_ok=True)
        os.chdir("elsewhere")
        print("hello from a predictor")

    def predict(self, image: RgbdImage) -> list[Grasp]:
        print("hello again")
        os.environ.pop("HOME", None)
        np.seterr(all="raise")
        sys.setrecursionlimit(sys.getrecursionlimit() + 7)
        return [Grasp(image.depth.shape[1] / 2, image.depth.shape[0] / 2, 0, 40)]


class Says(Closes):
    """Says of itself what no file can hold."""

    def info(self) -> dict[str, Any]:
        return {"weights": b"caf\xe9.pt".decode("utf-8", "surrogateescape"), "\udcff": ["\ud800"]}
