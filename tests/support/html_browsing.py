"""Opening reports in a real browser, for the tests of the HTML report."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
PATIENCE = 120_000
"""Milliseconds that a step may take on a machine that is busy."""


def until(page: Any, expression: str, arg: Any = None) -> None:
    """Wait for a JavaScript expression; ``wait_for_function`` polls by ``eval``, which the page forbids."""
    deadline = time.monotonic() + PATIENCE / 1000
    while not page.evaluate(expression, arg):
        assert time.monotonic() < deadline, f"never true: {expression}"
        page.wait_for_timeout(20)


@dataclass
class Opened:
    """A page, and what its browser complained of or asked for."""

    page: Any
    url: str
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def go(self, address: str = "") -> None:
        self.page.goto("about:blank")
        self.page.goto(self.url + address)
        until(self.page, "document.documentElement.dataset.ready")

    def names(self) -> list[str]:
        return self.page.locator("#trials .name").all_inner_texts()


@contextmanager
def opening(browser: Any, report: Path, options: dict[str, Any]) -> Iterator[Opened]:
    """Open a report; at the end, it must have complained of nothing and asked for nothing outside."""
    context = browser.new_context(**({"viewport": {"width": 1200, "height": 900}} | options))
    context.set_default_timeout(PATIENCE)
    page = context.new_page()
    found = Opened(page, report.as_uri())
    page.on("console", lambda m: found.complaints.append(m.text) if m.type in ("error", "warning") else None)
    page.on("pageerror", lambda e: found.complaints.append(str(e)))
    page.on("dialog", lambda d: (found.complaints.append(f"dialog {d.message}"), d.dismiss()))
    page.on("request", lambda r: found.requests.append(r.url))
    found.go()
    yield found
    assert found.complaints == []
    outside = [u for u in found.requests if not u.startswith(("data:", "blob:", "about:", report.as_uri()))]
    assert outside == []
    context.close()


def draw_charts(page: Any) -> int:
    for box in page.query_selector_all(".chart"):
        box.scroll_into_view_if_needed()
    until(page, "[...document.querySelectorAll('.chart')].every(b => b.dataset.drawn)")
    return page.locator(".chart .main-svg").count()
