"""Figure: what arm, tray and cargo sweep, from above and from the side, with the obstacles and the straight line."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from matplotlib.patheffects import withStroke

from nospill.collisions.bodies import Body, scene_bodies
from nospill.collisions.swept import outline, swept_outlines
from nospill.plots.evidence import Evidence
from nospill.plots.style import BLACK, BLUE, GREY, SMALL, WIDTH, headline, plain

_INSTANTS = 60
_ARM, _LOAD = "#D5D9DE", "#B9D8EE"
_MARGIN = 0.06
"""m; round what is swept."""
_LEFT, _RIGHT, _TOP, _GAP, _BOTTOM = 0.55, 0.12, 0.92, 0.62, 0.44
_HIGHEST = 3.4
"""in; of the view from above."""


def swept_volume_figure(evidence: Evidence) -> Figure | None:
    """Two views of what is swept, one above the other on the same scale; None without obstacles."""
    scene, played = evidence.plan.scene, evidence.judgement.replay
    if not scene.has_surroundings:
        return None
    t = np.linspace(played.t[0], played.t[-1], _INSTANTS)
    q = np.stack([np.interp(t, played.t, column) for column in played.joint_position.T], axis=1)
    line = played.tray.position
    along = _along(line)
    planes = {
        "from above": np.array([along, np.cross([0.0, 0.0, 1.0], along)]),
        "from the side": np.array([along, [0.0, 0.0, 1.0]]),
    }
    swept = [swept_outlines(scene, q, plane) for plane in planes.values()]
    extents = [_extent(areas) for areas in swept]
    across = (extents[0][1] - extents[0][0])[0]
    inner = min(WIDTH - _LEFT - _RIGHT, _HIGHEST * across / max((high - low)[1] for low, high in extents))
    heights = [inner * float((high - low)[1] / across) for low, high in extents]
    total = _TOP + sum(heights) + _GAP + _BOTTOM
    figure = Figure(figsize=(WIDTH, total))
    headline(figure, evidence, "Swept volume", left=0.1 / WIDTH, y=1 - 0.06 / total)
    top = total - _TOP
    still = [body for body in scene_bodies(scene) if body.obstacle is not None]
    for (name, plane), areas, (low, high), height in zip(planes.items(), swept, extents, heights, strict=True):
        axes = figure.add_axes((_LEFT / WIDTH, (top - height) / total, inner / WIDTH, height / total))
        _draw(axes, areas, still, line @ plane.T, plane)
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        axes.set_title(name)
        axes.set_ylabel("height [m]" if name == "from the side" else "to the left [m]")
        top -= height + _GAP
    figure.axes[-1].set_xlabel("along the way from start to end [m]")
    figure.legend(
        handles=[
            Patch(facecolor=_LOAD, label="tray and cargo"),
            Patch(facecolor=_ARM, label="arm"),
            Patch(facecolor="none", edgecolor=BLACK, hatch="////", label="obstacles"),
            Line2D([], [], color=BLUE, label="tray's centre"),
            Line2D([], [], color=GREY, linestyle="--", label="straight line"),
        ],
        loc="upper left",
        bbox_to_anchor=(0.06 / WIDTH, 1 - 0.42 / total),
        ncols=3,
        fontsize=SMALL,
        borderaxespad=0.0,
        labelspacing=0.25,
        columnspacing=1.2,
        handlelength=1.8,
    )
    return figure


def _along(line: np.ndarray) -> np.ndarray:
    """Level direction (3,) from the start of a motion to its end, or to the place farthest from the start."""
    way = (line[-1] - line[0]) * [1.0, 1.0, 0.0]
    if np.linalg.norm(way) < 0.1:
        gaps = (line - line[0]) * [1.0, 1.0, 0.0]
        way = gaps[int(np.argmax(np.linalg.norm(gaps, axis=1)))]
    length = float(np.linalg.norm(way))
    return way / length if length > 1e-6 else np.array([1.0, 0.0, 0.0])


def _extent(areas: dict[bool, list[np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner (2,) of what is shown, m."""
    points = np.concatenate([*areas[False], *areas[True]])
    return points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN


def _draw(
    axes: Axes, areas: dict[bool, list[np.ndarray]], still: list[Body], line: np.ndarray, plane: np.ndarray
) -> None:
    for on_path, colour in ((False, _ARM), (True, _LOAD)):
        # All edges first, then all areas over them: what stays of the edges is the outline of the union.
        axes.add_collection(PolyCollection(areas[on_path], facecolors="none", edgecolors=GREY, linewidths=1.2))
        axes.add_collection(PolyCollection(areas[on_path], facecolors=colour, edgecolors=colour, linewidths=0.2))
    for body in still:
        if body.shape.kind != "halfspace":
            corners = outline(body, plane)
            axes.add_patch(Polygon(corners, facecolor="none", edgecolor=BLACK, hatch="////", linewidth=0.8, alpha=0.7))
            middle = corners.mean(axis=0)
            text = axes.annotate(plain(body.name, 16), middle, ha="center", va="center", size=SMALL, clip_on=True)
            text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])
        elif plane[1] @ body.rotation[:, 2] > 1.0 - 1e-9:
            axes.axhspan(-1e3, float(body.position[2]), facecolor="none", edgecolor=BLACK, hatch="////", alpha=0.7)
    axes.plot(*line.T, color=BLUE)
    axes.plot(*line[[0, -1]].T, color=GREY, linestyle="--", marker="o", markersize=3)
    axes.set_aspect("equal", adjustable="box")
