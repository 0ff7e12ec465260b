"""From a planned motion to what the controller is asked for, and from that to what the joints do.

A joint follows its command by lag q' + q = command(t - delay). So the command

    command(t) = q(t + delay) + lag q'(t + delay)

makes it do q exactly; a delay that all joints have in common needs no compensation, since it only puts the motion off.
The equation has the solution sum_k (-lag)^k p^(k) on a polynomial p, and what is left of the state before dies with
exp(-t/lag): a command that is a spline is followed exactly, without steps.

Two clocks: the command's, on which the record and the files begin, and the plan's, which is behind it by the longest
delay.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nospill.core.piecewise import Pieces
from nospill.motion.interpolation import QUINTIC_SPLINE, HeldMotion, JointMotion, JointSamples
from nospill.motion.resampling import resampled, sampled
from nospill.motion.trajectory import Trajectory
from nospill.scene.controller import Controller

_RATE = 1000.0
"""Hz; a command that is no spline of its own is put on one with so many pieces a second."""
_SAME_INSTANT = 1e-6
"""Part of a period that rounding may add."""
_SETTLED = 14.0
"""Lags after which nothing is left of a lag: exp(-14) is 1e-6."""


def command_for(planned: JointMotion, controller: Controller) -> JointMotion:
    """What the controller is asked for, on its own clock; as planned where nothing is compensated.

    Args:
        planned: the motion of the joints, at rest before and after.
        controller: how they follow.
    """
    if not controller.compensate:
        return planned
    early = controller.latest - controller.delay

    def asked(t: np.ndarray, order: int = 0, /) -> np.ndarray:
        columns = []
        for joint, (shift, lag) in enumerate(zip(early, controller.lag, strict=True)):
            own = planned(t - shift, order)[:, joint]
            columns.append(own + lag * planned(t - shift, order + 1)[:, joint] if lag else own)
        return np.column_stack(columns)

    return asked


def commanded(trajectory: Trajectory, controller: Controller | None) -> JointSamples:
    """The command of a record, sample by sample and as long as it takes; the record's joints without controller."""
    if controller is None or not controller.compensate:
        return JointSamples(
            trajectory.t, trajectory.joint_position, trajectory.joint_speed, trajectory.joint_acceleration
        )
    count = math.ceil(controller.spread * trajectory.rate - _SAME_INSTANT)
    late = trajectory.t[-1] + np.arange(1, count + 1) / trajectory.rate
    t = np.concatenate([trajectory.t, late])
    asked = command_for(trajectory.motion, controller)
    return JointSamples(t, *(asked(t, order) for order in range(3)))


def commanded_at(trajectory: Trajectory, controller: Controller | None, rate: float) -> JointSamples:
    """The command of a record at another rate in Hz, times from 0; see `interpolation.resampled` for its errors."""
    if controller is None or not controller.compensate:
        return resampled(trajectory, rate)
    resampled(trajectory, rate)  # refuses what is no rate
    asked = command_for(trajectory.motion, controller)
    return sampled(asked, float(trajectory.t[0]), float(trajectory.t[-1]) + controller.spread, rate)


def asked_at(motion: JointMotion, controller: Controller, start: float, stop: float) -> JointSamples:
    """The positions that the interface of a controller reads of a command, one a period, to its end or just after.

    Args:
        motion: the command, at rest before `start` and after `stop`, s.
        controller: with an interface.
        start: s.
        stop: s.
    """
    count = math.ceil((stop - start) * controller.update_rate - _SAME_INSTANT)
    t = start + np.arange(count + 1) / controller.update_rate
    return JointSamples(t, motion(t))


def asked_by(motion: JointMotion, controller: Controller | None, start: float, stop: float) -> JointMotion:
    """What the drives are asked for: the spline through the positions that the interface reads, where it is stated."""
    if controller is None or controller.interface is None:
        return motion
    return QUINTIC_SPLINE.motion(asked_at(motion, controller, start, stop))


def followed(command: JointMotion, controller: Controller, start: float, stop: float) -> JointMotion:
    """What the joints do, on the plan's clock; what they are asked for where they are not late.

    Args:
        command: on its own clock, at rest before `start` and after `stop`, s.
        controller: how they follow.
        start: s.
        stop: s.
    """
    return follower(command, start, stop)(controller) if controller.is_late else command


def follower(command: JointMotion, start: float, stop: float) -> Callable[[Controller], JointMotion]:
    """What the joints do by any controller that makes them late, from one spline through a command.

    Args:
        command: as of `followed`.
        start: s.
        stop: s.
    """
    count = max(12, math.ceil((stop - start) * _RATE))
    t = start + (stop - start) / count * np.arange(count + 1)
    spline = QUINTIC_SPLINE.motion(JointSamples(t, command(t)))
    assert isinstance(spline, HeldMotion)
    assert isinstance(spline.inside, Pieces)
    pieces = spline.inside
    return lambda controller: _Followed(_lag(pieces, controller.lag), controller, start, stop)


def settling_after(controller: Controller) -> float:
    """How long after a plan the joints still move, s; nothing where the command compensates for it."""
    return 0.0 if controller.compensate else controller.spread + _SETTLED * float(np.max(controller.lag))


def settled_after(controller: Controller) -> float:
    """How long after the end of its command the last joint still moves, s, compensated or not."""
    return controller.latest + _SETTLED * float(np.max(controller.lag))


@dataclass(frozen=True, slots=True)
class _Lagged:
    """A first-order lag driven by piecewise polynomials, exactly.

    Attributes:
        steady: the polynomials that it would follow if it had always done so.
        rest: (n,) where it comes to rest after the last of them, rad.
        lag: (n,) s.
        left: (m + 1, n) what is left of the state before, at the breaks, rad.
    """

    steady: Pieces
    rest: np.ndarray
    lag: np.ndarray
    left: np.ndarray

    def __call__(self, t: np.ndarray, order: int) -> np.ndarray:
        """The derivative of this order, each joint at its own times: t is (m, n), s."""
        breaks = self.steady.breaks
        values = np.where(t >= breaks[-1], 0.0 if order else self.rest, self.steady.by_columns(t, order))
        if not np.any(self.lag):
            return values
        place = np.maximum(np.searchsorted(breaks, t, side="right") - 1, 0)
        lag = np.where(self.lag > 0.0, self.lag, 1.0)
        left = np.take_along_axis(self.left, place, axis=0)
        return values + left * (-1.0 / lag) ** order * np.exp((breaks[place] - t) / lag)


def _lag(pieces: Pieces, lag: np.ndarray) -> _Lagged:
    rest = pieces(pieces.breaks[[0, -1]])
    if not np.any(lag):
        return _Lagged(pieces, rest[1], lag, np.zeros((len(pieces.breaks), len(lag))))
    degree = pieces.coefficients.shape[0] - 1
    derived, steady = pieces.coefficients, pieces.coefficients.copy()
    for order in range(1, degree + 1):
        powers = np.arange(degree, -1, -1.0)[:, None, None]
        derived = np.concatenate([np.zeros_like(derived[:1]), (derived * powers)[:-1]])
        steady = steady + (-lag) ** order * derived
    # At every break the lag is continuous, and the polynomials differ by their fifth derivatives.
    widths = np.diff(pieces.breaks)
    last = np.zeros_like(steady[-1])
    for row in steady:
        last = last * widths[:, None] + row
    first = np.concatenate([steady[-1, 1:], last[-1:]])  # after the last break the command rests
    first[-1] = rest[1]
    decay = np.where(lag > 0.0, np.exp(-widths[:, None] / np.where(lag > 0.0, lag, 1.0)), 0.0)
    left = np.where(lag > 0.0, np.vstack([rest[0] - steady[-1, 0], last - first]), 0.0)
    # left[k + 1] = decay[k] left[k] + jump[k]: sums over one piece, two, four, until all are in it
    decay, reach = np.vstack([np.zeros_like(decay[:1]), decay]), 1
    while reach <= len(widths):
        left[reach:] += decay[reach:] * left[:-reach].copy()
        decay[reach:] *= decay[:-reach].copy()
        reach *= 2
    return _Lagged(Pieces(pieces.breaks, steady), rest[1], lag, left)


@dataclass(frozen=True, slots=True)
class _Followed:
    """A lagged command on the plan's clock, every joint with its own delay; at rest before the start."""

    lagged: _Lagged
    controller: Controller
    start: float
    stop: float

    def __call__(self, t: np.ndarray, order: int = 0, /) -> np.ndarray:
        """The derivative of this order at times t (m,), s."""
        at = t[:, None] + (self.controller.latest - self.controller.delay)
        values = self.lagged(np.maximum(at, self.start), order)
        return np.where(at < self.start, 0.0, values) if order else values
