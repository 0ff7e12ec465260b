"""Figure: what every liquid of a cycle does, legs and dwells on one clock, and how fast the tray is."""

from __future__ import annotations

import os

import numpy as np
from matplotlib.figure import Figure

from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plans.cycle import CyclePlan
from nospill.plots.comparison import save_figure
from nospill.plots.style import COLOURS, DASHES, INK, SMALL, WIDTH, draw_limit

_DRAWN = 250.0
"""Hz; points of a line that are drawn."""
_DWELL = "#EFEFEF"


def save_cycle_figure(plan: CyclePlan, path: str | os.PathLike[str]) -> None:
    """Draw the cycle and write it; the format follows the ending (.png, .pdf, .svg).

    Raises:
        ScenarioError: another ending. PlanFolderError: the file cannot be written.
    """
    save_figure(lambda: cycle_figure(plan), path, dpi=200)


def cycle_figure(plan: CyclePlan) -> Figure:
    """Heights of the liquids over their limits above, speed of the tray below; dwells are shaded."""
    figure = Figure(figsize=(1.6 * WIDTH, 3.6), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    names = list(dict.fromkeys(item.name for one in plan.legs for item in one.scene.cargo if item.filling is not None))
    looks = {
        name: {"color": COLOURS[index % len(COLOURS)], "linestyle": DASHES[index % len(DASHES)]}
        for index, name in enumerate(names)
    }
    shown: set[str] = set()
    for leg, one in zip(plan.times, plan.legs, strict=True):
        judged = {row.subject for row in one.certificate.rows if row.constraint == SloshHeight.name}
        for name in (name for name in names if name in judged):
            history = one.history(SloshHeight.name, name)
            every = slice(None, None, max(1, round(len(history.t) / (history.t[-1] - history.t[0]) / _DRAWN)))
            label = None if name in shown else name
            above.plot(leg.begins + history.t[every], 100 * history.use[every], label=label, **looks[name])
            shown.add(name)
        t = np.linspace(one.trajectory.t[0], one.trajectory.t[-1], round(leg.motion * _DRAWN))
        speed = np.linalg.norm(one.tray(t).velocity, axis=1)
        below.plot(leg.begins + t - t[0], speed, color=COLOURS[0])
        ends = leg.begins + leg.motion
        for axes in (above, below):
            axes.axvspan(ends, ends + leg.dwell, color=_DWELL, zorder=0)
        middle = leg.begins + leg.motion / 2.0
        above.annotate(
            f"{leg.name}\n{leg.motion:.2f} s",
            (middle, 1.0),
            xycoords=above.get_xaxis_transform(),
            xytext=(0, 2),
            textcoords="offset points",
            ha="center",
            va="bottom",
            size=SMALL,
            color=INK,
        )
    above.set_ylim(0.0, 118.0)
    draw_limit(above, 100.0, "limit", forbidden=118.0)
    above.set_ylabel("height of the liquid\n[% of its limit]")
    below.set_ylabel("tray [m/s]")
    below.set_ylim(0.0, None)
    below.set_xlim(0.0, plan.duration)
    below.set_xlabel("time [s]; dwells are grey")
    if shown:
        figure.legend(loc="outside lower right", ncols=min(len(shown), 6))
    return figure
