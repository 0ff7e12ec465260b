"""Figure: the whole plan on one sheet, A4 across."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nospill.judge.wording import describe
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plots.contact_use import draw_use
from nospill.plots.evidence import Evidence
from nospill.plots.joints import draw_speeds
from nospill.plots.path_view import draw_path
from nospill.plots.style import (
    BLUE,
    DARK_RED,
    GREEN,
    GREY,
    ORANGE,
    legend_columns,
    line_key,
    plain,
    without_shared_ending,
)
from nospill.plots.use_table import draw_use_table
from nospill.scene.tolerances import is_uncertain

SHEET = (11.69, 8.27)
"""in."""

_SMALLEST_DERIVATIVE = 1e-9


def summary_figure(evidence: Evidence) -> Figure:
    """Verdict, largest figures, path, certificate, path parameter, the objects' tightest limit and joint speeds."""
    figure = Figure(figsize=SHEET)
    _draw_heading(figure, evidence)
    draw_path(figure, evidence, (0.015, 0.375, 0.455, 0.455))
    draw_use_table(figure.add_axes((0.485, 0.375, 0.49, 0.455)), evidence)
    bottom, height, width = 0.06, 0.215, 0.265
    panels = [figure.add_axes((left, bottom, width, height)) for left in (0.055, 0.38, 0.705)]
    _draw_progress(panels[0], evidence)
    _draw_tightest(panels[1], evidence)
    draw_speeds(panels[2], evidence)
    joints = without_shared_ending(evidence.plan.scene.robot.joints)
    _legend(panels[2], {name: index for index, name in enumerate(joints)})
    for axes in panels:
        axes.set_xlabel("time [s]")
        axes.set_xlim(0.0, evidence.end_time)
    return figure


def _draw_heading(figure: Figure, evidence: Evidence) -> None:
    scene, certificate = evidence.plan.scene, evidence.judgement.certificate
    figure.text(0.03, 0.972, plain(scene.name, 40), size=17, weight="bold", va="top")
    about = f"{plain(scene.robot.title, 40)}  ·  {len(scene.cargo)} on the tray: "
    names = plain(", ".join(item.name for item in scene.cargo), max(75 - len(about), 12))
    figure.text(0.03, 0.93, about + names, size=8.5, va="top")
    rows = certificate.rows
    # Which numbers are worst stands in the certificate; here there is no room for it.
    detail = describe(replace(certificate.worst, subject=plain(certificate.worst.subject, 16), variant=""))
    over = " over its tolerances" if is_uncertain(scene) else ""
    if certificate.ok:
        verdict, color = f"CERTIFIED{over}: all {len(rows)} rows hold at {certificate.grid_hz:g} Hz", "#00704F"
        detail = f"nearest to its limit: {detail}"
    else:
        failed = [row for row in rows if not row.ok]
        verdict, color = (
            f"NOT CERTIFIED{over}: {len(failed)} of {len(rows)} rows fail at {certificate.grid_hz:g} Hz",
            DARK_RED,
        )
    figure.text(0.975, 0.972, verdict, size=11, weight="bold", ha="right", va="top", color=color)
    figure.text(0.975, 0.94, detail, size=8, ha="right", va="top")
    tiles = _tiles(evidence)
    for index, (value, label) in enumerate(tiles):
        x = 0.03 + 0.945 * index / len(tiles)
        figure.text(x, 0.895, value, size=14, weight="bold", va="top", color=BLUE)
        figure.text(x, 0.862, label, size=8, va="top", color="#333333")


def _tiles(evidence: Evidence) -> list[tuple[str, str]]:
    """Largest figures of the motion: (value with unit, what it is)."""
    maxima = evidence.maxima
    tiles = [
        (f"{evidence.end_time:.3f} s", "end of the motion"),
        (f"{maxima.tray_acceleration:.2f} m/s²", "tray acceleration"),
        (f"{maxima.tray_angular_acceleration:.1f} rad/s²", "angular acceleration"),
        (f"{np.degrees(maxima.tilt):.1f}°", "tilt of the tray"),
        (f"{100 * maxima.joint_speed_use:.1f} %", "of joint speed limit"),
    ]
    for heights, when in ((maxima.slosh_height, "liquid height"), (maxima.residual_height, "after the end")):
        if heights:
            name = max(heights, key=heights.__getitem__)
            tiles.append((f"{1e3 * heights[name]:.1f} mm", f"{when} ({plain(name, 12)})"))
    return tiles


def _draw_progress(axes: Axes, evidence: Evidence) -> None:
    """The path parameter and its two derivatives, the latter over their largest values."""
    trajectory = evidence.plan.trajectory
    curves = (
        (r"$s$", trajectory.s, "", BLUE, "-"),
        (r"$\dot{s}$", trajectory.s_rate, "1/s", ORANGE, (0, (5, 1.6))),
        (r"$\ddot{s}$", trajectory.s_acceleration, "1/s²", GREEN, (0, (1.3, 1.3))),
    )
    for name, values, unit, color, dashes in curves:
        largest = max(float(np.max(np.abs(values))), _SMALLEST_DERIVATIVE)
        label = f"{name} / {largest:.3g} {unit}" if unit else name
        axes.plot(trajectory.t, values / (largest if unit else 1.0), color=color, linestyle=dashes, label=label)
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set_ylabel("value / largest [1]")
    axes.set_ylim(-1.1, 1.1)
    axes.legend(loc="lower left", bbox_to_anchor=(-0.02, 1.0), ncols=3, borderpad=0.1, columnspacing=1.2)


def _draw_tightest(axes: Axes, evidence: Evidence) -> None:
    """Use of the liquids' limit, or without liquids of the objects' constraint that comes nearest to its limit."""
    by_constraint = evidence.by_constraint(EvaluationPoint.OBJECT)
    nearest = max(by_constraint, key=lambda name: max(float(np.max(trace.use)) for trace in by_constraint[name]))
    name = SloshHeight.name if SloshHeight.name in by_constraint else nearest
    traces, names = by_constraint[name], [cargo.name for cargo in evidence.plan.scene.cargo]
    looks = {trace.subject: names.index(trace.subject) for trace in traces}
    draw_use(axes, name, traces, looks=list(looks.values()))
    _legend(axes, looks)


def _legend(axes: Axes, looks: dict[str, int]) -> None:
    """A legend of names and their looks above the panel and its title; there is room for the first twelve."""
    handles = [line_key(plain(name, 10), look) for name, look in looks.items()][:12]
    axes.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(-0.02, 1.1),
        ncols=legend_columns(handles, 3.3),
        borderpad=0.1,
        labelspacing=0.2,
        columnspacing=1.0,
        handletextpad=0.4,
        handlelength=2.3,
    )
