"""Errors that users meet. Each names the thing at fault and the remedy."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class GraspBenchError(Exception):
    """Base of all errors with which grasp-bench refuses bad input."""


class UnknownNameError(GraspBenchError):
    """A name that is not among the valid ones.

    Attributes:
        kind: what was named (object, predictor, scenario …).
        name: the name given.
        valid: all valid names.

    Args:
        ways: other ways to name one, always shown at the end.
    """

    def __init__(self, kind: str, name: str, valid: Iterable[str], ways: Iterable[str] = ()) -> None:
        self.kind, self.name, self.valid = kind, name, sorted(set(valid))
        near = get_close_matches(name, self.valid, n=3, cutoff=0.5)
        hint = f" Did you mean {' or '.join(near)}?" if near else ""
        shown = self.valid if len(self.valid) <= 24 else [*self.valid[:20], f"… ({len(self.valid)} in all)"]
        super().__init__(f"Unknown {kind} {name!r}.{hint} Valid: {', '.join([*shown, *ways])}.")


class ScenarioError(GraspBenchError):
    """A scenario file that cannot be used."""


class AssetError(GraspBenchError):
    """A mesh, weight or manifest that is missing, truncated or not what it should be."""


class ResultsError(GraspBenchError):
    """A results folder that cannot be read, written or resumed."""


class PredictorError(GraspBenchError):
    """A predictor that cannot be loaded, or that answered with something unusable."""
