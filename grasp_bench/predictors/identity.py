"""What identifies a predictor that is not shipped, so that a run is not resumed with a changed one."""

from __future__ import annotations

import json
from typing import Any

from grasp_bench.errors import PredictorError
from grasp_bench.predictors.guard import Guard
from grasp_bench.predictors.names import PythonPath, parse
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.predictors.shipped import Shipped
from grasp_bench.predictors.use import in_use
from grasp_bench.system.apart import DiedError, Tell, TooLateError, answers

MOST_INFO = 2**16
"""Bytes that a predictor may say of itself."""


def identify(name: str, predictor: Predictor | None = None) -> dict[str, Any] | None:
    """Return facts that change when the predictor changes; None for a shipped one, which its version
    identifies.

    Args:
        name: what :func:`~grasp_bench.predictors.names.parse` takes.
        predictor: the one of this name, where it is made already; otherwise it is loaded, and closed again.

    Returns:
        ``files``: SHA-256 of each source file, by name (see :func:`grasp_bench.predictors.sources.sources`),
        or of those a command names;
        ``distribution``: name and version of the package it was installed with;
        ``info``: what it says of itself, or its server at ``GET /info``.

    Raises:
        PredictorError: as :func:`grasp_bench.predictors.load_predictor` does, or when ``info`` fails.
        AssetError: for a shipped network whose weights are missing or altered.
    """
    if predictor is None and isinstance(named := parse(name), Shipped):
        if named.weights is not None:
            named.weights.require()
        if named.weights is None or not named.weights.intact():
            with in_use(name):  # weights that the manifest does not list may not load
                pass
        return None
    if predictor is not None:
        return describe(name, predictor)
    if not isinstance(parse(name), PythonPath):  # our own code asks the server
        with in_use(name) as used:
            return describe(name, used)
    from grasp_bench.predictors.command import START_SECONDS

    try:
        for facts in answers(_describe_there, name, seconds=START_SECONDS):
            return facts
    except DiedError as error:
        raise PredictorError(f"{name} ended its process while it was made ({error}).") from error
    except TooLateError as error:
        raise PredictorError(
            f"{name} was not ready within {START_SECONDS:g} s. Where it must take longer, serve it yourself "
            f"(`grasp-bench serve {name}`) and give the address."
        ) from error
    raise PredictorError(f"{name} could not be made.")


def _describe_there(tell: Tell, name: str) -> None:
    """Describe a predictor, in a process of its own."""
    with in_use(name) as used:
        tell(describe(name, used))


def describe(name: str, predictor: object) -> dict[str, Any]:
    """Return the facts of a predictor that is loaded.

    Raises:
        PredictorError: for an ``info()`` that fails, or gives what is not JSON or too much.
    """
    facts = parse(name).facts(predictor)
    with Guard(f"info() of {name} failed or is not JSON:"):
        info = getattr(predictor, "info", None)
        if not callable(info):
            return facts
        text = json.dumps(info(), allow_nan=False)
        if len(text) > MOST_INFO:
            raise PredictorError(f"info() of {name} gives {len(text)} bytes; at most {MOST_INFO} are kept.")
        return facts | {"info": json.loads(text)}
