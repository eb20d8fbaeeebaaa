"""Whether a predictor that a run's record names may be started: a record is data, and may be a stranger's."""

from __future__ import annotations

from grasp_bench.errors import PredictorError
from grasp_bench.predictors.names import Command, PythonPath, Server, parse
from grasp_bench.system.texts import shown


class UntrustedError(PredictorError):
    """A record names a predictor that would act on this machine, and nobody said that it may."""


def what_it_does(name: str) -> str | None:
    """Return in words what using a predictor does on this machine beside grasping; None for a shipped one."""
    named = parse(name)
    if isinstance(named, PythonPath):
        return f"runs the Python code of {shown(named.path, 200)}"
    if isinstance(named, Command):
        return f"runs the command {shown(named.command.strip(), 200)}"
    if isinstance(named, Server):
        return f"sends images to {shown(named.name, 200)}"
    return None


def require(name: str, source: object, trusted: bool) -> None:
    """Refuse a predictor that a record names, unless it is shipped or trusted.

    Args:
        name: as it stands in the record.
        source: the run's folder, for the message.
        trusted: the user knows where the folder comes from.

    Raises:
        UntrustedError: saying what would happen, and how to allow it.
        UnknownNameError, PredictorError: as :func:`~grasp_bench.predictors.names.parse`.
    """
    does = what_it_does(name)
    if does is not None and not trusted:
        raise UntrustedError(
            f"Doing trials of {source} again {does} on this machine, as its run.json says. "
            "Give --trust (trust=True in Python) if you know where the folder comes from."
        )
