"""Joints that do not quite follow their command: late, swinging about it, or on elastic transmissions.

Three ways to be off, each a motion made from the one that is asked for:

- late: joint j does command_j(t - delay_j), through a first-order lag where it has one (`motion.control.followed`);
- swinging: joint j is off by a sinusoid, A cos(2 pi f t + phase);
- elastic: a spring and a damper are between motor and joint, e'' + 2 zeta w e' + w^2 e = -q'' for the distance e of the
  joint from its motor, which does q exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nospill.core.hermite import cubic_hermite, cubic_hermite_slope
from nospill.motion.control import follower
from nospill.motion.interpolation import JointMotion
from nospill.scene.controller import Controller
from nospill.scene.tracking import Arm

_ELASTIC_RATE = 2000.0
"""Hz; of the grid on which an elastic joint is integrated, exactly for accelerations that are linear between."""


def late_by(motion: JointMotion, start: float, stop: float) -> Callable[[Controller], JointMotion]:
    """What late joints make of a motion, on its own clock: joint j is at time t where it should be at t - delay_j.

    Of any arm, from one spline through the motion: many are made in little more time.

    Args:
        motion: that is asked for, at rest before `start` and after `stop`.
        start: s.
        stop: s.

    Returns:
        Delays and lags -> motion.
    """
    behind = follower(motion, start, stop)

    def done(arm: Controller) -> JointMotion:
        if not arm.is_late:
            return motion
        own = behind(arm)
        return lambda t, order=0, /: own(t - arm.latest, order)  # that clock begins with the latest joint

    return done


def done_by(motion: JointMotion, start: float, stop: float, after: float) -> Callable[[Arm], JointMotion]:
    """What the joints of arms make of a motion, on its own clock: late, then elastic, then beside it.

    Args:
        motion: that is asked for, at rest before `start` and after `stop`.
        start: s.
        stop: s.
        after: s, how much longer it is looked at.

    Returns:
        Arm -> motion.
    """
    late = late_by(motion, start, stop)
    return lambda arm: swung(late(arm.controller), arm, start, stop + after)


def swung(motion: JointMotion, arm: Arm, start: float, stop: float) -> JointMotion:
    """What the transmissions of an arm, and what it is off besides, make of the motion of its drives.

    Args:
        motion: of the drives, at rest before `start`.
        arm: the arm.
        start: s.
        stop: s, how far it is looked at.
    """
    if np.any(np.isfinite(arm.frequency)):
        motion = elastic(motion, arm.frequency, arm.damping, start, stop)
    if np.any(arm.amplitude):
        motion = Swinging(motion, arm.amplitude, arm.swing, arm.phase)
    return motion


@dataclass(frozen=True, slots=True)
class Swinging:
    """A motion with a sinusoid on every joint.

    Attributes:
        motion: that is asked for.
        amplitude: (n,) rad.
        frequency: Hz, of all joints or (n,) of each.
        phase: (n,) rad, of the cosine at time 0.
    """

    motion: JointMotion
    amplitude: np.ndarray
    frequency: np.ndarray | float
    phase: np.ndarray

    def __call__(self, t: np.ndarray, order: int = 0, /) -> np.ndarray:
        """The derivative of this order at times t (m,), s."""
        rate = 2.0 * np.pi * np.asarray(self.frequency)
        angle = rate * t[:, None] + self.phase + order * np.pi / 2
        return self.motion(t, order) + self.amplitude * rate**order * np.cos(angle)


@dataclass(frozen=True, slots=True)
class Elastic:
    """A motion of joints that swing on their transmissions.

    Attributes:
        motion: of the motors.
        rate: (n,) natural angular frequency of every joint, rad/s; zero where it is rigid.
        damping: damping ratio.
        t: (m,) grid of the integration, s.
        offset: (m, n) of the joints from the motors, rad.
        velocity: (m, n) its rate, rad/s.
    """

    motion: JointMotion
    rate: np.ndarray
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
        swung = -2.0 * self.damping * self.rate * velocity - self.rate**2 * offset
        rigid = self.rate == 0.0
        return np.where(rigid, self.motion(t, 2), swung) if np.any(rigid) else swung


def elastic(motion: JointMotion, frequency: np.ndarray, damping: float, start: float, stop: float) -> Elastic:
    """What elastic joints make of a motion.

    Args:
        motion: of the motors, at rest before `start`.
        frequency: (n,) natural frequency of every joint, Hz; infinite where it is rigid.
        damping: damping ratio, below 1.
        start: s.
        stop: s, how far it is looked at.
    """
    count = max(2, int(np.ceil((stop - start) * _ELASTIC_RATE)))
    t = np.linspace(start, stop, count + 1)
    step, swings = float(t[1] - t[0]), np.isfinite(frequency)
    rate = 2.0 * np.pi * frequency[swings]
    driven = -motion(t, 2)[:, swings]
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
    offset, velocity = (np.zeros((len(t), len(frequency))) for _ in range(2))
    offset[:, swings] = np.imag(states) / pole.imag
    velocity[:, swings] = np.real(states) + pole.real * offset[:, swings]
    return Elastic(
        motion, np.where(swings, 2.0 * np.pi * np.where(swings, frequency, 0.0), 0.0), damping, t, offset, velocity
    )
