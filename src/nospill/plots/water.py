"""Figure: the crest of every liquid over time, as certified, to the second order and of the full flow."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nospill.plots.comparison import save_figure
from nospill.plots.style import BLUE, SMALL, draw_end, draw_limit, limit_key, plain, series_look
from nospill.verify.water import CupReport, WaterReport

_COLUMNS = 2
_WIDTH, _HEIGHT, _HEAD = 4.4, 1.9, 0.6
"""in; of a panel, and what is above and below all of them."""
_MOST_LIMITS = 2.0
"""Limits that a panel is high at most: a flow that breaks down must not squeeze the others."""


def save_water(report: WaterReport, path: str | os.PathLike[str]) -> None:
    """Draw the liquids of a report and write them; the format follows the ending (.png, .pdf, .svg).

    Raises:
        ScenarioError: another ending. PlanFolderError: the file cannot be written.
    """
    save_figure(lambda: water_figure(report), path)


def water_figure(report: WaterReport) -> Figure:
    """One panel a liquid that was followed."""
    count = max(len(report.cups), 1)
    columns = min(_COLUMNS, count)
    rows = -(-count // columns)
    figure = Figure(figsize=(_WIDTH * columns, _HEAD + _HEIGHT * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, cup in zip(panels, report.cups, strict=False):
        _draw(axes, cup)
    for spare in panels[len(report.cups) :]:
        spare.remove()
    for index in range(len(report.cups)):
        if index % columns == 0:
            panels[index].set_ylabel("crest [mm]")
        if index + columns >= len(report.cups):
            panels[index].set_xlabel("time [s]")
    handles = [
        Line2D([], [], color=BLUE, label="certified"),
        Line2D([], [], label="second order", **_look(1)),
        Line2D([], [], label="full flow", **_look(2)),
        limit_key("limit"),
    ]
    figure.legend(handles=handles, loc="outside lower right", ncols=4)
    return figure


def _look(index: int) -> dict[str, Any]:
    return series_look(index) | {"marker": None, "markevery": None}


def _draw(axes: Any, cup: CupReport) -> None:
    found = cup.crests
    reached = max(float(np.max(found.second)), cup.full.value, cup.limit)
    top = 1e3 * min(1.1 * reached, max(_MOST_LIMITS * cup.limit, 1.1 * cup.full.value))
    axes.plot(cup.history[0], 1e3 * cup.history[1], color=BLUE)
    axes.plot(found.t, 1e3 * found.second, **_look(1))
    axes.plot(found.t[: len(found.full)], 1e3 * found.full, **_look(2))
    draw_limit(axes, 1e3 * cup.limit, f"limit {1e3 * cup.limit:.3g} mm", forbidden=top, span=(found.t[0], found.end))
    if cup.residual_limit is not None:
        rest = 1e3 * cup.residual_limit
        draw_limit(axes, rest, f"{rest:.3g} mm", forbidden=top, span=(found.end, found.t[-1]), align="right")
    draw_end(axes, found.end)
    axes.set_title(plain(cup.name, 26), size=SMALL)
    note = f"certified {1e3 * cup.certified.value:.1f}, full {1e3 * cup.full.value:.1f} mm"
    axes.set_title(f"{note}{' (in doubt)' if found.doubt else ''}", loc="right", size=SMALL)
    axes.set_ylim(0.0, top)
    axes.set_xlim(float(found.t[0]), float(found.t[-1]))
