"""What a notebook shows of a run: one trial with its picture, and the failures in small."""

from __future__ import annotations

import base64
import html
from dataclasses import dataclass
from pathlib import Path

from grasp_bench.errors import GraspBenchError, ResultsError
from grasp_bench.media.store import find
from grasp_bench.runs.record import Attempted, TrialRecord
from grasp_bench.runs.results import RunResults

MOST = 12
"""Failures that the display of a run shows."""
WIDE, SMALL = 448, 112
"""Width of the picture of a trial, and of a failure in small [px]."""


@dataclass(frozen=True)
class TrialView:
    """One trial, or one attempt of an episode of clutter, to be looked at: a picture in notebooks, else text.

    Attributes:
        run: the run's folder.
        record: what was recorded of the trial.
        attempt: which attempt of an episode; None for the whole trial.
        picture, clip: files with the four pictures, and with the film; None where none was kept.
    """

    run: Path
    record: TrialRecord
    attempt: int | None
    picture: Path | None
    clip: Path | None

    @classmethod
    def of(cls, run: RunResults, trial: int, attempt: int | None = None) -> TrialView:
        """Return the view of a trial by its number; without ``attempt``, the last of an episode is pictured.

        Raises:
            ResultsError: for a trial or an attempt that the run does not hold.
        """
        record = next((r for r in run.records if r.trial == trial), None)
        if record is None:
            held = f"trials {run.records[0].trial} to {run.records[-1].trial}" if len(run) else "no trial yet"
            raise ResultsError(f"{run.folder} holds no trial {trial}; it has {held}.")
        tries = [number for number, _ in record.tries]
        if attempt is not None and attempt not in tries:
            many = f"attempts 0 to {len(tries) - 1}" if record.clutter else "no attempts: it is no clutter"
            raise ResultsError(f"Trial {trial} of {run.folder} has no attempt {attempt}; it has {many}.")
        shown = tries[-1] if attempt is None and record.clutter and tries else attempt
        media = find(run.folder, trial, shown)
        return cls(run.folder, record, shown, media.sheet, media.clip)

    @property
    def _told(self) -> Attempted:
        return dict(self.record.tries).get(self.attempt, self.record)

    @property
    def _numbers(self) -> list[tuple[str, str]]:
        """What was measured, in words and with units."""
        told = self._told
        rows = [("object", told.object), ("outcome", told.outcome), ("why", told.detail)]
        if told.grasp is not None:
            rows.append(("predicted quality", f"{told.grasp.quality:.3g}"))
            rows.append(("rank of the grasp", str(told.rank)))
        if told.pose is not None:
            rows.append(("jaws opened", f"{1000 * told.pose.opening:.1f} mm"))
        if told.widening_mm is not None:
            rows.append(("wider than predicted", f"{told.widening_mm:g} mm"))
        if told.margin is not None and told.success:
            rows.append(
                ("grip broke at", f"{told.margin.factor:.3g} times the weight ({told.margin.direction})")
            )
        return [(name, value) for name, value in rows if value]

    @property
    def _without(self) -> str:
        """How to get what is not there."""
        number = f" --attempt {self.attempt}" if self.attempt is not None else ""
        return (
            'No picture of it was kept: run with media="failures" or "all", or look at it again with '
            f"`grasp-bench replay {self.run} --trial {self.record.trial}{number} --video trial.gif`."
        )

    @property
    def _title(self) -> str:
        attempt = "" if self.attempt is None else f", attempt {self.attempt}"
        return f"Trial {self.record.trial}{attempt} of {self.run}"

    def __repr__(self) -> str:
        lines = [self._title, *(f"  {name}: {value}" for name, value in self._numbers)]
        lines += [
            f"  {what}: {file}" for what, file in (("picture", self.picture), ("clip", self.clip)) if file
        ]
        return "\n".join(lines if self.picture else [*lines, f"  {self._without}"])

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        pictures = "".join(
            f'<img src="{data}" alt="{html.escape(alt)}" style="max-width:100%;width:{WIDE}px;margin:4px"> '
            for file, alt in (
                (self.picture, f"{self._title}: four pictures"),
                (self.clip, "the same as a film"),
            )
            if file is not None and (data := embedded(file))
        )
        rows = "".join(
            f'<tr><td style="text-align:left">{html.escape(n)}</td>'
            f'<td style="text-align:left">{html.escape(v)}</td></tr>'
            for n, v in self._numbers
        )
        return (
            f"<p><b>{html.escape(self._title)}</b></p>{pictures or f'<p>{html.escape(self._without)}</p>'}"
            f"<table>{rows}</table>"
        )


def failures(run: RunResults) -> str:
    """Return HTML of the first :data:`MOST` failures in small: their pictures, or those of the objects."""
    failed = [r for r in run.records if not r.success]
    if not failed:
        return ""
    shown = [TrialView.of(run, r.trial) for r in failed[:MOST]]
    objects = _portraits(run, [v.record.object for v in shown if v.picture is None])
    figures = "".join(
        f'<figure style="margin:4px;width:{SMALL}px;font-size:85%;line-height:1.2;overflow-wrap:anywhere">'
        f"{_image(embedded(view.picture) if view.picture else objects.get(view.record.object, ''))}"
        f"<figcaption>{view.record.trial}: {html.escape(view.record.object)}, "
        f"{html.escape(view.record.outcome)}</figcaption></figure>"
        for view in shown
    )
    more = f", the first {MOST} of {len(failed)}" if len(failed) > MOST else ""
    return (
        f"<p>Failures{more}; <code>run.show({failed[0].trial})</code> shows a trial:</p>"
        f'<div style="display:flex;flex-wrap:wrap">{figures}</div>'
    )


def embedded(file: Path) -> str:
    """Return a picture of a run as an address that holds it, empty where it cannot be read."""
    try:
        return f"data:image/webp;base64,{base64.b64encode(file.read_bytes()).decode()}"
    except OSError:
        return ""


def _image(data: str) -> str:
    return (
        f'<img src="{data}" alt="" style="width:{SMALL}px;height:{SMALL}px;object-fit:cover">' if data else ""
    )


def _portraits(run: RunResults, names: list[str]) -> dict[str, str]:
    """Return pictures of the run's objects by name; of other objects than the shipped ones there are none."""
    if not names:
        return {}
    from grasp_bench.media.portraits import thumbnail
    from grasp_bench.objects.catalog import Catalog

    catalog, found = Catalog(), {}
    for name in dict.fromkeys(names):
        entry = catalog.entries.get(name)
        if entry is None or entry["files"] != run.info.objects.get(name):
            continue
        try:
            data = thumbnail(catalog.load(name))
        except (GraspBenchError, OSError, ValueError):
            continue
        found[name] = f"data:image/webp;base64,{base64.b64encode(data).decode()}"
    return found
