"""Surface tension: a spring in parallel to that of gravity, and a rest surface that leans less.

With a contact line that slides freely at a contact angle of 90 deg the shapes of a prism's modes stay what they are,
and each frequency becomes omega^2 = (g k + sigma k^3/rho) tanh(k h) [Lamb, Hydrodynamics, sec. 267]; in any other
vessel the same holds to the first order with k^2 the mean squared slope of the mode over its mean square. Only
gravity's part grows with the apparent gravity, so it stays the stiffness and the rest becomes the oscillator's tension.

A contact line that is pinned adds the force that keeps the surface at the wall where it is. In the modes of the free
line, of mass m_n and height C_n at the wall, the frequencies are then the roots of sum C_n^2/(m_n (omega_n^2 -
omega^2)) = 0, one between each two of the free line's. Yaw modes of a box keep the free line's.

Where another contact angle is stated for a round vessel, the modes are those below its curved surface (`curved_modes`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from nospill.core.arrays import read_only
from nospill.scene.containers.base import Container
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.vessel import Vessel
from nospill.scene.liquids import Liquid
from nospill.scene.meridian import Meridian
from nospill.scene.sloshing.modes import STANDARD_GRAVITY, Oscillator, SloshModes
from nospill.scene.sloshing.yaw_modes import with_tension as yaw_with_tension
from nospill.scene.surface_tension.meniscus import capillary_length

ContactLine = Literal["", "free", "pinned"]
"""How the rim of the surface meets the wall; empty: surface tension is left out."""

_MANY = 48
"""Modes with which the pinned line's frequencies are found; half of them tell how far the series has come."""
_KNOWN = 20
"""Modes of a vessel that is no prism that elements give at once."""
_STEPS = 60
_UNMOVED = 1e-6
"""Part of the liquid's mass below which a mode is not moved by a surge, and has no place."""
_FASTEST = 2000.0
"""rad/s; modes that surface tension would make faster swing at this. No arm excites them: they stand where the apparent
gravity puts them, a few micrometres high."""


def liquid_modes(
    container: Container,
    liquid: Liquid,
    level: float,
    count: int,
    *,
    damping: float | None = None,
    contact_line: ContactLine = "",
    contact_angle: float | None = None,
) -> SloshModes:
    """The modes of a liquid in a container, with surface tension where the contact line is stated.

    Args:
        container: its geometry.
        liquid: what is in it.
        level: height at rest, m.
        count: modes in each direction.
        damping: ratio of the slowest mode; the formula's when left out.
        contact_line: "free" or "pinned"; empty for gravity alone.
        contact_angle: at which the surface at rest meets the wall of a round vessel, rad; None for a flat surface.

    Raises:
        ScenarioError: as for `Container.slosh_modes`, likewise ModelError.
    """
    modes = container.slosh_modes(liquid, level, count, damping=damping)
    if not contact_line or capillary_length(liquid) == 0.0:
        return modes
    meridian = None if contact_angle is None else _meridian(container)
    if meridian is not None and contact_angle is not None:
        return _curved_surface_modes(modes, meridian, liquid, contact_angle, pinned=contact_line == "pinned")
    free = with_tension(modes, liquid)
    if contact_line == "free":
        return replace(free, oscillators=tuple(map(_bound_frequency, free.oscillators)))
    many = with_tension(_many(container, liquid, level, count), liquid)
    return replace(free, oscillators=tuple(_bound_frequency(_pin(item, many.oscillators)) for item in free.oscillators))


def _many(container: Container, liquid: Liquid, level: float, count: int) -> SloshModes:
    """So many modes that the pinned line's first `count` are found in them.

    Of a vessel that is no prism the elements give the first ones; the higher ones live near the surface and are those
    of a deep cylinder of its radius, but for a factor on the height at a leaning wall, which the last known ones tell.
    """
    wanted = max(_MANY, 4 * count)
    if not isinstance(container, Vessel):
        return container.slosh_modes(liquid, level, wanted, damping=0.0)
    known = container.slosh_modes(liquid, level, max(_KNOWN, count), damping=0.0)
    radius = container.section(level).radius
    like = Cylinder(radius, 10 * radius).slosh_modes(liquid, 5 * radius, wanted, damping=0.0).oscillators
    pairs = [pair for pair in zip(known.oscillators, like, strict=False) if pair[0].number > known.count // 2]
    ratios = [mode.surface_gain**2 / mode.mass / (other.surface_gain**2 / other.mass) for mode, other in pairs]
    factor = math.sqrt(float(np.median(ratios)))
    higher = (replace(item, surface_gain=factor * item.surface_gain) for item in like[known.count :])
    return replace(known, oscillators=(*known.oscillators, *higher))


def with_tension(modes: SloshModes, liquid: Liquid) -> SloshModes:
    """Modes with the spring of surface tension, and the quasi-static gain of a surface that meets the wall squarely."""
    length = capillary_length(liquid)
    round_section = "y" in modes.oscillators[0].directions and "x" in modes.oscillators[0].directions
    gain = [_gain(half, length, round_section=round_section) for half in modes.quasi_static_gain.tolist()]
    oscillators = tuple(_stretch(item, length) for item in modes.oscillators)
    yaw = modes.yaw and yaw_with_tension(modes.yaw, length)
    if yaw is not None:
        yaw = replace(yaw, oscillators=tuple(map(_bound_frequency, yaw.oscillators)))
    return replace(modes, oscillators=oscillators, quasi_static_gain=read_only(gain), yaw=yaw)


def _meridian(container: Container) -> Meridian | None:
    """Of a round vessel."""
    if isinstance(container, Cylinder):
        edge = (container.radius, 0.0)
        return Meridian((((0.0, 0.0), edge), (edge, (container.radius, container.height))))
    return container.meridian if isinstance(container, Vessel) else None


def _curved_surface_modes(
    modes: SloshModes, meridian: Meridian, liquid: Liquid, angle: float, *, pinned: bool
) -> SloshModes:
    """Modes below the curved surface at rest, with the damping of the flat one; the rest of the liquid follows."""
    from nospill.scene.surface_tension.curved_modes import curved_modes  # only few vessels need the solver

    solved = curved_modes(meridian, modes.liquid_height, modes.count, capillary_length(liquid), angle)
    squares = STANDARD_GRAVITY * (solved.pinned if pinned else solved.curvature + solved.tension)
    masses = liquid.density * solved.volume
    heights = np.where(masses > _UNMOVED * modes.liquid_mass, solved.height, modes.liquid_height)
    oscillators = tuple(
        _bound_frequency(
            replace(
                item,
                frequency=math.sqrt(squares[n]),
                tension=float(squares[n] - STANDARD_GRAVITY * solved.curvature[n]),
                mass=float(masses[n]),
                height=float(heights[n]),
                surface_gain=float(solved.surface_gain[n]),
            )
        )
        for n, item in enumerate(modes.oscillators)
    )
    gain = read_only(np.full(2, solved.quasi_static_gain))
    return replace(modes.with_oscillators(oscillators), quasi_static_gain=gain)


def _bound_frequency(item: Oscillator) -> Oscillator:
    """A mode that is no faster than it needs to be: one that only follows would ask for ever finer steps."""
    fastest = max(_FASTEST, math.sqrt(item.frequency**2 - item.tension))
    if item.frequency <= fastest:
        return item
    return replace(item, frequency=fastest, tension=fastest**2 - STANDARD_GRAVITY * item.stiffness)


def _stretch(item: Oscillator, length: float) -> Oscillator:
    tension = STANDARD_GRAVITY * item.stiffness * (length * item.wave_number) ** 2
    return replace(item, frequency=math.sqrt(item.frequency**2 + tension), tension=tension)


def _gain(half: float, length: float, *, round_section: bool) -> float:
    """Height at the wall per lean of the apparent gravity: g eta - (sigma/rho) laplace(eta) = -a x, square to the wall.

    Args:
        half: radius of the surface or half the side of a box, m.
        length: capillary length, m.
        round_section: which of both.
    """
    if not round_section:
        return half - length * math.tanh(half / length)
    # Only small vessels need it, and SciPy with it; ive does not overflow.
    from scipy.special import ive

    x = half / length
    return half - length / float(ive(0, x) / ive(1, x) - 1.0 / x)


def _pin(item: Oscillator, free: Sequence[Oscillator]) -> Oscillator:
    """An oscillator at the frequency that it has where the contact line is held; all else is the free line's."""
    own = [mode for mode in free if mode.directions == item.directions]
    low, high = (_root(own[: max(len(own) // part, item.number + 1)], item.number) for part in (2, 1))
    # What the series leaves out falls with the number of modes.
    squared = 2.0 * high - low
    return replace(item, frequency=math.sqrt(squared), tension=squared - STANDARD_GRAVITY * item.stiffness)


def _root(free: Sequence[Oscillator], number: int) -> float:
    """Omega^2 of a pinned line, between the free line's for this number and the next, by bisection."""
    squares = np.array([mode.frequency**2 for mode in free])
    weights = np.array([mode.surface_gain**2 / mode.mass for mode in free])
    low, high = float(squares[number - 1]), float(squares[number])
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        if np.sum(weights / (squares - middle)) < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
