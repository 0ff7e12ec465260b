"""Figure: how much of every limit of the contact each object uses over time (the waiter's constraints)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nospill.judge.verdict import Trace
from nospill.judge.wording import shown_unit
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.constraints.lift import Lift
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plots.evidence import Evidence
from nospill.plots.style import draw_limit, entitle, line_key, plain, series_look, superscript, time_panels

HIGHEST_USE = 2.0
"""Uses above this are cut off; the number in the panel's corner still tells."""

_MEANING = {Lift.name: "force / weight"}


def contact_use_figure(evidence: Evidence) -> Figure:
    """One panel per constraint on the objects, one line per object."""
    by_constraint = evidence.by_constraint(EvaluationPoint.OBJECT)
    by_constraint.pop(SloshHeight.name, None)  # has its own figure, in millimetres
    subjects = [cargo.name for cargo in evidence.plan.scene.cargo]
    panels = time_panels(
        evidence,
        "Contact of every object",
        count=len(by_constraint),
        columns=2 if len(by_constraint) > 1 else 1,
        height=1.45,
        legend=[line_key(plain(name), index) for index, name in enumerate(subjects)],
        share_height=False,
    )
    for axes, (name, traces) in zip(panels.axes, by_constraint.items(), strict=True):
        looks = [subjects.index(trace.subject) for trace in traces]
        if np.any([np.any(trace.limit != 0.0) for trace in traces]):
            draw_use(axes, name, traces, looks=looks)
        else:
            _draw_floor(axes, name, traces, looks)
        axes.set_xlim(0.0, evidence.end_time)
    return panels.figure


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
    entitle(axes, title, f"max {peaks[largest]:.4f} ({plain(traces[largest].subject, 10)})")


def _draw_floor(axes: Axes, name: str, traces: tuple[Trace, ...], looks: list[int]) -> None:
    """Values that must stay above zero, in their own unit."""
    factor, unit = shown_unit(traces[0].unit)
    for trace, look in zip(traces, looks, strict=True):
        axes.plot(trace.t, factor * trace.value, **series_look(look))
    lows = [factor * float(np.min(trace.value)) for trace in traces]
    high = factor * max(float(np.max(trace.value)) for trace in traces)
    least = int(np.argmin(lows))
    bottom = min(-0.2 * high, 1.1 * lows[least])
    draw_limit(axes, 0.0, "limit 0", forbidden=bottom)
    axes.set_ylim(bottom, 1.08 * high)
    axes.set_ylabel(f"{_MEANING[name]} [1]" if name in _MEANING else f"{name} [{superscript(unit)}]")
    entitle(axes, name, f"min {lows[least]:.3g} ({plain(traces[least].subject, 10)})")
