"""A predictor for as long as it is needed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from grasp_bench.errors import PredictorError
from grasp_bench.predictors.guard import Guard
from grasp_bench.predictors.names import load_predictor
from grasp_bench.predictors.protocol import Predictor


@contextmanager
def in_use(predictor: str | Predictor) -> Iterator[Predictor]:
    """Give a predictor: one that is named is loaded, and closed in the end; one that is given stays open.

    Raises:
        UnknownNameError, PredictorError: as :func:`grasp_bench.predictors.names.load_predictor`.
    """
    if not isinstance(predictor, str):
        yield predictor
        return
    loaded = load_predictor(predictor)
    try:
        yield loaded
    finally:
        with suppress(PredictorError), Guard():  # it is not needed any more, whatever it says
            close = getattr(loaded, "close", None)
            if callable(close):
                close()
