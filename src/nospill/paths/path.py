"""Geometric paths of the tray's origin and its yaw, as piecewise polynomials of the path parameter s in [0, 1]."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.piecewise import SAME_KNOT, Pieces, bspline_pieces, interpolating_pieces, refined, spline_of_curve
from nospill.errors import ScenarioError
from nospill.paths.joint_curves import JointCurve
from nospill.paths.path_checks import checked_knots, checked_numbers, checked_point, checked_points, point_text

MAX_INTERPOLATED = 500
"""More interpolated points than this make planning needlessly slow: every span costs time in each of its steps."""

ARC_TOLERANCE = 1e-7
"""Largest distance in m between a circular arc and the spline that stands for it."""

_GAUSS_POINTS = 24


@dataclass(frozen=True, slots=True)
class Path:
    """r(s) and theta_z(s) of the tray frame in the robot's base frame.

    Attributes:
        breaks: (m + 1,) increasing, from 0 to 1.
        coefficients: (degree + 1, m, 4) for x, y, z (m) and yaw (rad); highest power of (s - breaks[i]) first.
            All are at least twice continuously differentiable inside (C2), so that jerk-limited s gives continuous
            acceleration; presets, lines, arcs, waypoints and yaw splines are C3 or better.
        notes: what was assumed or left out when it was made from recorded points, one sentence each, for people.
        joints: joint positions (n,) along it, rad, near which an arm of seven follows it; None where none are known.
        ends: joint positions (n,) in which the arm starts and arrives, rad; None where it may choose.
        joint_curve: the joints along it, where it is a path of the joints: they carry the tray, whose attitude is what
            they make it. None where the tray is level, or tilts by itself, and the arm follows.
    """

    breaks: np.ndarray
    coefficients: np.ndarray
    notes: tuple[str, ...] = ()
    joints: Pieces | None = None
    ends: tuple[np.ndarray | None, np.ndarray | None] = (None, None)
    joint_curve: JointCurve | None = None

    @property
    def prescribed(self) -> Pieces:
        """What s says, in columns: x, y, z and yaw; of a path of the joints the tray's pose and the joints."""
        return Pieces(self.breaks, self.coefficients) if self.joint_curve is None else self.joint_curve.pieces

    def at(self, s: np.ndarray | Sequence[float] | float) -> np.ndarray:
        """Position and yaw at path parameters `s`; outside [0, 1] the end pieces are continued.

        Args:
            s: (m,) path parameters, or one number.

        Returns:
            (m, 4): x, y, z in m and yaw in rad.
        """
        return self.derivative(s, 0)

    def derivative(self, s: np.ndarray | Sequence[float] | float, order: int = 1) -> np.ndarray:
        """Derivative of given order with respect to s, shape (m, 4); at a break the piece to its right counts."""
        return Pieces(self.breaks, self.coefficients)(np.atleast_1d(np.asarray(s, dtype=float)), order)

    @property
    def length(self) -> float:
        """Arc length of the position in m, by Gauss quadrature in every span."""
        nodes, weights = _gauss_rule()
        half = np.diff(self.breaks) / 2
        middle = (self.breaks[1:] + self.breaks[:-1]) / 2
        speed = np.linalg.norm(self.derivative((middle[:, None] + half[:, None] * nodes).ravel())[:, :3], axis=1)
        return float(half @ (speed.reshape(half.size, -1) @ weights))


@lru_cache(maxsize=1)
def _gauss_rule() -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of Gauss quadrature on [-1, 1]."""
    return np.polynomial.legendre.leggauss(_GAUSS_POINTS)


def path_from_bspline(
    control_points: np.ndarray | Sequence[Sequence[float]],
    degree: int,
    *,
    knots: np.ndarray | Sequence[float] | None = None,
    yaw: np.ndarray | Sequence[float] = (0.0, 0.0),
) -> Path:
    """Path from a B-spline.

    The curve is defined on its base interval [knots[degree], knots[-degree - 1]]. If that contains [0, 1], s is the
    knots' own parameter and the curve is restricted to [0, 1]; if not, the knots are shifted and scaled so that it
    becomes [0, 1].

    Args:
        control_points: (n, 3), m.
        degree: polynomial degree, at most n - 1.
        knots: (n + degree + 1,) not decreasing, or None for clamped uniform knots on [0, 1].
        yaw: see `straight_line`.

    Raises:
        ScenarioError: numbers that do not make a B-spline, or one whose second derivative jumps.
    """
    points = checked_points(control_points, "control_points")
    count = len(points)
    if isinstance(degree, bool) or not isinstance(degree, int | np.integer) or not 1 <= degree < count:
        raise ScenarioError(
            f"degree = {degree}: {count} control points allow an integer from 1 to {count - 1}; "
            "add control points or lower it"
        )
    if knots is None:
        vector = np.concatenate((np.zeros(degree), np.linspace(0.0, 1.0, count - degree + 1), np.ones(degree)))
    else:
        vector = checked_knots(knots, count, degree)
    return assembled(bspline_pieces(points, int(degree), vector), yaw_pieces(yaw))


def straight_line(
    start: np.ndarray | Sequence[float],
    end: np.ndarray | Sequence[float],
    *,
    yaw: np.ndarray | Sequence[float] = (0.0, 0.0),
) -> Path:
    """Straight line, linear in s.

    Args:
        start: (3,) first point, m.
        end: (3,) last point, m.
        yaw: two or more angles in rad. Two: linear in s. More: values at equally spaced s, joined by a spline of degree
            5 (fewer than six values: the polynomial through them).

    Raises:
        ScenarioError: numbers that are not finite, or a path that goes nowhere.
    """
    first, last = checked_point(start, "start"), checked_point(end, "end")
    return assembled(Pieces(np.array([0.0, 1.0]), np.array([[last - first], [first]])), yaw_pieces(yaw))


def circular_arc(
    start: np.ndarray | Sequence[float],
    through: np.ndarray | Sequence[float],
    end: np.ndarray | Sequence[float],
    *,
    yaw: np.ndarray | Sequence[float] = (0.0, 0.0),
) -> Path:
    """Circular arc through three points, at constant |dr/ds|.

    A circle is no polynomial: this is a C4 spline of degree 5 on as few equal spans as keep it within 1e-7 m of the
    circle (half a turn of 1 m radius takes 12).

    Args:
        start: (3,) first point, m.
        through: (3,) a point on the way, m.
        end: (3,) last point, m.
        yaw: see `straight_line`.

    Raises:
        ScenarioError: points that coincide or lie on one line.
    """
    first, middle, last = (
        checked_point(point, name) for point, name in ((start, "start"), (through, "through"), (end, "end"))
    )
    to_middle, to_last = middle - first, last - first
    normal = np.cross(to_middle, to_last)
    size = np.linalg.norm(to_middle) * np.linalg.norm(to_last) * np.linalg.norm(last - middle)
    if np.linalg.norm(normal) <= 1e-6 * max(np.linalg.norm(to_middle), np.linalg.norm(to_last)) ** 2 or size == 0.0:
        raise ScenarioError(
            f"arc with start {point_text(first)}, through {point_text(middle)}, end {point_text(last)}: the points "
            "coincide or lie on one line; move `through` off the line, or use a line"
        )
    # Circumcentre of the triangle, from the two perpendicular bisectors in its plane.
    to_centre = (
        np.cross(normal, to_middle) * (to_last @ to_last) - np.cross(normal, to_last) * (to_middle @ to_middle)
    ) / (2 * normal @ normal)
    centre = first + to_centre
    radius = float(np.linalg.norm(to_centre))
    along = -to_centre / radius
    across = np.cross(normal / np.linalg.norm(normal), along)
    angle = math.atan2((last - centre) @ across, (last - centre) @ along) % (2 * math.pi)

    def circle(s: np.ndarray, order: int) -> np.ndarray:
        phase = angle * s[:, None] + order * math.pi / 2
        return (centre if order == 0 else 0.0) + radius * angle**order * (
            np.cos(phase) * along + np.sin(phase) * across
        )

    pieces = spline_of_curve(circle, tolerance=ARC_TOLERANCE)
    if pieces is None:
        raise ScenarioError(f"arc: radius {radius:.6g} m is too large to follow within 1e-7 m; use a line or waypoints")
    return assembled(pieces, yaw_pieces(yaw))


def _arc_control_points() -> np.ndarray:
    """Every hundredth of 1000 samples of the tilted semicircle, first and last included: the published arc."""
    angle = np.linspace(0.0, np.pi, 1000)[[0, *range(99, 1000, 100)]]
    tilt, radius = np.radians(30.0), 0.6
    return np.column_stack(
        (
            0.7508 - radius + radius * np.sin(angle) * np.cos(tilt),
            -radius * np.cos(angle),
            1.2176 + radius * np.sin(angle) * np.sin(tilt),
        )
    )


def _offsets(origin: Sequence[float], x: Sequence[float], y: Sequence[float], z: Sequence[float]) -> np.ndarray:
    return np.asarray(origin) + np.column_stack(np.broadcast_arrays(x, y, z))


PRESETS: dict[str, Callable[[], np.ndarray]] = {
    "arc": _arc_control_points,
    "ark": lambda: _offsets((0.6, 0.7, 1.4), (0, 0.25, 0.5, 0.25, 0), (0, -0.2, -0.7, -1.2, -1.4), (0,)),
    "pp": lambda: _offsets(
        (0.9, 0.0, 1.4),
        (0, -0.1, -0.2, -0.2, -0.2, -0.6, -0.7, -0.7, -0.7),
        (0, 0, 0, 0.5, 0.6, 0.7, 0.7, 0.8, 0.9),
        (0,),
    ),
    "sl": lambda: _offsets((0.6, 0.4, 1.2), (0,), (0, -0.2, -0.4, -0.6, -0.8), (0,)),
    "sl3d": lambda: _offsets((1.1, 0.6, 1.1), (0,), (0, -0.1, -0.6, -1.1, -1.2), (0, 0.1, 0.2, 0.2, 0.2)),
}
"""Name -> B-spline control points (n, 3) in m of the paths published by LAR-IRMA (MATRIX project, D3)."""


def preset_path(
    name: str, *, yaw: np.ndarray | Sequence[float] = (0.0, 0.0), offset: np.ndarray | Sequence[float] = (0.0, 0.0, 0.0)
) -> Path:
    """One of the published paths, as a B-spline of degree 4.

    The knots of `arc` are the published ones, four of them 0.001 outside each end. For the others degree and knots are
    not published; assumed here: degree 4 and clamped uniform knots, which for five points is a Bezier curve.

    Args:
        name: key of `PRESETS`.
        yaw: see `straight_line`.
        offset: (3,) shift of the whole path, m.

    Raises:
        ScenarioError: an unknown name.
    """
    if name not in PRESETS:
        raise ScenarioError(f"path preset {name!r} is unknown; choose one of {', '.join(PRESETS)}")
    points = PRESETS[name]() + checked_point(offset, "offset")
    knots = np.concatenate((np.full(4, -0.001), np.linspace(0.0, 1.0, 8), np.full(4, 1.001))) if name == "arc" else None
    return path_from_bspline(points, 4, knots=knots, yaw=yaw)


def yaw_pieces(yaw: object) -> Pieces:
    """Yaw over s from two or more angles, see `straight_line`."""
    values = checked_numbers(yaw, "yaw")
    if values.ndim != 1 or values.size < 2:
        raise ScenarioError(f"yaw: shape {values.shape}; two or more angles are needed (start, ..., end)")
    if values.size == 2:
        return Pieces(np.array([0.0, 1.0]), np.array([[[values[1] - values[0]]], [[values[0]]]]))
    if values.size > MAX_INTERPOLATED:
        raise ScenarioError(f"yaw: {values.size} values, at most {MAX_INTERPOLATED} are allowed; keep fewer")
    return interpolating_pieces(np.linspace(0.0, 1.0, values.size), values[:, None])


def assembled(position: Pieces, turning: Pieces, notes: tuple[str, ...] = ()) -> Path:
    """The path of position (m) and yaw (rad): on the union of their breaks, with the larger of their degrees."""
    merged = np.union1d(position.breaks, turning.breaks)
    breaks = merged[np.append(True, np.diff(merged) > SAME_KNOT)]
    breaks[-1] = 1.0
    degree = max(len(position.coefficients), len(turning.coefficients)) - 1
    coefficients = np.concatenate(
        (refined(position, breaks, degree=degree), refined(turning, breaks, degree=degree)), axis=2
    )
    if np.max(np.abs(coefficients[:-1])) <= SAME_KNOT:
        raise ScenarioError("the path neither moves nor turns; give it points that differ or a yaw that changes")
    return Path(read_only(breaks), read_only(coefficients), notes)
