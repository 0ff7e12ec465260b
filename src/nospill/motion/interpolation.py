"""From joint samples to a continuous motion: what the receiver of the samples makes of them, one table.

A controller is given samples and moves between them in its own way. The judge plays exactly that motion, so every way
that a file format is read in has its entry here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Protocol

import numpy as np

from nospill.core.piecewise import Pieces, interpolating_spline
from nospill.errors import ScenarioError
from nospill.motion.trajectory import SloshTrack, Trajectory

LOWEST_RATE, HIGHEST_RATE = 10.0, 1000.0
"""Hz; the judge looks at least twice between two samples of the highest."""

_HOLD_SAMPLES = 6
_SAME_INSTANT = 1e-6
"""Part of a period by which rounding may put the end of a motion behind a sample."""


class JointMotion(Protocol):
    """A motion of all joints: times (m,) in s and order of derivative -> (m, n) in rad, rad/s, rad/s^2 ..."""

    def __call__(self, t: np.ndarray, order: int = 0, /) -> np.ndarray:
        """Return the derivative of this order at times `t`."""
        ...


@dataclass(frozen=True, slots=True)
class JointSamples:
    """Joint samples in the order of time.

    Attributes:
        t: (m,) increasing times, s.
        position: (m, n), rad.
        speed: (m, n), rad/s; None where only positions are known.
        acceleration: (m, n), rad/s^2, or None.
    """

    t: np.ndarray
    position: np.ndarray
    speed: np.ndarray | None = None
    acceleration: np.ndarray | None = None

    @property
    def rate(self) -> float:
        """Samples per second, Hz, in the mean."""
        return (len(self.t) - 1) / float(self.t[-1] - self.t[0])


@dataclass(frozen=True, slots=True)
class Interpolation:
    """One way from samples to a motion.

    Attributes:
        name: key in the table.
        title: what it is, in one line.
        motion: (samples) -> motion that passes through all of them and stands still before the first and after the
            last; raises ValueError when the samples lack a column that it needs.
    """

    name: str
    title: str
    motion: Callable[[JointSamples], JointMotion]


@dataclass(frozen=True, slots=True)
class HeldMotion:
    """A motion that stands still at its first and last positions outside [start, end], s."""

    inside: JointMotion
    start: float
    end: float

    def __call__(self, t: np.ndarray, order: int = 0, /) -> np.ndarray:
        """The derivative of this order at times t (m,), zero outside."""
        values = self.inside(np.clip(t, self.start, self.end), order)
        if order:
            values[(t < self.start) | (t > self.end)] = 0.0
        return values


def _quintic_spline(samples: JointSamples) -> JointMotion:
    t, q = samples.t, samples.position
    hold = np.arange(1, _HOLD_SAMPLES + 1) / samples.rate
    times = np.concatenate([t[0] - hold[::-1], t, t[-1] + hold])
    padded = np.concatenate([np.repeat(q[:1], len(hold), axis=0), q, np.repeat(q[-1:], len(hold), axis=0)])
    return HeldMotion(interpolating_spline(times, padded, 5), float(t[0]), float(t[-1]))


def _quintic_hermite(samples: JointSamples) -> JointMotion:
    """Per segment q0 + v0 u + a0 u^2/2 + c3 u^3 + c4 u^4 + c5 u^5 that meets the samples at both its ends.

    With the gaps that the first three terms leave at the end of a segment of length h, d = q1 - q0 - v0 h - a0 h^2/2,
    e = (v1 - v0 - a0 h) h and f = (a1 - a0) h^2: c3 h^3 = 10 d - 4 e + f/2, c4 h^4 = -15 d + 7 e - f,
    c5 h^5 = 6 d - 3 e + f/2.
    """
    if samples.speed is None or samples.acceleration is None:
        raise ValueError("the quintic of a segment needs speeds and accelerations of the samples")
    h = np.diff(samples.t)[:, None]
    (q0, v0, a0), (q1, v1, a1) = (
        [column[part] for column in (samples.position, samples.speed, samples.acceleration)]
        for part in (slice(None, -1), slice(1, None))
    )
    d, e, f = q1 - q0 - v0 * h - a0 * h**2 / 2, (v1 - v0 - a0 * h) * h, (a1 - a0) * h**2
    coefficients = [
        (6 * d - 3 * e + f / 2) / h**5,
        (-15 * d + 7 * e - f) / h**4,
        (10 * d - 4 * e + f / 2) / h**3,
        a0 / 2,
        v0,
        q0,
    ]
    return HeldMotion(Pieces(samples.t, np.stack(coefficients)), float(samples.t[0]), float(samples.t[-1]))


QUINTIC_SPLINE = Interpolation(
    "quintic spline",
    "one quintic spline through the positions: an arm under position control that is given a sample each period",
    _quintic_spline,
)
QUINTIC_HERMITE = Interpolation(
    "quintic hermite",
    "a quintic polynomial per segment through position, speed and acceleration of both its ends",
    _quintic_hermite,
)

INTERPOLATIONS: dict[str, Interpolation] = {item.name: item for item in (QUINTIC_SPLINE, QUINTIC_HERMITE)}
"""Every way from samples to a motion."""


def planned_motion(trajectory: Trajectory) -> JointMotion:
    """The motion that a plan's samples stand for: the quintic spline through its positions."""
    return QUINTIC_SPLINE.motion(JointSamples(trajectory.t, trajectory.joint_position))


def interpolated(trajectory: Trajectory, t: np.ndarray) -> Trajectory:
    """A record at other times (m,), s, each column by the quintic spline through its samples; at rest outside.

    Attitudes are splines of their quaternions, brought to length 1. The liquids of the record are not: at most the
    number of their coordinates can be read of the result.
    """
    names = [field.name for field in fields(trajectory) if field.name not in ("t", "joints", "slosh")]
    samples = [np.reshape(getattr(trajectory, name), (len(trajectory.t), -1)) for name in names]
    samples[names.index("tray_quaternion")] = _on_one_side(trajectory.tray_quaternion)
    ends = np.cumsum([column.shape[1] for column in samples])
    values = QUINTIC_SPLINE.motion(JointSamples(trajectory.t, np.hstack(samples)))(t)
    columns = dict(zip(names, np.split(values, ends[:-1], axis=1), strict=True))
    for name in ("s", "s_rate", "s_acceleration"):
        columns[name] = columns[name][:, 0]
    columns["tray_quaternion"] /= np.linalg.norm(columns["tray_quaternion"], axis=1, keepdims=True)
    slosh = {name: _level(track, len(t)) for name, track in trajectory.slosh.items()}
    return replace(trajectory, t=t, slosh=slosh, **columns)


def _level(track: SloshTrack, count: int) -> SloshTrack:
    coordinates = np.zeros((count, track.displacement.shape[1]))
    return SloshTrack(coordinates, coordinates, np.zeros(count))


def _on_one_side(quaternions: np.ndarray) -> np.ndarray:
    """The same attitudes, each quaternion with the sign that puts it nearest to the one before."""
    flips = np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0
    signs = np.where(np.cumsum(np.concatenate([[0], flips])) % 2, -1.0, 1.0)
    return quaternions * signs[:, None]


def resampled(trajectory: Trajectory, rate: float) -> JointSamples:
    """The motion that a plan's samples stand for, sampled at another rate; nothing is solved again.

    Times are whole nanoseconds from 0, as message formats keep them, and the last one is at or behind the end of the
    plan. The first and the last sample stand still exactly: a controller that is asked for a motion from rest to rest
    refuses what rounding leaves of a speed.

    Args:
        trajectory: the plan's samples.
        rate: samples per second, Hz, 10 to 1000.

    Raises:
        ScenarioError: the rate is not in this range.
    """
    if not LOWEST_RATE <= rate <= HIGHEST_RATE:  # not a number fails too
        raise ScenarioError(f"rate is {rate:g} Hz; allowed are {LOWEST_RATE:g} to {HIGHEST_RATE:g} Hz; try 500")
    return sampled(planned_motion(trajectory), float(trajectory.t[0]), float(trajectory.t[-1]), rate)


def sampled(motion: JointMotion, start: float, stop: float, rate: float) -> JointSamples:
    """Samples of a motion from `start` to `stop` in s, as `resampled` makes them of a plan: times from 0."""
    t = np.round(np.arange(math.ceil((stop - start) * rate - _SAME_INSTANT) + 1) / rate * 1e9) / 1e9
    position, speed, acceleration = (motion(start + t, order) for order in range(3))
    for column in (speed, acceleration):
        column[[0, -1]] = 0.0
    return JointSamples(t, position, speed, acceleration)
