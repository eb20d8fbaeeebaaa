"""The first thing that ``grasp-bench`` does: begin the workers of a run, then import the command line.

Workers take seconds to import what trials need, and the command line a tenth of one. What is guessed wrongly
here costs nothing: a run that asked for something else begins workers of its own.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext

GUESSED = {"predictor": "htc-grasp", "trials": "180", "workers": "0", "renderer": "auto"}
"""Options of ``run`` that say which workers it needs, and their defaults, which a test compares."""
UNLIKE = ("--help", "--weights", "--executor")
"""Options of a run whose workers are not begun here."""


def main() -> None:
    """Run the command line: one clear line for what is wrong, never a traceback for bad input."""
    with begun_ahead(sys.argv[1:]):
        from grasp_bench.cli.commands import main

        main()


def begun_ahead(words: Sequence[str]) -> AbstractContextManager[None]:
    """Begin workers where ``words`` ask for a run with shipped predictors on this machine; otherwise do
    nothing."""
    if (asked := guess(words)) is None:
        return nullcontext()
    from grasp_bench.execution.crew import early_crew
    from grasp_bench.system.machine import usable_cores

    workers, trials = int(asked["workers"]), int(asked["trials"])
    return early_crew((asked["predictor"],), min(workers, max(2, usable_cores())), trials)


def guess(words: Sequence[str]) -> dict[str, str] | None:
    """Return the options of :data:`GUESSED`; None where these workers would not do, or nobody can say."""
    if words[:1] != ["run"]:
        return None
    asked, left = dict(GUESSED), list(words[1:])
    while left:
        option, is_joined, value = left.pop(0).partition("=")
        if option in UNLIKE:
            return None
        if (name := option.removeprefix("--")) in asked and option.startswith("--"):
            if not is_joined and not left:
                return None
            asked[name] = value if is_joined else left.pop(0)
    numbers = asked["workers"].isdecimal() and asked["trials"].isdecimal()
    usual = asked["renderer"] in ("auto", "raycast") and ":" not in asked["predictor"]
    return asked if numbers and usual else None
