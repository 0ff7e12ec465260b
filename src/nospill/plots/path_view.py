"""The path in three dimensions, with the tray drawn at a few places on it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MultipleLocator
from mpl_toolkits.mplot3d import proj3d
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from nospill.drawing.obstacles import OBSTACLE, obstacle_mesh
from nospill.plots.evidence import Evidence
from nospill.plots.style import BLUE, GREY, ORANGE, SMALL, WIDTH, headline
from nospill.plots.tray_plan import footprint_outline
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scene.scene import Scene

DOT_INTERVAL = 0.1
"""s between the dots on the path."""

_ELEVATION = 30.0
_TICK_STEPS = (0.2, 0.1, 0.05)
"""m, between ticks of the upright axis: the longest that gives two at least."""
_GIVEN_POINTS = 201
_KEY_WIDTH = 4.6
"""in; what the key below the picture takes on one line."""
_ARM, _SHOWN = "#C3C8CE", 0.32
"""Colour of the arm below the tray, and how much of it is drawn, m."""
_OBSTACLE = (*(channel / 255 for channel in OBSTACLE), 0.22)
"""Colour of obstacles, through which the rest is seen."""
_MARGIN = 0.45
"""in; kept free round the box for ticks and labels."""


def path_figure(evidence: Evidence) -> Figure:
    """The path alone, as one figure."""
    figure = Figure(figsize=(WIDTH, 3.7))
    headline(figure, evidence, "Path of the tray", left=0.1 / WIDTH, y=1 - 0.06 / 3.7)
    draw_path(figure, evidence, (0.01, 0.02, 0.98, 0.85))
    return figure


def draw_path(figure: Figure, evidence: Evidence, place: tuple[float, float, float, float]) -> Any:
    """Path of the tray with its outline, the objects' footprints and its x axis at up to six places.

    Args:
        figure: where to draw.
        evidence: the plan.
        place: left, bottom, width, height in fractions of the figure.

    Returns:
        The axes, base frame, m.
    """
    played, scene = evidence.judgement.replay, evidence.plan.scene
    line = played.tray.position
    # Axes in three dimensions are typed as those of a plane, so Any.
    axes: Any = figure.add_axes(place, projection="3d", computed_zorder=False)
    instants = _instants(evidence)
    half = scene.tray.size / 2
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * half
    footprints = [footprint_outline(cargo) for cargo in scene.cargo]
    outlines = [_on_tray(evidence, index, corners) for index in instants]
    reach = 1.35 * half[0]
    head = np.array([[1.2, 0.0], [1.0, 0.11], [1.0, -0.11]]) * reach
    wrists = _wrists(evidence, instants)
    points = np.vstack([line, *outlines, *wrists, *(item.position for item in scene.motion.via)])
    low, high = points.min(axis=0) - 0.03, points.max(axis=0) + 0.03
    # Never flatter than a third, so that the ticks of a level path stay apart.
    high[2] = max(high[2], low[2] + 0.3 * float(np.max(high - low)))
    shadow = np.column_stack([line[:, :2], np.full(len(line), low[2])])

    for obstacle in scene.obstacles:
        mesh = obstacle_mesh(obstacle) if obstacle.shape.kind != "halfspace" else None
        if mesh is not None:
            faces = np.clip(mesh.vertices, low, high)[mesh.faces]  # what is beyond the picture lies in its sides
            axes.add_collection3d(
                Poly3DCollection(faces, facecolors=_OBSTACLE, linewidths=0, zorder=1.2, clip_on=False)
            )
    for wrist in wrists:
        axes.plot(*wrist.T, color=_ARM, linewidth=4.5, solid_capstyle="round", zorder=1.5, clip_on=False)
    axes.plot(*shadow.T, color="#BBBBBB", linewidth=1.0, zorder=1, clip_on=False)
    for index, outline in zip(instants, outlines, strict=True):
        bases = [_on_tray(evidence, index, footprint) for footprint in footprints]
        # One collection each: with different numbers of corners, Matplotlib reads memory that nobody has written.
        for shape, fill, edge in (
            (outline, "#DDE9F3C0", "#333333"),
            *((base, "#FFFFFFD0", "#666666") for base in bases),
        ):
            axes.add_collection3d(
                Poly3DCollection([shape], facecolors=fill, edgecolors=edge, linewidths=0.7, zorder=2, clip_on=False)
            )
        shaft = _on_tray(evidence, index, np.array([[0.0, 0.0], [reach, 0.0]]))
        axes.add_collection3d(Line3DCollection([shaft], colors=ORANGE, linewidths=1.6, zorder=3, clip_on=False))
        tip = _on_tray(evidence, index, head)
        axes.add_collection3d(Poly3DCollection([tip], facecolors=ORANGE, linewidths=0, zorder=3, clip_on=False))
    given = _given_path(scene)
    if given is not None:
        axes.plot(*given.T, color=GREY, linewidth=1.2, linestyle="--", zorder=4, clip_on=False)
    for item in scene.motion.via:
        axes.plot(*np.array(item.position)[:, None], marker="o", markersize=8, fillstyle="none", color=GREY, zorder=4)
    axes.plot(*line.T, color=BLUE, linewidth=1.8, zorder=4, clip_on=False)
    dots = np.searchsorted(played.t, np.arange(0.0, evidence.end_time, DOT_INTERVAL))
    axes.plot(*line[dots].T, linestyle="", marker="o", markersize=3, color=BLUE, zorder=5, clip_on=False)
    # A rim of paper round the letters hides less of the tray below them than a box.
    halo, place_of_text = [withStroke(linewidth=2.2, foreground="white")], {"ha": "center", "va": "bottom"}
    for index in instants:
        text = f"{min(played.t[index], evidence.end_time):.2f} s"
        axes.text(*line[index] + [0.0, 0.0, 0.1], text, size=SMALL, zorder=8, path_effects=halo, **place_of_text)
    for set_limits, start, stop in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), low, high, strict=True):
        set_limits(start, stop)
    key = f"dots every {DOT_INTERVAL:g} s; arrows: x axis of the tray; grey: the arm below it, path at the bottom"
    key += "; dashed: way" if given is not None else ""
    key += "; rings: places to pass" if scene.motion.via else ""
    if place[2] * figure.get_size_inches()[0] < _KEY_WIDTH or scene.motion.via:
        key = key.replace("; grey", ";\ngrey")
    figure.text(place[0] + place[2] / 2, place[1], key, size=SMALL, ha="center", va="bottom", color="#333333")
    _dress(axes)
    _fit(figure, axes, place, low, high, azimuth=_azimuth(line))
    return axes


def _given_path(scene: Scene) -> np.ndarray | None:
    """The given path (m, 3), m, where the tray may leave it."""
    if scene.motion.corridor is None:
        return None
    return scene.path.at(np.linspace(0.0, 1.0, _GIVEN_POINTS))[:, :3]


def _instants(evidence: Evidence) -> np.ndarray:
    """Indices into the replay at equal steps of the path parameter, as many as leave space between the trays."""
    trajectory, scene = evidence.plan.trajectory, evidence.plan.scene
    count = int(np.clip(scene.path.length // (1.2 * float(np.max(scene.tray.size))) + 1, 2, 6))
    times = np.interp(np.linspace(0.0, 1.0, count), np.maximum.accumulate(trajectory.s), trajectory.t)
    times[0] = 0.0
    played = evidence.judgement.replay.t
    return np.minimum(np.searchsorted(played, times), len(played) - 1)


def _wrists(evidence: Evidence, instants: np.ndarray) -> list[np.ndarray]:
    """The arm's joints at some instants from the tray backwards as far as is drawn, as lines (n, 3), m."""
    played = evidence.judgement.replay
    frames = joint_frames(arm_chain(evidence.plan.scene.robot), played.joint_position[instants])
    lines = np.stack([played.tray.position[instants], *frames.position[:0:-1]], axis=1)
    wrists = []
    for line in lines:
        gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        stops = np.append(gone[gone < _SHOWN], _SHOWN)
        wrists.append(np.column_stack([np.interp(stops, gone, line[:, axis]) for axis in range(3)]))
    return wrists


def _on_tray(evidence: Evidence, index: int, outline: np.ndarray) -> np.ndarray:
    """Points (n, 2) on the tray's surface at one instant of the replay, in the base frame, (n, 3) m."""
    tray = evidence.judgement.replay.tray
    return tray.position[index] + outline @ tray.rotation[index][:, :2].T


def _azimuth(line: np.ndarray) -> float:
    """Direction to look from, deg: across the way from start to end, on the side that shows most of the path's bend."""
    way = line[-1] - line[0]
    if np.hypot(way[0], way[1]) < 0.2:
        way = line[np.argmax(np.linalg.norm(line - line[0], axis=1))] - line[0]
    ahead = float(np.degrees(np.arctan2(way[1], way[0])))
    elevation = np.radians(_ELEVATION)

    def bend(azimuth: float) -> float:
        angle = np.radians(azimuth)
        toward = np.array([np.cos(elevation) * np.cos(angle), np.cos(elevation) * np.sin(angle), np.sin(elevation)])
        seen = (line - line.mean(axis=0)) @ (np.eye(3) - np.outer(toward, toward))
        return round(float(np.linalg.svd(seen, compute_uv=False)[1]), 2)

    return max((ahead - 65.0, ahead - 115.0, ahead + 65.0, ahead + 115.0), key=bend)


def _dress(axes: Any) -> None:
    """Quiet panes and ticks, names with units."""
    for axis, name in zip((axes.xaxis, axes.yaxis, axes.zaxis), "xyz", strict=True):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.set_label_text(f"{name} [m]", size=8)
        axis.set_tick_params(labelsize=7.5, pad=-2)
        # The label of the upright axis stands across its ticks and would be far off.
        axis.labelpad = -7 if name == "z" else -3
        axis.line.set_color(GREY)
        axis.set_major_locator(MultipleLocator(0.2))
    low, high = axes.get_zlim()
    step = max((step for step in _TICK_STEPS if (high - low) / step >= 2.5), default=_TICK_STEPS[-1])
    axes.zaxis.set_major_locator(MultipleLocator(step))


def _fit(
    figure: Figure,
    axes: Any,
    place: tuple[float, float, float, float],
    low: np.ndarray,
    high: np.ndarray,
    *,
    azimuth: float,
) -> None:
    """Equal scales, and the box as large as the place allows, in its middle."""
    axes.set_proj_type("ortho")
    axes.view_init(elev=_ELEVATION, azim=azimuth)
    axes.set_box_aspect(high - low)
    axes.apply_aspect()
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    x, y, z = corners.T
    across, up, _ = proj3d.proj_transform(x, y, z, axes.get_proj())
    pixels = axes.transData.transform(np.column_stack([across, up])) / figure.dpi
    size = np.array(figure.get_size_inches())
    space = np.array(place[2:]) * size - 2 * _MARGIN
    zoom = float(np.min(space / np.ptp(pixels, axis=0)))
    axes.set_box_aspect(high - low, zoom=zoom)
    # Zooming is about the middle of the axes; move that so that the box's middle falls into the middle of the place.
    middle = axes.get_position().get_points().mean(axis=0) * size
    offset = zoom * ((pixels.max(axis=0) + pixels.min(axis=0)) / 2 - middle)
    axes.set_position((place[0] - offset[0] / size[0], place[1] - offset[1] / size[1], place[2], place[3]))
