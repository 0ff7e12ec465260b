"""What the pictures of the pages have in common: paper to draw on, arrows, words, and one way to write a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Polygon

from nospill.plots.style import BLACK, BLUE, GREY, INK, LOOK

WIDTH = 7.4
"""in; at 100 points an inch of the screen, the width of a page's text."""

LIQUID, GLASS, BOARD = "#CFE3F2", "#7A8791", "#D9C9AE"
"""Colours of what is sketched: they differ in brightness too, for a print in grey."""

SETTINGS: dict[Any, Any] = {
    **LOOK,
    "svg.fonttype": "path",
    # The same picture gives the same bytes.
    "svg.hashsalt": "nospill",
    "mathtext.fontset": "dejavusans",
}


def write(figure: Figure, path: Path) -> None:
    """Write a drawing as SVG, which is sharp on every screen."""
    figure.savefig(path, format="svg", metadata={"Date": None})


def look() -> Any:
    """The project's style, for the time of a drawing."""
    return mpl.rc_context(SETTINGS)


def sheet(height: float, *, width: float = WIDTH) -> Figure:
    """An empty picture, in."""
    return Figure(figsize=(width, height))


def sketch(
    figure: Figure, place: tuple[float, float, float, float], x: tuple[float, float], y: tuple[float, float]
) -> Axes:
    """Paper without a frame, equal scales; `place` in fractions of the figure."""
    axes = figure.add_axes(place)
    axes.set_axis_off()
    axes.set_xlim(*x)
    axes.set_ylim(*y)
    axes.set_aspect("equal")
    return axes


def arrow(
    axes: Axes,
    start: tuple[float, float],
    end: tuple[float, float],
    *,
    color: str = BLACK,
    width: float = 1.6,
    style: str = "-|>",
    bend: float = 0.0,
) -> None:
    """An arrow in units of the axes; `bend` makes it an arc."""
    axes.annotate(
        "",
        end,
        start,
        arrowprops={
            "arrowstyle": style,
            "color": color,
            "linewidth": width,
            "shrinkA": 0,
            "shrinkB": 0,
            "mutation_scale": 11,
            "connectionstyle": f"arc3,rad={bend}",
        },
        zorder=6,
    )


def words(axes: Axes, place: tuple[float, float], text: str, **look: Any) -> None:
    """Text at a place, from its left end and in the middle of its height unless said otherwise."""
    axes.text(*place, text, **({"ha": "left", "va": "center", "size": 9, "color": INK, "zorder": 8} | look))


def note(axes: Axes, at: tuple[float, float], place: tuple[float, float], text: str, **look: Any) -> None:
    """Text at a place with a thin line to what it speaks of."""
    axes.annotate(
        text,
        at,
        place,
        arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.8, "shrinkA": 1, "shrinkB": 0},
        **({"ha": "left", "va": "center", "size": 8.5, "color": INK, "zorder": 8} | look),
    )


def cup(
    axes: Axes,
    *,
    radius: float = 1.0,
    height: float = 2.6,
    level: float = 1.6,
    slope: float = 0.0,
    foot: tuple[float, float] = (0.0, 0.0),
    angle: float = 0.0,
) -> np.ndarray:
    """A cup from the side with a surface of some slope; returns the rotation (2, 2) of its axes."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    wall = np.array([[-radius, height], [-radius, 0.0], [radius, 0.0], [radius, height]]) @ turn.T + foot
    rise = radius * slope
    water = np.array([[-radius, 0.0], [radius, 0.0], [radius, level + rise], [-radius, level - rise]]) @ turn.T + foot
    axes.add_patch(Polygon(water, facecolor=LIQUID, edgecolor="none", zorder=2))
    axes.plot(*water[2:].T, color=BLUE, linewidth=1.8, zorder=3)
    axes.plot(*wall.T, color=GLASS, linewidth=2.2, zorder=4, solid_joinstyle="round")
    return turn


def board(
    axes: Axes, half: float, *, at: tuple[float, float] = (0.0, 0.0), angle: float = 0.0, thick: float = 0.14
) -> None:
    """A tray from the side, its upper surface at y = 0 of its own frame."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    corners = np.array([[-half, 0.0], [half, 0.0], [half, -thick], [-half, -thick]]) @ turn.T + at
    axes.add_patch(Polygon(corners, facecolor=BOARD, edgecolor="#8C7B5C", linewidth=0.8, zorder=1))


def box(
    axes: Axes, corner: tuple[float, float], size: tuple[float, float], *, face: str = "#F4F7FA", edge: str = GLASS
) -> None:
    """A box with round corners."""
    shape = "round,pad=0,rounding_size=0.08"
    axes.add_patch(
        FancyBboxPatch(corner, *size, boxstyle=shape, facecolor=face, edgecolor=edge, linewidth=1.0, zorder=2)
    )
