"""Yaw modes: what a turn of a box about the vertical excites in its liquid [linear potential theory].

Axes of the box, origin in its middle, sides a and b. The velocity potential of the liquid is psi' Z + phi, where Z, the
Zhukovsky potential of the rectangle (grad Z . n = (e_z x r) . n on the walls), is the flow under a closed surface that
turns with the box, and phi the wave. To the first order in heights and in the rate of turn, at the surface

    eta' = d phi/dz,    d phi/dt + g eta + psi'' Z = 0.

With eta = sum b_mn S_mn(x, y), S_mn = sin(m pi x/a) sin(n pi y/b) for odd m and n, signed so that it is 1 in the corner
(+, +), k^2 = pi^2 (m^2/a^2 + n^2/b^2), kappa = k tanh(k h) and the divergence theorem for the share c_mn of S_mn in Z,

    b'' + 2 zeta omega b' + omega^2 b = -kappa c psi'',    omega^2 = g kappa,
    c_mn = (16/pi^2) (a^2/m^2 - b^2/n^2)/(a b k^2).

All other modes are left alone. The angular momentum is J_Z psi' + sum mu c b' with mu = rho a b/4 and J_Z that of the
flow Z: an oscillator of mass mu/kappa that slides along a circle of the radius kappa c, and no force. In a square
c_nn = 0, but c_mn = -c_nm is not: its corners stay level and its walls do not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from nospill.core.arrays import read_only
from nospill.scene.liquids import Liquid
from nospill.scene.sloshing.modes import STANDARD_GRAVITY, YAW, Oscillator, YawModes

_TERMS = 400
"""Of series over odd numbers; the potential's fall as their cubes or faster."""
_ALONG_WALL = (0.45, 0.55, 0.65, 0.8)
"""Parts of half a wall, from its middle: of all sets of four in steps of 0.05 the one that misses least."""


@dataclass(frozen=True, slots=True)
class YawMode:
    """One mode that is odd along both sides, liquid at rest h deep.

    Attributes:
        sides: a along x and b along y, m.
        waves: m and n, odd.
        liquid_height: h, m.
    """

    sides: tuple[float, float]
    waves: tuple[int, int]
    liquid_height: float

    @property
    def wave_number(self) -> float:
        """k, 1/m."""
        return math.hypot(*self._wave_numbers)

    @property
    def stiffness(self) -> float:
        """Kappa = k tanh(k h), 1/m."""
        return self.wave_number * math.tanh(self.wave_number * self.liquid_height)

    @property
    def share(self) -> float:
        """c, m^2, of this mode in the Zhukovsky potential."""
        (a, b), (m, n) = self.sides, self.waves
        return 16 / math.pi**2 * ((a / m) ** 2 - (b / n) ** 2) / (a * b * self.wave_number**2)

    @property
    def _wave_numbers(self) -> tuple[float, float]:
        (a, b), (m, n) = self.sides, self.waves
        return m * math.pi / a, n * math.pi / b

    def shape(self, points: np.ndarray) -> np.ndarray:
        """S (u,) at points (u, 2), m."""
        p, q = self._wave_numbers
        sign = math.sin(self.waves[0] * math.pi / 2) * math.sin(self.waves[1] * math.pi / 2)
        return sign * np.sin(p * points[:, 0]) * np.sin(q * points[:, 1])

    def laminar_damping(self, liquid: Liquid) -> float:
        """Damping ratio by Stokes layers on walls and bottom and by the interior, as `PrismMode.laminar_damping`.

        The integrals of |grad phi|^2 for phi = S cosh(k z), over the walls and the bottom and in the volume.
        """
        (a, b), (p, q), k, h = self.sides, self._wave_numbers, self.wave_number, self.liquid_height
        inverse = 2 * math.exp(-2 * k * h) / -math.expm1(-4 * k * h)  # 1/sinh(2 k h)
        cosine, sine = h * inverse / 2 + 1 / (4 * k), 1 / (4 * k) - h * inverse / 2
        walls = b * (q**2 * cosine + k**2 * sine) + a * (p**2 * cosine + k**2 * sine)
        ratio = 8 / (a * b * k) * (a * b * k**2 * inverse / 4 + walls)
        viscosity, omega = liquid.kinematic_viscosity, math.sqrt(STANDARD_GRAVITY * self.stiffness)
        return math.sqrt(viscosity / (2 * omega)) * ratio / 2 + 2 * viscosity * k**2 / omega


def yaw_modes(
    sides: tuple[float, float],
    liquid: Liquid,
    liquid_height: float,
    count: int,
    *,
    inertia: float,
    damping_scale: float,
    most_damping: float,
) -> YawModes:
    """The yaw modes of a box whose liquid has `count` modes along each side: 2 count - 1 of them.

    Those of one half wave along a side or along both; what is left follows a turn at once (`static_correction`), less
    than a tenth of the height.

    Args:
        sides: length and width, m.
        liquid: what is in it.
        liquid_height: h, m.
        count: of half waves along either side that are modelled next to the first along the other.
        inertia: J_Z of the liquid under a closed surface about the vertical, kg m^2.
        damping_scale: damping ratios over laminar ones, as for the modes along the sides.
        most_damping: largest damping ratio.
    """
    points = wall_points(sides)
    oscillators = []
    for number, pair in enumerate(_waves(2 * count - 1), start=1):
        mode = YawMode(sides, pair, liquid_height)
        oscillators.append(
            Oscillator(
                frequency=math.sqrt(STANDARD_GRAVITY * mode.stiffness),
                mass=liquid.density * sides[0] * sides[1] / (4 * mode.stiffness),
                height=liquid_height,
                damping=min(damping_scale * mode.laminar_damping(liquid), most_damping),
                surface_gain=1.0,
                directions=(YAW,),
                wave_number=mode.wave_number,
                number=number,
                arm=mode.stiffness * mode.share,
                wall_gains=tuple(mode.shape(points).tolist()),
            )
        )
    return YawModes(tuple(oscillators), sides, inertia, read_only(zhukovsky_potential(sides, points)))


def _waves(modes: int) -> list[tuple[int, int]]:
    """Half waves along x and y of the first modes: 1 and 1, 3 and 1, 1 and 3, 5 and 1 ..."""
    pairs = [(1, 1), *(pair for n in range(3, modes + 2, 2) for pair in ((n, 1), (1, n)))]
    return pairs[:modes]


def mode_shapes(modes: YawModes, points: np.ndarray) -> np.ndarray:
    """Height (u, k) at points (u, 2), m, from the middle of the box, per displacement of every yaw mode."""
    waves = _waves(len(modes.oscillators))
    return np.column_stack([YawMode(modes.sides, pair, 1.0).shape(points) for pair in waves])


def with_tension(modes: YawModes, length: float) -> YawModes:
    """The same with surface tension, the contact line free to slide at 90 deg.

    Each spring grows by the factor 1 + (l k)^2 [Lamb, Hydrodynamics, sec. 267] and the surface that follows a turn at
    once is lower by it in every mode.

    Args:
        modes: without it.
        length: capillary length l, m.
    """
    oscillators = []
    for item in modes.oscillators:
        tension = STANDARD_GRAVITY * item.stiffness * (length * item.wave_number) ** 2
        oscillators.append(replace(item, frequency=math.sqrt(item.frequency**2 + tension), tension=tension))
    (a, b), odd = modes.sides, np.arange(1, _TERMS, 2)
    m, n = odd[:, None], odd[None]
    squares = np.pi**2 * ((m / a) ** 2 + (n / b) ** 2)
    shares = 16 / np.pi**2 * ((a / m) ** 2 - (b / n) ** 2) / (a * b * squares)
    lost = shares * (length**2 * squares / (1 + length**2 * squares))
    sign = np.sin(odd * np.pi / 2)
    places = zip(wall_points(modes.sides).T, modes.sides, strict=True)
    along = [sign * np.sin(np.outer(place, odd) * np.pi / side) for place, side in places]
    lower = np.einsum("um,mn,un->u", along[0], lost, along[1])
    return replace(modes, oscillators=tuple(oscillators), gains=read_only(modes.gains - lower))


@lru_cache(maxsize=64)
def wall_points(sides: tuple[float, float]) -> np.ndarray:
    """Where the height of the yaw modes is looked at, (9, 2), m, read-only: a corner and four places on either wall.

    The other quarters of the wall mirror these. Over turns of 0.3 to 1.3 s of boxes of one to three sides' ratio the
    highest of them is 96 % of the highest place of the wall or more (`tests/scene/sloshing`).
    """
    half = np.array(sides) / 2
    along = [half * [part, 1.0] for part in _ALONG_WALL] + [half * [1.0, part] for part in _ALONG_WALL]
    return read_only(np.array([half, *along]))


def zhukovsky_potential(sides: tuple[float, float], points: np.ndarray) -> np.ndarray:
    """Z (u,) m^2 at points (u, 2) m of a rectangle, from its middle.

    -x y + sum (8 a s_m/(m pi)^2) sin(p x) sinh(p y)/(p cosh(p b/2)), p = m pi/a, m odd, s_m = sin(m pi/2).
    """
    (a, b), (x, y) = sides, points.T
    m = np.arange(1, 2 * _TERMS, 2)
    p = m * np.pi / a
    height = np.abs(y)[:, None]
    ratio = np.exp(p * (height - b / 2)) * -np.expm1(-2 * p * height) / (1 + np.exp(-p * b))
    terms = 8 * a * np.sin(m * np.pi / 2) / (m * np.pi) ** 2 / p * np.sin(np.outer(x, p)) * ratio
    return -x * y + np.sign(y) * terms.sum(axis=1)
