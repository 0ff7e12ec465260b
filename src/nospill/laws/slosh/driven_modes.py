"""Waves of second order that the modes of a cup drive, as further coordinates of its liquid.

With heights e and potentials p of the modes that drive, as their masses have them, V = (p, lean) and Omega the turn
about the axis, source s and pressure P are the quadratic forms of `potential_flow.interactions`. In axes of the cup a
driven mode of height b moves as [`potential_flow.orders`]

    D b = w + s,     D w = -kappa (f_z b + P + friction D b),     D = d/dt + Omega turn,

that is, with s' from the linear motion of what it is made of, D^2 b - D s + kappa (f_z b + P + friction D b) = 0: an
equation of the second order for a coordinate like all others. Its mass is none: it pushes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.frames import SX, FrameMotion
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.slosh.motion import OscillatorState
from nospill.potential_flow.driven_numbers import driven_patterns


@dataclass(frozen=True, slots=True)
class _Terms:
    """Arrays (...) of `potential_flow.driven_numbers`, entries SX or a plain zero."""

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
        return ca.vertcat(*self.of[name])


def _terms(numbers: ObjectNumbers) -> _Terms:
    values, first, found = SX(numbers.driven), 0, {}
    for name, pattern in driven_patterns().items():
        table = np.full(pattern.shape, None, dtype=object)
        for place in np.argwhere(pattern):
            table[tuple(place)] = values[first]
            first += 1
        found[name] = table
    return _Terms(found)


@dataclass(frozen=True, slots=True)
class _Waves:
    """What drives, at an instant: heights, potentials and lean, and their changes."""

    height: list[SX]
    velocity: list[SX]
    height_change: list[SX]
    changes: list[SX]


def _driving(terms: _Terms, numbers: ObjectNumbers, motion: FrameMotion, states: tuple[OscillatorState, ...]) -> _Waves:
    """The waves of the modal masses, of which the slowest ones drive; `states` are theirs along x and y."""
    count = len(terms.of["stiffness"]) // 2
    own = list(zip(numbers.oscillators, states, strict=True))[:count]
    height = ca.vertcat(*[mode.surface_gain * state.displacement for mode, state in own])
    rate = ca.vertcat(*[mode.surface_gain * state.velocity for mode, state in own])
    omega, alpha = motion.angular_velocity, motion.angular_acceleration
    force = motion.at(ca.vertcat(0, 0, numbers.liquid_height)).specific_force
    lean, lean_rate, turn = [omega[1], -omega[0]], [alpha[1], -alpha[0]], omega[2]
    heights = ca.vertsplit(height)
    carried = turn * terms.times("turn", heights) - terms.times("rise", lean)
    potential = (rate + carried) / terms.vector("stiffness")
    potentials = ca.vertsplit(potential)
    linear_rate = rate  # stiffness times potential, and what leans and turns
    pressure = force[2] * height + terms.times("place", ca.vertsplit(force[:2])) + terms.times("lean", lean_rate)
    pressure += turn * (terms.times("turn", potentials) + terms.times("turned_lean", lean))
    change = -pressure - terms.vector("friction") * linear_rate
    return _Waves(heights, [*potentials, *lean], ca.vertsplit(rate), [*ca.vertsplit(change), *lean_rate])


def driven_residual(
    numbers: ObjectNumbers, motion: FrameMotion, states: tuple[OscillatorState, ...], own: OscillatorState
) -> SX:
    """The equations of motion of the driven modes, (d, 1), m/s^2; zero on a motion, linear in their accelerations.

    Args:
        numbers: of the object.
        motion: of its frame, in its axes.
        states: of its modal masses.
        own: of the driven modes: heights, m, their rates and accelerations.
    """
    terms = _terms(numbers)
    waves = _driving(terms, numbers, motion, states)
    turn, axial = motion.angular_velocity[2], motion.at(ca.vertcat(0, 0, numbers.liquid_height)).specific_force[2]
    source = terms.form("surface", waves.height, waves.velocity)
    source_rate = terms.form("surface", waves.height_change, waves.velocity)
    source_rate += terms.form("surface", waves.height, waves.changes)
    pressure = terms.form("pressure", waves.height, [*waves.changes, *[turn * one for one in waves.velocity]])
    pressure += terms.form("square", waves.velocity, waves.velocity)

    def turned(values: SX) -> SX:
        return terms.times("own_turn", ca.vertsplit(values))

    rate = own.velocity + turn * turned(own.displacement)
    change = own.acceleration + 2 * turn * turned(own.velocity) + turn**2 * turned(turned(own.displacement))
    change += motion.angular_acceleration[2] * turned(own.displacement)
    push = axial * own.displacement + pressure + terms.vector("own_friction") * rate
    return change - source_rate - turn * turned(source) + terms.vector("own_stiffness") * push


def driven_squares(
    numbers: ObjectNumbers, motion: FrameMotion, states: tuple[OscillatorState, ...], own: OscillatorState
) -> SX:
    """Squares of the amplitudes of the driven modes once the tray stands level, (d, 1), m^2; arguments as there."""
    terms = _terms(numbers)
    waves = _driving(terms, numbers, motion, states)
    free = own.velocity - terms.form("surface", waves.height, waves.velocity)
    frequency = terms.vector("own_stiffness") * motion.specific_force[2]
    return own.displacement**2 + free**2 / frequency


def driven_frequencies(driven: np.ndarray, gravity: float) -> np.ndarray:
    """Frequencies (d,), rad/s, from the numbers of an object's driven modes."""
    first = 0
    for name, pattern in driven_patterns().items():
        count = int(np.count_nonzero(pattern))
        if name == "own_stiffness":
            return np.sqrt(gravity * driven[first : first + count])
        first += count
    raise AssertionError
