"""Paths of the joints: curves near the straight ways between points, and what they carry as polynomials of s.

Between two points the joints move straight, as planners of paths check it. A corner is rounded, or the joints stop at
it. The rounded curve is the smoothest within the distances allowed (`smoothing`), where no point is a corner and 64
even spans are enough for it; else Schoenberg's variation diminishing spline of the polygon [de Boor, A Practical Guide
to Splines, ch. XI]: of degree 5 on spans that are short where corners are sharp, its control points on the polygon at
the knots' averages. That one lies on a straight way where it is longer than six spans, and crosses no plane more often
than the polygon.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nospill.core.piecewise import SAME_KNOT, Pieces, bspline_pieces, interpolating_pieces
from nospill.errors import ScenarioError
from nospill.paths.smoothing import smooth_curve

POSE = 12
"""Columns of the tray: its position and, row by row, its rotation to the base."""

MOST_SPANS = 400
"""Of a curve: every span costs time in each step of planning."""

_DEGREE = 5
_WIDEST = 0.4
"""rad; length of a span to begin with."""
_FEWEST = 8
_PROBES = 8
"""Places in a span at which it is compared with the polygon."""
_HALVINGS = 14
_DENSE, _TIGHTENINGS = 401, 4
"""Places of the polygon near which the smoothest curve passes, and distances of the joints that are tried."""
_GRADED = 2.5
"""Most times as long as its neighbour a span is."""
_STRAIGHT = 1e-6
"""Of the way to the next point but one; a point that is this near to the straight line there is no corner."""
_TURN = np.radians(10.0)
"""A turn that counts as a corner in what is said."""

Gap = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Joint positions (m, n) of a curve and of the polygon, rad -> largest distance of a joint, rad, of the tray, m."""


@dataclass(frozen=True, slots=True, eq=False)
class JointCurve:
    """A path of the joints, and the tray that they carry along it.

    Attributes:
        pieces: of s in [0, 1], columns (12 + n): position of the tray, m, its rotation to the base row by row, and the
            joints, rad; C2, the joints C4 where they do not stop.
    """

    pieces: Pieces

    @property
    def joints(self) -> Pieces:
        """The joints (n) alone, rad."""
        return Pieces(self.pieces.breaks, self.pieces.coefficients[:, :, POSE:])

    def rates(self, s: np.ndarray) -> tuple[np.ndarray, ...]:
        """Joint positions and their derivatives by s to the third, (m, n) each, rad, at s (m,)."""
        return tuple(self.joints(s, order) for order in range(4))

    def poses(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (m, 3), m, and rotations (m, 3, 3) of the tray at s (m,)."""
        values = Pieces(self.pieces.breaks, self.pieces.coefficients[:, :, :POSE])(s)
        return values[:, :3], values[:, 3:].reshape(-1, 3, 3)

    @property
    def lean(self) -> np.ndarray:
        """Angle of the tray's axis from the vertical at the breaks (m + 1,), rad."""
        return np.arccos(np.clip(self.poses(self.pieces.breaks)[1][:, 2, 2], -1.0, 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class JoinedPoints:
    """A curve by way of points.

    Attributes:
        joints: of s in [0, 1], (n) columns, rad.
        s: (m,) where the points are on it.
        angle: largest distance of a joint from the straight ways, rad.
        length: largest distance of the tray from where it is on them, m.
        at: s of the place where the one or the other is largest, as parts of what is allowed.
    """

    joints: Pieces
    s: np.ndarray
    angle: float
    length: float
    at: float


def rounded(points: np.ndarray, sizes: np.ndarray, gap: Gap, angle: float, length: float) -> JoinedPoints:
    """The straight ways between points, every corner rounded within a distance of joints and of the tray.

    Args:
        points: (m, n) joint positions, rad; neighbours differ.
        sizes: (n,) way of each joint that counts as one, rad.
        gap: distance of joints and of the tray from where they are on the straight ways.
        angle: largest distance of a joint, rad.
        length: largest distance of the tray, m.

    Raises:
        ScenarioError: so many corners that no curve of a reasonable number of spans keeps the distances.
    """
    if len(_corners(points)) == 2:
        way = np.stack([points[-1] - points[0], points[0]])[:, None, :]
        return JoinedPoints(Pieces(np.array([0.0, 1.0]), way), _chords(points, sizes), 0.0, 0.0, 0.0)
    at = _chords(points, sizes)
    smooth = None if len(corners_of(points, sizes)) else _smoothest(points, at, gap, angle, length)
    if smooth is not None:
        return smooth
    longest = float(np.abs(np.diff(points, axis=0)).sum(axis=0).max())
    breaks = np.linspace(0.0, 1.0, max(_FEWEST, int(np.ceil(longest / _WIDEST))) + 1)
    for _ in range(_HALVINGS):
        if len(breaks) > MOST_SPANS:
            break
        knots = np.concatenate([np.zeros(_DEGREE), breaks, np.ones(_DEGREE)])
        averages = np.array([knots[index + 1 : index + 1 + _DEGREE].mean() for index in range(len(breaks) + 4)])
        pieces = bspline_pieces(_on(points, at, averages), _DEGREE, knots)
        inner = (np.arange(_PROBES) + 0.5) / _PROBES
        s = np.sort(np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * inner).ravel(), at))
        joints, tray = gap(pieces(s), _on(points, at, s))
        share = np.maximum(joints / angle, tray / length)
        if np.all(share <= 1.0):
            worst = int(np.argmax(share))
            return JoinedPoints(pieces, at, float(joints.max()), float(tray.max()), float(s[worst]))
        broken = np.zeros(len(breaks) - 1, dtype=bool)
        broken[np.clip(np.searchsorted(breaks, s[share > 1.0], side="right") - 1, 0, len(breaks) - 2)] = True
        breaks = _halved(breaks, broken)
    raise ScenarioError(
        f"{len(points)} points turn so often that no curve of {MOST_SPANS} pieces stays within "
        f"{np.degrees(angle):.3g} deg and {1e3 * length:.3g} mm of the straight ways between them; widen "
        "joint_tolerance and tray_tolerance, or give fewer points"
    )


def _smoothest(points: np.ndarray, at: np.ndarray, gap: Gap, angle: float, length: float) -> JoinedPoints | None:
    """The smoothest curve within the distances, by fewer of the joints' where the tray's asks for it; None without."""
    places = np.linspace(0.0, 1.0, _DENSE)
    places = places if len(points) > _DENSE else np.unique(np.concatenate([places, at]))
    straight, tolerance = _on(points, at, places), angle
    for _ in range(_TIGHTENINGS):
        found = smooth_curve(straight, tolerance)
        if found is None:
            return None
        joints, tray = gap(found.pieces(found.s), straight)
        share = np.maximum(joints / angle, tray / length)
        if np.all(share <= 1.0):
            worst = int(np.argmax(share))
            of_points = np.interp(at, places, found.s)
            return JoinedPoints(found.pieces, of_points, float(joints.max()), float(tray.max()), float(found.s[worst]))
        tolerance *= max(0.9 / float(share.max()), 0.1)
    return None


def stopping(points: np.ndarray, sizes: np.ndarray) -> JoinedPoints:
    """The straight ways between points themselves, on which the joints stop at every corner.

    Each way is a polynomial 10 x^3 - 15 x^4 + 6 x^5: whatever its speed, s passes a corner with the joints at rest.
    Points on a straight way are no corners. Arguments as of `rounded`.
    """
    kept = _corners(points)
    chords = np.linalg.norm(np.diff(points[kept], axis=0) / sizes, axis=1)
    s = np.concatenate([[0.0], np.cumsum(np.cbrt(chords))])
    s /= s[-1]
    s[-1] = 1.0
    width = np.diff(s)[:, None]
    way, none = np.diff(points[kept], axis=0), np.zeros((len(kept) - 1, points.shape[1]))
    coefficients = np.stack(
        [6.0 * way / width**5, -15.0 * way / width**4, 10.0 * way / width**3, none, none, points[kept][:-1]]
    )
    return JoinedPoints(Pieces(s, coefficients), s, 0.0, 0.0, 0.0)


def interpolated(points: np.ndarray, sizes: np.ndarray, gap: Gap) -> JoinedPoints:
    """The C4 spline of degree 5 through all points, over their chords; arguments as of `rounded`."""
    at = _chords(points, sizes)
    pieces = interpolating_pieces(at, points)
    s = np.linspace(0.0, 1.0, _PROBES * len(points) + 1)
    joints, tray = gap(pieces(s), _on(points, at, s))
    return JoinedPoints(pieces, at, float(joints.max()), float(tray.max()), float(s[np.argmax(joints)]))


def corners_of(points: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Indices of the points at which the way turns noticeably."""
    steps = np.diff(points, axis=0) / sizes
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    turn = np.arccos(np.clip(np.sum(steps[1:] * steps[:-1], axis=1), -1.0, 1.0))
    return np.flatnonzero(turn > _TURN) + 1


def _corners(points: np.ndarray) -> np.ndarray:
    """Indices of the points that are not on the straight line from the kept one before to the next."""
    kept = [0]
    for index in range(1, len(points) - 1):
        before, way = points[index] - points[kept[-1]], points[index + 1] - points[kept[-1]]
        square = float(way @ way)
        part = float(before @ way) / square if square > 0.0 else 0.0
        if not 0.0 < part < 1.0 or np.linalg.norm(before - part * way) > _STRAIGHT * np.sqrt(square):
            kept.append(index)
    return np.array([*kept, len(points) - 1])


def _chords(points: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Where each point is along the straight ways (m,), from 0 to 1, their lengths in sizes."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0) / sizes, axis=1))])
    return along / along[-1]


def _on(points: np.ndarray, at: np.ndarray, s: np.ndarray) -> np.ndarray:
    return np.column_stack([np.interp(s, at, column) for column in points.T])


def _halved(breaks: np.ndarray, broken: np.ndarray) -> np.ndarray:
    """Breaks with the broken spans halved, and the long ones beside short ones."""
    found = np.sort(np.concatenate([breaks, 0.5 * (breaks[:-1] + breaks[1:])[broken]]))
    while True:
        width = np.diff(found)
        beside = np.minimum(np.append(np.inf, width[:-1]), np.append(width[1:], np.inf))
        long = width > _GRADED * beside + SAME_KNOT
        if not long.any():
            return found
        found = np.sort(np.concatenate([found, 0.5 * (found[:-1] + found[1:])[long]]))
