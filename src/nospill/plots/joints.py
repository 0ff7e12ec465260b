"""Figure: joint positions; speed and, where they are limited, acceleration, jerk and torque over their limits."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nospill.certification.wording import percent
from nospill.core.short_names import short_names
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.joint_position import JointPosition
from nospill.laws.constraints.joint_speed import JointSpeed
from nospill.plots.evidence import Evidence
from nospill.plots.style import (
    BLACK,
    RED,
    draw_limit,
    entitle,
    line_key,
    plain,
    series_look,
    time_panels,
    write_limit,
)

NEAR = 0.15
"""A position limit is drawn when the joint comes nearer to it than this part of its range."""

_LABEL_WIDTH, _LABEL_HEIGHT = 0.36, 0.1
"""Space a limit's name takes in a panel, in fractions of its sides."""


def joints_figure(evidence: Evidence) -> Figure:
    """Positions above, a panel for every further limit of the joints below, a line per joint."""
    joints = evidence.plan.scene.robot.joints
    # By name and not by place: jerks are differences of samples, so they stand elsewhere than the other limits.
    names = [item.name for item in CONSTRAINTS if item.name.startswith("joint ") and evidence.traces(item.name)]
    limited = [name for name in names if name != JointPosition.name]
    panels = time_panels(
        evidence,
        "Joints",
        count=1 + len(limited),
        columns=1,
        height=2.0 if len(limited) < 2 else 1.5,
        legend=[line_key(plain(name), index) for index, name in enumerate(short_names(joints))],
        share_height=False,
    )
    _draw_positions(panels.axes[0], evidence)
    for axes, name in zip(panels.axes[1:], limited, strict=True):
        draw_joint_use(axes, evidence, name)
    return panels.figure


def _draw_positions(axes: Axes, evidence: Evidence) -> None:
    robot = evidence.plan.scene.robot
    traces = evidence.traces(JointPosition.name)
    names = short_names(robot.joints)
    near: list[tuple[float, bool, str]] = []
    for index, trace in enumerate(traces):
        axes.plot(trace.t, np.degrees(trace.value), **series_look(index))
        lower, upper = float(robot.lower[index]), float(robot.upper[index])
        distance_shown = NEAR * (upper - lower)
        near += [
            (float(np.degrees(limit)), above, _limit_name(names[index], limit))
            for limit, above, distance in (
                (lower, False, np.min(trace.value) - lower),
                (upper, True, upper - np.max(trace.value)),
            )
            if distance < distance_shown
        ]
    for limit, _, _ in near:
        axes.axhline(limit, color=RED, linewidth=1.2, zorder=2.5)
    axes.margins(y=0.14)
    axes.set_xlim(0.0, evidence.end_time)
    low, high = axes.get_ylim()
    taken: list[tuple[float, float]] = []
    t = np.concatenate([trace.t for trace in traces]) / evidence.end_time
    y = (np.degrees(np.concatenate([trace.value for trace in traces])) - low) / (high - low)
    for limit, outward, text in near:
        at = (limit - low) / (high - low)
        left, bottom = _quietest(t, y, at, outward, taken)
        taken.append((left, bottom))
        write_limit(axes, (left, limit), text, above=bottom >= at, transform=axes.get_yaxis_transform())
    axes.set_title("position" if near else "position (all limits are far)")
    axes.set_ylabel("angle [deg]")


def _limit_name(joint: str, limit: float) -> str:
    return f"limit of {plain(joint, 14)}: " + f"{np.degrees(limit):.0f}°".replace("-", "−")


def _quietest(
    t: np.ndarray, y: np.ndarray, at: float, outward: bool, taken: list[tuple[float, float]]
) -> tuple[float, float]:
    """Lower left corner for the name of a limit where it covers fewest points of the curves and no other name.

    All in fractions of the panel: curves through (t, y), a limit at height `at`, the corners taken by other names. The
    forbidden side is preferred, which `outward` says is above.
    """
    sides = (at, at - _LABEL_HEIGHT) if outward else (at - _LABEL_HEIGHT, at)

    def covered(corner: tuple[float, float]) -> tuple[bool, int]:
        left, bottom = corner
        inside = (t >= left) & (t <= left + _LABEL_WIDTH) & (y >= bottom) & (y <= bottom + _LABEL_HEIGHT)
        meets = any(abs(left - x) < _LABEL_WIDTH and abs(bottom - z) < _LABEL_HEIGHT for x, z in taken)
        return meets, int(np.sum(inside))

    return min(((left, bottom) for bottom in sides for left in (0.0, 0.16, 0.32, 0.48, 0.6)), key=covered)


def draw_speeds(axes: Axes, evidence: Evidence) -> None:
    """Signed joint speeds over their limits, with the limits at -1 and 1."""
    draw_joint_use(axes, evidence, JointSpeed.name)


def draw_joint_use(axes: Axes, evidence: Evidence, constraint: str) -> None:
    """A signed quantity of every joint over its limit, with the limits at -1 and 1.

    Args:
        axes: of the panel.
        evidence: the plan.
        constraint: name of one with ranges symmetric about zero, such as "joint torque".
    """
    traces = evidence.traces(constraint)
    values = [trace.value / np.abs(trace.limit) for trace in traces]
    for index, (trace, value) in enumerate(zip(traces, values, strict=True)):
        axes.plot(trace.t, value, **series_look(index))
    names = short_names([trace.subject for trace in traces])
    peaks = [float(np.max(np.abs(value))) for value in values]
    largest = int(np.argmax(peaks))
    reach = max(1.28, 1.05 * peaks[largest])
    draw_limit(axes, 1.0, "limit 1", forbidden=reach)
    draw_limit(axes, -1.0, "limit −1", forbidden=-reach)
    axes.axhline(0.0, color=BLACK, linewidth=0.6, zorder=1)
    axes.set_ylim(-reach, reach)
    axes.set_xlim(0.0, evidence.end_time)
    axes.set_ylabel(f"{constraint.removeprefix('joint ')} / limit [1]")
    entitle(axes, constraint, f"max {percent(peaks[largest], peaks[largest] <= 1.0)} ({plain(names[largest], 14)})")
