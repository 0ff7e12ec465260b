"""Figure: the heights of several runs, predicted with their bands and measured, one panel each."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nospill.plots.comparison import save_figure
from nospill.plots.style import BLACK, BLUE, SMALL, plain
from nospill.simulation.runs import RunComparison

_COLUMNS = 3
_WIDTH, _HEIGHT, _HEAD = 3.2, 1.5, 0.6
"""in; of a panel, and what is above and below all of them."""


def save_runs(runs: Sequence[RunComparison], path: str | os.PathLike[str]) -> None:
    """Draw the runs and write them; the format follows the ending (.png, .pdf, .svg).

    Raises:
        ScenarioError: another ending. PlanFolderError: the file cannot be written.
    """
    save_figure(lambda: runs_figure(runs), path)


def runs_figure(runs: Sequence[RunComparison]) -> Figure:
    """One panel a run, over the predicted clock."""
    columns = min(_COLUMNS, len(runs))
    rows = -(-len(runs) // columns)
    figure = Figure(figsize=(_WIDTH * columns, _HEAD + _HEIGHT * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, run in zip(panels, runs, strict=False):
        comparison = run.comparison
        axes.fill_between(comparison.t, 1e3 * run.low, 1e3 * run.high, color=BLUE, alpha=0.25, linewidth=0)
        axes.plot(comparison.t, 1e3 * comparison.predicted, color=BLUE, linewidth=1.0)
        axes.plot(comparison.t, 1e3 * comparison.measured, color=BLACK, marker=".", markersize=1.8, linewidth=0.4)
        axes.set_title(plain(run.name, 26), size=SMALL)
        figures = f"r {comparison.correlation:.2f}, peak {1e2 * comparison.relative_peak_error:+.0f} %"
        axes.set_title(figures, loc="right", size=SMALL)
        axes.set_xlim(float(comparison.t[0]), float(comparison.t[-1]))
        lowest = min(0.0, 1.1e3 * float(np.min(comparison.measured)))
        axes.set_ylim(lowest, 1.12e3 * float(max(np.max(run.high), np.max(comparison.measured))))
    for spare in panels[len(runs) :]:
        spare.remove()
    for index in range(len(runs)):
        if index % columns == 0:
            panels[index].set_ylabel("height [mm]")
        if index + columns >= len(runs):
            panels[index].set_xlabel("time [s]")
    handles = [
        Line2D([], [], color=BLUE, label="predicted, with the band of the tolerances"),
        Line2D([], [], color=BLACK, marker=".", linewidth=0.5, label="measured"),
    ]
    figure.legend(handles=handles, loc="outside lower right", ncols=2)
    return figure
