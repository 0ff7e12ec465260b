"""Waves that the modal masses of a liquid leave out, as further coordinates of it: of second order, and what turns do.

With heights h and potentials p of the modes of a problem (`potential_flow.driven_numbers`), V = (p, lean) of those of
masses, and Omega the turn about the axis, source s and pressure P are the quadratic forms of
`potential_flow.interactions`. Heights move as [`potential_flow.orders`]

    h' = kappa p - Omega T h + R lean + s,
    p' = -f_z h - g - Omega (T p + S lean) - P - friction h',

g what pushes to the first order. A coordinate b is what h is beyond the height h0 of the modal mass, which has
h0' = kappa p0 + R lean and p0' = -f_z h0 - g - friction h0' + Q, Q what the turn does to a mass along one side. So

    b'' = s' - (Omega T h)' - kappa (f_z b + Omega (T p + S lean) + P + friction b' + Q),

s' from the linear motion of what it is made of. In a cup the mass swings in two directions and has what a turn does:
its modes have no coordinate, b is the height of the others, which T does not mix with them. Masses of coordinates there
are none: they push nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.frames import SX, FrameMotion
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.slosh.motion import OscillatorState
from nospill.laws.structure import YAW_AXES, ObjectStructure
from nospill.potential_flow.driven_numbers import (
    DrivenKind,
    DrivenModes,
    driven_modes,
    driven_patterns,
    masses_of_modes,
)


@dataclass(frozen=True, slots=True)
class _Terms:
    """Arrays (...) of `potential_flow.driven_numbers`, entries SX, None where they are zero."""

    modes: DrivenModes
    of: dict[str, np.ndarray]

    def form(self, name: str, left: list[Any], right: list[Any]) -> SX:
        """Sum of left_i right_k A_ikl for every l, (d, 1)."""
        table = self.of[name]
        found = []
        for driven in range(table.shape[2]):
            total = SX(0)
            for i, one in enumerate(left):
                part = sum(
                    (table[i, k, driven] * other for k, other in enumerate(right) if table[i, k, driven] is not None),
                    start=SX(0),
                )
                total += one * part
            found.append(total)
        return ca.vertcat(*found)

    def times(self, name: str, right: list[Any]) -> SX:
        """A matrix (r, k) times a vector, (r, 1)."""
        rows = [
            sum((entry * other for entry, other in zip(row, right, strict=True) if entry is not None), start=SX(0))
            for row in self.of[name]
        ]
        return ca.vertcat(*rows)

    def vector(self, name: str) -> SX:
        """A vector, (r, 1)."""
        return ca.vertcat(*[SX(0) if entry is None else entry for entry in self.of[name]])


def _terms(numbers: ObjectNumbers, kind: DrivenKind) -> _Terms:
    values, first, found = SX(numbers.driven), 0, {}
    for name, pattern in driven_patterns(kind).items():
        table = np.full(pattern.shape, None, dtype=object)
        for place in np.argwhere(pattern):
            table[tuple(place)] = values[first]
            first += 1
        found[name] = table
    return _Terms(driven_modes(kind), found)


@dataclass(frozen=True, slots=True)
class _Waves:
    """The modes of a problem at an instant, and of them those of masses, which drive.

    Attributes:
        of_mass: (J, 1) heights of the masses, nothing of other modes.
        height, rate: (J, 1) of all, and how fast they change.
        spun: (d, 1) what a turn does to the potentials of modes with states, T p + S lean.
        heights, rates: n of masses' modes, with what they have beyond the masses.
        velocities: their potentials, and the lean.
        changes: of these.
    """

    of_mass: SX
    height: SX
    rate: SX
    spun: SX
    heights: list[SX]
    rates: list[SX]
    velocities: list[SX]
    changes: list[SX]


def _waves(
    terms: _Terms,
    item: ObjectStructure,
    numbers: ObjectNumbers,
    motion: FrameMotion,
    states: tuple[OscillatorState, ...],
    own: OscillatorState,
) -> _Waves:
    modes, masses = terms.modes, masses_of_modes(item.oscillators, item.driven)
    none, before = SX.zeros(modes.count - modes.moved), SX.zeros(modes.first)
    pairs = [(numbers.oscillators[index].surface_gain, states[index]) for index in masses]
    of_mass = ca.vertcat(*[gain * state.displacement for gain, state in pairs], none)
    height = of_mass + ca.vertcat(before, own.displacement)
    rate = ca.vertcat(*[gain * state.velocity for gain, state in pairs], none) + ca.vertcat(before, own.velocity)
    omega, alpha = motion.angular_velocity, motion.angular_acceleration
    force = motion.at(ca.vertcat(0, 0, numbers.liquid_height)).specific_force
    lean, lean_rate, turn = [omega[1], -omega[0]], [alpha[1], -alpha[0]], omega[2]
    carried = turn * terms.times("turn", ca.vertsplit(height)) - terms.times("rise", lean)
    potential = (rate + carried) / terms.vector("stiffness")
    spun = terms.times("turn", ca.vertsplit(potential)) + terms.times("turned_lean", lean)
    pressure = force[2] * height + terms.vector("friction") * rate + turn * spun
    pressure = pressure[: modes.moved] + terms.times("place", ca.vertsplit(force[:2])) + terms.times("lean", lean_rate)
    pressure += alpha[2] * terms.vector("turning")
    heights, rates, potentials = (ca.vertsplit(part)[: modes.moved] for part in (height, rate, potential))
    changes = [*ca.vertsplit(-pressure), *lean_rate]
    return _Waves(of_mass, height, rate, spun[modes.first :], heights, rates, [*potentials, *lean], changes)


def driven_residual(
    item: ObjectStructure,
    numbers: ObjectNumbers,
    motion: FrameMotion,
    states: tuple[OscillatorState, ...],
    own: OscillatorState,
) -> SX:
    """The equations of motion of the modes with states, (d, 1), m/s^2; zero on a motion, linear in accelerations.

    Args:
        item: structure of the object.
        numbers: of the object.
        motion: of its frame, in its axes.
        states: of its modal masses.
        own: of the modes with states: heights beyond those of masses, m, their rates and accelerations.
    """
    terms = _terms(numbers, item.driven)
    first, waves = terms.modes.first, _waves(terms, item, numbers, motion, states, own)
    turn, turn_rate = motion.angular_velocity[2], motion.angular_acceleration[2]
    axial = motion.at(ca.vertcat(0, 0, numbers.liquid_height)).specific_force[2]
    stiffness, friction = terms.vector("stiffness")[first:], terms.vector("friction")[first:]
    source = terms.form("surface", waves.heights, waves.velocities)
    change = terms.form("surface", waves.rates, waves.velocities)
    change += terms.form("surface", waves.heights, waves.changes)
    for factor, turned in ((turn_rate, waves.height), (turn, waves.rate)):
        change -= factor * terms.times("turn", ca.vertsplit(turned))[first:]
    pressure = terms.form("pressure", waves.heights, [*waves.changes, *[turn * one for one in waves.velocities]])
    pressure += terms.form("square", waves.velocities, waves.velocities) + turn**2 * terms.vector("spin")
    shifted = ca.vertcat(SX.zeros(first), source / stiffness)  # potentials are less by what the source has of rates
    pressure += turn * (waves.spun - terms.times("turn", ca.vertsplit(shifted))[first:])
    push = axial * own.displacement + pressure + friction * own.velocity
    if first < terms.modes.moved:
        push += _of_masses(terms, item, numbers, motion, waves.of_mass)
    return own.acceleration - change + stiffness * push


def _of_masses(terms: _Terms, item: ObjectStructure, numbers: ObjectNumbers, motion: FrameMotion, of_mass: SX) -> SX:
    """Pressures over density (J, 1) of what masses along one side have of a turn: they are thrown outwards."""
    found, omega = SX.zeros(terms.modes.count), motion.angular_velocity
    for place, index in enumerate(masses_of_modes(item.oscillators, item.driven)):
        axis, mass = item.oscillators[index][0], numbers.oscillators[index]
        if item.oscillators[index] != YAW_AXES:
            arm = terms.of["place"][place, axis] * (numbers.liquid_height - mass.height)
            found[place] = omega[2] * (omega[2] * of_mass[place] / terms.of["stiffness"][place] + arm * omega[axis])
    return found


def swinging_on(
    item: ObjectStructure,
    numbers: ObjectNumbers,
    motion: FrameMotion,
    states: tuple[OscillatorState, ...],
    own: OscillatorState,
) -> tuple[tuple[OscillatorState, ...], SX]:
    """What swings on freely once the tray stands level.

    Arguments as of `driven_residual`.

    Returns:
        The modal masses as they would stand with what their modes have beyond them, and squares of the amplitudes of
        the modes that have no mass, (J - n, 1), m^2.
    """
    terms = _terms(numbers, item.driven)
    modes, waves = terms.modes, _waves(terms, item, numbers, motion, states, own)
    free = own.velocity - terms.form("surface", waves.heights, waves.velocities)
    beyond, found = modes.moved - modes.first, list(states)
    if beyond > 0:
        for place, index in enumerate(masses_of_modes(item.oscillators, item.driven)):
            gain, state = numbers.oscillators[index].surface_gain, states[index]
            moved = state.displacement + own.displacement[place] / gain, state.velocity + free[place] / gain
            found[index] = replace(state, displacement=moved[0], velocity=moved[1])
    height, free = own.displacement[max(beyond, 0) :], free[max(beyond, 0) :]
    square_of_frequency = terms.vector("stiffness")[modes.moved :] * motion.specific_force[2]
    return tuple(found), height**2 + free**2 / square_of_frequency


def driven_frequencies(driven: np.ndarray, kind: DrivenKind, gravity: float) -> np.ndarray:
    """Frequencies (d,), rad/s, from the numbers of an object's modes with states."""
    first = 0
    for name, pattern in driven_patterns(kind).items():
        count = int(np.count_nonzero(pattern))
        if name == "stiffness":
            return np.sqrt(gravity * driven[first : first + count])[driven_modes(kind).first :]
        first += count
    raise AssertionError
