"""MkDocs hook: links from a page to files of the repository that are no pages.

On the web such a link leads to the repository where ``repo_url`` is set in ``mkdocs.yml``, and is
plain text with the file's path where it is not. In the Markdown it stays relative, so that it
works in a checkout, too.
"""

from __future__ import annotations

import posixpath
import re
from typing import Any

LINK = re.compile(r"(?<!!)\[([^\]]+)\]\((\.\./[^)\s#]+)(#[^)]*)?\)")


def on_page_markdown(markdown: str, page: Any, config: Any, **_: Any) -> str:
    """Rewrite links that lead out of ``docs/``."""
    folder = posixpath.dirname(page.file.src_uri)

    def replace(match: re.Match[str]) -> str:
        path = posixpath.normpath(posixpath.join(folder, match[2]))
        if not path.startswith("../"):
            return match[0]
        path = path.removeprefix("../")
        if config.repo_url:
            return f"[{match[1]}]({config.repo_url.rstrip('/')}/blob/main/{path})"
        return match[1] if path in match[1] else f"{match[1]} (`{path}`)"

    return LINK.sub(replace, markdown)
