"""Small pictures of objects, for trials of which no picture was kept."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from typing import Any

from grasp_bench.errors import GraspBenchError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.report.html.trials import name_of, tries_of


def lacking(rows: Iterable[dict[str, Any]], media: dict[str, dict[str, str]]) -> list[str]:
    """Return the objects, in order, of trials without a sheet in the page; only those with known facts."""
    names = {
        row["object"]: None
        for row in rows
        if "family" in row
        and not any(
            "sheet" in media.get(name_of(row["run"], row["trial"], number), {}) for number, _ in tries_of(row)
        )
    }
    return sorted(names)


def thumbnails(names: Iterable[str], catalog: Catalog, budget: int) -> dict[str, str]:
    """Return base64 of WebP pictures by object, as many as fit into ``budget`` bytes.

    An object whose files cannot be drawn has none.
    """
    from grasp_bench.media.portraits import thumbnail

    found: dict[str, str] = {}
    for name in names:
        try:
            picture = base64.b64encode(thumbnail(catalog.load(name))).decode()
        except (GraspBenchError, OSError, ValueError):
            continue
        budget -= len(picture) + len(name.encode()) + 8
        if budget < 0:
            break
        found[name] = picture
    return found
