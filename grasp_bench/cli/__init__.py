"""The command line: one file a command, which parses, calls and prints."""

from __future__ import annotations

from grasp_bench.cli.app import app, main

__all__ = ["app", "main"]
