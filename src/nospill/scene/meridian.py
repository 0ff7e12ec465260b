"""The meridian of a body of revolution: the curve that, turned about the axis, is the inside of a vessel.

It runs from the bottom's centre to the rim in pieces, each straight or a cubic spline, never downwards. Integrals along
it are exact: Gauss points suffice for polynomials.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.units import format_quantity
from nospill.errors import ScenarioError

_SAMPLES = 12
"""Straight parts that stand for a cubic where it is checked or drawn."""

_SAME = 1e-9
"""m; lengths below are rounding."""

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Meridian:
    """Inside of a vessel in pieces that meet at corners.

    Attributes:
        pieces: points (r, z) in m of each piece; two points are a straight line, more a smooth curve through them. A
            piece starts where the one before ends.
    """

    pieces: tuple[tuple[Point, ...], ...]

    @property
    def bottom(self) -> float:
        """Height of the lowest point, on the axis, m."""
        return self.pieces[0][0][1]

    @property
    def rim(self) -> Point:
        """Radius and height of the rim, m."""
        return self.pieces[-1][-1]

    @property
    def points(self) -> np.ndarray:
        """Points close enough to draw straight lines between, (n, 2), m."""
        return _polygon(self)

    def wetted(self, level: float) -> list[np.ndarray]:
        """The pieces below `level` (m): coefficients (k, 4, 2) of k cubics each, powers of a parameter from 0 to 1."""
        pieces = []
        for piece in _cubics(self):
            above = np.flatnonzero(piece.sum(axis=1)[:, 1] >= level)
            if not len(above):
                pieces.append(piece)
                continue
            last = int(above[0])
            end = _parameter_at(piece[last], level)
            if end > 0.0:
                cut = piece[last] * (end ** np.arange(4.0))[:, None]
                pieces.append(np.concatenate([piece[:last], cut[None]]))
            elif last:
                pieces.append(piece[:last])
            break
        return pieces

    def radius(self, level: float) -> float:
        """Radius of the inside at a height in m, m; beyond its ends that at the end."""
        cubics = self.wetted(min(max(level, self.bottom), self.rim[1]))
        return float(cubics[-1][-1].sum(axis=0)[0]) if cubics else 0.0

    def lean(self, level: float) -> float:
        """Angle of the wall from upright at a height in m, rad: positive where it opens; of the piece below."""
        cubics = self.wetted(min(max(level, self.bottom), self.rim[1]))
        along = np.arange(4.0) @ cubics[-1][-1]
        return math.atan2(float(along[0]), float(along[1]))

    def widest(self, level: float) -> float:
        """Largest radius below a height in m, m."""
        return max(float(np.max(_sample(piece)[:, 0])) for piece in self.wetted(level))

    def volume(self, level: float) -> float:
        """Volume inside up to a height in m, m^3."""
        return float(self._integrals(level)[0]) if level > self.bottom else 0.0

    def level(self, volume: float) -> float:
        """Height in m up to which a volume in m^3 fills it; the rim's where it holds less."""
        low, high = self.bottom, self.rim[1]
        if volume <= 0.0:
            return low
        if volume >= self.volume(high):
            return high
        from scipy.optimize import brentq

        return float(brentq(lambda z: self.volume(z) - volume, low, high, xtol=1e-15, rtol=1e-15))  # type: ignore[arg-type]

    def body(self, level: float) -> tuple[float, float, np.ndarray]:
        """The inside up to a height in m as a solid: volume, height of its centre, and inertia over mass about it.

        Returns:
            m^3; m; (3, 3) m^2.
        """
        volume, first, second, across = self._integrals(level)
        centre = first / volume
        side = across / volume / 4 + second / volume - centre**2
        return float(volume), float(centre), np.diag((side, side, across / volume / 2))

    def shell(self) -> tuple[float, np.ndarray]:
        """A thin shell of uniform thickness: height of its centre, m, and inertia over mass about it, (3, 3) m^2."""
        sums = np.zeros(4)
        for piece in _cubics(self):
            place, slope = _at_nodes(piece)
            radius, z = place[..., 0], place[..., 1]
            band = radius * np.linalg.norm(slope, axis=-1) * _quadrature()[1]
            sums += [float(np.sum(band * part)) for part in (1.0, z, z * z, radius * radius)]
        area, first, second, across = sums
        centre = first / area
        side = across / area / 2 + second / area - centre**2
        return centre, np.diag((side, side, across / area))

    def _integrals(self, level: float) -> np.ndarray:
        """Integrals of 1, z, z^2 and r^2/2 (times two: r^4 over the slices) in the volume, (4,)."""
        sums = np.zeros(4)
        for piece in self.wetted(level):
            place, slope = _at_nodes(piece)
            radius, z = place[..., 0], place[..., 1]
            slab = np.pi * radius**2 * slope[..., 1] * _quadrature()[1]
            sums += [float(np.sum(slab * part)) for part in (1.0, z, z * z, radius * radius)]
        return sums


def arc(centre: Point, radii: Point, angles: Point, count: int = 33) -> tuple[Point, ...]:
    """Points of an elliptic arc as a smooth piece.

    Args:
        centre: (r, z), m.
        radii: half axes along r and z, m.
        angles: first and last, rad, from r towards z.
        count: number of points; the spline through 33 is within 1e-8 of a quarter circle's radius.
    """
    angle = np.linspace(*angles, count)
    points = np.column_stack([centre[0] + radii[0] * np.cos(angle), centre[1] + radii[1] * np.sin(angle)])
    points[np.abs(points[:, 0]) < _SAME * radii[0], 0] = 0.0
    return tuple((float(r), float(z)) for r, z in points)


def polyline(points: Sequence[Point]) -> tuple[tuple[Point, ...], ...]:
    """Straight pieces from point to point."""
    return tuple((first, second) for first, second in pairwise(points))


def smooth_pieces(points: Sequence[Point]) -> tuple[tuple[Point, ...], ...]:
    """Smooth pieces through points; a point that stands twice in a row is a corner."""
    pieces: list[list[Point]] = [[points[0]]]
    for before, point in pairwise(points):
        if point == before:
            pieces.append([point])
        else:
            pieces[-1].append(point)
    return tuple(tuple(piece) for piece in pieces if len(piece) > 1)


def check_meridian(meridian: Meridian, key: str = "profile") -> None:
    """Refuse a curve that is not the inside of an open vessel.

    Raises:
        ScenarioError: it does not start on the axis, leaves the half plane r >= 0, z >= 0, crosses itself, falls, or
            has no height; the message starts with the key.
    """
    points = meridian.points
    start, lowest = points[0], points[int(np.argmin(points[:, 1]))]
    if abs(start[0]) > _SAME:
        raise ScenarioError(f"{key} starts at {_point_text(start)}: its first point must be on the axis, r = 0")
    if lowest[1] < -_SAME:
        raise ScenarioError(f"{key} goes below zero at {_point_text(lowest)}: z is counted from the tray; shift it up")
    inner = points[1:]
    on_axis = np.flatnonzero(inner[:, 0] <= _SAME)
    if len(on_axis) and on_axis[0] < len(inner) - 1:
        raise ScenarioError(
            f"{key} comes back to the axis at {_point_text(inner[on_axis[0]])}: only its ends may be there"
        )
    crossing = _crossing(points)
    if crossing is not None:
        raise ScenarioError(
            f"{key} crosses itself near {_point_text(crossing)}: give the points in order, bottom to rim"
        )
    falls = np.flatnonzero(np.diff(points[:, 1]) < -_SAME)
    if len(falls):
        raise ScenarioError(
            f"{key} goes down after {_point_text(points[falls[0]])}: an undercut traps air and a raised bottom is not "
            "modelled; z must never fall from one point to the next"
        )
    if not points[-1][1] > points[0][1] + _SAME:
        raise ScenarioError(f"{key} has no height: its rim must be above its bottom")
    if len(on_axis):
        raise ScenarioError(
            f"{key} ends on the axis at {_point_text(points[-1])}: the vessel is closed; end at an open rim"
        )


@lru_cache(maxsize=256)
def _cubics(meridian: Meridian) -> tuple[np.ndarray, ...]:
    """Coefficients (k, 4, 2) of each piece."""
    return tuple(_cubic(np.array(piece)) for piece in meridian.pieces)


def _cubic(points: np.ndarray) -> np.ndarray:
    if len(points) == 2:
        return read_only(np.stack([points[:-1], np.diff(points, axis=0), 0 * points[1:], 0 * points[1:]], axis=1))
    from scipy.interpolate import CubicSpline

    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    # A smooth bottom is level on the axis.
    ends: Any = ((1, 0.0), "not-a-knot") if points[0, 0] <= _SAME else "not-a-knot"
    r = CubicSpline(along, points[:, 0], bc_type="not-a-knot" if len(points) > 3 else "natural")
    z = CubicSpline(along, points[:, 1], bc_type=ends if len(points) > 3 else "natural")
    step = np.diff(along)
    powers = [np.stack([r.c[3 - power], z.c[3 - power]], axis=-1) * step[:, None] ** power for power in range(4)]
    return read_only(np.stack(powers, axis=1))


@lru_cache(maxsize=256)
def _polygon(meridian: Meridian) -> np.ndarray:
    parts = [np.array([meridian.pieces[0][0]])]
    parts += [_sample(piece)[1:] for piece in _cubics(meridian)]
    return read_only(np.concatenate(parts))


def _sample(piece: np.ndarray) -> np.ndarray:
    """Points (n, 2) along a piece, its ends and joints among them."""
    straight = not np.any(piece[:, 2:])
    part = np.linspace(0.0, 1.0, 2 if straight else _SAMPLES + 1)[1:]
    inner = np.einsum("kpx,pn->knx", piece, part ** np.arange(4)[:, None]).reshape(-1, 2)
    return np.vstack([piece[0, 0], inner])


def _at_nodes(piece: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places and derivatives at the Gauss points of each cubic, (k, 8, 2)."""
    power = np.arange(4)[:, None]
    nodes, _ = _quadrature()
    place = np.einsum("kpx,pn->knx", piece, nodes**power)
    slope = np.einsum("kpx,pn->knx", piece[:, 1:], power[1:] * nodes ** (power[1:] - 1))
    return place, slope


def _parameter_at(cubic: np.ndarray, level: float) -> float:
    """Parameter at which a rising cubic (4, 2) reaches a height."""
    z = cubic[:, 1]
    if z[0] >= level:
        return 0.0
    if not np.any(z[2:]):
        return min((level - z[0]) / z[1], 1.0)
    from scipy.optimize import brentq

    value = np.polynomial.polynomial.polyval
    return 1.0 if value(1.0, z) <= level else float(brentq(lambda u: value(u, z) - level, 0.0, 1.0, xtol=1e-15))  # type: ignore[arg-type]


def _crossing(points: np.ndarray) -> np.ndarray | None:
    """A point where two lines of a polyline that are not neighbours meet; None where none do."""
    start, step = points[:-1], np.diff(points, axis=0)
    first, second = np.triu_indices(len(start), 2)
    gap = start[second] - start[first]
    turn = _cross(step[first], step[second])
    with np.errstate(divide="ignore", invalid="ignore"):
        here, there = _cross(gap, step[second]) / turn, _cross(gap, step[first]) / turn
    met = np.flatnonzero((turn != 0.0) & (here >= 0.0) & (here <= 1.0) & (there >= 0.0) & (there <= 1.0))
    return start[first[met[0]]] + here[met[0]] * step[first[met[0]]] if len(met) else None


def _cross(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]


def _point_text(point: np.ndarray) -> str:
    r, z = (format_quantity(float(x) if math.isfinite(x) else 0.0, "length", digits=4) for x in point)
    return f"r = {r}, z = {z}"


@lru_cache(maxsize=1)
def _quadrature() -> tuple[np.ndarray, np.ndarray]:
    """Gauss nodes and weights on [0, 1], made when a vessel needs them: NumPy loads its polynomials for it."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    return 0.5 * nodes + 0.5, 0.5 * weights
