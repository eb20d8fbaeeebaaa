"""Differences between two runs, in words."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any

_NAMES = {
    "objects": "the objects or their files",
    "weights": "the weights",
    "versions": "the software versions",
    "trials": "the number of trials",
    "implementation": "the predictor's files, package or what it says of itself",
}
_SHOWN = 4


def differences(
    first: dict[str, Any],
    second: dict[str, Any],
    keys: Iterable[str],
    places: tuple[str, str] = ("there", "here"),
) -> dict[str, str]:
    """Return what differs between two ``run.json``, in words, by key.

    A key that is missing counts as null; ``places`` says where the two were found.
    """
    found = {}
    for key in keys:
        a, b = _plain(first.get(key)), _plain(second.get(key))
        details = list(_details(a, b, places))
        if key == "objects" and not details and list(a or ()) != list(b or ()):
            details = ["in another order, so that their trials have other numbers"]
        if details:
            more = f"; and {len(details) - _SHOWN} more" if len(details) > _SHOWN else ""
            found[key] = f"{_NAMES.get(key, f'the {key}')} ({'; '.join(details[:_SHOWN])}{more})"
    return found


def listed(found: dict[str, str]) -> str:
    """Return ``the seed (…), the weights (…) differ``."""
    return f"{', '.join(found.values())} differ{'s' if len(found) == 1 else ''}"


def _plain(value: Any) -> Any:
    return json.loads(json.dumps(value))


def _details(a: Any, b: Any, places: tuple[str, str], path: str = "") -> Iterator[str]:
    if isinstance(a, dict) and isinstance(b, dict):
        for key in dict.fromkeys([*a, *b]):
            below = f"{path}.{key}" if path else key
            if key not in a or key not in b:
                yield f"{below} only {places[key in b]}"
            else:
                yield from _details(a[key], b[key], places, below)
    elif a != b:
        name = f"{path}: " if path else ""
        yield f"{name}{_shown(a)} {places[0]}, {_shown(b)} {places[1]}"


def _shown(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, str):
        return f"{value[:9]}…" if len(value) == 64 and value.isalnum() else value[:60]
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else text[:57] + "…"
