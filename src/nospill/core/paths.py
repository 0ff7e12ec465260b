"""Geometric paths of the tray's origin and its yaw, as piecewise polynomials of the path parameter s in [0, 1]."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.files import UnreadableError, bounded_text
from nospill.core.piecewise import SAME_KNOT, Pieces, bspline_pieces, interpolating_pieces, refined, spline_of_curve
from nospill.core.units import as_written
from nospill.errors import ScenarioError

MAX_WAYPOINTS = 500
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
    """

    breaks: np.ndarray
    coefficients: np.ndarray

    def at(self, s: np.ndarray | float) -> np.ndarray:
        """Position and yaw at path parameters `s`; outside [0, 1] the end pieces are continued.

        Args:
            s: (m,) path parameters, or one number.

        Returns:
            (m, 4): x, y, z in m and yaw in rad.
        """
        return self.derivative(s, 0)

    def derivative(self, s: np.ndarray | float, order: int = 1) -> np.ndarray:
        """Derivative of given order with respect to s, shape (m, 4); at a break the piece to its right counts."""
        return Pieces(self.breaks, self.coefficients)(np.atleast_1d(np.asarray(s, dtype=float)), order)

    @property
    def length(self) -> float:
        """Arc length of the position in m, by Gauss quadrature in every span."""
        nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
        half = np.diff(self.breaks) / 2
        middle = (self.breaks[1:] + self.breaks[:-1]) / 2
        speed = np.linalg.norm(self.derivative((middle[:, None] + half[:, None] * nodes).ravel())[:, :3], axis=1)
        return float(half @ (speed.reshape(half.size, -1) @ weights))


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
    points = _checked_points(control_points, "control_points")
    count = len(points)
    if isinstance(degree, bool) or not isinstance(degree, int | np.integer) or not 1 <= degree < count:
        raise ScenarioError(
            f"degree = {degree}: {count} control points allow an integer from 1 to {count - 1}; "
            "add control points or lower it"
        )
    if knots is None:
        vector = np.concatenate((np.zeros(degree), np.linspace(0.0, 1.0, count - degree + 1), np.ones(degree)))
    else:
        vector = _checked_knots(knots, count, degree)
    return _assemble(bspline_pieces(points, int(degree), vector), yaw)


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
    first, last = _checked_point(start, "start"), _checked_point(end, "end")
    return _assemble(Pieces(np.array([0.0, 1.0]), np.array([[last - first], [first]])), yaw)


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
        _checked_point(point, name) for point, name in ((start, "start"), (through, "through"), (end, "end"))
    )
    to_middle, to_last = middle - first, last - first
    normal = np.cross(to_middle, to_last)
    size = np.linalg.norm(to_middle) * np.linalg.norm(to_last) * np.linalg.norm(last - middle)
    if np.linalg.norm(normal) <= 1e-6 * max(np.linalg.norm(to_middle), np.linalg.norm(to_last)) ** 2 or size == 0.0:
        raise ScenarioError(
            f"arc with start {_text(first)}, through {_text(middle)}, end {_text(last)}: the points coincide or lie on "
            "one line; move `through` off the line, or use a line"
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
    return _assemble(pieces, yaw)


def path_through_waypoints(
    points: np.ndarray | Sequence[Sequence[float]], *, yaw: np.ndarray | Sequence[float] = (0.0, 0.0)
) -> Path:
    """Smooth path through points: a C4 spline of degree 5 in the chord length; 2 to 5 points give one polynomial.

    Args:
        points: (n, 3), m; neighbours differ.
        yaw: see `straight_line`.

    Raises:
        ScenarioError: too few or too many points, neighbours that coincide, numbers that are not finite.
    """
    places = _checked_points(points, "waypoints")
    if len(places) > MAX_WAYPOINTS:
        raise ScenarioError(
            f"waypoints: {len(places)} points, at most {MAX_WAYPOINTS} are allowed; keep fewer, a spline joins them"
        )
    chords = np.linalg.norm(np.diff(places, axis=0), axis=1)
    nearest = int(np.argmin(chords))
    if chords[nearest] <= SAME_KNOT * max(1.0, float(chords.sum())):
        raise ScenarioError(
            f"waypoints {nearest + 1} and {nearest + 2} are the same point {_text(places[nearest])}; remove one of them"
        )
    s = np.concatenate(([0.0], np.cumsum(chords)))
    return _assemble(interpolating_pieces(s / s[-1], places), yaw)


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
    points = PRESETS[name]() + _checked_point(offset, "offset")
    knots = np.concatenate((np.full(4, -0.001), np.linspace(0.0, 1.0, 8), np.full(4, 1.001))) if name == "arc" else None
    return path_from_bspline(points, 4, knots=knots, yaw=yaw)


_LARGEST_FILE = 100_000_000
_HEADER_CELL = re.compile(r"^([xyz])\s*[_ \[(]*\s*(m)?\s*[\])]?$", re.IGNORECASE)


def read_waypoints(csv_path: FilePath | str) -> np.ndarray:
    """Waypoints from a CSV file: columns x, y, z in metres, separated by commas or semicolons.

    A header line (`x,y,z`, or with the unit as in `x_m` or `x [m]`), blank lines and lines that start with # may be
    present.

    Returns:
        (n, 3) points in m.

    Raises:
        ScenarioError: the file cannot be read, or a line is not three finite numbers; the message names file and line.
    """
    path = FilePath(csv_path)
    try:
        lines = bounded_text(path, _LARGEST_FILE).splitlines()
    except UnreadableError as error:
        raise ScenarioError(f"{path}: {error}; give a CSV file with columns x, y, z in m") from None
    rows: list[tuple[float, ...]] = []
    header_allowed = True
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        cells = [cell.strip() for cell in line.split(";" if ";" in line else ",")]
        if header_allowed and cells[0][:1].isalpha() and cells[0].lower() not in {"nan", "inf", "infinity"}:
            _check_header(cells, f"{path} line {number}")
        else:
            rows.append(_row(cells, f"{path} line {number}"))
        header_allowed = False
    if len(rows) < 2:
        raise ScenarioError(f"{path}: {len(rows)} waypoints; a path needs at least 2 lines of x, y, z in m")
    return np.array(rows)


def _check_header(cells: list[str], place: str) -> None:
    matches = [_HEADER_CELL.match(cell) for cell in cells]
    if [match.group(1).lower() if match else "" for match in matches] != ["x", "y", "z"]:
        raise ScenarioError(
            f"{place}: header {as_written(', '.join(cells))}; the columns must be x, y, z in m, in this order"
        )


def _row(cells: list[str], place: str) -> tuple[float, ...]:
    if len(cells) != 3:
        raise ScenarioError(f"{place}: {len(cells)} columns; 3 are needed (x, y, z in m, separated by , or ;)")
    values: list[float] = []
    for cell in cells:
        try:
            value = float(cell)
        except ValueError:
            raise ScenarioError(
                f"{place}: {as_written(cell)} is not a number; write metres with a decimal point"
            ) from None
        if not math.isfinite(value):
            raise ScenarioError(
                f"{place}: {as_written(cell)} is not a finite number; write metres with a decimal point"
            )
        values.append(value)
    return tuple(values)


def _checked_numbers(values: object, name: str) -> np.ndarray:
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise ScenarioError(f"{name}: not an array of numbers, or its rows differ in length") from None
    if not np.all(np.isfinite(array)):
        raise ScenarioError(f"{name}: contains a value that is not a finite number")
    if array.size and np.max(np.abs(array)) > 1e6:
        raise ScenarioError(
            f"{name}: contains {array.flat[np.argmax(np.abs(array))]:g}; at most 1e6 in size is allowed (m, rad)"
        )
    return array


def _checked_point(values: object, name: str) -> np.ndarray:
    point = _checked_numbers(values, name)
    if point.shape != (3,):
        raise ScenarioError(f"{name}: shape {point.shape}; three numbers x, y, z in m are needed")
    return point


def _checked_points(values: object, name: str) -> np.ndarray:
    points = _checked_numbers(values, name)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
        raise ScenarioError(f"{name}: shape {points.shape}; at least 2 points of three numbers x, y, z in m are needed")
    return points


def _checked_knots(values: object, count: int, degree: int) -> np.ndarray:
    knots = _checked_numbers(values, "knots")
    if knots.shape != (count + degree + 1,):
        raise ScenarioError(
            f"knots: {knots.size} given; {count} control points of degree {degree} need {count + degree + 1} knots"
        )
    falling = np.flatnonzero(np.diff(knots) < 0)
    if falling.size:
        raise ScenarioError(
            f"knots: knot {falling[0] + 2} = {knots[falling[0] + 1]:g} is below the one before; sort them"
        )
    begin, end = knots[degree], knots[-degree - 1]
    if end - begin <= SAME_KNOT:
        raise ScenarioError(f"knots: the curve's interval from {begin:g} to {end:g} is empty; spread the inner knots")
    return knots if begin <= SAME_KNOT and end >= 1 - SAME_KNOT else (knots - begin) / (end - begin)


def _yaw_pieces(yaw: object) -> Pieces:
    values = _checked_numbers(yaw, "yaw")
    if values.ndim != 1 or values.size < 2:
        raise ScenarioError(f"yaw: shape {values.shape}; two or more angles are needed (start, ..., end)")
    if values.size == 2:
        return Pieces(np.array([0.0, 1.0]), np.array([[[values[1] - values[0]]], [[values[0]]]]))
    if values.size > MAX_WAYPOINTS:
        raise ScenarioError(f"yaw: {values.size} values, at most {MAX_WAYPOINTS} are allowed; keep fewer")
    return interpolating_pieces(np.linspace(0.0, 1.0, values.size), values[:, None])


def _assemble(position: Pieces, yaw: object) -> Path:
    """Position and yaw on the union of their breaks and with the larger of their degrees."""
    turning = _yaw_pieces(yaw)
    merged = np.union1d(position.breaks, turning.breaks)
    breaks = merged[np.append(True, np.diff(merged) > SAME_KNOT)]
    breaks[-1] = 1.0
    degree = max(len(position.coefficients), len(turning.coefficients)) - 1
    coefficients = np.concatenate(
        (refined(position, breaks, degree=degree), refined(turning, breaks, degree=degree)), axis=2
    )
    if np.max(np.abs(coefficients[:-1])) <= SAME_KNOT:
        raise ScenarioError("the path neither moves nor turns; give it points that differ or a yaw that changes")
    return Path(read_only(breaks), read_only(coefficients))


def _text(point: np.ndarray) -> str:
    return "(" + ", ".join(f"{value:.6g}" for value in point) + ")"
