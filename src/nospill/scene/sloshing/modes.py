"""The modal record of a liquid at rest in its container, whatever the container's shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from nospill.core.arrays import read_only

STANDARD_GRAVITY = 9.80665
"""m/s^2; the value of the published computations."""

YAW = "yaw"
"""Direction of a yaw mode, whose mass slides along a circle about the container's axis."""

WALL_POINTS = 9
"""Places of a quarter of a box's wall at which the height of its yaw modes is looked at (`yaw_modes.wall_points`)."""


@dataclass(frozen=True, slots=True)
class Oscillator:
    """One modal mass of the liquid.

    Attributes:
        frequency: natural frequency omega_n under standard gravity, rad/s, surface tension included.
        mass: modal mass m_n, kg.
        height: height H_n of the mass above the container's bottom at rest, m.
        damping: damping ratio zeta_n.
        surface_gain: C_n, height of the surface at the wall towards which the mass has moved, per its displacement;
            free of g. Positive for every mode of a prism: an apparent gravity that leans moves every mass and every
            crest to the same side; negative for some higher modes of vessels that widen.
        directions: horizontal directions it moves in, ("x", "y") for a circular cup, ("x",) or ("y",) in a box;
            ("yaw",) of a yaw mode.
        wave_number: k_n, 1/m.
        number: n, 1 for the slowest mode along its directions.
        tension: part of omega_n^2 that comes from surface tension and not from gravity, 1/s^2; 0 where it is left out.
        place: (x, y) of the axis that it swings about, m; off the middle where a carrier feels the liquids in it.
        arm: of a yaw mode, radius of the circle along which its mass slides, m; negative where the corner (+, +) falls
            as the mass moves with the turn. Zero of others.
        wall_gains: of a yaw mode, height at each of the `WALL_POINTS` per displacement.
    """

    frequency: float
    mass: float
    height: float
    damping: float
    surface_gain: float
    directions: tuple[str, ...]
    wave_number: float
    number: int
    tension: float = 0.0
    place: tuple[float, float] = (0.0, 0.0)
    arm: float = 0.0
    wall_gains: tuple[float, ...] = ()

    @property
    def yaws(self) -> bool:
        """Whether it is a yaw mode."""
        return self.directions == (YAW,)

    @property
    def stiffness(self) -> float:
        """k_n tanh(k_n h), 1/m: restoring acceleration per displacement and apparent gravity; free of g.

        omega_n^2/g where surface tension is left out. The mass at rest in an apparent gravity that leans by a_xy/a_z
        then stands at -a_xy/(a_z stiffness).
        """
        return (self.frequency**2 - self.tension) / STANDARD_GRAVITY

    @property
    def compliance(self) -> float:
        """g/omega_n^2, m: displacement at rest per lean of standard gravity."""
        return STANDARD_GRAVITY / self.frequency**2

    @property
    def curvature(self) -> float:
        """P_n, 1/m: curvature of the surface the mass slides on, a paraboloid for the first mode, else a plane.

        On a paraboloid gravity along the axis is the spring, and P_1 is the stiffness. A fast mode would stand on a
        slope of 1 at a displacement of a millimetre or two, where nothing but linear potential theory supports it; its
        spring is linear. So is that of a yaw mode.
        """
        return self.stiffness if self.number == 1 and not self.yaws else 0.0


def wall_gains(oscillators: Sequence[Oscillator]) -> np.ndarray:
    """Heights per coordinate, (11, k): of modes along x and y at the wall there, of yaw modes at `WALL_POINTS`."""
    columns = []
    for mode in oscillators:
        for direction in mode.directions:
            gains = np.zeros(2 + WALL_POINTS)
            if direction == YAW:
                gains[2:] = mode.wall_gains
            else:
                gains["xy".index(direction)] = mode.surface_gain
            columns.append(gains)
    return np.array(columns).reshape(-1, 2 + WALL_POINTS).T


@dataclass(frozen=True, slots=True)
class YawModes:
    """What a turn about the vertical moves in the liquid of a box, see `yaw_modes`.

    Attributes:
        oscillators: the yaw modes, first that of one half wave along each side; their displacement is the height in the
            corner (+, +).
        sides: of the box along x and y, m.
        inertia: of the liquid about the vertical under a closed surface, kg m^2; less than that of the frozen liquid.
        gains: (9,) m^2, height at each of the `WALL_POINTS` per -psi''/a_z with all modes.
    """

    oscillators: tuple[Oscillator, ...]
    sides: tuple[float, float]
    inertia: float
    gains: np.ndarray

    @property
    def fixed_inertia(self) -> float:
        """Of what is left besides the moving masses, kg m^2; with all of them in place it is `inertia`."""
        return self.inertia - sum(mode.mass * mode.arm**2 for mode in self.oscillators)

    @property
    def static_correction(self) -> np.ndarray:
        """As `SloshModes.static_correction`, of the yaw modes that are not carried: (9,) m^2 per -psi''/a_z."""
        carried = [mode.arm * mode.compliance * np.array(mode.wall_gains) for mode in self.oscillators]
        return read_only(self.gains - np.sum(carried, axis=0))


@dataclass(frozen=True, slots=True)
class SloshModes:
    """Equivalent mechanical model of a liquid: a fixed part and modal masses [slosh theory].

    Attributes:
        oscillators: ordered mode by mode; a box gives x then y for every mode.
        liquid_mass: m_F, kg.
        liquid_height: h at rest, m.
        fixed_mass: m_0 = m_F - sum m_n, kg. Negative in a shallow box, whose modes along x and along y both leave it
            although each is carried rigidly across its own direction; m_0 plus those masses is never negative.
        fixed_height: H_0 above the bottom from sum m_i H_i = m_F H_C (h/2 in a prism), m.
        fixed_inertia: I_0 about the horizontal axes through H_0, shape (2,), kg m^2 (x axis, y axis); about the
            vertical it is that of `yaw`.
        quasi_static_gain: (2,), m: height at the wall per lateral/axial apparent gravity with all modes, along x and y
            (radius of the rest surface, or half the side of a box).
        yaw: what a turn about the vertical moves; None in a body of revolution, whose liquid stays where it is.
    """

    oscillators: tuple[Oscillator, ...]
    liquid_mass: float
    liquid_height: float
    fixed_mass: float
    fixed_height: float
    fixed_inertia: np.ndarray
    quasi_static_gain: np.ndarray
    yaw: YawModes | None = None

    @property
    def slowest(self) -> Oscillator:
        """The one of the lowest frequency: the first mode, of a box that along its longer side."""
        return min(self.oscillators, key=lambda mode: mode.frequency)

    @property
    def count(self) -> int:
        """Number of modes in each direction."""
        return max(mode.number for mode in self.oscillators)

    @property
    def static_correction(self) -> np.ndarray:
        """Quasi-static height that the modes carried leave out, along x and y, shape (2,), m, read-only.

        quasi_static_gain - sum C_n g/omega_n^2 in standard gravity. With a the specific force at the rest surface the
        height at the wall is |sum C_n q_n - static_correction a_xy/a_z|: the modes not carried follow the apparent
        gravity at once. For one mode of a circular cup it is (1 - 2/(xi_1^2 - 1)) R, 16 % of the radius.
        """
        carried = [
            sum(mode.surface_gain * mode.compliance for mode in self.oscillators if axis in mode.directions)
            for axis in ("x", "y")
        ]
        return read_only(self.quasi_static_gain - carried)

    def faster(self, factor: float) -> SloshModes:
        """The same liquid with all its frequencies times a factor: an error of the model, whatever makes it."""
        if factor == 1.0:
            return self

        def changed(modes: tuple[Oscillator, ...]) -> tuple[Oscillator, ...]:
            return tuple(replace(mode, frequency=factor * mode.frequency) for mode in modes)

        yaw = None if self.yaw is None else replace(self.yaw, oscillators=changed(self.yaw.oscillators))
        return replace(self, oscillators=changed(self.oscillators), yaw=yaw)

    def with_oscillators(self, oscillators: tuple[Oscillator, ...]) -> SloshModes:
        """The same liquid with other modal masses; the fixed part leaves its mass, centre and inertia as they were."""

        def sums(mass: float, height: float, modes: tuple[Oscillator, ...]) -> np.ndarray:
            parts = [(mass, height), *((mode.mass, mode.height) for mode in modes)]
            return np.array([sum(m * z**power for m, z in parts) for power in (0, 1, 2)])

        before, moved = sums(self.fixed_mass, self.fixed_height, self.oscillators), sums(0.0, 0.0, oscillators)
        mass, moment, _ = before - moved
        inertia = self.fixed_inertia + before[2] - moved[2] - moment**2 / mass
        return replace(
            self,
            oscillators=oscillators,
            fixed_mass=float(mass),
            fixed_height=float(moment / mass),
            fixed_inertia=read_only(inertia),
        )
