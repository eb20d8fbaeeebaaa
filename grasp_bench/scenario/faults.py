"""What is wrong with a file of sections: a line for each fault that names the key and what would be right."""

from __future__ import annotations

import types
from typing import Any, Union, get_args, get_origin

from pydantic import ValidationError

from grasp_bench.errors import UnknownNameError
from grasp_bench.scenario.fields import Section
from grasp_bench.system.texts import legible, shown

MOST_FAULTS = 10
"""Faults of one scenario that are told."""


def fault_lines(error: ValidationError, origin: str, whole: type[Section]) -> list[str]:
    """Return a line for each fault of a file, the first few of them.

    Args:
        error: what validation as ``whole`` raised.
        origin: the file, as it is named in each line.
        whole: what the file was to hold.
    """
    faults = [_explain(origin, e, whole) for e in error.errors(include_url=False)]
    more = [f"{origin}: and {len(faults) - MOST_FAULTS} more"] if len(faults) > MOST_FAULTS else []
    return [*faults[:MOST_FAULTS], *more]


def section_of(annotation: Any) -> type[Section] | None:
    """Return the section an annotation stands for, optional or not; None for a plain value."""
    options = get_args(annotation) if get_origin(annotation) in (Union, types.UnionType) else (annotation,)
    found = [o for o in options if isinstance(o, type) and issubclass(o, Section)]
    return found[0] if found else None


def _explain(origin: str, error: Any, whole: type[Section]) -> str:
    keys = [legible(str(k), 100) for k in error["loc"]]
    where = ".".join(keys) or whole.__name__.lower()
    if error["type"] == "extra_forbidden":
        model: Any = whole
        for key in keys[:-1]:
            field = None if model is None else model.model_fields.get(key)
            model = None if field is None else section_of(field.annotation)
        if model is None:
            return f"{origin}: unknown key {shown(where, 80)}"
        what = f"key in {where!r}:" if len(keys) > 1 else "key"
        return f"{origin}: {UnknownNameError(what, keys[-1], model.model_fields)}"
    given = "" if isinstance(error["input"], dict) else f" (got {shown(error['input'], 80)})"
    return f"{origin}: {where}: {legible(error['msg'], 300)}{given}"
