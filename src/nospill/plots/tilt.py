"""Figure: how the tray tilts, and how much less the objects feel sideways because of it."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nospill.plots.evidence import Evidence
from nospill.plots.style import BLUE, ORANGE, SMALL, draw_limit, time_panels

_DASHED = (0, (5, 1.6))


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
    trajectory = evidence.plan.trajectory
    limit = float(np.degrees(evidence.plan.scene.motion.max_tilt))
    angles = np.degrees(trajectory.tilt)
    axes.plot(trajectory.t, angles[:, 0], color=BLUE, label=r"$\theta_x$ (roll)")
    axes.plot(trajectory.t, angles[:, 1], color=ORANGE, linestyle=_DASHED, label=r"$\theta_y$ (pitch)")
    # The angle of both together has no limit: as a third line it would cross the limits of the others.
    together = float(np.degrees(evidence.maxima.tilt))
    axes.set_title(f"together up to {together:.1f}°", loc="right", size=SMALL)
    reach = max(1.28 * limit, 1.08 * float(np.max(np.abs(angles))))
    draw_limit(axes, limit, f"limit of each angle {limit:.3g}°", forbidden=reach)
    draw_limit(axes, -limit, f"limit of each angle −{limit:.3g}°", forbidden=-reach)
    axes.set_ylim(-reach, reach)
    axes.set_ylabel("angle [deg]")


def _draw_lateral(axes: Axes, evidence: Evidence) -> None:
    """What an object fixed to the tray feels; what friction has to hold of it stands in the figure of the contact.

    A liquid is pushed only as far as it follows its cup, so the friction times the normal force is no limit of these.
    """
    played = evidence.judgement.replay
    tilted = np.hypot(played.body[6], played.body[7])
    level = np.hypot(played.tray.acceleration[:, 0], played.tray.acceleration[:, 1])
    axes.plot(played.t, tilted, color=BLUE, label="as planned")
    axes.plot(played.t, level, color=ORANGE, linestyle=_DASHED, label="on a level tray")
    axes.set_ylim(0.0, 1.1 * max(float(np.max(level)), float(np.max(tilted)), 1e-3))
    axes.set_ylabel("lateral specific force [m/s²]")
