"""A comparison in words: for the terminal, for a summary page, and as JUnit XML."""

from __future__ import annotations

import re
from xml.etree import ElementTree as Xml

from grasp_bench.report.firmness_gate import CheckedFirmness
from grasp_bench.report.gate import Checked, Verdict
from grasp_bench.report.tables import TextTable, escaped, markdown
from grasp_bench.runs.statistics import Rate

Either = Checked | CheckedFirmness
SHOWN = 12
"""Changed trials that are listed."""

UNDECIDED = (Verdict.INCONCLUSIVE, Verdict.UNDERPOWERED)


def meaning(checked: Either) -> str:
    """Say in a sentence what the verdict means."""
    if isinstance(checked, CheckedFirmness):
        return checked.meaning
    margin, low = checked.margin, checked.interval[0]
    if checked.verdict is Verdict.NO_REGRESSION:
        return f"A drop of {margin:.1%} or more is excluded (p = {checked.p_margin:.2g} ≤ {checked.alpha:g})."
    if checked.verdict is Verdict.REGRESSION:
        return (
            f"The rate dropped: {checked.pairs.lost} trials were lost and {checked.pairs.gained} gained "
            f"(p = {checked.p_worse:.2g} ≤ {checked.alpha:g})."
        )
    if checked.verdict is Verdict.IDENTICAL:
        return f"All {checked.pairs.trials} records are the same."
    if checked.verdict is Verdict.DIFFERENT:
        return f"{len(checked.changed)} of {checked.pairs.trials} records differ."
    would = checked.enough if checked.verdict is Verdict.UNDERPOWERED else checked.needed
    more = f" About {would} trials would." if would else ""
    return (
        f"No drop is proven (p = {checked.p_worse:.2g}), but one of up to {-low:.1%} is not excluded; "
        f"these trials cannot tell a drop of {margin:.1%} from none.{more}"
    )


def rows(checked: Either) -> list[tuple[str, str]]:
    """Return the figures: what, and how much."""
    if isinstance(checked, CheckedFirmness):
        return checked.figures
    n, (low, high) = checked.pairs.trials, checked.interval
    before, after = checked.successes
    return [
        ("Baseline", str(Rate(before, n))),
        ("New", str(Rate(after, n))),
        (
            "Difference",
            f"{checked.pairs.difference:+.1%}, {1 - 2 * checked.alpha:.0%} interval {low:+.1%} – "
            f"{high:+.1%} (Tango's score)",
        ),
        ("Pairs", f"{checked.pairs.lost} lost, {checked.pairs.gained} gained, of {n}"),
        (
            "Is it a drop?",
            f"p = {checked.p_worse:.3g} (McNemar, exact, one-sided; two-sided {checked.p_two_sided:.3g})",
        ),
        (f"Less than −{checked.margin:.1%}?", f"p = {checked.p_margin:.3g} (Tango's score, non-inferiority)"),
        ("Power", power(checked)),
        ("Harness faults", f"{checked.faults[0]} before, {checked.faults[1]} now"),
    ]


def power(checked: Checked) -> str:
    """Say what drop these trials can show."""
    if checked.visible is None:
        seen = "no drop is proven in 80 of 100 cases with so few trials"
    else:
        seen = f"a drop of {checked.visible:.1%} is proven in 80 of 100 cases"
        if checked.visible_unrelated is not None and checked.visible_unrelated > checked.visible + 5e-4:
            seen += f" ({checked.visible_unrelated:.1%} had the two runs nothing in common)"
    return f"{seen}; one of {checked.margin:.1%} in {100 * checked.power:.0f}"


def as_text(checked: Either) -> str:
    """Return text for the terminal."""
    lines = [f"{checked.verdict.upper()}: {meaning(checked)}", ""]
    lines += [f"  {name:<18} {value}" for name, value in rows(checked)]
    if checked.changed:
        lines += ["", "Changed trials:"]
        lines += [
            f"  {c.trial:>6} {c.object}: {c.before} → {c.after}{c.detail and f' ({c.detail})'}"
            for c in checked.changed[:SHOWN]
        ]
        if len(checked.changed) > SHOWN:
            lines.append(f"  … and {len(checked.changed) - SHOWN} more")
    lines += ["", *checked.notes] if checked.notes else []
    return "\n".join(lines) + "\n"


def as_markdown(checked: Either) -> str:
    """Return Markdown for a pull request's summary page."""
    mark = {True: "❌", False: "⚠️" if checked.verdict in UNDECIDED else "✅"}[checked.failed]
    title, more = f"{mark} grasp-bench: {checked.verdict}", len(checked.changed) - SHOWN
    tables = [TextTable(title, ("", ""), rows(checked), lead=meaning(checked), level=3)]
    if checked.changed:
        tables.append(
            TextTable(
                "",
                ("Trial", "Object", "Before", "Now", "Why"),
                [[str(c.trial), c.object, c.before, c.after, c.detail] for c in checked.changed[:SHOWN]],
                note=f"… and {more} more." if more > 0 else "",
                numbers=(0,),
            )
        )
    notes = [f"> {escaped(note)}\n" for note in checked.notes]
    return markdown(tables) + ("\n" + "".join(notes) if notes else "")


def as_junit(checked: Either) -> bytes:
    """Return JUnit XML: one suite with the verdict, and a skipped test where nothing is decided."""
    suite = Xml.Element(
        "testsuite",
        name="grasp-bench check",
        tests="1",
        failures=str(int(checked.failed)),
        errors="0",
        skipped=str(int(checked.verdict in UNDECIDED)),
    )
    properties = Xml.SubElement(suite, "properties")
    for name, value in rows(checked):
        Xml.SubElement(properties, "property", name=_xml(name), value=_xml(value))
    case = Xml.SubElement(
        suite,
        "testcase",
        classname="grasp-bench.check",
        name=_xml(f"{checked.new} against {checked.baseline}"),
    )
    if checked.failed:
        Xml.SubElement(
            case, "failure", message=_xml(meaning(checked)), type=str(checked.verdict)
        ).text = _xml(as_text(checked))
    elif checked.verdict in UNDECIDED:
        Xml.SubElement(case, "skipped", message=_xml(meaning(checked)))
    Xml.SubElement(suite, "system-out").text = _xml(as_text(checked))
    root = Xml.Element("testsuites")
    root.append(suite)
    Xml.indent(root)
    return Xml.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def _xml(text: str) -> str:
    """Return text without the characters that XML cannot hold."""
    return re.sub(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "�", text)
