"""Figure: how much of every limit of the contact each object uses over time (the waiter's constraints)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

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
_MOST_NAMED = 12
"""Objects that have a line of their own look; of more the fullest do, and the others are grey behind them."""
_OTHERS = {"color": "#c8c8c8", "linewidth": 0.6}


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
    looks = looks_of([trace for name in shown for trace in by_constraint[name]], subjects)
    panels = time_panels(
        evidence,
        "Contact of every object",
        count=len(shown),
        columns=2 if len(shown) > 1 else 1,
        height=1.45,
        legend=legend_of(looks, len(subjects)),
        share_height=False,
        note=f"Below {100 * _SLACK:.0f} % of its limit at all times: {', '.join(slack)}" if slack else "",
    )
    for axes, name in zip(panels.axes, shown, strict=True):
        draw_use(axes, name, by_constraint[name], looks=looks)
        axes.set_xlim(0.0, evidence.end_time)
    return panels.figure


def _largest(traces: tuple[Trace, ...]) -> tuple[float, bool]:
    """Largest use of some traces, and whether the limit holds."""
    use = max(float(np.max(trace.use)) for trace in traces)
    return use, use <= 1.0


def looks_of(traces: Iterable[Trace], subjects: Sequence[str], most: int = _MOST_NAMED) -> dict[str, int]:
    """Objects that have a look of their own and its number: all, or of more than `most` those that use most."""
    if len(subjects) <= most:
        return {name: index for index, name in enumerate(subjects)}
    uses: dict[str, float] = {}
    for trace in traces:
        uses[trace.subject] = max(float(np.max(trace.use)), uses.get(trace.subject, 0.0))
    fullest = sorted(uses, key=lambda name: -uses[name])[:most]
    return {name: index for index, name in enumerate(name for name in subjects if name in fullest)}


def legend_of(looks: Mapping[str, int], count: int, names: Sequence[str] | None = None) -> list[Line2D]:
    """Keys of the objects that have a look, and one of the others where there are any among `count` objects.

    Args:
        looks: of `looks_of`.
        count: of all objects.
        names: by which the objects are called; their own when left out.
    """
    keys = [line_key(plain(name), look) for name, look in zip(names or looks, looks.values(), strict=True)]
    others = count - len(looks)
    return [*keys, Line2D([], [], **_OTHERS, label=f"{others} others")] if others else keys


def draw_use(axes: Axes, title: str, traces: tuple[Trace, ...], *, looks: Mapping[str, int]) -> None:
    """Lines of use of a limit, one per trace, with the limit at 1 and the largest use in the corner.

    Args:
        axes: of the panel.
        title: above it.
        traces: of one constraint.
        looks: number of each object's look; what has none is grey, behind the others.
    """
    for trace in sorted(traces, key=lambda trace: trace.subject in looks):
        own = looks.get(trace.subject)
        look = _OTHERS if own is None else series_look(own)
        axes.plot(trace.t, np.minimum(trace.use, 2 * HIGHEST_USE), **look)
    peaks = [float(np.max(trace.use)) for trace in traces]
    largest = int(np.argmax(peaks))
    top = float(np.clip(1.08 * peaks[largest], 1.24, HIGHEST_USE))
    draw_limit(axes, 1.0, "limit 1", forbidden=top)
    axes.set_ylim(0.0, top)
    axes.set_ylabel("use of limit [1]")
    use = percent(peaks[largest], peaks[largest] <= 1.0)
    entitle(axes, title, f"max {use} ({plain(traces[largest].subject, 10)})")
