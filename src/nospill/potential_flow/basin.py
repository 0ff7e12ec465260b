"""The liquid of one container as the flow sees it: modes of its surface, depth, damping, and how turns excite it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from nospill.core.arrays import read_only
from nospill.potential_flow.bessel import slope_root
from nospill.potential_flow.surface_modes import (
    SurfaceModes,
    disc_modes,
    disc_shapes,
    disc_waves,
    rectangle_modes,
    rectangle_shapes,
    rectangle_waves,
)
from nospill.scene.cargo import Cargo, Filling
from nospill.scene.containers.base import Container
from nospill.scene.containers.box import Box
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.scene.sloshing.prism import LARGEST_DAMPING

FINE, COARSE = 5.3, 4.3
"""Largest wave number of the nonlinear flow over that of the slowest mode: 9.8 and 7.9 over the radius of a cup.

Waves of a few millimetres' length are not steep ones that follow from the long ones, and their amplitudes per pressure
grow as exp(k eta): with 12/R a free wave of R/3 breaks up in the flow's numbers before it does in water. The second
order takes the coarse set: of it the shortest waves of a fine one are the larger part where accelerations jump, of the
full flow they are not."""

SAME_WAVE = 1e-6
"""Relative difference of wave numbers up to which modes of two sets are the same."""

LINEAR_MODES = 12
"""Modes in each direction of the linear flow; what is left follows the apparent gravity at once."""


@dataclass(frozen=True, slots=True)
class Basin:
    """A liquid at rest.

    Attributes:
        modes: of its surface.
        depth: h at rest, m.
        damping: (J,) ratio of every mode.
    """

    modes: SurfaceModes
    depth: float
    damping: np.ndarray

    @property
    def stiffness(self) -> np.ndarray:
        """(J,) kappa = k tanh(k h), 1/m: rate of the surface per potential; omega^2 = g kappa."""
        return self.modes.wave_number * np.tanh(self.modes.wave_number * self.depth)

    @property
    def frequency(self) -> np.ndarray:
        """(J,) omega under standard gravity, rad/s."""
        return np.sqrt(STANDARD_GRAVITY * self.stiffness)

    @property
    def friction(self) -> np.ndarray:
        """(J,) pressure over density per rate of the surface, 2 zeta omega/kappa, m/s."""
        return 2 * self.damping * self.frequency / self.stiffness

    @property
    def place(self) -> np.ndarray:
        """(J, 2) share of every mode in the functions x and y, m."""
        return self.modes.coefficients(self.modes.points)


def basin_of(cargo: Cargo, finest: float = FINE) -> Basin:
    """The liquid of an upright cylinder or box with all its modes up to a wave number.

    Damping ratios are that of the slowest mode times laminar ones, as in the linear model (`slosh_model`); the latter
    from the layers on wall and bottom and from the interior.

    Args:
        cargo: `unsupported` says whether it may be asked for.
        finest: largest wave number over that of the slowest mode.
    """
    filling = _filling(cargo)
    if isinstance(cargo.container, Cylinder):
        modes = disc_modes(cargo.container.radius, disc_waves(finest * slope_root(1, 1)))
    else:
        sides = _sides(cargo)
        modes = rectangle_modes(sides, rectangle_waves(sides, finest * math.pi / max(sides) * (1 + 1e-9)))
    return _filled(modes, filling)


def driven_basin(cargo: Cargo) -> Basin:
    """The modes of `COARSE` that move to the second order, and the excited ones that drive them.

    Products of two modes of one nodal diameter have none and two: in a cup the others stay at rest.
    """
    return _filled(_driven_modes(cargo.container), _filling(cargo))


def basin_with(cargo: Cargo, waves: Sequence[tuple[int, int]]) -> Basin:
    """The liquid of an upright cylinder or box with some of its modes."""
    if isinstance(cargo.container, Cylinder):
        return _filled(disc_modes(cargo.container.radius, list(waves)), _filling(cargo))
    return _filled(rectangle_modes(_sides(cargo), list(waves)), _filling(cargo))


def driven_shapes(container: Container, points: np.ndarray) -> np.ndarray:
    """Shapes (P, J) of the modes of `driven_basin` at points (P, 2) of the surface, m from its middle."""
    waves = _driven_waves(container)
    if isinstance(container, Cylinder):
        return disc_shapes(container.radius, waves, points)
    assert isinstance(container, Box)  # as `unsupported` asks for
    return rectangle_shapes((container.length, container.width), waves, points)


def _driven_waves(container: Container) -> list[tuple[int, int]]:
    if isinstance(container, Cylinder):
        return [wave for wave in disc_waves(COARSE * slope_root(1, 1)) if wave[0] <= 2]
    assert isinstance(container, Box)  # as `unsupported` asks for
    sides = container.length, container.width
    return rectangle_waves(sides, COARSE * math.pi / max(sides) * (1 + 1e-9))


@lru_cache(maxsize=32)
def _driven_modes(container: Container) -> SurfaceModes:
    waves = _driven_waves(container)
    if isinstance(container, Cylinder):
        return disc_modes(container.radius, waves)
    assert isinstance(container, Box)  # as `unsupported` asks for
    return rectangle_modes((container.length, container.width), waves)


def linear_basin(cargo: Cargo) -> Basin:
    """The modes that a motion excites in linear theory, `LINEAR_MODES` in each direction, of a box those of yaw too."""
    if isinstance(cargo.container, Cylinder):
        modes = disc_modes(cargo.container.radius, [(1, circle) for circle in range(1, LINEAR_MODES + 1)])
        return _filled(modes, _filling(cargo))
    odd = range(1, 2 * LINEAR_MODES, 2)
    waves = [(m, 0) for m in odd] + [(0, m) for m in odd]
    waves += [(1, 1), *(pair for m in odd[1:] for pair in ((m, 1), (1, m)))]
    return _filled(rectangle_modes(_sides(cargo), waves), _filling(cargo))


def _filling(cargo: Cargo) -> Filling:
    assert cargo.filling is not None  # what is asked for is a liquid
    return cargo.filling


def _sides(cargo: Cargo) -> tuple[float, float]:
    assert isinstance(cargo.container, Box)
    return cargo.container.length, cargo.container.width


def _filled(modes: SurfaceModes, filling: Filling) -> Basin:
    basin = Basin(modes, filling.liquid_height, np.zeros(len(modes.wave_number)))
    slowest = min(filling.oscillators, key=lambda mode: mode.frequency)
    laminar = laminar_damping(basin, filling.liquid.kinematic_viscosity)
    nearest = int(np.argmin(np.abs(modes.wave_number - slowest.wave_number)))
    ratio = np.minimum(slowest.damping / laminar[nearest] * laminar, max(slowest.damping, LARGEST_DAMPING))
    return replace(basin, damping=read_only(ratio))


def laminar_damping(basin: Basin, viscosity: float) -> np.ndarray:
    """(J,) damping ratios by Stokes layers on wall and bottom and by the interior, as `PrismMode.laminar_damping`.

    With C = cosh(k h): a mode holds kappa times the integral of F^2, its bottom k^2 times that over C^2, its wall the
    integrals of F_s^2 and of k^2 F^2 along it times those of cosh^2 and sinh^2 over the depth and C^2.
    """
    modes, h = basin.modes, basin.depth
    k = modes.wave_number
    faded = np.exp(-2 * k * h)
    inverse_square = 4 * faded / (1 + faded) ** 2  # 1/cosh^2(k h)
    half, rest = inverse_square * h / 2, np.tanh(k * h) / (2 * k)
    along = modes.wall_weight @ modes.wall_slope**2
    across = k**2 * (modes.wall_weight @ modes.wall_shape**2)
    wall = along * (rest + half) + across * (rest - half)
    ratio = (wall + k**2 * inverse_square * modes.norm) / (basin.stiffness * modes.norm)
    return np.sqrt(viscosity / (2 * basin.frequency)) * ratio / 2 + 2 * viscosity * k**2 / basin.frequency
