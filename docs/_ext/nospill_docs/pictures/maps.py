"""Maps: what the commands do, what lies in a plan folder, the tables of a scenario."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nospill.plans.plan import Plan
from nospill.plots.style import BLUE, DARK_RED, GREEN, GREY, ORANGE
from nospill.plots.tray_plan import footprint_outline
from nospill_docs.pictures.paper import BOARD, GLASS, LIQUID, arrow, box, note, sheet, sketch, words


def commands() -> Figure:
    """From the scenario to the plan folder, and what reads it."""
    figure = sheet(2.75)
    axes = sketch(figure, (0.0, 0.0, 1.0, 1.0), (0.0, 7.4), (0.0, 2.75))
    _station(axes, (0.05, 1.0), (1.35, 0.75), "scenario", "one TOML file", face="#F6EEDD")
    arrow(axes, (1.4, 1.375), (2.6, 1.375))
    words(axes, (2.0, 1.52), "plan", ha="center", weight="bold")
    words(axes, (2.0, 1.2), "studio", ha="center", size=8.5)
    _station(axes, (2.65, 1.0), (1.45, 0.75), "plan folder", "motion, certificate", face="#E4EDF4")
    readers = (
        ("look", "view, film, plot, report"),
        ("judge", "check, executed, verify, margins"),
        ("hand over", "export: URScript, ROS 2, CSV, MAT"),
    )
    for row, (name, what) in enumerate(readers):
        y = 2.1 - 0.95 * row
        _station(axes, (4.95, y - 0.1), (2.4, 0.65), name, what)
        arrow(axes, (4.1, 1.375), (4.93, y + 0.225), color=GREY)
    words(axes, (0.05, 0.62), "also: slow, examples, robots, schema, cache, identify;", size=8.5)
    words(axes, (0.05, 0.4), "simulate and compare work on one container, without a plan.", size=8.5)
    return figure


def _station(
    axes: Axes, corner: tuple[float, float], size: tuple[float, float], name: str, what: str, *, face: str = "#F4F7FA"
) -> None:
    box(axes, corner, size, face=face)
    middle = corner[0] + size[0] / 2
    words(axes, (middle, corner[1] + 0.66 * size[1]), name, ha="center", weight="bold")
    words(axes, (middle, corner[1] + 0.3 * size[1]), what, ha="center", size=8.5)


def plan_folder() -> Figure:
    """The files of a plan folder, and who reads each."""
    figure = sheet(2.5)
    axes = sketch(figure, (0.0, 0.0, 1.0, 1.0), (0.0, 7.4), (0.0, 2.5))
    box(axes, (0.05, 0.08), (2.55, 2.34), face="#E4EDF4")
    words(axes, (0.2, 2.2), "out/tea/", weight="bold", family="DejaVu Sans Mono")
    rows = (
        (("scenario.toml", "trajectory.csv"), "nospill check: the judge needs these two, nothing else", BLUE),
        (
            ("certificate.json", "summary.json"),
            "programs: every row; duration, largest figures, what holds it back",
            GREEN,
        ),
        (("robot.csv",), "the controller; other formats: nospill export", ORANGE),
        (("figures/",), "people: summary.png, and all figures after nospill plot", GREY),
    )
    y = 1.9
    for names, reader, colour in rows:
        top = y
        for name in names:
            words(axes, (0.4, y), name, family="DejaVu Sans Mono", size=9)
            y -= 0.29
        middle = (top + y + 0.29) / 2
        arrow(axes, (2.65, middle), (3.15, middle), color=colour)
        words(axes, (3.25, middle), reader, size=8.5)
        y -= 0.04
    return figure


def scenario(plan: Plan) -> Figure:
    """A scenario from above, with the table that says each thing."""
    figure = sheet(3.3)
    scene = plan.scene
    axes = sketch(figure, (0.0, 0.0, 1.0, 1.0), (-0.5, 1.68), (-0.58, 0.4))
    points = scene.path.at(np.linspace(0.0, 1.0, 100))[:, :3]
    # Turned, so that a path from left to right lies across the page.
    line = np.column_stack([points[:, 1], 0.75 - points[:, 0]]) * (1.0, -1.0) + (0.55, 0.0)
    axes.plot(*line.T, color=DARK_RED, linewidth=1.4, linestyle=(0, (5, 1.6)), zorder=1)
    half = scene.tray.size / 2
    start = line[0]
    board = start + np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    axes.fill(*board.T, facecolor=BOARD, edgecolor="#8C7B5C", zorder=2)
    centres = []
    for cargo in scene.cargo:
        outline = footprint_outline(cargo) + start
        axes.fill(*outline.T, facecolor=LIQUID, edgecolor=GLASS, linewidth=1.6, zorder=3)
        centres.append(cargo.position + start)
        words(axes, tuple(centres[-1]), cargo.name, ha="center", size=8.5)
    axes.plot(0.55, -0.5, "s", color="#6F767D", markersize=13)
    axes.plot(
        [0.55, 0.3, start[0]],
        [-0.5, -0.35, start[1] - half[1]],
        color="#B0B5BB",
        linewidth=9,
        zorder=0,
        solid_joinstyle="round",
    )
    note(axes, (0.55, -0.5), (0.68, -0.5), "[robot]  model, base, limits", weight="bold")
    note(axes, tuple(line[60]), (0.75, 0.2), "[path]  where the middle of the tray goes", weight="bold")
    note(axes, tuple(board[3]), (-0.5, 0.32), "[tray]  size, friction, offset", weight="bold")
    note(
        axes,
        tuple(centres[0] + (0.0, 0.02)),
        (0.25, 0.33),
        "[[cargo]]  place, shape, liquid, how high it may rise",
        weight="bold",
    )
    for y, text in (
        (-0.16, "[motion]  may the tray tilt, how does it end"),
        (-0.25, "[tolerance]  which numbers may be off"),
        (-0.34, "[approach]  the way to the start"),
    ):
        words(axes, (0.68, y), text, weight="bold", size=8.5)
    return figure
