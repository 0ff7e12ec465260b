"""Figure: how much of every limit of the contact each object uses over time (the waiter's constraints)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nospill.certification.verdict import Trace
from nospill.certification.wording import percent
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plots.evidence import Evidence
from nospill.plots.style import draw_limit, entitle, line_key, plain, series_look, time_panels

HIGHEST_USE = 2.0
"""Uses above this are cut off; the number in the panel's corner still tells."""

_SLACK = 0.1
"""Use below which a constraint is named only."""


def contact_use_figure(evidence: Evidence) -> Figure | None:
    """One panel per constraint on the objects, one line per object; the fullest first, the slack ones in words.

    None without objects.
    """
    by_constraint = evidence.by_constraint(EvaluationPoint.OBJECT)
    by_constraint.pop(SloshHeight.name, None)  # has its own figure, in millimetres
    if not by_constraint:
        return None
    subjects = [cargo.name for cargo in evidence.plan.scene.cargo]
    peaks = {name: _largest(traces) for name, traces in by_constraint.items()}
    ordered = sorted(peaks, key=lambda name: -peaks[name][0])
    shown = [name for name in ordered if peaks[name][0] >= _SLACK] or ordered[:1]
    slack = [f"{name} {percent(*peaks[name])}" for name in ordered if name not in shown]
    panels = time_panels(
        evidence,
        "Contact of every object",
        count=len(shown),
        columns=2 if len(shown) > 1 else 1,
        height=1.45,
        legend=[line_key(plain(name), index) for index, name in enumerate(subjects)],
        share_height=False,
        note=f"Below {100 * _SLACK:.0f} % of its limit at all times: {', '.join(slack)}" if slack else "",
    )
    for axes, name in zip(panels.axes, shown, strict=True):
        traces = by_constraint[name]
        draw_use(axes, name, traces, looks=[subjects.index(trace.subject) for trace in traces])
        axes.set_xlim(0.0, evidence.end_time)
    return panels.figure


def _largest(traces: tuple[Trace, ...]) -> tuple[float, bool]:
    """Largest use of some traces, and whether the limit holds."""
    use = max(float(np.max(trace.use)) for trace in traces)
    return use, use <= 1.0


def draw_use(axes: Axes, title: str, traces: tuple[Trace, ...], *, looks: list[int]) -> None:
    """Lines of use of a limit, one per trace, with the limit at 1 and the largest use in the corner.

    Args:
        axes: of the panel.
        title: above it.
        traces: of one constraint.
        looks: number of each line's look.
    """
    uses = [trace.use for trace in traces]
    for trace, use, look in zip(traces, uses, looks, strict=True):
        axes.plot(trace.t, np.minimum(use, 2 * HIGHEST_USE), **series_look(look))
    peaks = [float(np.max(use)) for use in uses]
    largest = int(np.argmax(peaks))
    top = float(np.clip(1.08 * peaks[largest], 1.24, HIGHEST_USE))
    draw_limit(axes, 1.0, "limit 1", forbidden=top)
    axes.set_ylim(0.0, top)
    axes.set_ylabel("use of limit [1]")
    use = percent(peaks[largest], peaks[largest] <= 1.0)
    entitle(axes, title, f"max {use} ({plain(traces[largest].subject, 10)})")
