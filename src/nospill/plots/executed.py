"""Figure: heights of the liquids as planned, as executed with the band that noise leaves, and as measured."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nospill.execution.executed import Executed
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plots.comparison import save_figure
from nospill.plots.style import BLACK, BLUE, LOOK, ORANGE, SMALL, WIDTH, draw_limit, plain

_PANEL, _HEAD = 1.35, 0.8
"""in; height of a panel, and of what is above and below all of them."""
_DRAWN = 250.0
"""Hz; points of a line that are drawn."""
_AFTER = 0.5
"""s; of rest that is shown after the motion."""


def save_executed(run: Executed, place: Path) -> None:
    """Draw the figure and write it; the format follows the ending.

    Raises:
        PlanFolderError: the file cannot be written.
    """
    save_figure(lambda: executed_figure(run), place, dpi=200)


def executed_svg(found: Executed) -> str:
    """The figure as SVG text with letters as outlines; the same run gives the same text."""
    look: Any = {**LOOK, "svg.hashsalt": "nospill"}
    text = io.StringIO()
    with mpl.rc_context(look):
        empty = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        executed_figure(found).savefig(text, format="svg", metadata=empty)
    return text.getvalue()


def executed_figure(run: Executed) -> Figure:
    """One panel a liquid; those that were measured first where only some were."""
    names = sorted(run.heights, key=lambda name: name not in run.measured)
    figure = Figure(figsize=(WIDTH, _HEAD + _PANEL * max(1, len(names))), layout="constrained")
    panels = figure.subplots(max(1, len(names)), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    figure.suptitle("Liquid height, planned, executed and measured", x=0.02, ha="left", size=9, weight="bold")
    limits = {trace.subject: 1e3 * float(trace.limit[0]) for trace in run.judgement.traces if _is_height(trace)}
    tops = [1e3 * float(np.max(values)) for values in run.heights.values()]
    tops += [1e3 * own.measured_peak for own in run.measured.values()]
    top = 1.12 * max([*tops, *limits.values()], default=1.0)
    for axes, name in zip(panels, names, strict=False):
        draw_limit(axes, limits[name], f"limit {limits[name]:.3g} mm", forbidden=top)
        _draw(axes, run, name)
        axes.set_ylim(0.0, top)
        axes.set_ylabel("height [mm]")
    begin = run.recorded.begin - run.clock
    panels[-1].set_xlim(begin - 0.05, run.recorded.end - run.clock + _AFTER)
    panels[-1].set_xlabel("time [s]")
    handles = [Line2D([], [], color=BLUE, label="executed")]
    if run.planned is not None:
        handles.insert(0, Line2D([], [], color=ORANGE, linestyle=(0, (4, 1.5)), label="planned"))
    if run.measured:
        handles.append(Line2D([], [], color=BLACK, marker=".", linewidth=0.5, label="measured"))
    figure.legend(handles=handles, loc="outside lower right", ncols=3)
    return figure


def _draw(axes: Axes, run: Executed, name: str) -> None:
    t, last = run.judgement.replay.t, run.recorded.end - run.clock + _AFTER
    drawn = np.flatnonzero(t <= last)[:: max(1, round(run.judgement.replay.rate / _DRAWN))]
    t, height, band = t[drawn], 1e3 * run.heights[name][drawn], 1e3 * run.height_bands[name][drawn]
    words = []
    if run.planned is not None:
        for trace in run.planned.traces:
            if _is_height(trace) and trace.subject == name:
                every = max(1, round(len(trace.t) / (trace.t[-1] - trace.t[0]) / _DRAWN))
                axes.plot(trace.t[::every], 1e3 * trace.value[::every], color=ORANGE, linestyle=(0, (4, 1.5)), zorder=3)
                words.append(f"planned {1e3 * float(np.max(trace.value)):.1f}")
    axes.fill_between(t, height - band, height + band, color=BLUE, alpha=0.25, linewidth=0)
    axes.plot(t, height, color=BLUE)
    words.append(f"executed {1e3 * np.max(run.heights[name]):.1f}")
    measured = run.measured.get(name)
    if measured is not None:
        axes.plot(measured.t, 1e3 * measured.measured, color=BLACK, marker=".", markersize=2.5, linewidth=0.5, zorder=3)
        words.append(f"measured {1e3 * measured.measured_peak:.1f}")
    axes.set_title(plain(name))
    axes.set_title(f"peaks: {', '.join(words)} mm", loc="right", size=SMALL)


def _is_height(trace: Any) -> bool:
    return trace.constraint == SloshHeight.name
