"""Figure: nearest distance to every obstacle over time, and of the arm to itself."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from nospill.collisions.over_time import nearest_over_time
from nospill.plots.evidence import Evidence
from nospill.plots.style import BLUE, draw_limit, entitle, limit_key, plain, time_panels

_INSTANTS = 300
_MOST = 8
"""Panels; the ones that come nearest to their limits are drawn."""


def distances_figure(evidence: Evidence) -> Figure | None:
    """One panel per obstacle with what is nearest to it, and one for the arm with itself; None without obstacles."""
    played = evidence.judgement.replay
    t = np.linspace(played.t[0], played.t[-1], _INSTANTS)
    q = np.stack([np.interp(t, played.t, column) for column in played.joint_position.T], axis=1)
    histories = list(nearest_over_time(evidence.plan.scene, q))
    if not histories:
        return None
    least = sorted(
        range(len(histories)), key=lambda index: float(np.min(histories[index].distance)) - histories[index].limit
    )
    histories = [histories[index] for index in sorted(least[:_MOST])]
    panels = time_panels(
        evidence,
        "Nearest distance",
        count=len(histories),
        columns=1,
        height=1.2,
        share_height=False,
        legend=[limit_key("distance to keep")],
    )
    for axes, item in zip(panels.axes, histories, strict=True):
        distance, limit = 1e3 * item.distance, 1e3 * item.limit
        top = max(1.15 * float(np.max(distance)), 1.5 * limit, 1.0)
        low = min(-0.02 * top, 1.1 * float(np.min(distance)))
        axes.plot(t, distance, color=BLUE)
        draw_limit(axes, limit, f"{limit:.3g} mm" if limit else "", forbidden=low)
        entitle(
            axes,
            plain(f"to {item.obstacle}", 20) if item.obstacle else "arm with itself and its load",
            f"{plain(item.nearest, 40)}: {np.min(distance):.3g} mm",
        )
        axes.set_ylim(low, top)
        axes.set_xlim(t[0], t[-1])
        axes.set_ylabel("distance [mm]")
    return panels.figure
