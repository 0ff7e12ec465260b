"""Figure: height of every liquid over time, its limit, and what it does after the end."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nospill.certification.verdict import Trace, worst_row
from nospill.certification.wording import row_text
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plots.evidence import Evidence
from nospill.plots.style import BLUE, Panels, draw_end, draw_limit, entitle, limit_key, plain, time_panels

_FREE_DASH = (0, (3, 1.2))
_LEAST_SHARE = 0.005
_MOST_PANELS = 8


def slosh_heights_figure(evidence: Evidence) -> Figure | None:
    """One panel per object with liquid, all on the same axes; None without liquids.

    Of many liquids those that come nearest to their limits. The height is the one the judge integrated again along the
    exported joints; after the end the liquid swings freely.
    """
    every = evidence.traces(SloshHeight.name)
    if not every:
        return None
    fullest = sorted(every, key=lambda trace: worst_row(trace).use, reverse=True)[:_MOST_PANELS]
    shown = {trace.subject for trace in fullest}
    heights = tuple(trace for trace in every if trace.subject in shown)
    title = "every liquid" if len(heights) == len(every) else f"the {len(heights)} fullest of {len(every)} liquids"
    panels = time_panels(
        evidence,
        f"Slosh height of {title}",
        count=len(heights),
        columns=1 if len(heights) < 4 else 2,
        height=1.3,
        legend=[
            Line2D([], [], color=BLUE, label="moving"),
            Line2D([], [], color=BLUE, linestyle=_FREE_DASH, label="swinging freely"),
            limit_key("limit"),
        ],
    )
    _draw(panels, evidence, heights)
    return panels.figure


def _draw(panels: Panels, evidence: Evidence, heights: tuple[Trace, ...]) -> None:
    free_times, free = evidence.free_heights()
    residual = {trace.subject: trace for trace in evidence.traces(ResidualHeight.name)}
    limits = [float(trace.limit[0]) for trace in heights]
    shares = {item.row.subject: item.share for item in evidence.limiting if item.row.constraint == SloshHeight.name}
    # A liquid that leaves its cup must not squeeze the others; 1.6 limits show that it did.
    reached = max(min(float(np.nanmax(trace.value)), 1.6 * max(limits)) for trace in heights)
    top = 1e3 * max(1.22 * max(limits), 1.05 * reached)
    longest = 24 if len(heights) < 4 else 12
    for index, (axes, trace, limit) in enumerate(zip(panels.axes, heights, limits, strict=True)):
        axes.plot(trace.t, 1e3 * trace.value, color=BLUE)
        axes.plot(free_times, 1e3 * free[trace.subject], color=BLUE, linestyle=_FREE_DASH)
        moving = (0.0, evidence.end_time if trace.subject in residual else free_times[-1])
        draw_limit(axes, 1e3 * limit, f"limit {1e3 * limit:.3g} mm", forbidden=top, span=moving)
        draw_end(axes, evidence.end_time)
        if trace.subject in residual:
            rest = 1e3 * float(residual[trace.subject].limit[0])
            resting = (evidence.end_time, float(free_times[-1]))
            draw_limit(axes, rest, f"{rest:.3g} mm", forbidden=top, span=resting, align="right")
        held = shares.get(trace.subject, 0.0)
        worst = worst_row(trace)
        peak = f"max {row_text(worst).value} mm"
        # Where they all come to their limit, their peaks say nothing.
        note = peak if held < _LEAST_SHARE or not worst.ok else f"{100 * held:.0f} % at limit"
        entitle(axes, plain(trace.subject, longest), note)
        axes.set_ylim(0.0, top)
        axes.set_xlim(0.0, free_times[-1])
        if index % (1 if len(heights) < 4 else 2) == 0:
            axes.set_ylabel("height [mm]")
