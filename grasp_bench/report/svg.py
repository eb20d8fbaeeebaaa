"""What the figures that are written as SVG share: how one begins, its text, its colours."""

from __future__ import annotations

from html import escape


def start(width: float, height: float, title: str, font_size: int = 13) -> list[str]:
    """Return how a figure with a white ground begins; ``title`` is read out and shown on hovering."""
    return [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-size="{font_size}" '
        'font-family="system-ui, sans-serif" role="img">',
        f"<title>{escape(title)}</title>",
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
    ]


def text(x: float, y: float, content: str, anchor: str = "start", bold: bool = False) -> str:
    """Return a line of text at ``x``, which its ``anchor`` (start, middle or end) is at."""
    weight = ' font-weight="bold"' if bold else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{weight} '
        f'fill="#333333">{escape(content)}</text>'
    )
