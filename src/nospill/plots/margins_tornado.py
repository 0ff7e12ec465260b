"""Which number moves the largest use of a plan's limits how far (a tornado), over the distribution of that use."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nospill.errors import PlanFolderError
from nospill.plots.style import BLACK, BLUE, GREY, LOOK, ORANGE, RED, SMALL, WIDTH, plain, write_limit

_BAR, _HISTOGRAM, _ROW = 0.62, 1.35, 0.4
_RESOLUTION = 220
_MOST = 10
_BINS = 40
MEASURE_LOOKS: dict[str, dict[str, Any]] = {"liquid": {"color": BLUE}, "contact": {"color": ORANGE, "hatch": "///"}}
"""Measure of an influence -> look of its bar; hatching tells them apart in a grey print."""


@dataclass(frozen=True, slots=True)
class Bar:
    """One number: margin as planned and at both ends of its effect (1), where they are, and the limiting constraint.

    `measure` is "liquid" or "contact": on which constraints the margin was measured.
    """

    name: str
    measure: str
    nominal: float
    least: float
    greatest: float
    least_at: str
    greatest_at: str
    limited_by: str


def tornado_figure(bars: list[Bar], worst_margin: np.ndarray, *, nominal: float, title: str) -> Figure:
    """Draw the bars, in the order given, above a histogram of the worst margin.

    Args:
        bars: the strongest are drawn, ten at most; there may be none.
        worst_margin: (m,) of the samples, fractions of the limit.
        nominal: with the scenario's numbers.
        title: headline.
    """
    bars = bars[:_MOST]
    rows = max(len(bars), 1)
    total = 0.68 + _ROW * rows + 0.75 + _HISTOGRAM + 0.45
    figure = Figure(figsize=(WIDTH, total))
    upper, lower = figure.subplots(2, 1, height_ratios=[_ROW * rows, _HISTOGRAM])
    figure.subplots_adjust(
        left=0.16, right=0.97, top=1 - 0.6 / total, bottom=0.45 / total, hspace=1.5 / (_ROW * rows + _HISTOGRAM)
    )
    figure.text(0.16, 1 - 0.06 / total, title, ha="left", va="top", weight="bold")
    _draw_bars(upper, bars)
    values = _use(worst_margin[np.isfinite(worst_margin)])
    lower.hist(values, bins=_BINS, color=GREY, linewidth=0)
    lower.set_ylabel("samples")
    lower.set_xlabel("largest use [% of the limit]")
    lower.set_title(f"{len(worst_margin)} samples, all numbers off at once", size=SMALL)
    lower.axvline(_use(nominal), color=GREY, linewidth=1.0, linestyle=(0, (2, 1.5)), zorder=3)
    for axes in (upper, lower):
        axes.axvline(100.0, color=RED, linewidth=1.2, zorder=3)
        write_limit(axes, (0.0, 1.0), "limit", above=False, transform=axes.get_xaxis_transform())
    handles = [Patch(label=f"limits of the {name}s", **MEASURE_LOOKS[name]) for name in MEASURE_LOOKS]
    shown = [
        handle for handle, name in zip(handles, MEASURE_LOOKS, strict=True) if any(name == bar.measure for bar in bars)
    ]
    if shown:
        place = (0.16, 1 - 0.23 / total)
        figure.legend(handles=shown, loc="upper left", bbox_to_anchor=place, ncols=2, borderaxespad=0.0, borderpad=0.0)
    return figure


def _draw_bars(axes: Axes, bars: list[Bar]) -> None:
    ends = [float(_use(value)) for bar in bars for value in (bar.least, bar.greatest)] or [99.0, 101.0]
    span = max(max(ends) - min(ends), 1e-6)
    for row, bar in enumerate(bars):
        least, greatest = _use(bar.greatest), _use(bar.least)
        style = MEASURE_LOOKS[bar.measure]
        axes.barh(row, greatest - least, left=least, height=_BAR, edgecolor="white", linewidth=0.0, **style)
        at = _use(bar.nominal)
        axes.plot((at, at), (row - _BAR / 2, row + _BAR / 2), color=BLACK, linewidth=1.2, zorder=4)
        for value, text, side in ((least, bar.greatest_at, "right"), (greatest, bar.least_at, "left")):
            if abs(value - at) < 1e-3 * span:
                continue  # this end changes nothing
            offset = -3 if side == "right" else 3
            axes.annotate(
                text,
                (value, row),
                xytext=(offset, 0),
                textcoords="offset points",
                ha=side,
                va="center",
                size=SMALL,
                zorder=5,
                bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.5},
            )
        axes.annotate(
            plain(bar.limited_by, 34),
            (least, row + _BAR / 2),
            xytext=(0, -1),
            textcoords="offset points",
            ha="left",
            va="top",
            size=6.5,
            color="#444444",
            zorder=5,
            bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.2},
        )
    axes.set_yticks(range(len(bars)), [bar.name for bar in bars])
    axes.set_ylim(max(len(bars), 1) - 0.35, -0.6)
    axes.set_xlim(min(ends) - 0.35 * span, max(ends) + 0.35 * span)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("use [% of the limit]")
    axes.set_title("one number at a time; black: with the scenario's own numbers", size=SMALL)


def _use(margin: Any) -> Any:
    """Use of limits, percent, of which margins are left, fractions of the limits."""
    return 100.0 * (1.0 - margin)


def save_tornado(
    bars: list[Bar], worst_margin: np.ndarray, folder: Path, *, nominal: float, title: str
) -> tuple[Path, Path]:
    """Write tornado.png and tornado.pdf into a folder that exists.

    Raises:
        PlanFolderError: the disk refuses.
    """
    paths = folder / "tornado.png", folder / "tornado.pdf"
    try:
        with matplotlib.rc_context(LOOK):
            figure = tornado_figure(bars, worst_margin, nominal=nominal, title=title)
            figure.savefig(paths[0], dpi=_RESOLUTION)
            figure.savefig(paths[1], metadata={"CreationDate": None})
    except OSError as error:
        raise PlanFolderError(f"{folder}: the figure cannot be written ({error.strerror or error})") from error
    return paths
