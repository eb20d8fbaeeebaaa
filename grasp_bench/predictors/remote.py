"""A predictor behind an address: the client of :mod:`grasp_bench.predictors.wire`.

Nothing that the other side says is trusted: every exchange has a deadline and a size limit,
redirects and compressed answers are refused, and any fault becomes a
:class:`~grasp_bench.errors.PredictorError` that ends one trial.
"""

from __future__ import annotations

import asyncio
import functools
import ipaddress
import os
import threading
from collections.abc import Coroutine
from typing import Any, TypeVar

import httpx
import numpy as np

from grasp_bench.camera import RgbdImage
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp, GraspPose
from grasp_bench.predictors import wire

T = TypeVar("T")

ANSWER_SECONDS = 30.0
"""How long a predictor may take for one image, waiting for its turn included."""
INFO_SECONDS = 5.0
"""How long ``GET /info`` may take."""


class UnansweredError(PredictorError):
    """Nobody answered, or not in time: the server may be gone or stuck."""


class RemotePredictor:
    """Asks a server for grasps.

    Args:
        address: where ``/predict`` and ``/info`` are, such as ``http://127.0.0.1:8000``.
        label: what messages call it; the address by default.
        seconds: greatest time for one image.

    Raises:
        PredictorError: for an address that is not valid. Whether a server answers there is seen when
            :meth:`info` or :meth:`predict` is called.
    """

    def __init__(self, address: str, label: str | None = None, seconds: float = ANSWER_SECONDS) -> None:
        self._address = _checked_address(address)
        self._label = label or self._address
        self._seconds = seconds
        self._seed = wire.seed_of(np.random.default_rng(0))
        # Environment proxies would send a loopback request elsewhere. Connections are not kept: one that the
        # server drops between two trials would fail the second.
        self._client = httpx.AsyncClient(
            trust_env=False,
            follow_redirects=False,
            timeout=None,
            headers={"Accept-Encoding": "identity", "Connection": "close"},
            limits=httpx.Limits(max_keepalive_connections=0),
        )

    def begin(self, rng: np.random.Generator) -> None:
        """Take the trial's random stream; its state travels with the image."""
        self._seed = wire.seed_of(rng)

    def predict(self, image: RgbdImage) -> list[Grasp | GraspPose]:
        """Ask the server for grasps.

        Raises:
            UnansweredError: when there is no answer in time.
            PredictorError: for one that cannot be used, saying why.
        """
        status, body = self._ask(
            "POST", "/predict", wire.encode_request(image, self._seed), self._seconds, wire.ANSWER_BYTES
        )
        if status != 200:
            raise PredictorError(_reason(body) or f"{self._label} answered with status {status}")
        try:
            return wire.decode_answer(body)
        except PredictorError as error:
            raise PredictorError(f"{self._label}: {error}") from error

    def info(self, seconds: float = INFO_SECONDS) -> dict[str, Any]:
        """Return what the server says of itself; ``protocol`` is in it.

        Raises:
            UnansweredError: when there is no answer in time.
            PredictorError: for a server that does not speak this protocol.
        """
        status, body = self._ask("GET", "/info", b"", seconds, wire.INFO_BYTES)
        if status == 503:
            raise UnansweredError(f"{self._label} is not ready (status 503)")
        try:
            if status != 200:
                raise PredictorError(f"status {status}")
            content = wire.decode_object(body)
            spoken = content.get("protocol")
            if isinstance(spoken, bool) or spoken not in wire.UNDERSTOOD:
                known = " or ".join(map(str, wire.UNDERSTOOD))
                raise PredictorError(f"protocol {spoken!r}, not {known}")
        except PredictorError as error:
            raise PredictorError(
                f"{self._label}/info is not that of a grasp predictor: {error}; see docs/predictors.md."
            ) from error
        return content

    def close(self) -> None:
        """Close the connection."""
        _in_background(self._client.aclose())

    def _ask(self, method: str, path: str, content: bytes, seconds: float, limit: int) -> tuple[int, bytes]:
        try:
            return _in_background(self._exchange(method, path, content, seconds, limit))
        except TimeoutError as error:
            raise UnansweredError(f"{self._label} gave no answer within {seconds:g} s") from error
        except httpx.ConnectError as error:
            raise UnansweredError(f"nothing listens at {self._label} ({error})") from error
        except httpx.HTTPError as error:
            raise UnansweredError(f"{self._label} broke off ({type(error).__name__}: {error})") from error

    async def _exchange(
        self, method: str, path: str, content: bytes, seconds: float, limit: int
    ) -> tuple[int, bytes]:
        """Make one request, with the deadline on the whole of it: a server may drip as slowly as it likes."""
        refused: httpx.ConnectError | None = None
        try:
            async with asyncio.timeout(seconds):
                while True:
                    try:
                        return await self._attempt(method, path, content, limit)
                    except httpx.ConnectError as error:  # not sent yet: a server that restarts is waited for
                        refused = error
                    await asyncio.sleep(0.1)
        except TimeoutError:
            raise refused or TimeoutError() from None

    async def _attempt(self, method: str, path: str, content: bytes, limit: int) -> tuple[int, bytes]:
        async with self._client.stream(method, self._address + path, content=content) as answer:
            if answer.is_redirect:
                raise PredictorError(
                    f"{self._label} redirects to {answer.headers['location'][:100]}; "
                    "redirects are not followed"
                )
            if answer.headers.get("content-encoding", "identity") != "identity":
                raise PredictorError(f"{self._label} answered compressed, which was not asked for")
            body = bytearray()
            async for chunk in answer.aiter_raw():
                body += chunk
                if len(body) > limit:
                    raise PredictorError(f"{self._label} answered with more than {limit} bytes")
            return answer.status_code, bytes(body)


def _reason(body: bytes) -> str | None:
    """Return the server's own words for what went wrong: those of the predictor, were it local."""
    try:
        said = wire.decode_object(body).get("error")
    except PredictorError:
        return None
    return said[:1000] if isinstance(said, str) and said else None


def _checked_address(address: str) -> str:
    try:
        url = httpx.URL(address)
        port = url.port
    except (httpx.InvalidURL, ValueError) as error:
        raise PredictorError(
            f"{address!r} is not an address ({error}); it must look like http://127.0.0.1:8000."
        ) from error
    impossible = port is not None and not 0 < port < 2**16
    if (
        url.scheme not in ("http", "https")
        or not url.host
        or impossible
        or url.query
        or url.fragment
        or (any(c.isspace() for c in address))
    ):
        raise PredictorError(
            f"{address!r} is not the address of a server; it must look like http://127.0.0.1:8000."
        )
    if url.userinfo:
        raise PredictorError("Leave name and password out of the address: it is written to run.json.")
    return address.rstrip("/")


def is_loopback(host: str) -> bool:
    """Return whether only this machine can reach ``host``."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


# ---------------------------------------------------------------- a loop of its own

# The caller may run an event loop already, as notebooks do, so exchanges run on another thread's.


@functools.cache
def _loop(process: int) -> asyncio.AbstractEventLoop:
    loop = asyncio.new_event_loop()
    threading.Thread(target=loop.run_forever, name="grasp-bench-remote", daemon=True).start()
    return loop


def _in_background(work: Coroutine[Any, Any, T]) -> T:
    return asyncio.run_coroutine_threadsafe(work, _loop(os.getpid())).result()
