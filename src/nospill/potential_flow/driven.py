"""The second order driven by waves of the first order that are known already, as a judge has them.

`orders.second_order` is linear in its own state, and what drives it follows from the first order. So every mode is an
oscillator of its own, stiffened by the axial force. A step is exact for a constant one; the source enters by the
trapezoidal rule, which loses (omega h)^2/12 of it. A turn about the axis takes waves with m nodal diameters round as
exp(-i m theta), so those of a cup are integrated in axes that do not turn. In a box a turn mixes all modes; that part
is left out of the second order, as the modal model leaves it out of the first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nospill.core.hermite import cubic_hermite
from nospill.potential_flow.basin import Basin, driven_basin
from nospill.potential_flow.integration import rows_at
from nospill.potential_flow.interactions import Interactions, interactions
from nospill.potential_flow.orders import LinearTerms, lean_of, linear_terms
from nospill.scene.cargo import Cargo
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.sloshing.modes import Oscillator

STEP_ANGLE = 0.04
"""Largest step, rad of the fastest mode: 0.01 % of what drives it is lost, and little of what jerks do within one."""
_STANDS_STILL = 1e-9
"""rad/s; a mode this slow is not told from one without stiffness."""
_ROUNDING = 1e-9
"""Part of the largest share of a mode below which it is none."""


@dataclass(frozen=True, slots=True)
class Driven:
    """A liquid whose second order is asked for.

    Attributes:
        terms: of the first and the second order, in the modes that drive and are driven.
        gains: (J, k) height of every mode per displacement of the modal masses.
        axes: (J, L) amplitudes of the driven oscillators per height of a mode, complex for a pair of cosine and sine.
        diameters: (L,) nodal diameters of a cup's oscillators; 0 in a box.
        interactions: of the modes that drive.
    """

    terms: LinearTerms
    gains: np.ndarray
    axes: np.ndarray
    diameters: np.ndarray
    interactions: Interactions


def driven(cargo: Cargo) -> Driven:
    """Set up the second order of a liquid; `unsupported` says whether it may be asked for."""
    assert cargo.filling is not None  # what is asked for is a liquid
    return _driven_like(LiquidKey(cargo))


@lru_cache(maxsize=64)
def _driven_like(key: LiquidKey) -> Driven:
    terms, cargo = linear_terms(driven_basin(key.cargo)), key.cargo
    count = len(terms.stiffness)
    axes, diameters = np.eye(count, dtype=complex), np.zeros(count)
    if isinstance(cargo.container, Cylinder):
        turned = np.rint(np.max(np.abs(terms.spin), axis=0))
        columns = []
        for mode in np.flatnonzero(turned != 1):
            partner = int(np.argmax(terms.spin[:, mode]))
            if turned[mode] == 0 or terms.spin[partner, mode] > 0.5:
                column = np.zeros(count, complex)
                column[mode] = 1.0
                column[partner] += 1j if turned[mode] else 0.0
                columns.append((column, turned[mode]))
        axes, diameters = np.stack([item[0] for item in columns], axis=1), np.array([item[1] for item in columns])
    gains = height_gains(cargo.oscillators, terms.basin)
    return Driven(terms, gains, axes, diameters, interactions(terms, _driving(terms, gains)))


def _driving(terms: LinearTerms, gains: np.ndarray) -> np.ndarray:
    """Places (n,) of the modes that the masses, the tray or a turn move to the first order, rounding left out."""
    turned = (np.abs(terms.spin) > _ROUNDING * np.max(np.abs(terms.spin), initial=1e-300)).astype(float)
    reached = np.any(gains, axis=1)
    for column in (terms.rise, terms.lean, terms.place, terms.slip, terms.turn[:, None]):
        size = np.max(np.abs(column), axis=1)
        reached |= size > _ROUNDING * np.max(size, initial=1e-300)
    return np.flatnonzero(reached | (turned @ reached > 0.0))


class LiquidKey:
    """A liquid by what its terms follow from; equal of like ones."""

    def __init__(self, cargo: Cargo) -> None:
        filling = cargo.filling
        assert filling is not None
        slowest = filling.modes.slowest
        self.cargo = cargo
        self.values = (
            cargo.container,
            filling.liquid_height,
            slowest.wave_number,
            slowest.damping,
            filling.liquid.kinematic_viscosity,
            filling.oscillators,
        )

    def __hash__(self) -> int:
        return hash(self.values)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, LiquidKey) and self.values == other.values


def height_gains(oscillators: Sequence[Oscillator], basin: Basin) -> np.ndarray:
    """Heights (J, k) of a basin's modes per displacement of modal masses; nothing of masses whose mode it has not."""
    modes, place, columns = basin.modes, basin.place, []
    for mode in oscillators:
        near = np.isclose(modes.wave_number, mode.wave_number, rtol=1e-6)
        for direction in mode.directions:
            share = np.ones(len(near)) if mode.yaws else np.abs(place[:, "xy".index(direction)])
            column = np.zeros(len(near))
            if np.any(near):
                column[int(np.argmax(np.where(near, share, -1.0)))] = mode.surface_gain
            columns.append(column)
    return np.array(columns).T


def second_order_states(
    liquid: Driven,
    body: np.ndarray,
    displacement: np.ndarray,
    velocity: np.ndarray,
    step: float,
    start: np.ndarray | None = None,
    *,
    motions: int = 1,
    step_angle: float = STEP_ANGLE,
) -> np.ndarray:
    """Heights, m, and own velocities, m/s, of the second order in the modes of the basin, (m, 2, J).

    An own velocity is the stiffness times the potential: that of the height without what drives it.

    Args:
        liquid: which.
        body: (9, m) angular velocity, angular acceleration and specific force of the bottom's centre, container axes.
        displacement: (m, k) of the modal masses, m.
        velocity: (m, k) likewise, m/s.
        step: between the instants, s.
        start: (2, J) when it begins; at rest when left out.
        motions: how many of one length follow one another in the instants, each of which begins so.
        step_angle: largest step of the integration, rad of the fastest mode.
    """
    basin, count = liquid.terms.basin, len(displacement) // motions
    every = max(int(step_angle / (float(np.max(basin.frequency)) * step)), 1)
    own = np.append(np.arange(0, count - 1, every), count - 1)
    picked = (count * np.arange(motions)[:, None] + own).ravel()
    rows = rows_at(body[:, picked], np.array([0.0, 0.0, basin.depth]))
    first = _states(liquid, rows, displacement[picked], velocity[picked])
    sources = liquid.interactions.sources(first, rows)
    begin = np.zeros((2, len(liquid.terms.stiffness))) if start is None else start
    states = _integrated(liquid, sources, rows, step * np.diff(own), begin, motions)
    if len(own) < count:
        of_each = states.reshape(motions, len(own), -1)
        states = np.concatenate([_between(of_motion, own, every) for of_motion in of_each])
    return states.reshape(motions * count, 2, -1)


def _between(states: np.ndarray, picked: np.ndarray, every: int) -> np.ndarray:
    """States (n, c) at some places, `every` apart but for the last one, at all places between, by cubics: (m, c).

    Straight lines would lose 0.2 % of the fastest mode, and where depends on the instant at which a motion begins.
    """
    slopes = np.gradient(states, picked, axis=0, edge_order=2 if len(picked) > 2 else 1)
    ends = np.stack([states[:-1], states[1:], slopes[:-1], slopes[1:]], axis=1)
    width, last = float(every), int(picked[-1] - picked[-2])
    before = _cubic_weights(np.arange(every) / width, width) @ ends[:-1]
    after = _cubic_weights(np.arange(last + 1) / last, float(last)) @ ends[-1]
    return np.concatenate([before.reshape(-1, states.shape[1]), after])


def _cubic_weights(u: np.ndarray, width: float) -> np.ndarray:
    """Weights (m, 4) of both values and both slopes at places u (m,), from 0 to 1, of an interval."""
    ends, none = np.eye(2)[:, :, None], np.zeros((2, 2, 1))
    weights = [cubic_hermite(u, width, ends, none), cubic_hermite(u, width, none, ends)]
    return np.concatenate(weights).T


def _states(liquid: Driven, rows: np.ndarray, displacement: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """(m, 2, J) heights and potentials of the first order, these as the surface's own motion has them."""
    terms, height = liquid.terms, displacement @ liquid.gains.T
    carried = rows[2][:, None] * (height @ terms.spin.T)
    leaned = (terms.rise @ lean_of(rows[:3])).T
    return np.stack([height, (velocity @ liquid.gains.T + carried - leaned) / terms.stiffness], axis=1)


def _integrated(
    liquid: Driven, sources: np.ndarray, rows: np.ndarray, steps: np.ndarray, begin: np.ndarray, motions: int
) -> np.ndarray:
    """States (m, 2, J), heights and own velocities, that sources (m, 2, J) make from that at the beginning, (2, J).

    Some motions follow one another, with the same steps each; between two of them all begins anew.
    """
    terms, count = liquid.terms, len(steps) + 1
    turn = np.zeros((motions, count))
    spin = rows[2].reshape(motions, count)
    turn[:, 1:] = np.cumsum((spin[:, :-1] + spin[:, 1:]) / 2 * steps, axis=1)
    still = np.exp(1j * np.outer(turn, liquid.diameters))  # from the cup's axes to those that do not turn
    pushes = np.stack([sources[:, 0], -sources[:, 1] - terms.friction * sources[:, 0]]) @ liquid.axes * still
    of_pair = np.argmax(np.abs(liquid.axes), axis=0)
    kappa = terms.stiffness[of_pair]
    decay, force = terms.friction[of_pair] * kappa / 2, (rows[8][:-1] + rows[8][1:])[:, None] / 2
    root = np.sqrt((kappa * force - decay**2).astype(complex))
    root = np.where(np.abs(root) < _STANDS_STILL, _STANDS_STILL, root)
    h = np.tile(np.append(steps, 0.0), motions)[:-1, None]
    fade = np.exp(-decay * h)
    cosine, sine = np.real(fade * np.cos(root * h)), np.real(fade * np.sin(root * h) / root)
    onwards = np.stack([cosine + decay * sine, kappa * sine, -force * sine, cosine - decay * sine], axis=1)
    onwards = onwards.reshape(-1, 2, 2, len(kappa))
    before, after = h / 2 * pushes[:, :-1], h / 2 * pushes[:, 1:]
    pushed = np.einsum("kxyl,ykl->kxl", onwards, before) + np.moveaxis(after, 1, 0)
    scale = np.stack([np.ones_like(kappa), kappa])
    at_first, anew = begin @ liquid.axes / scale, slice(count - 1, None, count)
    onwards[anew], pushed[anew] = 0.0, at_first
    states = recursion(onwards, pushed, at_first)
    found = states * scale * still.conj()[:, None]
    return np.real(found @ liquid.axes.conj().T)


def recursion(onwards: np.ndarray, pushed: np.ndarray, begin: np.ndarray) -> np.ndarray:
    """States (m + 1, 2, L), s[k + 1] = onwards[k] s[k] + pushed[k], in about 3 sqrt(m) calls of NumPy.

    The steps are cut into blocks. All blocks go on at once from rest and from both unit states; then one block after
    the other is begun where the one before ends.

    Args:
        onwards: (m, 2, 2, L).
        pushed: (m, 2, L).
        begin: (2, L).
    """
    count, length = len(onwards), max(int(np.sqrt(len(onwards))), 1)
    blocks, missing = -(-count // length), -count % length
    filled = np.zeros((missing, *onwards.shape[1:])) + np.eye(2)[..., None]
    matrices = np.concatenate([onwards, filled]).reshape(blocks, length, *onwards.shape[1:])
    shifts = np.concatenate([pushed, np.zeros((missing, *pushed.shape[1:]), complex)])
    shifts = shifts.reshape(blocks, length, *pushed.shape[1:])
    at_rest = np.zeros((length + 1, *shifts[:, 0].shape), complex)
    units = np.zeros((length + 1, *matrices[:, 0].shape))
    units[0] = np.eye(2)[..., None]
    for step in range(length):
        matrix = matrices[:, step]
        at_rest[step + 1] = matrix[:, :, 0] * at_rest[step, :, :1] + matrix[:, :, 1] * at_rest[step, :, 1:]
        at_rest[step + 1] += shifts[:, step]
        units[step + 1] = matrix[:, :, :1] * units[step, :, :1] + matrix[:, :, 1:] * units[step, :, 1:]
    begun = np.empty((blocks, *begin.shape), complex)
    state = begin.astype(complex)
    for block in range(blocks):
        begun[block] = state
        state = (units[-1, block] * state).sum(axis=1) + at_rest[-1, block]
    states = at_rest + units[..., 0, :] * begun[:, :1] + units[..., 1, :] * begun[:, 1:]
    return np.concatenate([begin[None], np.moveaxis(states[1:], 0, 1).reshape(-1, *begin.shape)])[: count + 1]
