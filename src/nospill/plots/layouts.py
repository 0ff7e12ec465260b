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
    after: tuple[Scene, float | None],
    tried: Sequence[float | None],
    path: str | os.PathLike[str],
    *,
    margin: bool = False,
) -> None:
    """Draw a layout and write it; the format follows the ending (.png, .pdf, .svg).

    Args:
        before: the scene as stated and its duration, s, or its margin; None where it has no certified motion.
        after: the same of the best layout.
        tried: the same of every layout that was planned, in their order.
        path: of the file.
        margin: whether the numbers are margins, of which the greatest is best.

    Raises:
        ScenarioError: another ending. PlanFolderError: the file cannot be written.
    """
    save_figure(lambda: layout_figure(before, after, tried, margin=margin), path)


def layout_figure(
    before: tuple[Scene, float | None],
    after: tuple[Scene, float | None],
    tried: Sequence[float | None],
    *,
    margin: bool = False,
) -> Figure:
    """Both trays from above, and below them what was found of all layouts; arguments as of `save_layout`."""
    figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=(3, 2))
    panels = [figure.add_subplot(grid[0, column]) for column in range(2)]
    told, best_of = (_margin, max) if margin else (_seconds, min)
    for axes, (scene, number), what in zip(panels, (before, after), ("as stated", "best"), strict=True):
        axes.set_aspect("equal")
        draw_tray(axes, scene)
        for cargo in (item for item in scene.cargo if not item.carrier):
            x, y = 1e3 * cargo.position
            axes.text(x, y, cargo.name[:_LETTERS], size=SMALL, ha="center", va="center")
        axes.set_title(f"{what}: {'no motion' if number is None else told(number)}")
        axes.set_xlabel("x of the tray [mm]")
    panels[0].set_ylabel("y of the tray [mm]")
    axes = figure.add_subplot(grid[1, :])
    numbers = [index for index, value in enumerate(tried, start=1) if value is not None]
    known = [100.0 * value if margin else value for value in tried if value is not None]
    axes.plot(numbers, known, color=GREY, marker="o", markersize=3, linestyle="none", label="planned")
    best = [best_of(known[: index + 1]) for index in range(len(known))]
    axes.step(numbers, best, where="post", color=BLUE, label="best so far")
    axes.set_xlabel("layouts planned")
    axes.set_ylabel("margin [%]" if margin else "duration [s]")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(frameon=False)
    return figure


def _seconds(duration: float) -> str:
    return f"{duration:.3f} s"


def _margin(part: float) -> str:
    return f"margin {part:.1%}"
