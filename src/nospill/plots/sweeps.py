"""Figures of a sweep by its number of axes: a curve, a heat map, panels; and the Pareto front of two goals."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from nospill.errors import PlanFolderError
from nospill.plots.style import BLUE, GREY, INK, LOOK, RED, SMALL, WIDTH, plain

_RESOLUTION = 220
_HEIGHT = 2.9
_PANEL, _COLUMNS = 1.7, 2
_MOST_TICKS = 8
_MOST_PANELS = 8
_TICKS_OF_PANEL = 4


@dataclass(frozen=True, slots=True)
class Scale:
    """What points are drawn along: an axis of the sweep or a column.

    Attributes:
        name: with its unit, as printed.
        places: (points,) number of each point; of words their index. NaN where there is none.
        words: in the order of their indices; empty for numbers.
    """

    name: str
    places: np.ndarray
    words: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SweepPicture:
    """What the figures show.

    Attributes:
        title: headline.
        axes: of the sweep.
        goals: columns, the first one decides; with them whether the greatest is wanted.
        certified: (points,) bool.
        best: index of the best point; None where there is none.
    """

    title: str
    axes: tuple[Scale, ...]
    goals: tuple[tuple[Scale, bool], ...]
    certified: np.ndarray
    best: int | None


def sweep_figures(picture: SweepPicture) -> dict[str, Figure]:
    """Figures by name: `sweep`, and `pareto` where there are two goals."""
    draw = {1: _curve, 2: _heat_map}.get(len(picture.axes), _panels)
    figures = {"sweep": draw(picture)}
    if len(picture.goals) > 1:
        figures["pareto"] = _pareto(picture)
    return figures


def pareto_front(values: np.ndarray) -> np.ndarray:
    """Which points no other one beats: (points,) bool.

    Args:
        values: (points, goals), the less the better; NaN is beaten by all.
    """
    found = np.all(np.isfinite(values), axis=1)
    for index in np.flatnonzero(found):
        others = values[np.all(np.isfinite(values), axis=1)]
        beaten = np.all(others <= values[index], axis=1) & np.any(others < values[index], axis=1)
        found[index] = not beaten.any()
    return found


def save_sweep_figures(picture: SweepPicture, folder: Path) -> list[Path]:
    """Write each figure as NAME.png and NAME.svg into a folder that exists.

    Raises:
        PlanFolderError: the disk refuses.
    """
    paths = []
    try:
        with matplotlib.rc_context({**LOOK, "svg.hashsalt": "nospill"}):
            for name, figure in sweep_figures(picture).items():
                for ending, options in (("png", {"dpi": _RESOLUTION}), ("svg", {"metadata": {"Date": None}})):
                    paths.append(folder / f"{name}.{ending}")
                    figure.savefig(paths[-1], **options)  # type: ignore[arg-type]
    except OSError as error:
        raise PlanFolderError(f"{folder}: the figure cannot be written ({error.strerror or error})") from error
    return paths


def _figure(picture: SweepPicture, height: float = _HEIGHT) -> Figure:
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    figure.suptitle(plain(picture.title, 70), x=0.01, ha="left", size=9, weight="bold")
    return figure


def _curve(picture: SweepPicture) -> Figure:
    figure = _figure(picture)
    _draw_over(figure.subplots(), picture, picture.axes[0], line=True)
    return figure


def _panels(picture: SweepPicture) -> Figure:
    shown = picture.axes[:_MOST_PANELS]
    rows = -(-len(shown) // _COLUMNS)
    figure = _figure(picture, 0.4 + _PANEL * rows)
    grid = figure.subplots(rows, _COLUMNS, sharey=True, squeeze=False).ravel()
    for axes, scale in zip(grid, shown, strict=False):
        _draw_over(axes, picture, scale, line=False)
        if not scale.words:
            axes.locator_params(axis="x", nbins=_TICKS_OF_PANEL)
    for spare in grid[len(shown) :]:
        spare.remove()
    return figure


def _draw_over(axes: Axes, picture: SweepPicture, scale: Scale, *, line: bool) -> None:
    """The first goal over one axis; failures as crosses at the bottom."""
    goal, held = picture.goals[0][0], picture.certified
    order = np.argsort(scale.places, kind="stable")
    kept = order[held[order]]
    axes.plot(scale.places[kept], goal.places[kept], "-o" if line else "o", color=BLUE, markersize=3.5)
    lost = ~held
    if lost.any():
        heights = np.full(int(lost.sum()), 0.03)
        axes.plot(
            scale.places[lost], heights, "x", color=RED, transform=axes.get_xaxis_transform(), label="not certified"
        )
        axes.legend(loc="upper right")  # the best place would be looked for among all points
    _mark_best(axes, picture, scale.places, goal.places)
    _name(axes, scale, goal)


def _heat_map(picture: SweepPicture) -> Figure:
    """The first goal as colour over both axes: cells of a grid, else points."""
    figure = _figure(picture, 3.4)
    axes = figure.subplots()
    across, up = picture.axes
    goal, held = picture.goals[0][0], picture.certified
    columns, rows = np.unique(across.places), np.unique(up.places)
    axes.grid(visible=False)
    if len(columns) * len(rows) == len(across.places) and min(len(columns), len(rows)) > 1:
        cells = np.full((len(rows), len(columns)), np.nan)
        cells[np.searchsorted(rows, up.places), np.searchsorted(columns, across.places)] = np.where(
            held, goal.places, np.nan
        )
        # cells of one size, however far apart the values are
        across, up = _by_rank(across, columns), _by_rank(up, rows)
        drawn = axes.pcolormesh(range(len(columns)), range(len(rows)), cells, cmap="viridis", linewidth=0)
    else:
        drawn = axes.scatter(across.places[held], up.places[held], c=goal.places[held], cmap="viridis", s=14)
    axes.plot(across.places[~held], up.places[~held], "x", color=RED, markersize=3.5)
    figure.colorbar(drawn, ax=axes, label=plain(goal.name, 40))
    _mark_best(axes, picture, across.places, up.places)
    _name(axes, across, up)
    return figure


def _pareto(picture: SweepPicture) -> Figure:
    figure = _figure(picture)
    axes = figure.subplots()
    (first, first_up), (second, second_up) = picture.goals[:2]
    signed = np.column_stack([first.places * (-1.0 if first_up else 1.0), second.places * (-1.0 if second_up else 1.0)])
    signed[~picture.certified] = np.nan
    front = pareto_front(signed)
    axes.plot(second.places[picture.certified], first.places[picture.certified], "o", color=GREY, markersize=3)
    order = np.flatnonzero(front)[np.argsort(second.places[front], kind="stable")]
    axes.plot(second.places[order], first.places[order], "-o", color=BLUE, markersize=4, label="Pareto front")
    axes.legend(loc="best")
    _name(axes, second, first)
    return figure


def _mark_best(axes: Axes, picture: SweepPicture, x: np.ndarray, y: np.ndarray) -> None:
    if picture.best is not None:
        place, halo = (x[picture.best], y[picture.best]), [withStroke(linewidth=3, foreground="white")]  # on dark cells
        axes.plot(*place, "o", markersize=9, markerfacecolor="none", color=INK, path_effects=halo)
        axes.annotate(
            "best",
            place,
            xytext=(0, 8),
            textcoords="offset points",
            ha="center",
            size=SMALL,
            color=INK,
            path_effects=halo,
        )


def _name(axes: Axes, across: Scale, up: Scale) -> None:
    axes.set_xlabel(plain(across.name, 44))
    axes.set_ylabel(plain(up.name, 32))
    for scale, axis in ((across, axes.xaxis), (up, axes.yaxis)):
        if scale.words:
            shown = range(0, len(scale.words), -(-len(scale.words) // _MOST_TICKS))
            axis.set_ticks(shown, [plain(scale.words[index], 14) for index in shown])


def _by_rank(scale: Scale, places: np.ndarray) -> Scale:
    """A scale on which its values lie one apart, each with its own name.

    Args:
        scale: of the points.
        places: its values in rising order.
    """
    words = scale.words or tuple(f"{place:.4g}" for place in places)
    return Scale(scale.name, np.searchsorted(places, scale.places).astype(float), words)
