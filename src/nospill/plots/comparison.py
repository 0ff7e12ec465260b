"""Figure: a measured height of a liquid over its prediction, and where they differ."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from nospill.errors import PlanFolderError, ScenarioError
from nospill.plots.style import BLACK, BLUE, GREY, LOOK, ORANGE, SMALL, WIDTH
from nospill.simulation.compare import Comparison

FORMATS = (".png", ".pdf", ".svg")
"""Endings a figure's name may have."""


def require_figure_name(path: str | os.PathLike[str]) -> Path:
    """The place of a figure, checked before any work.

    Raises:
        ScenarioError: an ending that is no format we write.
    """
    place = Path(path)
    if place.suffix.lower() not in FORMATS:
        raise ScenarioError(f"{place}: a figure's name must end in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}")
    return place


def save_comparison(comparison: Comparison, path: str | os.PathLike[str]) -> None:
    """Draw a comparison and write it; the format follows the ending (.png, .pdf, .svg).

    Raises:
        ScenarioError: another ending. PlanFolderError: the file cannot be written.
    """
    save_figure(lambda: comparison_figure(comparison), path, dpi=200)


def save_figure(draw: Callable[[], Figure], path: str | os.PathLike[str], *, dpi: int = 150) -> None:
    """Draw a figure and write it; the format follows the ending.

    Raises:
        ScenarioError: another ending. PlanFolderError: the file cannot be written.
    """
    place = require_figure_name(path)
    look: Any = LOOK  # the stubs ask for literal key names
    with mpl.rc_context(look):
        try:
            draw().savefig(place, dpi=dpi, format=place.suffix.lower()[1:])
        except OSError as error:
            raise PlanFolderError(f"cannot write {place}: {error.strerror or error}; name another place") from error


def comparison_figure(comparison: Comparison) -> Figure:
    """Heights above, difference below, over the predicted clock; the figures of the comparison in the titles."""
    figure = Figure(figsize=(WIDTH, 3.5), layout="constrained")
    heights, difference = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    t = comparison.t
    heights.plot(t, 1e3 * comparison.measured, color=BLACK, marker=".", markersize=3, linewidth=0.7, label="measured")
    heights.plot(t, 1e3 * comparison.predicted, color=BLUE, linewidth=1.4, label="predicted")
    for values, colour in ((comparison.predicted, BLUE), (comparison.measured, BLACK)):
        at = int(np.argmax(values))
        heights.plot(t[at], 1e3 * values[at], marker="v", color=colour, markersize=5, linestyle="none")
    top = 1e3 * float(max(np.max(comparison.predicted), np.max(comparison.measured)))
    heights.set_ylim(0.0, 1.12 * top)
    heights.set_ylabel("height [mm]")
    heights.legend(loc="upper right", ncols=2, borderaxespad=0.1)
    figure.suptitle("Liquid height, predicted and measured", x=0.02, ha="left", size=9, weight="bold")
    heights.set_title(
        f"correlation {comparison.correlation:.3f}, peak {1e2 * comparison.relative_peak_error:+.1f} %",
        loc="right",
        size=SMALL,
    )
    residual = 1e3 * (comparison.predicted - comparison.measured)
    difference.fill_between(t, residual, color=ORANGE, alpha=0.5, linewidth=0)
    difference.plot(t, residual, color=ORANGE, linewidth=0.8)
    difference.axhline(0.0, color=GREY, linewidth=0.8)
    difference.set_ylabel("error [mm]")
    difference.set_xlabel("time on the predicted clock [s]")
    difference.set_title(
        f"root mean square {1e3 * comparison.rmse:.2f} mm, integral {1e2 * comparison.integral_error:+.0f} %",
        loc="right",
        size=SMALL,
    )
    difference.set_xlim(float(t[0]), float(t[-1]))
    figure.align_ylabels()
    return figure
