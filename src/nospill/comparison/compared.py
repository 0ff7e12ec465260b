"""A plan with the durations of what it is compared with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from nospill.comparison.trapezoid import trapezoid_motion
from nospill.errors import NospillError
from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.scenario import scene_from_table

LEVEL, TRAPEZOID = "level tray", "trapezoid"
"""What a plan is compared with, as reports and the summary name it."""


def compared(planned: Plan, *, say: Callable[[str], None] = lambda _: None) -> Plan:
    """The plan with `report.compared`: s, of the fastest certified motion of each kind, by name.

    What has no certified motion is left out; so is the level tray where the plan's own is level.

    Args:
        planned: the plan.
        say: called with what is computed next.
    """
    durations: dict[str, float] = {}
    if planned.scene.motion.tilt_free:
        say(LEVEL)
        level = _level(planned)
        if level is not None:
            durations[LEVEL] = level
    say(TRAPEZOID)
    trapezoid = trapezoid_motion(planned.scene, planned.duration)
    if trapezoid is not None:
        durations[TRAPEZOID] = trapezoid.end_time
    return replace(planned, report=replace(planned.report, compared=durations))


def _level(planned: Plan) -> float | None:
    """Duration of the fastest certified motion of the same task on a level tray, s."""
    source = dict(planned.scene.source)
    given = source.get("motion")
    motion = {key: value for key, value in given.items() if key != "duration"} if isinstance(given, dict) else {}
    table = {**source, "motion": {**motion, "tilt": "fixed"}}
    try:
        level = plan(scene_from_table(table, name=planned.scene.name).limited_as(planned.scene))
    except NospillError:
        return None
    return level.duration if level.certificate.ok else None
