"""Pictures of vessels: the shapes a scenario can name, the elements of one, and a glass on a foot."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.tri import Triangulation

from nospill.plots.style import BLUE, GREY
from nospill.scene.containers.base import Container
from nospill.scene.containers.box import Box
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.vessels import Bowl, ConicalFlask, RoundFlask, Tapered, TestTube, WineGlass
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.meridian_mesh import mesh_liquid
from nospill_docs.pictures.paper import GLASS, LIQUID, note, sheet, sketch, words

SHAPES: dict[str, tuple[Container, float]] = {
    "cylinder": (Cylinder(radius=0.035, height=0.095), 0.06),
    "box": (Box(length=0.09, width=0.06, height=0.07), 0.045),
    "tapered": (Tapered(height=0.11, bottom_radius=0.028, top_radius=0.04), 0.08),
    "bowl": (Bowl(height=0.06, radius=0.055, bottom_radius=0.022), 0.036),
    "wine-glass": (WineGlass(height=0.16, bowl_height=0.09, radius=0.04, rim_radius=0.031, base_radius=0.036), 0.115),
    "conical-flask": (
        ConicalFlask(height=0.13, bottom_radius=0.045, neck_radius=0.015, shoulder_height=0.095),
        0.05,
    ),
    "round-flask": (RoundFlask(height=0.14, radius=0.042, bottom_radius=0.02, neck_radius=0.014), 0.045),
    "test-tube": (TestTube(height=0.12, radius=0.016, base_radius=0.03), 0.075),
}
"""What the picture of shapes shows: each with the height of its liquid, m."""

_SCALE = 1e3


def shapes() -> Figure:
    """Every shape from the side, to one scale, with the first frequency of water in it."""
    figure = sheet(2.7)
    axes = sketch(figure, (0.0, 0.0, 1.0, 1.0), (-50.0, 850.0), (-85.0, 245.0))
    middle = 0.0
    for number, (name, (container, level)) in enumerate(SHAPES.items()):
        middle = 800.0 * (number + 0.5) / len(SHAPES)
        _side(axes, container, level, middle)
        first = container.slosh_modes(LIQUIDS["water"], level, 1).oscillators[0].frequency / (2 * np.pi)
        words(axes, (middle, -32.0), name.replace("-", "-\n"), ha="center", size=8.5, weight="bold")
        words(axes, (middle, -70.0), f"{first:.1f} Hz", ha="center", size=8.5)
    axes.plot([-50.0, 850.0], [0.0, 0.0], color=GREY, linewidth=1.0, zorder=0)
    axes.plot([0.0, 100.0], [215.0, 215.0], color=GREY, linewidth=2.0)
    words(axes, (108.0, 215.0), "100 mm; below each shape the first frequency of the water in it", size=8.5)
    return figure


def _side(axes: Axes, container: Container, level: float, middle: float) -> None:
    base = _SCALE * float(container.footprint.half_lengths[0])
    inside = container.inside * (base, _SCALE)
    heights = np.linspace(inside[0, 1], _SCALE * level, 60)
    width = np.interp(heights, inside[:, 1], inside[:, 0])
    water = np.vstack([np.column_stack([middle - width, heights]), np.column_stack([middle + width, heights])[::-1]])
    axes.add_patch(Polygon(water, facecolor=LIQUID, zorder=1))
    axes.plot([middle - width[-1], middle + width[-1]], 2 * [_SCALE * level], color=BLUE, linewidth=1.6, zorder=3)
    outside = container.outside * (base, _SCALE)
    for side in (-1.0, 1.0):
        axes.plot(middle + side * outside[:, 0], outside[:, 1], color=GLASS, linewidth=1.8, zorder=4)
        axes.plot(middle + side * inside[:, 0], inside[:, 1], color=GLASS, linewidth=1.2, zorder=4)
    axes.plot([middle - base, middle + base], [0.0, 0.0], color=GLASS, linewidth=2.4, zorder=4)


def elements() -> Figure:
    """The triangles of a paper cup and of a wine glass, and what follows from them."""
    figure = sheet(3.1)
    cups = (("tapered", "a paper cup"), ("wine-glass", "a wine glass"))
    for number, (name, title) in enumerate(cups):
        container, level = SHAPES[name]
        assert isinstance(container, Tapered | WineGlass)
        mesh = mesh_liquid(container.meridian, level, 20)
        axes = sketch(figure, (0.01 + 0.5 * number, 0.0, 0.48, 0.9), (-52.0, 82.0), (-10.0, 165.0))
        figure.text(0.25 + 0.5 * number, 0.93, title, ha="center", weight="bold", size=9)
        _side(axes, container, level, 0.0)
        grid = Triangulation(*(_SCALE * mesh.nodes.T), triangles=mesh.triangles[:, :3])
        axes.triplot(grid, color=BLUE, linewidth=0.45, zorder=3)
        found = container.slosh_modes(LIQUIDS["water"], level, 2)
        for mode, size in zip(found.oscillators, (13, 7), strict=True):
            axes.plot(0.0, _SCALE * mode.height, "o", color=BLUE, markeredgecolor="white", markersize=size, zorder=6)
        first = found.oscillators[0]
        note(
            axes,
            (0.0, _SCALE * first.height),
            (46.0, _SCALE * first.height - 22.0),
            f"first mode:\n{100 * first.mass / found.liquid_mass:.0f} % of the\n"
            f"liquid, {first.frequency / (2 * np.pi):.2f} Hz",
        )
    return figure
