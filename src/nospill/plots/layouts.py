"""Figure: the tray before and after a search for a better layout, and the motions that were planned on the way."""

from __future__ import annotations

import os
from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from nospill.plots.comparison import save_figure
from nospill.plots.style import BLUE, GREY, SMALL, WIDTH
from nospill.plots.tray_plan import draw_tray
from nospill.scene.scene import Scene

_LETTERS = 8
"""Of a name on its object."""


def save_layout(
    before: tuple[Scene, float | None],
    after: tuple[Scene, float],
    durations: Sequence[float | None],
    path: str | os.PathLike[str],
) -> None:
    """Draw a layout and write it; the format follows the ending (.png, .pdf, .svg).

    Args:
        before: the scene as stated and its duration, s, None where it has no certified motion.
        after: the same of the best layout.
        durations: of every layout that was planned, in their order, s; None where it has no certified motion.
        path: of the file.

    Raises:
        ScenarioError: another ending. PlanFolderError: the file cannot be written.
    """
    save_figure(lambda: layout_figure(before, after, durations), path)


def layout_figure(
    before: tuple[Scene, float | None], after: tuple[Scene, float], durations: Sequence[float | None]
) -> Figure:
    """Both trays from above, and below them the durations of all that was planned; arguments as of `save_layout`."""
    figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=(3, 2))
    panels = [figure.add_subplot(grid[0, column]) for column in range(2)]
    for axes, (scene, duration), what in zip(panels, (before, after), ("as stated", "best"), strict=True):
        axes.set_aspect("equal")
        draw_tray(axes, scene)
        for cargo in (item for item in scene.cargo if not item.carrier):
            x, y = 1e3 * cargo.position
            axes.text(x, y, cargo.name[:_LETTERS], size=SMALL, ha="center", va="center")
        axes.set_title(f"{what}: {'no motion' if duration is None else f'{duration:.3f} s'}")
        axes.set_xlabel("x of the tray [mm]")
    panels[0].set_ylabel("y of the tray [mm]")
    axes = figure.add_subplot(grid[1, :])
    numbers = [index for index, duration in enumerate(durations, start=1) if duration is not None]
    known = [duration for duration in durations if duration is not None]
    axes.plot(numbers, known, color=GREY, marker="o", markersize=3, linestyle="none", label="planned")
    best = [min(known[: index + 1]) for index in range(len(known))]
    axes.step(numbers, best, where="post", color=BLUE, label="best so far")
    axes.set_xlabel("layouts planned")
    axes.set_ylabel("duration [s]")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(frameon=False)
    return figure
