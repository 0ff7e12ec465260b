"""Figure: joint positions, and joint speeds as fractions of their limits."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nospill.constraints.joint_position import JointPosition
from nospill.constraints.joint_speed import JointSpeed
from nospill.plots.evidence import Evidence
from nospill.plots.style import BLACK, RED, SMALL, draw_limit, line_key, plain, series_look, time_panels, write_limit

NEAR = 0.15
"""A position limit is drawn when the joint comes nearer to it than this part of its range."""


def joints_figure(evidence: Evidence) -> Figure:
    """Positions above, speeds below, a line per joint."""
    joints = evidence.plan.scene.robot.joints
    panels = time_panels(
        evidence,
        "Joints",
        count=2,
        columns=1,
        height=2.1,
        legend=[line_key(plain(name), index) for index, name in enumerate(joints)],
        share_height=False,
    )
    _draw_positions(panels.axes[0], evidence)
    draw_speeds(panels.axes[1], evidence)
    return panels.figure


def _draw_positions(axes: Axes, evidence: Evidence) -> None:
    robot = evidence.plan.scene.robot
    near = []
    for index, trace in enumerate(evidence.traces(JointPosition.name)):
        axes.plot(trace.t, np.degrees(trace.value), **series_look(index))
        lower, upper = float(robot.lower[index]), float(robot.upper[index])
        room = NEAR * (upper - lower)
        near += [
            (
                float(np.degrees(limit)),
                above,
                f"limit of {plain(trace.subject)}: " + f"{np.degrees(limit):.0f}°".replace("-", "−"),
            )
            for limit, above, distance in (
                (lower, False, np.min(trace.value) - lower),
                (upper, True, upper - np.max(trace.value)),
            )
            if distance < room
        ]
    for limit, above, text in near:
        axes.axhline(limit, color=RED, linewidth=1.2, zorder=2.5)
        write_limit(axes, (0.0, limit), text, above=above, transform=axes.get_yaxis_transform())
    axes.set_title("position" if near else "position (all limits are far)")
    axes.set_ylabel("angle [deg]")
    axes.set_xlim(0.0, evidence.end_time)
    axes.margins(y=0.12)


def draw_speeds(axes: Axes, evidence: Evidence) -> None:
    """Signed joint speeds over their limits, with the limits at -1 and 1."""
    traces = evidence.traces(JointSpeed.name)
    speeds = [trace.value / np.abs(trace.limit) for trace in traces]
    for index, (trace, speed) in enumerate(zip(traces, speeds, strict=True)):
        axes.plot(trace.t, speed, **series_look(index))
    peaks = [float(np.max(np.abs(speed))) for speed in speeds]
    largest = int(np.argmax(peaks))
    reach = max(1.28, 1.05 * peaks[largest])
    draw_limit(axes, 1.0, "limit 1", forbidden=reach)
    draw_limit(axes, -1.0, "limit −1", forbidden=-reach)
    axes.axhline(0.0, color=BLACK, linewidth=0.6, zorder=1)
    axes.set_ylim(-reach, reach)
    axes.set_xlim(0.0, evidence.end_time)
    axes.set_ylabel("speed / limit [1]")
    axes.set_title("joint speed")
    axes.set_title(f"max {peaks[largest]:.4f} ({plain(traces[largest].subject, 14)})", loc="right", size=SMALL)
