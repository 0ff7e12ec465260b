"""Joints that do not quite follow their command: late, swinging about it, or on elastic transmissions.

Three ways to be off, each a motion made from the one that is asked for:

- late: joint j does command_j(t - delay_j), through a first-order lag where it has one (`motion.control.followed`);
- swinging: joint j is off by a sinusoid, A cos(2 pi f t + phase);
- elastic: a spring and a damper are between motor and joint, e'' + 2 zeta w e' + w^2 e = -q'' for the distance e of the
  joint from its motor, which does q exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.core.hermite import cubic_hermite, cubic_hermite_slope
from nospill.motion.control import followed
from nospill.motion.interpolation import JointMotion
from nospill.scene.controller import Controller

_ELASTIC_RATE = 2000.0
"""Hz; of the grid on which an elastic joint is integrated, exactly for accelerations that are linear between."""


def late(motion: JointMotion, arm: Controller, start: float, stop: float) -> JointMotion:
    """What late joints make of a motion, on its own clock: joint j is at time t where it should be at t - delay_j.

    Args:
        motion: that is asked for, at rest before `start` and after `stop`.
        arm: delays and lags.
        start: s.
        stop: s.
    """
    behind = followed(motion, arm, start, stop)

    def of(t: np.ndarray, order: int = 0, /) -> np.ndarray:
        return behind(t - arm.latest, order)  # that clock begins with the latest joint

    return of


@dataclass(frozen=True, slots=True)
class Swinging:
    """A motion with a sinusoid on every joint.

    Attributes:
        motion: that is asked for.
        amplitude: (n,) rad.
        frequency: Hz.
        phase: (n,) rad, of the cosine at time 0.
    """

    motion: JointMotion
    amplitude: np.ndarray
    frequency: float
    phase: np.ndarray

    def __call__(self, t: np.ndarray, order: int = 0, /) -> np.ndarray:
        """The derivative of this order at times t (m,), s."""
        rate = 2.0 * np.pi * self.frequency
        angle = rate * t[:, None] + self.phase + order * np.pi / 2
        return self.motion(t, order) + self.amplitude * rate**order * np.cos(angle)


@dataclass(frozen=True, slots=True)
class Elastic:
    """A motion of joints that swing on their transmissions.

    Attributes:
        motion: of the motors.
        rate: natural angular frequency of every joint, rad/s.
        damping: damping ratio.
        t: (m,) grid of the integration, s.
        offset: (m, n) of the joints from the motors, rad.
        velocity: (m, n) its rate, rad/s.
    """

    motion: JointMotion
    rate: float
    damping: float
    t: np.ndarray
    offset: np.ndarray
    velocity: np.ndarray

    def __call__(self, t: np.ndarray, order: int = 0, /) -> np.ndarray:
        """The derivative of this order, 0 to 2, at times t (m,) on the grid's span, s."""
        left = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.t) - 2)
        width = float(self.t[1] - self.t[0])
        u = ((t - self.t[left]) / width)[:, None]
        values, slopes = (np.stack([own[left], own[left + 1]]) for own in (self.offset, self.velocity))
        if order == 0:
            return self.motion(t) + cubic_hermite(u, width, values, slopes)
        velocity = cubic_hermite_slope(u, width, values, slopes)
        if order == 1:
            return self.motion(t, 1) + velocity
        offset = cubic_hermite(u, width, values, slopes)
        return -2.0 * self.damping * self.rate * velocity - self.rate**2 * offset


def elastic(motion: JointMotion, frequency: float, damping: float, start: float, stop: float) -> Elastic:
    """What elastic joints make of a motion.

    Args:
        motion: of the motors, at rest before `start`.
        frequency: natural frequency of every joint, Hz.
        damping: damping ratio, below 1.
        start: s.
        stop: s, how far it is looked at.
    """
    rate = 2.0 * np.pi * frequency
    count = max(2, int(np.ceil((stop - start) * _ELASTIC_RATE)))
    t = np.linspace(start, stop, count + 1)
    step, driven = float(t[1] - t[0]), -motion(t, 2)
    # With the complex state z = e' - conj(p) e, z' = p z + u: exact for u linear over a step. e = Im z / Im p.
    pole = rate * complex(-damping, np.sqrt(1.0 - damping**2))
    decay = np.exp(pole * step)
    slope_part = (decay - 1.0 - pole * step) / (pole**2 * step)
    first, last = (decay - 1.0) / pole - slope_part, slope_part
    pushes = first * driven[:-1] + last * driven[1:]
    # z[k + 1] = exp(p h) z[k] + push[k] from rest: sums over one step, two, four, until all are in it
    states, reach = np.vstack([np.zeros(driven.shape[1]), pushes]), 1
    while reach <= count:
        states[reach:] += decay**reach * states[:-reach].copy()
        reach *= 2
    offset = np.imag(states) / pole.imag
    velocity = np.real(states) + pole.real * offset
    return Elastic(motion, rate, damping, t, offset, velocity)
