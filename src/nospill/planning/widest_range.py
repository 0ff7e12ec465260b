"""How far down a range of speeds a motion holds, where planning ends before it holds at all of them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from nospill.certification.certificate import Judgement, judge_motion
from nospill.errors import ModelError
from nospill.planning.task import Task

if TYPE_CHECKING:
    from nospill.motion.trajectory import Trajectory

_TRIES = 3
"""Steps up the grid of speeds, where a judgement looks between its speeds and finds a limit broken there."""


def holds_from(judgement: Judgement, task: Task) -> float | None:
    """Least of the speeds looked at from which on every row holds there, a part of the planned one.

    None where no range was asked for, and where a row is broken at its greatest speed or is about no object.
    """
    rules = task.scene.motion
    if rules.speed_range is None:
        return None
    broken = [row for row in judgement.variant_rows if not row.ok]
    if any(not row.of_object for row in broken):
        return None
    speeds = task.speeds
    grid = sorted({1.0, *(speeds.get((row.subject, row.variant), 1.0) for row in judgement.variant_rows)})
    worst = max((speeds.get((row.subject, row.variant), 1.0) for row in broken), default=0.0)
    return next((speed for speed in grid if speed > worst and speed <= rules.speed_range[1]), None)


def broken_speeds(judgement: Judgement, task: Task) -> frozenset[float]:
    """Speeds looked at, parts of the planned one, at which a row of an object is broken."""
    broken = (row for row in judgement.variant_rows if row.of_object and not row.ok)
    return frozenset(task.speeds.get((row.subject, row.variant), 1.0) for row in broken)


def holds_further(judgement: Judgement, other: Judgement, task: Task) -> bool:
    """Whether a motion holds further down the range than another, or does at all."""
    ours, theirs = holds_from(judgement, task), holds_from(other, task)
    return ours is not None and (theirs is None or ours < theirs)


def range_reached(trajectory: Trajectory, judgement: Judgement, task: Task) -> str:
    """The sentence about a motion that does not hold at all speeds that were asked for; empty where none is certified.

    The part of the range that is named has a certificate of its own.
    """
    scene, least = task.scene, holds_from(judgement, task)
    if judgement.certificate.ok or least is None or scene.motion.speed_range is None:
        return ""
    asked, greatest = scene.motion.speed_range
    for speed in [item for item in sorted(scene.motion.speeds) if least <= item < greatest][:_TRIES]:
        rounded = round(speed + 5e-4, 3)
        if not rounded < greatest:
            break
        narrower = replace(scene, motion=replace(scene.motion, speed_range=(rounded, greatest)))
        try:
            held = judge_motion(trajectory, narrower).certificate.ok
        except ModelError:
            return ""
        if held:
            return (
                f"no motion was found that keeps the limits at all speeds from {100 * asked:g} % on: this one is "
                f"certified from {100 * rounded:.4g} % of its speed on; state motion.speed_range = [{rounded:g}, "
                f"{greatest:g}], or allow more by planning.max_plan_time"
            )
    return ""
