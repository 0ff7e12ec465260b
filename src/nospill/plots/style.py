"""One look for all figures: colours, line styles, limits, panels in fixed inches.

Colours are those of Okabe and Ito, which people with any colour blindness tell apart; every line of a panel also has
its own dash pattern or marker, so that a grey print can still be read. Figures are 4.4 in wide with letters of 7.5 to 9
points; on a column of 85 mm the smallest are 5.7 points high.
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nospill.core.short_names import cut
from nospill.plots.evidence import Evidence

BLUE, ORANGE, GREEN, PURPLE = "#0072B2", "#E69F00", "#009E73", "#CC79A7"
SKY, BLACK, GREY, RED = "#56B4E9", "#000000", "#777777", "#D55E00"
DARK_RED = "#9A4300"
"""For letters: vermilion, darkened until it can be read on white and on its own shade."""
_SHADE = "#F9EADE"
INK = "#333333"
"""For letters that say less than others."""
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, BLACK, SKY, GREY)
"""For series; vermilion is kept for limits."""

DASHES: tuple[Any, ...] = ("-", (0, (5, 1.6)), (0, (1.3, 1.3)), (0, (6, 1.5, 1.3, 1.5)))
MARKERS = ("", "o", "s", "^", "x")

WIDTH = 4.4
"""in; width of every figure but the summary sheet."""

SMALL = 7.5
"""Size of labels inside panels, points."""

LOOK: dict[Any, Any] = {
    "font.family": ["DejaVu Sans"],
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.titlepad": 4,
    # Where it is wanted: else every tick is measured once more to find out.
    "axes.titley": 1.0,
    "axes.labelsize": 9,
    "axes.labelpad": 2,
    "axes.linewidth": 0.7,
    "axes.edgecolor": "#444444",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.6,
    "grid.linestyle": "-",
    "lines.linewidth": 1.4,
    "lines.markersize": 3.5,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 2.6,
    "path.simplify": True,
    "path.simplify_threshold": 0.3,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "savefig.bbox": "standard",
    # TrueType: publishers refuse the outlines of type 3, and letters can be searched and copied.
    "pdf.fonttype": 42,
}
"""Settings for `matplotlib.rc_context`; nothing is set outside it."""

_LEFT, _RIGHT, _BOTTOM, _GAP = 0.62, 0.12, 0.44, 0.36
_TITLE_ROW, _NAME_ROW, _LEGEND_ROW = 0.2, 0.17, 0.155
_NOTE_LETTERS = 84
_LETTER = 0.52 * 8 / 72
"""in; mean width of a letter of the legend."""
_WIDE_LETTER = 0.62 / 72
"""in per point of size; width of a letter that few names exceed on average."""


def series_look(index: int) -> dict[str, Any]:
    """Colour, dash pattern and marker of the index-th line of a panel; (dash, marker) repeats after 20 lines."""
    marker = MARKERS[index // len(DASHES) % len(MARKERS)]
    look: dict[str, Any] = {"color": COLOURS[index % len(COLOURS)], "linestyle": DASHES[index % len(DASHES)]}
    return look | ({"marker": marker, "markevery": (0.03 + 0.02 * (index % 4), 0.12)} if marker else {})


def plain(name: str, longest: int = 22) -> str:
    """A user's name as figure text: no formula signs, shortened in its middle where it is too long."""
    return cut(name, longest).replace("$", r"\$")


@dataclass(frozen=True, slots=True)
class Panels:
    """A figure and its panels, row by row."""

    figure: Figure
    axes: tuple[Axes, ...]


def time_panels(
    evidence: Evidence,
    title: str,
    *,
    count: int,
    columns: int,
    height: float,
    legend: list[Line2D] | None = None,
    share_height: bool = True,
    note: str = "",
) -> Panels:
    """A figure of `count` panels over a common time axis, `height` in each, with a headline and a legend above them.

    A note, if there is one, is a sentence below the panels.
    """
    rows = -(-count // columns)
    handles = legend or []
    across = legend_columns(handles, WIDTH - 0.1)
    legend_height = _LEGEND_ROW * -(-len(handles) // across) + (0.05 if handles else 0.0)
    heading = 0.06 + _TITLE_ROW + _NAME_ROW
    top = heading + legend_height + _TITLE_ROW + 0.04
    lines = textwrap.wrap(note, _NOTE_LETTERS)
    bottom = _BOTTOM + _LEGEND_ROW * len(lines)
    total = top + rows * height + (rows - 1) * _GAP + bottom
    figure = Figure(figsize=(WIDTH, total))
    grid = figure.subplots(rows, columns, sharex=True, sharey=share_height, squeeze=False)
    inner = WIDTH - _LEFT - _RIGHT
    column = (inner - (columns - 1) * (0.2 if share_height else 0.66)) / columns
    figure.subplots_adjust(
        left=_LEFT / WIDTH,
        right=1 - _RIGHT / WIDTH,
        top=1 - top / total,
        bottom=bottom / total,
        hspace=_GAP / height,
        wspace=(inner / column - columns) / (columns - 1) if columns > 1 else 0.0,
    )
    headline(figure, evidence, title, left=0.1 / WIDTH, y=1 - 0.06 / total)
    figure.text(0.1 / WIDTH, 0.05 / total, plain("\n".join(lines), len(note) + 1), va="bottom", size=SMALL, color=INK)
    if handles:
        figure.legend(
            handles,
            [str(handle.get_label()) for handle in handles],
            loc="upper left",
            bbox_to_anchor=(0.06 / WIDTH, 1 - heading / total),
            ncols=across,
            borderaxespad=0.0,
            borderpad=0.1,
            labelspacing=0.25,
            columnspacing=1.2,
            handletextpad=0.5,
        )
    axes = list(grid.ravel())
    for spare in axes[count:]:
        spare.remove()
    for index in range(count):
        if index + columns >= count:
            axes[index].set_xlabel("time [s]")
            axes[index].tick_params(labelbottom=True)
    return Panels(figure, tuple(axes[:count]))


def headline(figure: Figure, evidence: Evidence, title: str, *, left: float, y: float) -> None:
    """What is shown, and below it the plan's name, end time and verdict; `left` and `y` in fractions of the figure."""
    verdict = evidence.judgement.certificate.word
    name = plain(evidence.plan.scene.name, 32)
    below = y - _TITLE_ROW / figure.get_size_inches()[1]
    figure.text(left, y, title, ha="left", va="top", weight="bold")
    figure.text(left, below, f"{name}: {evidence.end_time:.3f} s, {verdict}", ha="left", va="top", size=8, color=INK)


def entitle(axes: Axes, title: str, peak: str) -> None:
    """Print what a panel shows and, on the right, its largest figure; inside the panel where both do not fit above."""
    axes.set_title(title)
    available = axes.get_position().width * axes.get_figure(root=True).get_size_inches()[0]  # type: ignore[union-attr]
    if _WIDE_LETTER * (9 * len(title) + SMALL * len(peak)) <= available:
        axes.set_title(peak, loc="right", size=SMALL)
        return
    axes.annotate(
        peak,
        (1.0, 1.0),
        xycoords="axes fraction",
        xytext=(-2, -2),
        textcoords="offset points",
        ha="right",
        va="top",
        size=SMALL,
        zorder=4,
        bbox={"facecolor": _SHADE, "alpha": 0.7, "edgecolor": "none", "pad": 0.6},
    )


def line_key(label: str, index: int) -> Line2D:
    """Legend entry of the index-th series."""
    look = {key: value for key, value in series_look(index).items() if key != "markevery"}
    # Some versions leave labels that start with an underscore out of the legend; a space without width goes before it.
    return Line2D([], [], label=label if not label.startswith("_") else f"\u200b{label}", **look)


def limit_key(label: str) -> Line2D:
    """Legend entry of limits."""
    return Line2D([], [], label=label, color=RED, linewidth=1.2)


def draw_limit(
    axes: Axes,
    value: float,
    name: str,
    *,
    forbidden: float,
    span: tuple[float, float] | None = None,
    align: str = "left",
) -> None:
    """A limit as a line with its name, its forbidden side shaded as far as `forbidden`.

    Args:
        axes: of the panel.
        value: of the limit, in units of the panel, as is `forbidden`.
        name: printed on the forbidden side.
        forbidden: end of the shading.
        span: times from and to which it holds, s; None for all.
        align: "left" or "right" end of the span for the name.
    """
    above = forbidden > value
    at = (0.0, 1.0) if span is None else span
    across = axes.get_yaxis_transform() if span is None else axes.transData
    axes.fill_between(at, value, forbidden, transform=across, facecolor=RED, alpha=0.13, linewidth=0, zorder=0.5)
    axes.plot(at, (value, value), transform=across, color=RED, linewidth=1.2, zorder=2.5)
    write_limit(axes, (at[0] if align == "left" else at[1], value), name, above=above, align=align, transform=across)


def write_limit(
    axes: Axes, place: tuple[float, float], name: str, *, above: bool, align: str = "left", transform: Any
) -> None:
    """The name of a limit beside its line."""
    axes.annotate(
        name,
        place,
        xycoords=transform,
        xytext=(2 if align == "left" else -1, 1.5 if above else -2),
        textcoords="offset points",
        ha=align,
        va="bottom" if above else "top",
        size=SMALL,
        color=DARK_RED,
        zorder=4,
        bbox={"facecolor": _SHADE, "alpha": 0.7, "edgecolor": "none", "pad": 0.6},
    )


def draw_end(axes: Axes, time: float) -> None:
    """The end of the motion as a vertical line with its name."""
    axes.axvline(time, color="#444444", linewidth=0.9, linestyle=(0, (2, 1.5)), zorder=2.4)
    axes.annotate(
        "end of motion",
        (time, 0.97),
        xycoords=("data", "axes fraction"),
        xytext=(2, 0),
        textcoords="offset points",
        rotation=90,
        ha="left",
        va="top",
        size=SMALL,
        color="#333333",
    )


def legend_columns(handles: list[Line2D], width: float) -> int:
    """How many columns of a legend fit into a width in in, at least one."""
    longest = max((len(str(handle.get_label())) for handle in handles), default=0)
    return int(np.clip(width // (longest * _LETTER + 0.52), 1, max(len(handles), 1)))
