"""Pages that are made while the site is built: commands, API, examples, and the repository's own files.

Run by mkdocs-gen-files, so that they are never older than the code.
"""

from __future__ import annotations

import ast
import os
import re
from pathlib import Path
from typing import Any

import mkdocs_gen_files
from typer.testing import CliRunner

ROOT = Path(__file__).resolve().parents[1]
WIDTH = 96

API = {
    "Runs": ("run", "load", "Run", "Comparison"),
    "Predictors": (
        "RgbdImage",
        "Intrinsics",
        "CameraPose",
        "Grasp",
        "GraspMaps",
        "GraspPose",
        "Predictor",
        "load_predictor",
    ),
    "One trial": ("Workcell", "run_trial", "Trial", "TrialRecord", "Outcome"),
    "Objects and scenarios": ("Catalog", "ObjectModel", "load_object", "Scenario", "load_scenario"),
    "Errors": ("GraspBenchError",),
}


def api_page() -> str:
    """The public names of ``grasp_bench``, by theme."""
    import grasp_bench

    left = set(grasp_bench.__all__) - {name for names in API.values() for name in names}
    groups = {**API, "More": tuple(sorted(left))} if left else API
    lines = [
        "# Python API",
        "",
        "All names are imported from `grasp_bench`; [the guide](../python.md) shows "
        "them in use. Shapes, units and frames stand with each name.",
        "",
    ]
    for title, names in groups.items():
        lines += [f"## {title}", ""]
        for name in names:
            lines += [f"::: grasp_bench.{grasp_bench._HOME[name]}.{name}", ""]
    lines += ["## Gymnasium", "", "::: grasp_bench.gym.GraspEnv", ""]
    return "\n".join(lines)


def command_page() -> str:
    """``--help`` of every command, as the terminal shows it."""
    import typer

    from grasp_bench.cli import app

    os.environ.update(COLUMNS=str(WIDTH), TERMINAL_WIDTH=str(WIDTH), NO_COLOR="1")
    runner = CliRunner()
    lines = [
        "# Commands",
        "",
        "Every command with all its options, as `--help` prints them. "
        "[Conventions and exit codes](../cli.md).",
        "",
    ]

    def describe(command: Any, path: list[str]) -> None:
        if path:
            lines.extend([f"{'#' * (1 + len(path))} {' '.join(path)}", ""])
        text = runner.invoke(app, [*path, "--help"], prog_name="grasp-bench", color=False).output
        lines.extend(["```text", *(line.rstrip() for line in text.strip("\n").splitlines()), "```", ""])
        for name, child in getattr(command, "commands", {}).items():
            describe(child, [*path, name])

    describe(typer.main.get_command(app), [])
    return "\n".join(lines)


def example_page() -> str:
    """The numbered examples, each with its docstring as introduction."""
    lines = [
        "# Examples",
        "",
        "Numbered from the smallest on; the tests run every one of them. They lie in `examples/`.",
        "",
    ]
    for path in sorted((ROOT / "examples").glob("[0-9]*")):
        number, _, name = path.stem.partition("_")
        lines += [f"## {number} · {name.replace('_', ' ').capitalize()}", ""]
        files = [path] if path.is_file() else sorted(path.glob("*.py")) + sorted(path.glob("*.toml"))
        for file in files:
            body = file.read_text(encoding="utf-8")
            if file.suffix == ".py":
                title, _, rest = (ast.get_docstring(ast.parse(body)) or path.stem).partition("\n")
                lines += [title, ""]
                if rest.strip():
                    lines += ["```text", rest.strip("\n"), "```", ""]
                body = body[body.index('"""', 3) + 3 :]
            language = "python" if file.suffix == ".py" else "toml"
            name = file.relative_to(ROOT / "examples")
            lines += [f'```{language} title="{name}"', body.strip("\n"), "```", ""]
    return "\n".join(lines)


def root_page(name: str) -> str:
    """A Markdown file of the repository's root, its links as seen from ``docs/``."""
    text = (ROOT / name).read_text(encoding="utf-8")
    return re.sub(r"\]\((?!https?:|#)(docs/)?", lambda m: "](" if m[1] else "](../", text)


PAGES = {
    "reference/api.md": api_page,
    "reference/commands.md": command_page,
    "reference/examples.md": example_page,
    "changelog.md": lambda: root_page("CHANGELOG.md"),
    "contributing.md": lambda: root_page("CONTRIBUTING.md"),
}

if __name__ in ("__main__", "<run_path>"):
    for name, make in PAGES.items():
        with mkdocs_gen_files.open(name, "w") as page:
            page.write(make())
