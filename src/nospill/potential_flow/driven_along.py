"""The second order driven by waves of the first order that are known already, as a judge has them.

`orders.second_order` is linear in its own state, and what drives it follows from the first order. So every mode is an
oscillator of its own, stiffened by the axial force. A step is exact for a constant one; the source enters by the
trapezoidal rule, which loses (omega h)^2/12 of it. In a cup that turns the oscillators are followed in axes that do not
turn (`driven`).
"""

from __future__ import annotations

import numpy as np

from nospill.core.hermite import cubic_hermite
from nospill.potential_flow.compiled_waves import compiled_waves
from nospill.potential_flow.driven import Driven
from nospill.potential_flow.integration import rows_at
from nospill.potential_flow.orders import lean_of

STEP_ANGLE = 0.04
"""Largest step, rad of the fastest mode: 0.01 % of what drives it is lost, and little of what jerks do within one."""
_STANDS_STILL = 1e-9
"""rad/s; a mode this slow is not told from one without stiffness."""


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
    if len(own) < count:
        picked = (count * np.arange(motions)[:, None] + own).ravel()
        body, displacement, velocity = body[:, picked], displacement[picked], velocity[picked]
    rows = rows_at(body, np.array([0.0, 0.0, basin.depth]))
    begin = np.zeros((2, len(liquid.terms.stiffness))) if start is None else start
    states = _waves(liquid, rows, displacement, velocity, step * np.diff(own), begin, motions)
    if len(own) < count:
        of_each = states.reshape(motions, len(own), -1)
        states = np.concatenate([_between(of_motion, own, every) for of_motion in of_each])
    return states.reshape(motions * count, 2, -1)


def _waves(
    liquid: Driven,
    rows: np.ndarray,
    displacement: np.ndarray,
    velocity: np.ndarray,
    steps: np.ndarray,
    begin: np.ndarray,
    motions: int,
) -> np.ndarray:
    """States (m, 2, J) by steps (m / motions - 1,), s, of all instants; as machine code where that can be had."""
    compiled = compiled_waves(liquid)
    if compiled is None:
        sources = liquid.interactions.sources(_states(liquid, rows, displacement, velocity), rows)
        return _integrated(liquid, sources, rows, steps, begin, motions)
    gains = liquid.gains[liquid.interactions.moved].T
    along, heights, rates = (
        part.reshape(motions, len(steps) + 1, -1) for part in (rows.T, displacement @ gains, velocity @ gains)
    )
    return compiled(along, heights, rates, steps, begin)


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
