"""From joint samples to a continuous motion: what the receiver of the samples makes of them, one table.

A controller is given samples and moves between them in its own way. The judge plays exactly that motion, so every way
that a file format is read in has its entry here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from nospill.core.piecewise import Pieces, interpolating_spline

_HOLD_SAMPLES = 6


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
        in_motion: whether the joints have come to the first sample with its speed and acceleration, and not from rest.
    """

    t: np.ndarray
    position: np.ndarray
    speed: np.ndarray | None = None
    acceleration: np.ndarray | None = None
    in_motion: bool = field(default=False, kw_only=True)

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
            last, and of samples in motion goes on from the speed and acceleration of the first; raises ValueError when
            the samples lack a column that it needs.
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
    if samples.in_motion and samples.speed is not None and samples.acceleration is not None:
        first = np.stack([samples.speed[0], samples.acceleration[0]])
        return HeldMotion(_beginning_with(first, times, padded, t[0]), float(t[0]), float(t[-1]))
    return HeldMotion(interpolating_spline(times, padded, 5), float(t[0]), float(t[-1]))


def _beginning_with(first: np.ndarray, times: np.ndarray, values: np.ndarray, start: float) -> Pieces:
    """The quintic spline that begins with speed and acceleration `first` (2, n), whatever was before it.

    Two polynomials before `start`, in the place of what would be there, bend it to them: it is linear in its values.
    Constant acceleration there would not do, since the jerk may jump: 4e-3 rad/s were seen at 125 Hz.

    Args:
        first: rad/s and rad/s^2.
        times: (m,), some of them before `start`, s.
        values: (m, n), rad.
        start: s.
    """
    since = np.minimum(times - start, 0.0)[:, None]
    quadratic = since * first[0] + since**2 / 2 * first[1]
    bends = (since / since[0]) ** np.array([3.0, 4.0])
    spline = interpolating_spline(times, np.hstack([values + quadratic, bends]), 5)
    found = np.concatenate([spline(np.array([start]), order) for order in (1, 2)])
    weights = np.linalg.solve(found[:, -2:], first - found[:, :-2])
    return Pieces(spline.breaks, spline.coefficients[..., :-2] + spline.coefficients[..., -2:] @ weights)


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


def _cubic_hermite(samples: JointSamples) -> JointMotion:
    """Per segment the cubic that has positions and speeds of both its ends; its acceleration jumps at the samples.

    With d = q1 - q0 of a segment of length h: q0 + v0 u + (3 d/h - 2 v0 - v1) u^2/h + (v0 + v1 - 2 d/h) u^3/h^2.
    """
    if samples.speed is None:
        raise ValueError("the cubic of a segment needs speeds of the samples")
    h = np.diff(samples.t)[:, None]
    (q0, v0), (q1, v1) = (
        [column[part] for column in (samples.position, samples.speed)] for part in (slice(None, -1), slice(1, None))
    )
    mean = (q1 - q0) / h
    coefficients = [(v0 + v1 - 2 * mean) / h**2, (3 * mean - 2 * v0 - v1) / h, v0, q0]
    return HeldMotion(Pieces(samples.t, np.stack(coefficients)), float(samples.t[0]), float(samples.t[-1]))


def _cubic_spline(samples: JointSamples) -> JointMotion:
    """The cubic spline through the positions that stands still at both ends."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(samples.t, samples.position, bc_type="clamped")
    return HeldMotion(Pieces(samples.t, spline.c), float(samples.t[0]), float(samples.t[-1]))


def linear_at(rate: float) -> Interpolation:
    """Straight lines between the positions, as a controller asks its drives for them at a rate in Hz.

    The speed of straight lines jumps where they meet. An arm under position control that is given a sample each period
    takes a period for it: that is the quintic spline through the samples of the lines at this rate.
    """

    def motion(samples: JointSamples) -> JointMotion:
        start, stop = float(samples.t[0]), float(samples.t[-1])
        t = start + np.arange(int(np.ceil((stop - start) * rate - 1e-6)) + 1) / rate
        lines = [np.interp(t, samples.t, joint) for joint in samples.position.T]
        return _quintic_spline(JointSamples(t, np.column_stack(lines)))

    return Interpolation(
        f"lines at {rate:g} Hz", f"straight lines between the positions, a sample every {1e3 / rate:g} ms", motion
    )


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

CUBIC_HERMITE = Interpolation(
    "cubic hermite", "a cubic polynomial per segment through position and speed of both its ends", _cubic_hermite
)
CUBIC_SPLINE = Interpolation(
    "cubic spline", "one cubic spline through the positions, at rest at both ends", _cubic_spline
)

INTERPOLATIONS: dict[str, Interpolation] = {
    item.name: item for item in (QUINTIC_SPLINE, QUINTIC_HERMITE, CUBIC_HERMITE, CUBIC_SPLINE)
}
"""Every way from samples to a motion, but for straight lines, which need a rate."""
