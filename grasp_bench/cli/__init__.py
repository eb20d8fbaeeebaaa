"""The command line: one file a command, which parses, calls and prints."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from grasp_bench.cli.start import main

if TYPE_CHECKING:
    from grasp_bench.cli.commands import app as app

__all__ = ["app", "main"]


def __getattr__(name: str) -> Any:
    if name == "app":  # brings all commands, which the workers of a run need not wait for
        from grasp_bench.cli.commands import app

        return app
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
