"""The modal record of a liquid at rest in its container, whatever the container's shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

STANDARD_GRAVITY = 9.80665
"""m/s^2; the value of the published computations."""


@dataclass(frozen=True, slots=True)
class Oscillator:
    """One modal mass of the liquid.

    Attributes:
        frequency: natural frequency omega_n under standard gravity, rad/s.
        mass: modal mass m_n, kg.
        height: height H_n of the mass above the container's bottom at rest, m.
        damping: damping ratio zeta_n.
        surface_gain: C_n, height of the surface at the wall per displacement of the mass (signed where walls differ in sign).
        directions: horizontal directions it moves in, ("x", "y") for a circular cup, ("x",) or ("y",) in a box.
        wave_number: k_n, 1/m.
    """

    frequency: float
    mass: float
    height: float
    damping: float
    surface_gain: float
    directions: tuple[str, ...]
    wave_number: float

    @property
    def curvature(self) -> float:
        """P = omega_n^2/g = k_n tanh(k_n h), 1/m: curvature of the paraboloid the mass slides on; free of g."""
        return self.frequency**2 / STANDARD_GRAVITY


@dataclass(frozen=True, slots=True)
class SloshModes:
    """Equivalent mechanical model of a liquid: a fixed part and modal masses [slosh theory, upright prism].

    Attributes:
        oscillators: ordered mode by mode; a box gives x then y for every mode.
        liquid_mass: m_F, kg.
        liquid_height: h at rest, m.
        fixed_mass: m_0 = m_F - sum m_n, kg.
        fixed_height: H_0 above the bottom from sum m_i H_i = m_F h/2, m.
        fixed_inertia: I_0 about the horizontal axes through H_0, shape (2,), kg m^2 (x axis, y axis); zero about the vertical.
        frozen_yaw_inertia: inertia of the frozen liquid about the vertical axis, a bound for the twist constraint, kg m^2.
        quasi_static_gain: (2,), m: height at the wall per lateral/axial apparent gravity with all modes, along x and y
            (R, or half the side of a box).
    """

    oscillators: tuple[Oscillator, ...]
    liquid_mass: float
    liquid_height: float
    fixed_mass: float
    fixed_height: float
    fixed_inertia: np.ndarray
    frozen_yaw_inertia: float
    quasi_static_gain: np.ndarray
