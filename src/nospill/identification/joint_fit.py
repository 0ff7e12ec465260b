"""Delay and lag of every joint, from what it was asked for and what it did."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from nospill.execution.motion import RecordedMotion
from nospill.execution.tracking import delays
from nospill.identification.estimates import Estimate, fitted
from nospill.identification.second_order import SecondOrder, fit_second_order
from nospill.motion.control import followed
from nospill.motion.interpolation import JointMotion
from nospill.scene.controller import Controller

_LAG_STEP = 1e-5
"""s; of the difference that gives the derivative by the lag."""
_FIRST_LAG = 2e-3
_LARGEST_LAG = 0.5
_SEARCH = 0.1
"""s; the delay is looked for so far to either side of that which fits best without a lag."""
_IDENTIFIABLE = {"delay": 2e-3, "lag": 2e-3}
"""s; half widths of 95 % above which a number is not identifiable."""
_LEAST_TRAVEL = 0.01
"""rad; a joint that moves by less tells nothing."""
_AFTER = 0.3
"""s; of rest after the motion, in which a lag dies."""
_NEIGHBOURS = 25
MISFIT = 3.0
"""What is left above so many times the noise is no noise: the law is not the whole story."""
_LEAST_NOISE = 1e-9
"""rad."""


@dataclass(frozen=True, slots=True, eq=False)
class JointFit:
    """What a log tells of one joint.

    Attributes:
        joint: its name.
        delay: s; of joints against the command in the log, or against the joint that begins first.
        lag: s.
        left: root mean square of what is left, rad.
        moves: whether it moves enough to tell anything.
        noise: of its record, rad.
        second: what a lag of second order makes of it, where one of first order leaves more than noise.
    """

    joint: str
    delay: Estimate
    lag: Estimate
    left: float
    moves: bool
    noise: float
    second: SecondOrder | None = None

    @property
    def misfit(self) -> bool:
        """Whether the lag of first order leaves more than noise."""
        return self.moves and self.left > MISFIT * max(self.noise, _LEAST_NOISE)

    @property
    def unexplained(self) -> bool:
        """Whether neither lag explains what it does."""
        left = self.left if self.second is None else self.second.left
        return self.moves and left > MISFIT * max(self.noise, _LEAST_NOISE)


def fit_joints(recorded: RecordedMotion, command: JointMotion, span: tuple[float, float]) -> tuple[JointFit, ...]:
    """Fit lag q' + q = command(t - delay) to every joint of a log.

    Args:
        recorded: the log.
        command: what was asked for, at rest before and after its span.
        span: first and last instant of the command, s; its clock may be another than the log's.
    """
    log, sampling = recorded.log, recorded.sampling
    t, position = sampling.t, log.position[sampling.kept]
    executed = recorded.held()
    grid = np.arange(span[0], span[1], 0.002)
    first = _first_motion(command, grid)
    together = delays(executed, command, grid, recorded.begin - first, together=True)[0]
    whole = delays(executed, command, grid, float(together))
    picked = (t > recorded.begin - 0.05) & (t < recorded.end + _AFTER)
    # of the even clock that is laid through the stamps
    clock = 2.0 * sampling.jitter / np.sqrt(len(log.t)) if sampling.even else 0.0
    fits = []
    for joint, name in enumerate(log.joints):
        moves = float(np.ptp(position[:, joint])) > _LEAST_TRAVEL
        start = float(whole[joint] if moves else together)
        seen = t[picked], position[picked, joint]
        noise = float(recorded.smooth.noise[joint])
        first = _fit(name, joint, *seen, command, span, start, clock, noise, moves=moves)
        fits.append(_with_second(first, *seen, lambda at, j=joint: command(at)[:, j], span) if first.misfit else first)
    return tuple(fits)


def _with_second(
    first: JointFit,
    t: np.ndarray,
    position: np.ndarray,
    command: Callable[[np.ndarray], np.ndarray],
    span: tuple[float, float],
) -> JointFit:
    """A fit with that of second order, where this leaves less than half of what the first does."""
    second = fit_second_order(first.joint, t, position, command, span, delay=first.delay.value, lag=first.lag.value)
    return replace(first, second=second) if second.left < 0.5 * first.left else first


def against_the_first(fits: tuple[JointFit, ...]) -> tuple[JointFit, ...]:
    """Delays less that of the joint that begins first: all that can be told where the two clocks differ."""
    known = [own.delay.value for own in fits if own.moves and own.delay.identifiable]
    least = min(known, default=0.0)

    def shifted(own: JointFit) -> JointFit:
        moved = replace(own.delay, value=own.delay.value - least)
        second = own.second
        if second is not None:
            second = replace(second, delay=replace(second.delay, value=second.delay.value - least))
        return replace(own, delay=moved, second=second)

    return tuple(map(shifted, fits))


def _fit(
    name: str,
    joint: int,
    t: np.ndarray,
    position: np.ndarray,
    command: JointMotion,
    span: tuple[float, float],
    delay: float,
    clock: float,
    noise: float,
    *,
    moves: bool,
) -> JointFit:
    def own(at: np.ndarray, order: int = 0, /) -> np.ndarray:
        return command(at, order)[:, joint : joint + 1]

    def lagged(lag: float) -> JointMotion:
        return followed(own, Controller(np.zeros(1), np.array([lag])), *span)

    def residuals(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        late, lag = values
        here, beyond = lagged(lag), lagged(lag + _LAG_STEP)
        at = t - late
        done = here(at)[:, 0]
        by_lag = (beyond(at)[:, 0] - done) / _LAG_STEP
        return done - position, np.column_stack([-here(at, 1)[:, 0], by_lag])

    if not moves:
        never = (Estimate(what, name, "s", 0.0, np.inf, _IDENTIFIABLE[what]) for what in ("delay", "lag"))
        return JointFit(name, *never, left=float(np.std(position)), moves=False, noise=noise)
    solution = fitted(
        residuals,
        np.array([delay - _FIRST_LAG, _FIRST_LAG]),
        np.array([1e-3, 1e-3]),
        np.array([delay - _SEARCH, 0.0]),
        np.array([delay + _SEARCH, _LARGEST_LAG]),
        neighbours=_NEIGHBOURS,
    )
    deviation = np.sqrt(np.diag(solution.covariance) + clock**2)
    late, lag = (
        Estimate(what, name, "s", float(value), float(own), _IDENTIFIABLE[what])
        for what, value, own in zip(("delay", "lag"), solution.values, deviation, strict=True)
    )
    return JointFit(name, late, lag, solution.left, moves=True, noise=noise)


def _first_motion(command: JointMotion, grid: np.ndarray) -> float:
    moving = np.flatnonzero(np.max(np.abs(command(grid, 1)), axis=1) > 1e-3)
    return float(grid[moving[0]]) if len(moving) else float(grid[0])
