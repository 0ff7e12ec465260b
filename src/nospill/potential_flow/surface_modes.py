"""Natural modes of the free surface of an upright prism: shapes, gradients, and the points they are integrated at.

On the cross-section every mode is a Neumann eigenfunction F of the horizontal Laplacian, F_xx + F_yy = -k^2 F, whose
potential is F cosh(k (z + h))/cosh(k h), z from the rest level [Abramson, NASA SP-106, ch. 2; Lamb, Hydrodynamics,
sec. 190, 191]: in a disc J_m(k r) cos or sin(m theta), in a rectangle the product of two cosines. All of them are kept,
not only those that a motion excites in linear theory: the nonlinear flow moves the others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nospill.core.arrays import read_only
from nospill.potential_flow.bessel import bessel, bessel_slope, slope_root, slope_roots

_WALL_POINTS = 144
"""Places round the wall of a disc; a crest lies within 1.25 deg of one. A rectangle has a quarter on each side."""


@dataclass(frozen=True, slots=True)
class Polar:
    """The modes of a disc as W waves on G rings: a radial function times the cosine, and the sine where m > 0.

    Attributes:
        diameters: (W,) m of each wave, whose modes stand one after the other.
        radial: (W, G) F over that cosine or sine.
        outward: (W, G) its slope, 1/m.
        radius: (G,) of the rings, m; the points of a ring stand one after the other.
        angle: (S,) of the points of each, rad, in the middle of equal parts.
    """

    diameters: np.ndarray
    radial: np.ndarray
    outward: np.ndarray
    radius: np.ndarray
    angle: np.ndarray


@dataclass(frozen=True, slots=True)
class SurfaceModes:
    """Modes of a cross-section, J of them, at P points inside and V on the wall.

    Attributes:
        wave_number: (J,) k, 1/m.
        points: (P, 2) of the quadrature, m, from the middle.
        weight: (P,) of the quadrature, m^2; they sum to the area.
        shape: (P, J) F, 1 where a mode is highest on the wall.
        slope: (2, P, J) its derivatives by x and y, 1/m.
        wall: (V, 2) points on the wall, m.
        wall_weight: (V,) m; they sum to the circumference.
        wall_shape: (V, J) F on the wall.
        wall_slope: (V, J) derivative along the wall, 1/m; a constant sign apart. That across it is zero.
        turn: (2, P) Zhukovsky's potential of a turn about the vertical: its gradient Z less (-y, x), m; the velocity
            of the liquid past the wall when the container turns with 1 rad/s under a closed surface.
        turn_potential: (P,) the potential itself, m^2; zero in a disc.
        polar: the same modes of a disc; None of a rectangle.
    """

    wave_number: np.ndarray
    points: np.ndarray
    weight: np.ndarray
    shape: np.ndarray
    slope: np.ndarray
    wall: np.ndarray
    wall_weight: np.ndarray
    wall_shape: np.ndarray
    wall_slope: np.ndarray
    turn: np.ndarray
    turn_potential: np.ndarray
    polar: Polar | None = None

    @property
    def norm(self) -> np.ndarray:
        """(J,) integral of F^2, m^2."""
        return np.einsum("p,pj,pj->j", self.weight, self.shape, self.shape)

    def coefficients(self, values: np.ndarray) -> np.ndarray:
        """(J, ...) of the modes in values (P, ...)."""
        weighted = (self.shape * self.weight[:, None]).T @ values
        return weighted / self.norm.reshape(-1, *[1] * (values.ndim - 1))


def disc_waves(largest: float) -> list[tuple[int, int]]:
    """Nodal diameters and circles (m, n), n from 1, of the modes with k R up to `largest`."""
    waves: list[tuple[int, int]] = []
    for diameters in range(int(largest) + 1):  # the first root of J_m' is above m
        waves += [(diameters, circle + 1) for circle in range(len(slope_roots(diameters, largest)))]
    return waves


def disc_modes(radius: float, waves: list[tuple[int, int]]) -> SurfaceModes:
    """Modes of a disc of this radius, m; cosines and sines where there are nodal diameters.

    Args:
        radius: R, m.
        waves: (m, n) nodal diameters and number, counted from 1, of the root of J_m'.
    """
    polar, area = _rings(radius, waves)
    spokes, rings = len(polar.angle), len(polar.radius)
    r, angle = np.repeat(polar.radius, spokes), np.tile(polar.angle, rings)
    around = 2 * np.pi * np.arange(_WALL_POINTS) / _WALL_POINTS
    c, s = np.cos(angle), np.sin(angle)
    columns: dict[str, list[np.ndarray]] = {"k": [], "f": [], "x": [], "y": [], "wall": [], "along": []}
    for (diameters, circle), *of_rings in zip(waves, polar.radial, polar.outward, strict=True):
        k = slope_root(diameters, circle) / radius
        radial, outward = (np.repeat(values, spokes) for values in of_rings)
        for quarter in (0.0, np.pi / 2)[: 1 if diameters == 0 else 2]:  # cos(m theta - pi/2) is the sine
            phase, wall_phase = diameters * angle - quarter, diameters * around - quarter
            out, across = outward * np.cos(phase), -diameters * radial / r * np.sin(phase)
            columns["k"].append(np.array(k))
            columns["f"].append(radial * np.cos(phase))
            columns["x"].append(out * c - across * s)
            columns["y"].append(out * s + across * c)
            columns["wall"].append(np.cos(wall_phase))
            columns["along"].append(-diameters / radius * np.sin(wall_phase))
    stacked = {name: np.stack(values, axis=-1) for name, values in columns.items()}
    points = np.column_stack([r * c, r * s])
    return SurfaceModes(
        wave_number=read_only(stacked["k"]),
        points=read_only(points),
        weight=read_only(np.repeat(area, spokes)),
        shape=read_only(stacked["f"]),
        slope=read_only(np.stack([stacked["x"], stacked["y"]])),
        wall=read_only(radius * np.column_stack([np.cos(around), np.sin(around)])),
        wall_weight=read_only(np.full(_WALL_POINTS, 2 * np.pi * radius / _WALL_POINTS)),
        wall_shape=read_only(stacked["wall"]),
        wall_slope=read_only(stacked["along"]),
        turn=read_only(np.stack([points[:, 1], -points[:, 0]])),
        turn_potential=read_only(np.zeros(len(points))),
        polar=polar,
    )


def _rings(radius: float, waves: list[tuple[int, int]]) -> tuple[Polar, np.ndarray]:
    """The waves on rings, and the area (G,), m^2, of each point of a ring."""
    most = max(diameters for diameters, _ in waves)
    spokes = max(5 * most // 2 + 3, 8)
    node, weight = np.polynomial.legendre.leggauss(6 + 2 * max(circle for _, circle in waves) + most // 3)
    r = radius * (node + 1) / 2
    radial, outward = [], []
    for diameters, circle in waves:
        root = slope_root(diameters, circle)
        k, top = root / radius, float(bessel(diameters, root))
        radial.append(bessel(diameters, k * r) / top)
        outward.append(k * bessel_slope(diameters, k * r) / top)
    polar = Polar(
        diameters=read_only([diameters for diameters, _ in waves]),
        radial=read_only(np.array(radial)),
        outward=read_only(np.array(outward)),
        radius=read_only(r),
        angle=read_only(2 * np.pi * (np.arange(spokes) + 0.5) / spokes),
    )
    return polar, radius * weight / 2 * r * 2 * np.pi / spokes


def disc_shapes(radius: float, waves: list[tuple[int, int]], points: np.ndarray) -> np.ndarray:
    """Shapes (P, J) of `disc_modes` at points (P, 2), m."""
    r, angle = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    columns = []
    for diameters, circle in waves:
        root = slope_root(diameters, circle)
        radial = bessel(diameters, root * r / radius) / float(bessel(diameters, root))
        columns += [radial * np.cos(diameters * angle - turn) for turn in (0.0, np.pi / 2)[: 1 + (diameters > 0)]]
    return np.stack(columns, axis=1)


def rectangle_shapes(sides: tuple[float, float], waves: list[tuple[int, int]], points: np.ndarray) -> np.ndarray:
    """Shapes (P, J) of `rectangle_modes` at points (P, 2), m."""
    return _cosines(sides, waves, points)[0]


def rectangle_waves(sides: tuple[float, float], largest: float) -> list[tuple[int, int]]:
    """Half waves (m, n) along x and y of the modes with a wave number up to `largest`, 1/m; not the level surface."""
    most = [int(largest * side / math.pi) for side in sides]
    return [
        (m, n)
        for m in range(most[0] + 1)
        for n in range(most[1] + 1)
        if 0.0 < math.hypot(m * math.pi / sides[0], n * math.pi / sides[1]) <= largest
    ]


def rectangle_modes(sides: tuple[float, float], waves: list[tuple[int, int]]) -> SurfaceModes:
    """Modes of a rectangle, cos(m pi (x + a/2)/a) cos(n pi (y + b/2)/b), 1 in the corner (+, +).

    Args:
        sides: a along x and b along y, m.
        waves: (m, n) half waves along x and y.
    """
    lines = []
    for side, most in zip(sides, np.max(np.array(waves), axis=0).tolist(), strict=True):
        node, weight = np.polynomial.legendre.leggauss(6 + 2 * most + most // 2)
        lines.append((side / 2 * node, side / 2 * weight))
    (x, wx), (y, wy) = lines
    points = np.column_stack([np.repeat(x, len(y)), np.tile(y, len(x))])
    wall, length, along = _rectangle_wall(sides)
    at = {name: _cosines(sides, waves, place) for name, place in (("inside", points), ("wall", wall))}
    shape, slope_x, slope_y = at["inside"]
    wall_shape, wall_x, wall_y = at["wall"]
    potential, gradient = _zhukovsky(sides, points)
    return SurfaceModes(
        wave_number=read_only([math.hypot(m * math.pi / sides[0], n * math.pi / sides[1]) for m, n in waves]),
        points=read_only(points),
        weight=read_only(np.outer(wx, wy).ravel()),
        shape=read_only(shape),
        slope=read_only(np.stack([slope_x, slope_y])),
        wall=read_only(wall),
        wall_weight=read_only(length),
        wall_shape=read_only(wall_shape),
        wall_slope=read_only(np.where(along[:, None], wall_x, wall_y)),
        turn=read_only(gradient - np.stack([-points[:, 1], points[:, 0]])),
        turn_potential=read_only(potential),
    )


def _cosines(
    sides: tuple[float, float], waves: list[tuple[int, int]], place: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    number = np.array(waves).T * np.pi / np.array(sides)[:, None]
    phase = [np.outer(place[:, axis] + sides[axis] / 2, number[axis]) for axis in (0, 1)]
    sign = np.array([(-1.0) ** (m + n) for m, n in waves])
    cosine, sine = [np.cos(angle) for angle in phase], [np.sin(angle) for angle in phase]
    return (
        sign * cosine[0] * cosine[1],
        -sign * number[0] * sine[0] * cosine[1],
        -sign * number[1] * cosine[0] * sine[1],
    )


def _rectangle_wall(sides: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points with corners on all four sides, trapezoid weights, and whether the wall runs along x there."""
    count = _WALL_POINTS // 4 + 1
    step = np.linspace(-0.5, 0.5, count)
    weight = np.r_[0.5, np.ones(count - 2), 0.5] / (count - 1)
    a, b = sides
    edges = [np.column_stack([a * step, np.full(count, sign * b / 2)]) for sign in (-1, 1)]
    edges += [np.column_stack([np.full(count, sign * a / 2), b * step]) for sign in (-1, 1)]
    return (
        np.concatenate(edges),
        np.concatenate([a * weight, a * weight, b * weight, b * weight]),
        np.repeat([True, True, False, False], count),
    )


def _zhukovsky(sides: tuple[float, float], points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Potential (P,) m^2 of a turn about the vertical and its gradient (2, P), m.

    -x y + sum 8 a s_m/(m pi)^2 sin(p x) sinh(p y)/(p cosh(p b/2)), p = m pi/a, m odd, s_m = sin(m pi/2), as in
    `scene.sloshing.yaw_modes`.
    """
    (a, b), (x, y) = sides, points.T
    m = np.arange(1, 400, 2)
    p = m * np.pi / a
    height = np.abs(y)[:, None]
    rise = np.exp(p * (height - b / 2)) / (1 + np.exp(-p * b))
    falling = np.exp(-2 * p * height)
    sinh, cosh = np.sign(y)[:, None] * rise * (1 - falling), rise * (1 + falling)
    share = 8 * a * np.sin(m * np.pi / 2) / (m * np.pi) ** 2
    sine, cosine = np.sin(np.outer(x, p)), np.cos(np.outer(x, p))
    potential = -x * y + (share / p * sine * sinh).sum(axis=1)
    return potential, np.stack([-y + (share * cosine * sinh).sum(axis=1), -x + (share * sine * cosh).sum(axis=1)])
