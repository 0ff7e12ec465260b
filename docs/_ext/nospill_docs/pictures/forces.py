"""Pictures of frames, apparent gravity and the forces under an object."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from nospill.plots.style import BLACK, BLUE, DARK_RED, GREEN, GREY, ORANGE, PURPLE, RED
from nospill_docs.pictures.paper import BOARD, arrow, board, cup, note, sheet, sketch, words


def frames() -> Figure:
    """Base, flange, tray and container frames on one arm, from the side."""
    figure = sheet(3.3)
    axes = sketch(figure, (0.0, 0.0, 1.0, 1.0), (-1.2, 8.6), (-0.35, 4.0))
    axes.plot([-1.2, 8.6], [-0.02, -0.02], color=GREY, linewidth=1.0)
    links = np.array([[0.0, 0.0], [0.0, 1.0], [-0.2, 2.6], [1.75, 1.2], [3.9, 0.75]])
    axes.plot(*links.T, color="#B0B5BB", linewidth=13, solid_capstyle="round", solid_joinstyle="round", zorder=1)
    axes.plot(*links[1:].T, "o", color="#6F767D", markersize=8, zorder=2)
    axes.plot([3.9, 3.9], [0.75, 1.8], color="#8A9096", linewidth=8, zorder=1)
    board(axes, 1.75, at=(3.9, 1.95))
    cup(axes, radius=0.32, height=0.95, level=0.6, foot=(5.15, 1.95))
    axes.add_patch(Polygon([[2.4, 1.95], [3.0, 1.95], [3.0, 2.6], [2.4, 2.6]], facecolor="#8F80A0", zorder=2))
    for place, name, tail in (
        ((0.0, 0.0), "base", "foot of the robot, z against gravity"),
        ((3.9, 1.0), "flange", "end of the chain"),
        ((3.9, 1.95), "tray", "middle of the upper surface"),
        ((5.15, 1.95), "container", "middle of the bottom, z to the rim"),
    ):
        _axes(axes, place)
        at = {"base": (0.85, 0.45), "flange": (4.75, 1.15), "tray": (2.3, 3.1), "container": (5.75, 2.3)}[name]
        words(axes, at, name, weight="bold", size=9.5)
        words(axes, (at[0], at[1] - 0.22), tail, size=8)
    arrow(axes, (7.6, 1.5), (7.6, 0.6), color=BLACK)
    words(axes, (7.7, 1.05), "gravity $g$")
    words(axes, (0.14, 0.6), "z", size=8)
    words(axes, (0.5, 0.14), "x", size=8)
    words(axes, (5.6, 3.7), "path $r(s)$ of the tray's origin", size=8, color=DARK_RED)
    s = np.linspace(0.0, 1.0, 60)
    axes.plot(
        3.9 + 4.0 * s, 1.95 + 1.45 * np.sin(2.2 * s), color=DARK_RED, linewidth=1.2, linestyle=(0, (5, 1.6)), zorder=0
    )
    return figure


def _axes(axes: Axes, place: tuple[float, float], length: float = 0.62) -> None:
    arrow(axes, place, (place[0] + length, place[1]), color=BLUE)
    arrow(axes, place, (place[0], place[1] + length), color=GREEN)
    axes.plot(*place, "o", color=BLACK, markersize=3.5, zorder=7)


def apparent_gravity() -> Figure:
    """The same acceleration on a level and on a tilted tray: what is left across the tray."""
    figure = sheet(3.1)
    lean = np.arctan2(3.4, 9.81)
    for number, (angle, title) in enumerate(((0.0, "level tray"), (float(lean), "tray tilted into the acceleration"))):
        axes = sketch(figure, (0.5 * number, 0.0, 0.5, 0.9), (-3.3, 3.6), (-2.2, 3.6))
        figure.text(0.25 + 0.5 * number, 0.94, title, ha="center", weight="bold", size=9)
        # The surface is across the apparent gravity; on a tray that is tilted by its lean it is level in the cup.
        slope = 0.0 if angle else -3.4 / 9.81
        turned = -angle
        board(axes, 1.7, angle=turned)
        turn = cup(axes, radius=0.75, height=2.1, level=1.25, slope=slope, angle=turned)
        middle = turn @ (0.0, 1.05)
        arrow(axes, (1.6, 3.0), (2.7, 3.0), color=BLACK)
        words(axes, (1.6, 3.3), "acceleration $\\ddot p$", size=8.5)
        down = middle + np.array([-0.85, -2.45])
        arrow(axes, tuple(middle), (middle[0], middle[1] - 2.45), color=GREY)
        words(axes, (middle[0] + 0.08, middle[1] - 2.0), "gravity $g$", size=8.5)
        arrow(axes, tuple(middle), (middle[0] - 0.85, middle[1]), color=GREY)
        words(axes, (middle[0] - 0.9, middle[1] + 0.02), "$-\\ddot p$", ha="right", size=8.5)
        arrow(axes, tuple(middle), tuple(down), color=RED, width=2.2)
        words(axes, (down[0] - 0.02, down[1] + 0.5), "apparent\ngravity $-b$", ha="right", color=DARK_RED, size=8.5)
        said = (
            "runs up the wall; friction carries $m\\ddot p$"
            if not angle
            else "flat in its cup; friction carries nothing"
        )
        words(axes, (0.2, -2.0), said, ha="center", size=8.5)
    return figure


def forces_on_a_cup() -> Figure:
    """What the tray must supply (left), and the four budgets that limit it (right)."""
    figure = sheet(3.5)
    axes = sketch(figure, (0.0, 0.0, 0.5, 1.0), (-2.9, 2.9), (-1.5, 3.9))
    board(axes, 2.5)
    cup(axes, radius=1.0, height=3.0, level=1.9, slope=-0.28)
    arrow(axes, (0.0, 3.5), (1.1, 3.5))
    words(axes, (-0.1, 3.5), "acceleration", ha="right")
    arrow(axes, (0.0, 1.2), (0.0, 0.0), color=GREY)
    axes.plot(0.0, 1.2, "o", color=BLACK, markersize=5, zorder=7)
    words(axes, (0.12, 0.75), "weight", size=8.5)
    axes.plot(-0.35, 1.5, "o", color=BLUE, markersize=9, zorder=7)
    note(axes, (-0.35, 1.5), (1.25, 2.3), "mass of a\nmode, with\nits own phase")
    arrow(axes, (-0.45, -1.05), (-0.45, 0.0), color=GREEN, width=2.2)
    words(axes, (-0.6, -0.9), "$N$ presses", ha="right", color="#006B4E")
    arrow(axes, (-0.45, -0.07), (0.75, -0.07), color=ORANGE, width=2.2)
    words(axes, (0.8, -0.35), "$F_{xy}$ friction", color="#8A5F00")
    note(axes, (-0.45, 0.0), (-2.75, 1.1), "centre of\npressure $c$")
    budgets = sketch(figure, (0.5, 0.0, 0.5, 1.0), (-2.6, 3.6), (-2.0, 3.8))
    for row, (name, says) in enumerate(
        (
            ("lift", "$N \\geq 0$: the tray presses"),
            ("slip", "$F_x^2 + F_y^2 + (T/r)^2 \\leq (\\mu N)^2$"),
            ("tip", "$c$ inside the footprint, less its reserve"),
            ("twist", "$|M_z| \\leq \\frac{2}{3}\\,\\mu N R$"),
        )
    ):
        words(budgets, (-2.5, 3.5 - 0.45 * row), name, weight="bold")
        words(budgets, (-1.6, 3.5 - 0.45 * row), says)
    budgets.add_patch(Circle((0.0, -0.2), 1.5, facecolor=BOARD, edgecolor=GREY, linewidth=1.2))
    budgets.add_patch(Circle((0.0, -0.2), 1.42, fill=False, edgecolor=RED, linewidth=1.2, linestyle=(0, (4, 1.5))))
    budgets.plot(-0.7, 0.1, "x", color=BLACK, markersize=7, zorder=7)
    arrow(budgets, (-0.7, 0.1), (0.35, 0.45), color=ORANGE, width=2.2)
    arrow(budgets, (-0.2, 0.1), (-1.0, 0.5), color=PURPLE, bend=-0.9)
    words(budgets, (-0.75, -0.15), "$c$")
    words(budgets, (-0.15, 0.75), "$F_{xy}$", color="#8A5F00")
    words(budgets, (-0.35, -0.55), "$T$ turns about $c$", color="#7A3F60")
    note(budgets, (1.35, 0.25), (1.75, 0.9), "footprint less\nits reserve", color=DARK_RED)
    words(budgets, (0.0, -1.88), "the footprint from above", ha="center", size=8.5)
    return figure


def friction_lever() -> Figure:
    """How the lever of friction shrinks towards the edge, and what is left of the friction set there."""
    figure = sheet(2.7)
    lever, body = figure.subplots(1, 2)
    figure.subplots_adjust(left=0.075, right=0.985, top=0.88, bottom=0.17, wspace=0.25)
    away = np.linspace(0.0, 1.0, 300)
    a, b = 1.0 - away, 0.03 * np.sqrt(1.0 + away**2)
    lever.plot(away, 0.5 * (a + b + np.sqrt((a - b) ** 2 + 0.01**2)), color=BLUE, label="used here")
    lever.plot(away, 1.0 - away, color=BLACK, linestyle=(0, (5, 1.6)), linewidth=1.0, label="$1-\\varepsilon$")
    lever.axvline(0.95, color=RED, linewidth=1.2)
    lever.annotate(
        "limit of tip\nwith its reserve",
        (0.95, 0.55),
        xytext=(-4, 0),
        textcoords="offset points",
        ha="right",
        size=8,
        color=DARK_RED,
    )
    lever.set_title("Lever of friction against turning")
    lever.set_xlabel("distance of $c$ from the middle, of the footprint [1]")
    lever.set_ylabel("lever over $r_0$ [1]")
    lever.legend(loc="lower left")
    lever.set_xlim(0.0, 1.0)
    lever.set_ylim(0.0, 1.05)
    for epsilon, colour, dashes in ((0.0, BLUE, "-"), (0.5, GREEN, (0, (5, 1.6))), (0.9, PURPLE, (0, (1.3, 1.3)))):
        force = np.linspace(-1.0, 1.0, 201)
        moment = (1.0 - epsilon) * np.sqrt(1.0 - force**2)
        body.plot(
            np.append(force, force[::-1]),
            np.append(moment, -moment),
            color=colour,
            linestyle=dashes,
            label=f"$\\varepsilon$ = {epsilon:g}",
        )
    body.set_title("Force and moment it can supply together")
    body.set_xlabel("$F_x/(\\mu N)$ [1]")
    body.set_ylabel("$T/(\\mu N r_0)$ [1]")
    body.legend(loc="center", handlelength=2.2)
    return figure
