"""What identifies a predictor that is not shipped, so that a run is not resumed with a changed one."""

from __future__ import annotations

import json
from typing import Any

from grasp_bench.errors import PredictorError
from grasp_bench.predictors.names import parse
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.predictors.shipped import Shipped
from grasp_bench.predictors.use import in_use


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
    with in_use(name if predictor is None else predictor) as used:
        return describe(name, used)


def describe(name: str, predictor: object) -> dict[str, Any]:
    """Return the facts of a predictor that is loaded."""
    facts = parse(name).facts(predictor)
    info = getattr(predictor, "info", None)
    return facts | {"info": _plain(name, info)} if callable(info) else facts


def _plain(name: str, info: Any) -> Any:
    try:
        return json.loads(json.dumps(info(), allow_nan=False))
    except PredictorError:
        raise
    except (Exception, SystemExit) as error:  # a foreign method, or something that is not JSON
        raise PredictorError(
            f"info() of {name} failed or is not JSON: {type(error).__name__}: {error}"
        ) from error
