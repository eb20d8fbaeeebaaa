"""Words of foreign code and of strangers' files, made fit to be written and shown."""

from __future__ import annotations

import re
import sys
import sysconfig
import traceback
from pathlib import Path
from typing import Any

LONGEST = 2000
"""Characters of a message that are kept."""
_PACKAGE = str(Path(__file__).resolve().parents[1])
_LIBRARIES = tuple(
    {str(Path(p).resolve()) for n, p in sysconfig.get_paths().items() if n in ("stdlib", "platstdlib")}
)
# Control characters act on terminals, and marks of direction let text look like another.
_ACTING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


def legible(text: str, longest: int | None = None) -> str:
    """Return text as a plain ``str`` that UTF-8 can hold and a terminal shows without acting on it.

    What is neither becomes U+FFFD; what is longer than ``longest`` characters is cut in its middle.
    """
    if longest is not None and str.__len__(text) > longest:
        head = longest * 2 // 3
        tail = longest - head - 3
        text = f"{str.__getitem__(text, slice(head))} … {str.__getitem__(text, slice(-tail, None))}"
    # Unbound methods: a subclass of str may answer anything.
    valid = str.encode(text, "utf-16-le", "surrogatepass").decode("utf-16-le", "replace")
    return _ACTING.sub("\ufffd", valid)


def legible_all(content: Any) -> Any:
    """Return plain data whose texts can all be written, see :func:`legible`."""
    if isinstance(content, str):
        return (
            content
            if type(content) is str and content.isascii() and content.isprintable()
            else legible(content)
        )
    if isinstance(content, dict):
        return {legible_all(k): legible_all(v) for k, v in content.items()}
    if isinstance(content, (list, tuple)) and type(content) in (list, tuple):
        return type(content)(map(legible_all, content))
    return content


def said(error: BaseException, longest: int = LONGEST) -> str:
    """Return the message of any exception, however odd: legible, and cut."""
    try:
        text = str(error)
    except BaseException as other:
        return f"(no message: its __str__ raised {named(other)})"
    return legible(text, longest)


def raised(error: BaseException, longest: int = 1000) -> str:
    """Return type and message of any exception, such as ``ValueError: no such file``."""
    text = said(error, longest)
    return f"{named(error)}: {text}" if text else named(error)


def shown(value: object, longest: int = 40) -> str:
    """Return a value as a message shows it: legible, and cut where it is long; never raises."""
    if isinstance(value, (list, tuple, dict, set, frozenset)) and len(value) > 1000:
        return f"{named(value)} of {len(value)}"  # its words could be without end
    try:
        text = repr(value)
    except BaseException:
        return f"a {named(value)}"
    if str.__len__(text) <= longest:
        return legible(text)
    return legible(str.__getitem__(text, slice(longest - 3))) + "…"


def place(error: BaseException) -> str:
    """Return ``file.py:12``, the line of the user's own code where an exception arose; empty if none."""
    found = ""
    for frame, line in traceback.walk_tb(error.__traceback__):
        file = frame.f_code.co_filename
        if not file.startswith("<") and not _is_library(file):
            found = f"{Path(file).name}:{line}"
    return legible(found, 200)


def whole_traceback(error: BaseException, longest: int = 8000) -> str:
    """Return the traceback of an exception as Python prints it; never raises."""
    try:
        lines = traceback.format_exception(type(error), error, error.__traceback__, limit=-30)
    except BaseException:
        lines = [f"{raised(error)}\n"]
    return legible("".join(lines), longest)


def _is_library(file: str) -> bool:
    parts = Path(file).parts
    return (
        file.startswith((_PACKAGE, *_LIBRARIES))
        or "site-packages" in parts
        or "dist-packages" in parts
        or file.startswith(sys.base_prefix + "/lib")
    )


def named(thing: object) -> str:
    """Return the name of a thing's type, legible and cut: a type may be called anything."""
    return legible(type.__dict__["__name__"].__get__(type(thing)), 100)
