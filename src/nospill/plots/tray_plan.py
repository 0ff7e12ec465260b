"""Figure: the tray from above with what stands on it, to scale."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from nospill.plots.evidence import Evidence
from nospill.plots.style import BLUE, DARK_RED, GREY, INK, ORANGE, SMALL, WIDTH, headline, plain
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene

_LEFT, _RIGHT, _TOP, _BOTTOM = 0.62, 0.3, 0.5, 0.68
_TALLEST = 4.4
"""in; a tray that is much deeper than wide is drawn smaller."""


def tray_plan_figure(evidence: Evidence) -> Figure:
    """The tray's outline, every footprint and widest section with name and fill height, x and y in mm, tray frame."""
    scene = evidence.plan.scene
    sides = 1.08e3 * scene.tray.size
    width = min(WIDTH - _LEFT - _RIGHT, _TALLEST * float(sides[0] / sides[1]))
    height = width * float(sides[1] / sides[0])
    total = _TOP + height + _BOTTOM
    figure = Figure(figsize=(WIDTH, total))
    headline(figure, evidence, "Tray from above, to scale", left=0.1 / WIDTH, y=1 - 0.06 / total)
    left = (WIDTH + _LEFT - _RIGHT - width) / 2
    axes = figure.add_axes((left / WIDTH, _BOTTOM / total, width / WIDTH, height / total))
    draw_tray(axes, scene)
    for cargo in scene.cargo:
        if not cargo.carrier:
            _write_on(axes, cargo, width / sides[0])
    axes.set_xlabel("x of the tray [mm]")
    axes.set_ylabel("y of the tray [mm]")
    key = "full line: liquid, fill of rim height in mm; dashed: solid; thin: widest section; arrow: x"
    figure.text(0.5, 0.08 / total, key, size=SMALL, ha="center", va="bottom", color=INK)
    return figure


def draw_tray(axes: Axes, scene: Scene) -> None:
    """The tray's outline with every footprint and widest section, its middle and x axis, mm."""
    sides, half = 1.08e3 * scene.tray.size, 1e3 * scene.tray.size / 2
    axes.add_patch(
        Rectangle((-half[0], -half[1]), 2 * half[0], 2 * half[1], facecolor="#F4F7FA", edgecolor=INK, linewidth=1.1)
    )
    for cargo in scene.cargo:
        widest = float(np.max(cargo.container.outside[:, 0]))
        fill, edge, dashes = ("#CFE3F2", BLUE, "-") if cargo.filling else ("#ECECEC", GREY, (0, (4, 1.5)))
        for part, look in ((1.0, {"facecolor": fill, "linewidth": 1.2}), (widest, {"fill": False, "linewidth": 0.7})):
            outline = 1e3 * footprint_outline(cargo, part=part)
            axes.add_patch(Polygon(outline, edgecolor=edge, linestyle=dashes, **look))
    axes.annotate(
        "", (0.3 * half[0], 0), (0, 0), arrowprops={"arrowstyle": "-|>", "color": ORANGE, "linewidth": 1.6}, zorder=1.5
    )
    axes.plot(0, 0, marker="+", color=DARK_RED, markersize=7)
    axes.set_xlim(-sides[0] / 2, sides[0] / 2)
    axes.set_ylim(-sides[1] / 2, sides[1] / 2)


def _write_on(axes: Axes, cargo: Cargo, scale: float) -> None:
    """Name and fill of an object; `scale`: inches a millimetre."""
    outline, middle = 1e3 * footprint_outline(cargo), 1e3 * cargo.position
    width_shown = float(np.ptp(outline[:, 0])) * scale
    across = "center" if cargo.contents is None else "top"
    lines = [plain(cargo.name, max(int(width_shown / 0.075), 5))]
    if cargo.contents is not None:
        # what stands in it takes its middle
        middle = np.array([middle[0], np.min(outline[:, 1])])
        lines = [f"{lines[0]}, {len(cargo.contents.content)} in it"]
    elif cargo.filling:
        lines.append(f"{1e3 * cargo.filling.liquid_height:.3g} of {1e3 * cargo.container.height:.3g}")
    else:
        lines.append(f"{1e3 * cargo.container.height:.3g} high")
    told = {"fixed": cargo.fixed, "lid": cargo.filling is not None and cargo.filling.lid}
    lines += [", ".join(word for word, holds in told.items() if holds)] if any(told.values()) else []
    axes.text(middle[0], middle[1], "\n".join(lines), size=SMALL, ha="center", va=across)


def footprint_outline(cargo: Cargo, *, part: float = 1.0) -> np.ndarray:
    """Outline of an object's bottom in the tray frame, (n, 2) m; with `part`, of a section so many times as large."""
    c, s = np.cos(cargo.yaw), np.sin(cargo.yaw)
    return cargo.position + part * cargo.container.outline @ np.array([[c, s], [-s, c]])
