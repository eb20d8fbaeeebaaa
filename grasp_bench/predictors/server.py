"""Serves a predictor at an address: the other side of :mod:`grasp_bench.predictors.remote`."""

from __future__ import annotations

import asyncio
import json
import socket
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from grasp_bench.camera import RgbdImage
from grasp_bench.errors import GraspBenchError, PredictorError
from grasp_bench.predictors import wire
from grasp_bench.predictors.identity import describe
from grasp_bench.predictors.names import load_predictor
from grasp_bench.predictors.protocol import Predictor, PrivilegedPredictor, ask

BODY_SECONDS = 30.0
"""How long a client may take to send its request [s]."""
BODIES = 4
"""Requests held in memory at once; others wait."""


def make_app(predictor: Predictor, info: dict[str, Any], limit: int = wire.REQUEST_BYTES) -> Starlette:
    """Make the ASGI application with ``POST /predict`` and ``GET /info``.

    Args:
        predictor: the one served, asked about one image at a time.
        info: facts that ``GET /info`` gives besides the protocol.
        limit: most bytes of a request, packed or unpacked.
    """
    bodies, turn = asyncio.Semaphore(BODIES), asyncio.Lock()
    said = json.dumps({"protocol": wire.PROTOCOL, **info}, allow_nan=False).encode()

    async def predict(request: Request) -> Response:
        async with bodies:
            try:
                async with asyncio.timeout(BODY_SECONDS):
                    body = await _body(request, limit)
                image, seed = await run_in_threadpool(wire.decode_request, body, limit)
            except TimeoutError:
                return _refusal(408, f"the request took longer than {BODY_SECONDS:g} s")
            except _TooLargeError:
                return _refusal(413, f"the request has more than {limit} bytes")
            except (wire.RequestError, ClientDisconnect) as error:
                return _refusal(400, str(error))
            async with turn:
                try:
                    content = await run_in_threadpool(_answer, predictor, image, seed)
                except PredictorError as error:
                    return _refusal(500, str(error))
        return Response(content, media_type="application/json")

    async def tell(_: Request) -> Response:
        return Response(said, media_type="application/json")

    return Starlette(routes=[Route("/predict", predict, methods=["POST"]), Route("/info", tell)])


class _TooLargeError(Exception):
    pass


async def _body(request: Request, limit: int) -> bytes:
    length = request.headers.get("content-length", "0")
    if not length.isdecimal() or int(length) > limit:
        raise _TooLargeError
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > limit:
            raise _TooLargeError
    return bytes(body)


def _answer(predictor: Predictor, image: RgbdImage, seed: wire.Seed) -> bytes:
    return wire.encode_answer(ask(predictor, image, wire.generator(seed)))


def _refusal(status: int, reason: str) -> Response:
    return JSONResponse({"error": reason}, status)


def servable(name: str) -> tuple[Predictor, dict[str, Any]]:
    """Load a predictor that can be served, and its facts.

    Raises:
        PredictorError: for a control that needs the simulator's truth.
    """
    predictor = load_predictor(name)
    if isinstance(predictor, PrivilegedPredictor):
        raise PredictorError(
            f"{name} cannot be served: it is a control that needs the object's true pose, "
            "which no request holds. Run it with --predictor " + name + "."
        )
    return predictor, {"predictor": name, **describe(name, predictor)}


def listen(host: str, port: int) -> socket.socket:
    """Open a socket that listens; port 0 takes a free one.

    Raises:
        GraspBenchError: when the port is taken or the host is not this machine's.
    """
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        server = socket.socket(family, socket.SOCK_STREAM)
        server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        server.bind(address)
        server.listen(128)
        return server
    except (OSError, OverflowError) as error:
        raise GraspBenchError(
            f"Nothing can listen at {host}:{port} ({error}); choose another --port, 0 for any that is free."
        ) from error


def serve(app: Starlette, server: socket.socket) -> None:
    """Answer requests until interrupted."""
    config = uvicorn.Config(app, log_level="warning", access_log=False, limit_concurrency=256, lifespan="off")
    uvicorn.Server(config).run(sockets=[server])
