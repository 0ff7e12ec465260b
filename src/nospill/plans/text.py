"""What a plan says of itself in words: its certificate, its warnings, what holds it back, what was chosen."""

from __future__ import annotations

from nospill.certification.table import certificate_text
from nospill.plans.plan import Plan
from nospill.plans.settling import AFTER_APPROACH, settling_time
from nospill.plans.warnings.record import warning_lines


def plan_text(plan: Plan) -> str:
    """All of it, as `nospill plan` prints it."""
    warnings = [f"warning: {line}" for line in warning_lines(plan.warnings)]
    return "\n".join([certificate_text(plan.certificate, plan.scene), "", *warnings, *plan_lines(plan)])


def plan_lines(plan: Plan) -> list[str]:
    """Duration, what holds the motion back, what it survives, what it was compared with and what was chosen."""
    return [
        f"duration: {plan.duration:.3f} s",
        *([f"direct way blocked: {plan.report.blocked_way}"] if plan.report.blocked_way else []),
        *([f"held back: {plan.limiting_text}"] if plan.limiting_text else []),
        *([plan.savings_text] if plan.savings_text else []),
        *([plan.left_text] if plan.left_text else []),
        *([plan.survival_text] if plan.survival_text else []),
        *plan.comparison,
        *_choices(plan),
    ]


def _choices(found: Plan) -> list[str]:
    """What was chosen for the arm, and how it gets to the start, a line each."""
    lines = [f"branch: {found.report.branch}"]
    if found.report.base_yaw is not None:
        lines.append(f"base yaw: {found.report.base_yaw} (left free)")
    if found.report.end_yaws is not None:
        lines.append(f"yaw of the tray: {found.report.end_yaws} (left free)")
    rules = found.scene.motion
    if rules.hold_before or rules.hold_after:
        lines.append(f"holds: {rules.hold_before:g} s before and {rules.hold_after:g} s after, in exported files")
    segment = found.approach
    if segment is not None:
        tray = "loaded" if segment.loaded else "empty"
        slowed = "" if segment.stretch == 1.0 else f", {segment.stretch:g} times as slowly as its limits allow"
        unchecked = "" if found.scene.obstacles else "; collisions with what is around are not checked"
        lines.append(f"approach: {segment.duration:.3f} s with the tray {tray}{slowed}{unchecked}")
        wait = settling_time(found.scene, found.certificate, AFTER_APPROACH)
        if wait > 0.0:
            lines.append(f"approach: the liquids swing on; wait {wait:.1f} s before the motion, which starts from rest")
    settling = settling_time(found.scene, found.certificate)
    if settling > 0.0:
        lines.append(f"next motion: after {settling:.1f} s, when the liquids are at rest (2 % of their limits)")
    return lines
