"""Figure: how the tray tilts, and how much less the objects feel sideways because of it."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nospill.plots.evidence import Evidence
from nospill.plots.style import BLACK, BLUE, GREEN, ORANGE, draw_limit, time_panels

_DASHED, _DOTTED = (0, (5, 1.6)), (0, (1.3, 1.3))


def tilt_figure(evidence: Evidence) -> Figure | None:
    """Tilt angles above, lateral specific force at the tray's centre below; None where the tray stays level."""
    if not evidence.plan.scene.motion.tilt_free:
        return None
    panels = time_panels(evidence, "Tilt of the tray", count=2, columns=1, height=2.0, share_height=False)
    _draw_angles(panels.axes[0], evidence)
    _draw_lateral(panels.axes[1], evidence)
    for axes in panels.axes:
        axes.set_xlim(0.0, evidence.end_time)
        axes.legend(
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            ncols=3,
            borderaxespad=0.1,
            borderpad=0.1,
            columnspacing=1.2,
            handletextpad=0.5,
        )
    return panels.figure


def _draw_angles(axes: Axes, evidence: Evidence) -> None:
    trajectory, tray = evidence.plan.trajectory, evidence.judgement.replay.tray
    limit = float(np.degrees(evidence.plan.scene.motion.max_tilt))
    total = np.degrees(np.arccos(np.clip(tray.rotation[:, 2, 2], -1.0, 1.0)))
    angles = np.degrees(trajectory.tilt)
    whole = f"total, max {np.max(total):.1f}°"
    axes.plot(trajectory.t, angles[:, 0], color=BLUE, label=r"$\theta_x$ (roll)")
    axes.plot(trajectory.t, angles[:, 1], color=ORANGE, linestyle=_DASHED, label=r"$\theta_y$ (pitch)")
    axes.plot(evidence.judgement.replay.t, total, color=BLACK, linestyle=_DOTTED, label=whole)
    reach = max(1.28 * limit, 1.08 * float(np.max(total)))
    draw_limit(axes, limit, f"limit of each angle {limit:.3g}°", forbidden=reach)
    draw_limit(axes, -limit, f"limit of each angle −{limit:.3g}°", forbidden=-reach)
    axes.set_ylim(-reach, reach)
    axes.set_ylabel("angle [deg]")


def _draw_lateral(axes: Axes, evidence: Evidence) -> None:
    played, scene = evidence.judgement.replay, evidence.plan.scene
    tilted = np.hypot(played.body[6], played.body[7])
    level = np.hypot(played.tray.acceleration[:, 0], played.tray.acceleration[:, 1])
    axes.plot(played.t, tilted, color=BLUE, label="as planned")
    axes.plot(played.t, level, color=ORANGE, linestyle=_DASHED, label="level tray")
    friction = min(cargo.planned_friction for cargo in scene.cargo)
    # A liquid is pushed only as far as it follows its cup, so its cup may be driven beyond this for a moment.
    holds = f"friction, μ = {friction:.2f}"
    axes.plot(played.t, friction * played.body[8], color=GREEN, linestyle=_DOTTED, label=holds)
    axes.set_ylim(0.0, 1.1 * max(float(np.max(level)), float(np.max(tilted)), 1e-3))
    axes.set_ylabel("lateral specific force [m/s²]")
