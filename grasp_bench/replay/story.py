"""A trial told in words: what was seen, what was wanted, and how it ended."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from grasp_bench.media.recording import Moment
from grasp_bench.media.takes import Take
from grasp_bench.replay.rebuild import Replay
from grasp_bench.trials.attempt import Trial


def story(replay: Replay) -> list[str]:
    """Tell a trial in one or two sentences a step, in order; an episode attempt after attempt."""
    record, scenario = replay.record, replay.scenario
    told = [
        f"Trial {record.trial}: {record.object} ({record.category}), scenario {scenario.name}, "
        f"seed {record.seed}, predictor {replay.run.predictor}."
    ]
    episode = record.clutter
    if episode is None:
        return [*told, *(line for take in replay.takes for line in tell(take))]
    told.append(f"On the table: {', '.join(episode.objects)}.")
    for take in replay.takes:
        attempt = episode.attempts[take.attempt or 0]
        told += [f"Attempt {take.attempt}: {attempt.object} ({attempt.category}).", *tell(take)]
        if attempt.removed:
            told.append(f"Taken away: {', '.join(attempt.removed)}.")
    emptied = f"all {episode.cleared} objects taken away" if record.success else record.detail
    return [*told, f"Table: {record.outcome}, {emptied}."]


def tell(take: Take) -> list[str]:
    """Tell what happened in one try, from its picture to its end."""
    done, record = take.done, take.done.record
    if done.image is None:
        return [f"Ended before there was an image: {record.outcome}. {record.detail}"]
    valid = done.image.valid.mean()
    near = float(np.percentile(done.image.depth[done.image.valid], 0.1)) if valid else math.nan
    size = done.image.intrinsics
    told = [
        f"Seen: {size.width}×{size.height} pixels, {valid:.1%} of them with a depth, the nearest at "
        f"{1000 * near:.0f} mm."
    ]
    if not done.grasps:
        return [*told, f"Proposed: nothing. Ended: {record.outcome}. {record.detail}"]
    best = done.grasps[0]
    many = f"{len(done.grasps)} grasps, the best" if len(done.grasps) > 1 else "one grasp,"
    told.append(
        f"Proposed: {many} at x {best.x:.1f}, y {best.y:.1f} px, {math.degrees(best.angle):.1f}°, "
        f"{best.width:.1f} px wide, quality {best.quality:.2f}."
    )
    told += _motion(done)
    told += _contact(take.moments[:-1])
    held = f"lifted {1000 * record.lift_height:.0f} mm and held with {record.contact_force:.0f} N a finger"
    return [*told, f"Ended: {record.outcome}, {record.detail or held}."]


def _motion(done: Trial) -> list[str]:
    """Tell what was planned, and how well it was reached."""
    record, plan = done.record, done.plan
    if plan is None:
        return ["Planned: none of them can be carried out."]
    x, y, z = 1000 * plan.pose.position
    told = [
        f"Planned: number {record.rank} of them (from 0), fingers at x {x:.0f}, y {y:.0f}, z {z:.0f} mm, "
        f"{1000 * plan.pose.opening:.0f} mm apart."
    ]
    if record.tcp_error is not None:
        distance, angle = record.tcp_error
        told.append(f"Reached: within {1000 * distance:.2f} mm and {math.degrees(angle):.2f}°.")
    return told


def _contact(moments: Sequence[Moment]) -> list[str]:
    """Tell when the fingers held the object, and when they no longer did."""
    held = [m.touch is not None and m.touch.held for m in moments]
    if not any(held):
        touched = [m.time for m in moments if m.touch is not None and m.touch.left + m.touch.right > 0]
        if touched:
            return [f"Held: never by both fingers; one touched it from {touched[0]:.2f} s on."]
        return ["Held: never; no finger touched it."] if moments else []
    first, last = held.index(True), len(held) - 1 - held[::-1].index(True)
    told = f"Held: by both fingers from {moments[first].time:.2f} s"
    if last == len(held) - 1:
        return [f"{told} to the end at {moments[-1].time:.2f} s."]
    lost = moments[last + 1].touch
    which = (
        "both fingers"
        if lost is None or lost.left + lost.right == 0
        else f"the {'left' if lost.left == 0 else 'right'} finger"
    )
    return [f"{told} to {moments[last].time:.2f} s, when {which} lost it."]
