"""The leaderboard as a Markdown table."""

from __future__ import annotations

from grasp_bench.report.leaderboard import Row

HEAD = ("Predictor", "Authors", "Lifted", "Rate", "95 % interval", "Harness faults", "Trained on")


def as_markdown(rows: list[Row]) -> str:
    """Contestants by rate, then the controls in italics.

    Rows whose intervals overlap are not ordered by it: the order is that of the counts.
    """
    ordered = sorted(rows, key=lambda r: (r.control, -r.successes / r.trials, r.about.name))
    lines = ["| " + " | ".join(HEAD) + " |", "| --- | --- | ---: | ---: | ---: | ---: | --- |"]
    lines += ["| " + " | ".join(_cells(row)) + " |" for row in ordered]
    return "\n".join(lines)


def _cells(row: Row) -> list[str]:
    low, high = row.interval
    name = _safe(row.about.name)
    if row.about.link:
        name = f"[{name}](<{row.about.link}>)"
    if row.control:
        name = f"*{name}* (control)"
    return [
        name,
        _safe(row.about.authors),
        f"{row.successes}/{row.trials}",
        f"{row.successes / row.trials:.1%}",
        f"{low:.1%} – {high:.1%}",
        str(row.faults),
        _safe(row.about.trained_on),
    ]


def _safe(text: str) -> str:
    """Text that cannot break out of its cell, nor bring markup or HTML of its own."""
    for character in "\\`*_{}[]()#|!~":
        text = text.replace(character, "\\" + character)
    return " ".join(text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").split())
