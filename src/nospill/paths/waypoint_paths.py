"""Paths through waypoints: interpolated where they are few, smoothed where they were recorded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from nospill.core.piecewise import SAME_KNOT, Pieces, interpolating_pieces
from nospill.errors import ScenarioError
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


def path_through_waypoints(
    points: np.ndarray | Sequence[Sequence[float]],
    *,
    yaw: np.ndarray | Sequence[float] = (0.0, 0.0),
    yaw_at_points: np.ndarray | Sequence[float] | None = None,
    smoothing: float | None = None,
) -> Path:
    """Path through points: a smoothing spline where one passes them closely enough, else the C4 spline of degree 5.

    The interpolating spline runs over the chord length; 2 to 5 points give one polynomial. Points that repeat the one
    before are left out; the path's notes say so, and what the smoothing does.

    Args:
        points: (n, 3), m.
        yaw: see `straight_line`.
        yaw_at_points: (n,) yaw at each point, rad, in place of `yaw`.
        smoothing: largest distance of a point from the path, m (0.2 m times a yaw's error counts as one); 0
            interpolates. None: `SMOOTHING`, and points that it is too little for are interpolated.

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
        curve = interpolating_pieces(_chord_parameters(places), poses)
    position = Pieces(curve.breaks, curve.coefficients[:, :, :3])
    turning = yaw_pieces(yaw) if angles is None else Pieces(curve.breaks, curve.coefficients[:, :, 3:] / _LEVER)
    return assembled(position, turning, tuple(notes))


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
