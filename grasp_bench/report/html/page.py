"""The page: figures and rows in, one self-contained HTML file out."""

from __future__ import annotations

import base64
import gzip
import hashlib
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from grasp_bench.errors import GraspBenchError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.report.html.content import content, p_value
from grasp_bench.report.html.thumbnails import lacking, thumbnails
from grasp_bench.report.html.trials import Embedded, embed, tries_of
from grasp_bench.runs.results import RunResults
from grasp_bench.system.integrity import write_whole

PACKAGE = "grasp_bench.report.html"
MEGABYTE = 1_000_000
SIZE_LIMIT = 15 * MEGABYTE
"""Largest size of the file [bytes]; pictures that would exceed it are left out."""
SCRIPTS = ("begin.js", "charts.js", "runs.js", "trials.js", "trial.js", "address.js")
STYLES = ("report.css", "trials.css")
PER_TRY = 128
"""Bytes around the pictures of a trial, or of an attempt of an episode, in the page."""


@dataclass(frozen=True)
class Written:
    """What :func:`write_html` did.

    Attributes:
        path, size: the file, and its size [bytes].
        trials, pictures: number of trials, and of sheets and clips, in the page.
        left_out: number of sheets and clips that would have made it too large.
    """

    path: Path
    size: int
    trials: int
    pictures: int
    left_out: int


def write_html(
    folders: list[Path],
    out: Path,
    root: Path | None = None,
    objects: Path | None = None,
    limit: int = SIZE_LIMIT,
) -> Written:
    """Write the report of all runs as one file without outside references.

    Args:
        folders: the runs' folders; those without a trial are left out.
        out: file to write.
        root: folder below which paths name the runs.
        objects: folder of the objects' catalogue; the shipped ones by default.
        limit: largest size of the file with pictures [bytes]; failures come first.

    Raises:
        GraspBenchError: when no run holds a trial, or the file cannot be written.
    """
    runs = [run for run in map(RunResults, folders) if len(run)]
    if not runs:
        raise GraspBenchError("None of the runs holds a trial yet; finish one, then report it.")
    text, embedded, count = render(runs, root, Catalog(objects), limit)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_whole(out, text.encode())
    except OSError as error:
        raise GraspBenchError(f"{out} cannot be written ({error.strerror}).") from error
    return Written(out, len(text.encode()), count, embedded.found - embedded.left_out, embedded.left_out)


def render(
    runs: list[RunResults], root: Path | None, catalog: Catalog, limit: int
) -> tuple[str, Embedded, int]:
    """Return the page, the pictures in it, and the number of its trials."""
    context = content(runs, root, catalog)
    rows = context["data"]["trials"]
    script, plotly = Markup("".join(_asset(name) for name in SCRIPTS)), get_plotlyjs()
    context |= {
        "version": version("grasp-bench"),
        "style": Markup("".join(_asset(name) for name in STYLES)),
        "script": script,
        "plotly": _packed(plotly),
        "policy": f"default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; "
        f"script-src {_hash(script)} {_hash(plotly)}",
    }
    template = _environment().get_template("report.html.j2")
    bare = template.render(context, embedded=Embedded({}, 0, 0), thumbs={})
    left = limit - len(bare.encode()) - PER_TRY * sum(len(tries_of(row)) for row in rows)
    embedded = embed(runs, rows, left)
    left -= sum(len(part) for media in embedded.media.values() for part in media.values())
    thumbs = thumbnails(lacking(rows, embedded.media), catalog, left)
    return template.render(context, embedded=embedded, thumbs=thumbs), embedded, len(rows)


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader(PACKAGE),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["percent"] = lambda x: f"{100 * x:.1f} %"
    environment.filters["p_value"] = p_value
    environment.filters["beside"] = _beside
    return environment


def _beside(run: str, predictor: str) -> str:
    """Return what a run's name says beside its predictor's."""
    folder, _, name = run.rpartition("/")
    return f"in {folder}" if folder and name == predictor else "" if run == predictor else run


def _asset(name: str) -> str:
    return files(PACKAGE).joinpath("static", name).read_text(encoding="utf-8")


def _packed(text: str) -> str:
    """Return text as base64 of gzip, always the same: a quarter of Plotly's size, parsed when needed."""
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def _hash(script: str) -> str:
    """Return a script's source expression in a content security policy."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'"


def describe(written: Written) -> str:
    """Return one line for the terminal."""
    left = f"; {written.left_out} more did not fit (--max-mb raises the limit)" if written.left_out else ""
    return (
        f"{written.path}: {written.trials} trials, {written.pictures} pictures and clips{left}, "
        f"{written.size / MEGABYTE:.1f} MB."
    )
