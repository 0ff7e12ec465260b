"""Pictures of paths and ways: recorded points and their smooth curve, approach and holds, why there is no motion."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from nospill.approach.search import find_approach
from nospill.paths.waypoint_paths import path_through_waypoints
from nospill.plans.plan import Plan
from nospill.plots.style import BLACK, BLUE, DARK_RED, GREEN, GREY, ORANGE, RED, series_look
from nospill_docs.pictures.paper import note, sheet, sketch, words


def smoothing() -> Figure:
    """Recorded points, the curve through all of them, the smooth one within a tolerance, and their curvature."""
    figure = sheet(2.7)
    place, bend = figure.subplots(1, 2)
    figure.subplots_adjust(left=0.08, right=0.985, top=0.88, bottom=0.17, wspace=0.24)
    # Scatter of a hand that leads an arm along an arc, made without chance.
    count = 60
    angle = np.linspace(0.15, 0.85, count) * np.pi
    scatter = 0.0025 * np.sin(37.0 * np.arange(count) ** 1.5) + 0.0015 * np.cos(11.0 * np.arange(count) ** 1.3)
    points = np.column_stack([(0.5 + scatter) * np.cos(angle), (0.5 + scatter) * np.sin(angle), np.zeros(count)])
    s = np.linspace(0.0, 1.0, 1500)
    smooth = path_through_waypoints(points, smoothing=0.004)
    through = path_through_waypoints(points[::4], smoothing=0.0)
    place.plot(1e3 * points[:, 0], 1e3 * points[:, 1], "o", color=BLACK, markersize=3, label="recorded points")
    for path, colour, dashes, name in (
        (through, ORANGE, (0, (5, 1.6)), "through every fourth"),
        (smooth, BLUE, "-", "smoothing = 4 mm"),
    ):
        at = path.at(s)[:, :3]
        place.plot(1e3 * at[:, 0], 1e3 * at[:, 1], color=colour, linestyle=dashes, label=name)
        first, second = np.gradient(at, s, axis=0), np.gradient(np.gradient(at, s, axis=0), s, axis=0)
        curvature = np.linalg.norm(np.cross(first, second), axis=1) / np.linalg.norm(first, axis=1) ** 3
        bend.plot(s[5:-5], curvature[5:-5], color=colour, linestyle=dashes)
    place.set_xlim(-260.0, 130.0)
    place.set_ylim(420.0, 540.0)
    place.set_title("Part of a recorded path")
    place.set_xlabel("x [mm]")
    place.set_ylabel("y [mm]")
    place.legend(loc="lower center")
    bend.set_title("Its curvature: what the tray has to follow")
    bend.set_xlabel("path parameter s [1]")
    bend.set_ylabel("curvature [1/m]")
    bend.set_xlim(0.0, 1.0)
    bend.set_ylim(bottom=0.0)
    return figure


def approach(plan: Plan) -> Figure:
    """Joint angles over the approach, the holds and the motion of one plan."""
    figure = sheet(2.9)
    axes = figure.add_axes((0.085, 0.16, 0.9, 0.66))
    scene = plan.scene
    stated = {"approach": {"from": "home", "tray": "empty"}, "motion.hold_before": 0.5, "motion.hold_after": 0.5}
    rules = scene.changed(stated).approach
    assert rules is not None
    way = find_approach(scene, rules, plan.trajectory.joint_position[0]).segment.samples
    wait, hold = 0.6, 0.5
    start = float(way.t[-1]) + wait
    motion = plan.trajectory
    for joint in range(motion.joint_position.shape[1]):
        angles = np.degrees(np.concatenate([way.position[:, joint], motion.joint_position[:, joint]]))
        t = np.concatenate([way.t, start + hold + motion.t])
        end = t[-1] + hold
        axes.plot(np.append(t, end), np.append(angles, angles[-1]), **series_look(joint), label=f"joint {joint + 1}")
    axes.set_xlim(0.0, end)
    axes.set_ylim(-190.0, 150.0)
    marks = (
        (0.0, float(way.t[-1]), "approach\n(approach.csv)", "#E4EDF4"),
        (float(way.t[-1]), start, "load\nthe tray", "#FFFFFF"),
        (start, start + hold, "hold_\nbefore", "#EEEEEE"),
        (start + hold, start + hold + plan.duration, "the motion: its time\nis the plan's duration", "#F6EEDD"),
        (start + hold + plan.duration, end, "hold_\nafter", "#EEEEEE"),
    )
    for begin, stop, text, colour in marks:
        axes.axvspan(begin, stop, color=colour, zorder=0, linewidth=0)
        axes.text(0.5 * (begin + stop), 143.0, text, ha="center", va="top", size=8.5)
    axes.set_xlabel("time [s]; loading takes as long as it takes")
    axes.set_ylabel("joint position [deg]")
    axes.legend(loc="lower center", ncols=6, bbox_to_anchor=(0.5, 1.0), columnspacing=1.0, handlelength=2.2)
    return figure


def reasons(plan: Plan) -> Figure:
    """Two kinds of failure: an end out of reach, and less time than any motion needs."""
    figure = sheet(2.9)
    axes = sketch(figure, (0.0, 0.02, 0.56, 0.9), (-0.75, 2.45), (-0.95, 1.25))
    figure.text(0.27, 0.94, "out of reach, from above", ha="center", weight="bold", size=9)
    robot = plan.scene.robot
    reach = (robot.reach or 1.0) * math.cos(math.asin(0.35))
    axes.add_patch(Circle((0.0, 0.0), reach, facecolor="#EAF1F6", edgecolor=GREY, linewidth=1.1))
    axes.plot(0.0, 0.0, "s", color="#6F767D", markersize=9)
    start, end = np.array([0.75, -0.45]), np.array([1.6, 0.45])
    s = np.linspace(0.0, 1.0, 200)[:, None]
    line = (1 - s) * start + s * end
    inside = np.hypot(*line.T) <= reach
    axes.plot(*line[inside].T, color=BLUE, linewidth=2.2)
    axes.plot(*line[~inside].T, color=RED, linewidth=2.2, linestyle=(0, (3, 1.2)))
    axes.plot(*start, "o", color=GREEN, markersize=7)
    axes.plot(*end, "X", color=RED, markersize=9)
    words(axes, (0.05, -0.12), "base", size=8.5)
    words(axes, (-0.55, 0.75), "what the flange\nreaches", size=8.5)
    note(
        axes,
        tuple(line[inside][-1]),
        (1.4, -0.5),
        "the message names\nthis place, and how far\nthe arm is short",
        size=8.5,
    )
    bars = figure.add_axes((0.62, 0.2, 0.36, 0.62))
    figure.text(0.8, 0.94, "less time than any motion needs", ha="center", weight="bold", size=9)
    for row, (name, value, colour) in enumerate((("asked for", 0.5, RED), ("fastest found", plan.duration, BLUE))):
        bars.barh(row, value, color=colour, height=0.5, hatch="////" if row == 0 else None, edgecolor="white")
        bars.text(value + 0.02, row, f"{value:.2f} s", va="center", size=9)
        bars.text(0.02, row - 0.38, name, va="center", size=8.5)
    worst = plan.certificate.worst
    bars.text(0.02, 1.45, f"held back by {worst.constraint} of {worst.subject}", size=8.5, va="center", color=DARK_RED)
    bars.set_yticks([])
    bars.set_ylim(1.75, -0.7)
    bars.set_xlim(0.0, 1.25 * plan.duration)
    bars.set_xlabel("duration [s]")
    bars.grid(axis="y", visible=False)
    return figure
