"""What a scenario that begins in motion may not state as well."""

from __future__ import annotations

from nospill.errors import ScenarioError
from nospill.scenario.fields import FREE
from nospill.scenario.model import Scenario


def require_may_begin_in_motion(scenario: Scenario) -> None:
    """Refuse what does not go together with a motion that begins in motion, and a stop without one.

    Raises:
        ScenarioError: names the other key and why.
    """
    if scenario.initial_state is None:
        if scenario.motion.stop:
            raise ScenarioError(
                "motion.stop is stated without it; give the state to stop from, as plan.state_at(t) does"
            )
        return
    rules, path = scenario.motion, scenario.path
    if rules.stop and (path.width is not None or path.yaw_free):
        raise ScenarioError(
            "motion.stop is stated, and the tray may leave its path or turn on it (a corridor, a free path, a free "
            "yaw): stops of such a plan go along its own way; nospill stops DIR, or ns.stops(plan), finds them"
        )
    late = scenario.controller is not None and scenario.controller.is_late
    band = scenario.tolerance is not None and scenario.tolerance.has_band
    reasons = {
        "[approach]": (scenario.approach is not None, "comes before the motion, and ends at rest"),
        "motion.hold_before": (rules.hold_before > 0.0, "is rest before the motion"),
        "motion.stoppable": (rules.stoppable is not None, "is about motions from rest"),
        "motion.speed_range": (rules.speed_range is not None, "is of motions whose beginning is slower as well"),
        "[controller] with delay or lag": (late, "asks for the joints ahead of time, before the motion begins"),
        "tolerance.tracking": (band, "is about joints that were late before the motion too, which nothing knows"),
        "robot.base_yaw": (scenario.robot.base_yaw == FREE, "is to be chosen, and the joints are in motion"),
    }
    for key, (stated, why) in reasons.items():
        if stated:
            raise ScenarioError(f"{key} is stated too: it {why}; leave one of them out")
