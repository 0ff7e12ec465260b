"""What every upright prism with liquid has in common: from wave numbers to the equivalent mechanical model.

Heights are above the bottom. For any upright prism filled to h only the wave number k_n of a mode enters
omega_n^2 = g k_n tanh(k_n h) and H_n = h - (2/k_n) tanh(k_n h/2) (the place of the modal mass with its weight moment
kept).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from nospill.core.arrays import read_only
from nospill.errors import ScenarioError
from nospill.scene.liquids import Liquid
from nospill.scene.sloshing.modes import STANDARD_GRAVITY, Oscillator, SloshModes

_FIRST_ROOT = 1.8411837813406595

EMPIRICAL_DAMPING = 0.92 * 2 * math.sqrt(2) * _FIRST_ROOT**0.25 * (_FIRST_ROOT**2 - 1) / (_FIRST_ROOT**2 + 1)
"""1.65: damping measured in cylinders over that of laminar Stokes layers in a deep one: the published constant 0.92
over (xi^2 + 1)/((xi^2 - 1) 2 sqrt(2) xi^(1/4)) = 0.5575 with xi = 1.8412."""

LARGEST_DAMPING = 0.99
"""Cap of the faster modes' damping ratio, which grows without end: beyond it they no longer swing, only follow."""

MOST_DAMPING = 100.0
"""Largest damping ratio of a slowest mode: a liquid that needs a hundred of its periods to level is none on a tray."""

_SMALLEST_FIXED_FRACTION = 1e-9


@dataclass(frozen=True, slots=True)
class PrismMode:
    """The part of a mode that depends on the cross-section.

    Attributes:
        wave_number: k_n, 1/m.
        mass_fraction: m_n/m_F.
        surface_gain: C_n, height at the wall per displacement of the modal mass.
        layer_ratio: integral of |grad phi|^2 over the wetted walls and bottom over its integral in the volume, 1/m.
        directions: horizontal directions it moves in.
    """

    wave_number: float
    mass_fraction: float
    surface_gain: float
    layer_ratio: float
    directions: tuple[str, ...]

    def frequency(self, liquid_height: float) -> float:
        """omega_n under standard gravity, rad/s."""
        return math.sqrt(STANDARD_GRAVITY * self.wave_number * math.tanh(self.wave_number * liquid_height))

    def mass_height(self, liquid_height: float) -> float:
        """H_n of the modal mass, m."""
        return liquid_height - 2 / self.wave_number * math.tanh(self.wave_number * liquid_height / 2)

    def layer_damping(self, liquid: Liquid, liquid_height: float) -> float:
        """Damping ratio by laminar Stokes layers on walls and bottom.

        A layer dissipates rho |u|^2 sqrt(nu omega/8) per area and time on average (u: amplitude along the wall), the
        wave holds rho/2 times the integral of |u|^2; damping ratio = dissipation/(2 omega energy).
        """
        return math.sqrt(liquid.kinematic_viscosity / (2 * self.frequency(liquid_height))) * self.layer_ratio / 2

    def laminar_damping(self, liquid: Liquid, liquid_height: float) -> float:
        """Stokes layers and the interior, 2 nu k^2/omega [Lamb, Hydrodynamics, sec. 348]."""
        interior = 2 * liquid.kinematic_viscosity * self.wave_number**2 / self.frequency(liquid_height)
        return self.layer_damping(liquid, liquid_height) + interior


@dataclass(frozen=True, slots=True)
class FrozenLiquid:
    """The liquid as a whole.

    Attributes:
        mass: m_F, kg.
        centre_height: of its centre of mass above the bottom, m.
        enclosed_inertia: (2,) inertia of the ideal liquid, closed off at its surface, about the horizontal axes x and
            y through its centre [Stokes-Joukowski], kg m^2.
        quasi_static_gain: (2,) height at the wall per lateral/axial apparent gravity, along x and y, m.
    """

    mass: float
    centre_height: float
    enclosed_inertia: np.ndarray
    quasi_static_gain: np.ndarray


def check_filling(liquid: Liquid, liquid_height: float, count: int, *, rim: float, damping: float | None) -> None:
    """Refuse what no modes can be computed for.

    Raises:
        ScenarioError: liquid height not in (0, rim], viscosity or density not above 0, no mode, damping not in [0, 1).
    """
    if not 0.0 < liquid_height <= rim:
        raise ScenarioError(
            f"liquid_height = {liquid_height:g} m: above 0 and at most the rim's height {rim:g} m is allowed"
        )
    if not (liquid.density > 0.0 and 0.0 < liquid.kinematic_viscosity < math.inf):
        raise ScenarioError(
            f"liquid {liquid.name}: density {liquid.density:g} kg/m^3, viscosity "
            f"{liquid.kinematic_viscosity:g} m^2/s; both must be above 0"
        )
    if count < 1:
        raise ScenarioError(f"slosh modes = {count}: at least 1 is needed for a liquid")
    if damping is not None and not 0.0 <= damping <= MOST_DAMPING:
        raise ScenarioError(
            f"damping = {damping:g}: a damping ratio from 0 to {MOST_DAMPING:g} is allowed; leave it out for the "
            "formula"
        )


def thick_damping(formula: float, mode: LiquidMode, liquid: Liquid, liquid_height: float) -> float:
    """The damping ratio of a formula for thin layers, or that of creeping flow where that is more.

    In a thick liquid a wave no longer swings and falls as exp(-g t/(2 nu k)) [Lamb, Hydrodynamics, sec. 349], as a mode
    of damping ratio nu k^2/omega does; walls only add to it.
    """
    return max(formula, liquid.kinematic_viscosity * mode.wave_number**2 / mode.frequency(liquid_height))


class LiquidMode(Protocol):
    """What the equivalent mechanical model asks of a mode, see `PrismMode`; all but the methods is geometry."""

    @property
    def wave_number(self) -> float: ...  # noqa: D102
    @property
    def mass_fraction(self) -> float: ...  # noqa: D102
    @property
    def surface_gain(self) -> float: ...  # noqa: D102
    @property
    def directions(self) -> tuple[str, ...]: ...  # noqa: D102

    def frequency(self, liquid_height: float) -> float: ...  # noqa: D102

    def mass_height(self, liquid_height: float) -> float: ...  # noqa: D102

    def laminar_damping(self, liquid: Liquid, liquid_height: float) -> float: ...  # noqa: D102


def slosh_model(
    modes: Sequence[LiquidMode], frozen: FrozenLiquid, *, liquid: Liquid, liquid_height: float, damping: float
) -> SloshModes:
    """Equivalent mechanical model: modal masses, and the fixed part that leaves mass, centre and inertia right.

    m_0 = m_F - sum m_n; m_0 H_0 = m_F H_C - sum m_n H_n; I_0 = J_C - m_0 h_0^2 - sum m_n h_n^2 with h_n from the
    liquid's centre.

    Args:
        modes: in the order of the model.
        frozen: the liquid as a whole.
        liquid: for the damping.
        liquid_height: h, m.
        damping: ratio of the slowest mode; the others scale with their laminar damping, up to `LARGEST_DAMPING`.

    Raises:
        ScenarioError: a liquid too viscous to slosh.
    """
    if damping > MOST_DAMPING:
        raise ScenarioError(
            f"liquid {liquid.name}: damping ratio {damping:.3g} of its slowest mode, at most {MOST_DAMPING:g} is "
            "allowed; it is too viscous to slosh: model it as a solid, or state the damping"
        )
    slowest = min(modes, key=lambda mode: mode.wave_number)
    scale = damping / slowest.laminar_damping(liquid, liquid_height)
    oscillators = tuple(
        Oscillator(
            number=1 + sum(slower.directions == mode.directions for slower in modes[:index]),
            frequency=mode.frequency(liquid_height),
            mass=mode.mass_fraction * frozen.mass,
            height=mode.mass_height(liquid_height),
            damping=min(scale * mode.laminar_damping(liquid, liquid_height), max(damping, LARGEST_DAMPING)),
            surface_gain=mode.surface_gain,
            directions=mode.directions,
            wave_number=mode.wave_number,
        )
        for index, mode in enumerate(modes)
    )
    fixed_mass = frozen.mass - sum(oscillator.mass for oscillator in oscillators)
    if abs(fixed_mass) < _SMALLEST_FIXED_FRACTION * frozen.mass:
        # A box can have exactly all of its mass in its modes; its place would then be infinitely far away.
        fixed_mass = _SMALLEST_FIXED_FRACTION * frozen.mass
    centre = frozen.centre_height
    fixed_offset = -sum(mode.mass * (mode.height - centre) for mode in oscillators) / fixed_mass
    moved = fixed_mass * fixed_offset**2 + sum(mode.mass * (mode.height - centre) ** 2 for mode in oscillators)
    return SloshModes(
        oscillators=oscillators,
        liquid_mass=frozen.mass,
        liquid_height=liquid_height,
        fixed_mass=fixed_mass,
        fixed_height=centre + fixed_offset,
        fixed_inertia=read_only(frozen.enclosed_inertia - moved),
        quasi_static_gain=read_only(frozen.quasi_static_gain),
    )


def prism_inside(height: float) -> np.ndarray:
    """Bottom and wall of a prism as `Container.inside` gives them, (3, 2)."""
    return read_only(np.array(((0.0, 0.0), (1.0, 0.0), (1.0, height))))


def prism_outside(height: float) -> np.ndarray:
    """The wall of a prism as `Container.outside` gives it, (2, 2)."""
    return read_only(np.array(((1.0, 0.0), (1.0, height))))


def check_size(value: float, name: str) -> None:
    """Refuse a length that is not a positive finite number.

    Raises:
        ScenarioError: naming the length.
    """
    if not 0.0 < value < math.inf:
        raise ScenarioError(f"{name} = {value:g} m: a length above 0 is needed")


def inverse_sinh_ratio(x: float) -> float:
    """1/sinh(x) for x > 0, without overflow."""
    return -2 * math.exp(-x) / math.expm1(-2 * x)
