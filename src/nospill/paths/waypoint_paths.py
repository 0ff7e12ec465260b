"""Paths through waypoints: interpolated where they are few, smoothed where they were recorded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from nospill.core.piecewise import SAME_KNOT, Pieces, interpolating_pieces
from nospill.errors import ScenarioError
from nospill.paths.blended_lines import blended_lines, farthest_from_lines
from nospill.paths.path import MAX_INTERPOLATED, Path, assembled, yaw_pieces
from nospill.paths.path_checks import checked_numbers, checked_points, point_text
from nospill.paths.smoothing import SmoothCurve, closest_curve, smooth_curve

MAX_WAYPOINTS = 20_000
"""Most points that are smoothed."""

SMOOTHING = 2e-5
"""Tolerance of the smoothing where none is given, m: the digits points are written with."""

_LEVER = 0.2
"""m; a yaw of 1 rad counts as this distance from a recorded pose: what it moves the edge of a tray by."""
_ROUGH = 30.0
"""Largest third derivative of the interpolating curve over that of the smooth one near it, for it to be refused."""
_FEWEST_RECORDED = 30
_MEANT = 0.01
"""Fewer points than these, or points farther from a smooth curve than this part of the path's extent, are not recorded
but chosen: however sharply they turn, it is meant."""
_PROBES = 2001
_SAME_PLACE = 1e-5
"""m; two points nearer than this are one: no arm repeats a place to that."""
_MUCH = 0.1
"""Part of a line's length by which a curve may leave it without advice."""


def path_through_waypoints(
    points: np.ndarray | Sequence[Sequence[float]],
    *,
    yaw: np.ndarray | Sequence[float] = (0.0, 0.0),
    yaw_at_points: np.ndarray | Sequence[float] | None = None,
    smoothing: float | None = None,
    blend: float | None = None,
) -> Path:
    """Path through points: a smoothing spline where one passes them closely enough, else the C4 spline of degree 5.

    The interpolating spline runs over the chord length; 2 to 5 points give one polynomial. Points that repeat the one
    before are left out; the path's notes say so, what the smoothing does, and how far the curve leaves the straight
    lines between the points. With `blend` the path is these lines with rounded corners.

    Args:
        points: (n, 3), m.
        yaw: see `straight_line`.
        yaw_at_points: (n,) yaw at each point, rad, in place of `yaw`.
        smoothing: largest distance of a point from the path, m (0.2 m times a yaw's error counts as one); 0
            interpolates. None: `SMOOTHING`, and points that it is too little for are interpolated.
        blend: distance from a corner within which it is rounded, m; no smoothing then.

    Raises:
        ScenarioError: too few or too many points, numbers that are not finite; points that no smooth curve passes
            within the tolerance, or that scatter so much that a curve through all of them asks for many times the
            acceleration.
    """
    places = checked_points(points, "waypoints")
    angles = None if yaw_at_points is None else checked_numbers(yaw_at_points, "yaw_at_points")
    if angles is not None and angles.shape != (len(places),):
        raise ScenarioError(f"yaw_at_points: {angles.size} angles for {len(places)} points; one a point is needed")
    if len(places) > MAX_WAYPOINTS:
        raise ScenarioError(f"waypoints: {len(places)} points, at most {MAX_WAYPOINTS} are allowed; keep fewer")
    places, angles, notes = _without_repetitions(places, angles)
    poses = places if angles is None else np.column_stack([places, _LEVER * angles])
    if blend is not None:
        if smoothing is not None:
            raise ScenarioError("blend and smoothing: both are given; blend rounds the corners of lines, keep one")
        places, angles, notes = _without_neighbours(places, angles, notes)
        if len(places) > MAX_INTERPOLATED:
            raise ScenarioError(f"blend: {len(places)} points, at most {MAX_INTERPOLATED} are joined by lines")
        poses = places if angles is None else np.column_stack([places, _LEVER * angles])
        return _path(blended_lines(poses, blend), yaw, angles, notes)
    tolerance = SMOOTHING if smoothing is None else smoothing
    smooth = smooth_curve(poses, tolerance) if tolerance > 0.0 else None
    if smooth is not None:
        spans = len(smooth.pieces.breaks) - 1
        notes.append(
            f"a smooth curve of {spans} spans joins the {len(places)} waypoints, at most "
            f"{1e3 * smooth.deviation:.3g} mm off them (waypoint {smooth.at + 1})"
        )
        curve = smooth.pieces
    else:
        _refuse_roughness(poses, tolerance, smoothing)
        if len(places) > MAX_INTERPOLATED:
            raise _too_rough(poses, tolerance)
        places, angles, notes = _without_neighbours(places, angles, notes)
        poses = places if angles is None else np.column_stack([places, _LEVER * angles])
        s = _chord_parameters(places)
        curve = interpolating_pieces(s, poses)
        notes += _lines_note(curve, places, s)
    return _path(curve, yaw, angles, notes)


def _path(curve: Pieces, yaw: np.ndarray | Sequence[float], angles: np.ndarray | None, notes: Sequence[str]) -> Path:
    """The path of a curve of places, and of angles times `_LEVER` where the points have some."""
    position = Pieces(curve.breaks, curve.coefficients[:, :, :3])
    turning = yaw_pieces(yaw) if angles is None else Pieces(curve.breaks, curve.coefficients[:, :, 3:] / _LEVER)
    return assembled(position, turning, tuple(notes))


def _without_neighbours(
    places: np.ndarray, angles: np.ndarray | None, notes: Sequence[str]
) -> tuple[np.ndarray, np.ndarray | None, list[str]]:
    """The points without those that are the one before but for what no arm repeats: a curve would swing between them.

    The last point stays, and the one before it goes.
    """
    kept = [0]
    for index in range(1, len(places)):
        if np.linalg.norm(places[index] - places[kept[-1]]) > _SAME_PLACE:
            kept.append(index)
    if kept[-1] != len(places) - 1:
        kept[-1] = len(places) - 1
    if len(kept) == len(places) or len(kept) < 2:
        return places, angles, list(notes)
    missing = sorted(set(range(len(places))) - set(kept))
    said = f"{len(missing)} waypoints within {1e3 * _SAME_PLACE:g} mm of the one before are left out"
    if len(missing) == 1:
        said = f"waypoint {missing[0] + 1} is within {1e3 * _SAME_PLACE:g} mm of its neighbour and is left out"
    return places[kept], None if angles is None else angles[kept], [*notes, said]


def _lines_note(curve: Pieces, places: np.ndarray, s: np.ndarray) -> list[str]:
    """How far the curve leaves the straight lines between the points, and what keeps to them where that is much."""
    if len(places) < 3:
        return []
    farthest, at = farthest_from_lines(curve, places, s)
    if farthest <= _SAME_PLACE:
        return []
    length = float(np.linalg.norm(places[at + 1] - places[at]))
    note = (
        f"the curve through the waypoints leaves the straight lines between them by up to {1e3 * farthest:.3g} mm, "
        f"between waypoints {at + 1} and {at + 2}, which are {1e3 * length:.3g} mm apart"
    )
    return [f"{note}; blend keeps to the lines and rounds their corners" if farthest > _MUCH * length else note]


def path_through_poses(poses: np.ndarray, joints: np.ndarray | None = None) -> Path:
    """Path through poses at even path parameters, by the C4 spline of degree 5, as smooth as they are.

    Args:
        poses: (n, 4), x, y, z, m, and yaw, rad; a tray may turn where it stands.
        joints: (n, joints) of an arm of seven that holds the tray at them, rad.

    Raises:
        ScenarioError: numbers that are not finite, or too few or too many; a path that goes nowhere.
    """
    places, yaw = checked_points(poses[:, :3], "way"), checked_numbers(poses[:, 3], "way_yaw")
    s = np.linspace(0.0, 1.0, len(places))
    path = assembled(interpolating_pieces(s, places), interpolating_pieces(s, yaw[:, None]))
    return path if joints is None else replace(path, joints=interpolating_pieces(s, joints))


def _without_repetitions(
    places: np.ndarray, angles: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray | None, list[str]]:
    """The points without those that repeat the one before, and a note where there are any."""
    chords = np.linalg.norm(np.diff(places, axis=0), axis=1)
    repeated = np.flatnonzero(chords <= SAME_KNOT * max(1.0, float(chords.sum()))) + 1
    if not repeated.size:
        return places, angles, []
    kept = np.setdiff1d(np.arange(len(places)), repeated)
    if len(kept) < 2:
        raise ScenarioError(
            f"waypoints: all {len(places)} are the same point {point_text(places[0])}; give two or more"
        )
    if angles is not None and len(kept) < len(places):
        turned = float(np.abs(np.diff(angles))[repeated - 1].max())
        if turned > 1e-3:
            raise ScenarioError(
                f"waypoints: the tray turns by {np.degrees(turned):.3g} deg at one point "
                f"{point_text(places[repeated[0]])}; a path turns while it moves"
            )
    several = f"{len(repeated)} waypoints repeat the one before, the first of them waypoint {repeated[0] + 1}, and are"
    one = f"waypoint {repeated[0] + 1} repeats the one before and is"
    note = f"{one if len(repeated) == 1 else several} left out"
    return places[kept], None if angles is None else angles[kept], [note]


def _chord_parameters(places: np.ndarray) -> np.ndarray:
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))))
    return along / along[-1]


def _refuse_roughness(poses: np.ndarray, tolerance: float, smoothing: float | None) -> None:
    """Raise the error for points that a curve through all of them, or near them, would have to shake for."""
    if smoothing is not None and smoothing > 0.0:
        raise _too_rough(poses, tolerance)
    closest = closest_curve(poses, tolerance) if smoothing is None and len(poses) >= _FEWEST_RECORDED else None
    extent = float(np.linalg.norm(np.ptp(poses, axis=0)))
    if closest is None or closest.deviation > _MEANT * extent or len(poses) > MAX_INTERPOLATED:
        return
    wide = smooth_curve(poses, 1.2 * closest.deviation)
    if wide is None:
        return
    s = np.linspace(0.0, 1.0, _PROBES)
    through = interpolating_pieces(_chord_parameters(poses[:, :3]), poses)
    first, second, third = (through(s, order)[:, :3] for order in (1, 2, 3))
    ratio = np.abs(third).max() / np.abs(wide.pieces(s, 3)[:, :3]).max()
    if ratio > _ROUGH:
        speed = np.linalg.norm(first, axis=1)
        bend = np.linalg.norm(np.cross(first, second), axis=1)
        radii = speed**3 / np.maximum(bend, 1e-12)
        sharpest = int(np.argmin(radii))
        acceleration = np.abs(second).max() / np.abs(wide.pieces(s, 2)[:, :3]).max()
        raise ScenarioError(
            f"waypoints: the {len(poses)} points scatter by up to {1e3 * closest.deviation:.2g} mm about a smooth "
            f"curve; a path through all of them turns within {1e3 * radii[sharpest]:.2g} mm at s = {s[sharpest]:.2f} "
            f"and asks for {acceleration:.2g} times the acceleration; give {_suggestion(closest)}, or smoothing = 0 "
            "to pass through every point"
        )


def _too_rough(poses: np.ndarray, tolerance: float) -> ScenarioError:
    closest = closest_curve(poses, tolerance)
    if closest is None:
        return ScenarioError(
            f"smoothing {1e3 * tolerance:g} mm: {len(poses)} waypoints are too few to be smoothed (18 are needed); "
            "leave smoothing out, they are interpolated"
        )
    return ScenarioError(
        f"waypoints: no smooth curve passes all {len(poses)} within {1e3 * tolerance:g} mm; on "
        f"{len(closest.pieces.breaks) - 1} spans the closest is {1e3 * closest.deviation:.3g} mm off at waypoint "
        f"{closest.at + 1} (s = {closest.s[closest.at]:.2f}); give {_suggestion(closest)} or mend that point"
    )


def _suggestion(closest: SmoothCurve) -> str:
    return f'smoothing = "{1.2e3 * closest.deviation:.2g} mm"'
