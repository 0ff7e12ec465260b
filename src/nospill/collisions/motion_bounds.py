"""A sampled joint motion with bounds on what it does between the samples.

Between two samples the motion is one quintic, as every entry of `motion.interpolation` is. Position, speed and
acceleration at both ends fix it, and its derivatives stay within the hull of their Bernstein coefficients.

A point fixed to a joint's frame has the acceleration sum_i J_i qdd_i + sum_ik dJ_i/dq_k qd_i qd_k, and both J_i and
dJ_i/dq_k are no longer than the distance of the point from axis i or k, whichever is nearer to it in the chain. With
r_i the greatest such distance over all configurations (`axis_reach`),

    |a| <= sum_i r_i |qdd_i| + sum_k r_k |qd_k| (|qd_k| + 2 sum_{i<k} |qd_i|).

An axis that follows another joint counts by itself, with its own rates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.robots.kinematics.bodies import BodyChain

_ROUNDING = 1.001
"""Factor on bounds: rounding of the second differences, and sample times rounded to whole nanoseconds."""


@dataclass(frozen=True, slots=True, eq=False)
class SampledMotion:
    """Joint samples (m, n) evenly spaced in time.

    Attributes:
        chain: the arm.
        t: (m,) s.
        q: positions, rad.
        qd: speeds, rad/s.
        qdd: accelerations, rad/s^2.
    """

    chain: BodyChain
    t: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray

    @property
    def step(self) -> float:
        """Time between two samples, s."""
        return float(self.t[1] - self.t[0])

    def around_samples(self, reach: np.ndarray) -> np.ndarray:
        """Bound on the acceleration (m, b), m/s^2, of points of b bodies within a step before and after each sample.

        Args:
            reach: (bodies of the chain, b) distance of the body's points from the axis of each, m, at most.
        """
        between = self._between() @ reach * _ROUNDING
        edge = np.zeros((1, between.shape[1]))
        return np.maximum(np.concatenate([edge, between]), np.concatenate([between, edge]))

    def _between(self) -> np.ndarray:
        """What the reach of each body's axis is multiplied by, (m - 1, bodies), from sample to sample, m/s^2 per m."""
        h = self.step
        chain = self.chain
        corners = [chain.angles(self.q), h / 5 * chain.rates(self.qd), h * h / 20 * chain.rates(self.qdd)]
        start, end = ([column[part] for column in corners] for part in (slice(None, -1), slice(1, None)))
        bernstein = np.stack(
            [
                start[0],
                start[0] + start[1],
                start[0] + 2 * start[1] + start[2],
                end[0] - 2 * end[1] + end[2],
                end[0] - end[1],
                end[0],
            ]
        )
        slopes = np.diff(bernstein, axis=0)
        speed = 5 / h * np.max(np.abs(slopes), axis=0)
        acceleration = 20 / h**2 * np.max(np.abs(np.diff(slopes, axis=0)), axis=0)
        before = np.cumsum(speed, axis=1) - speed
        return acceleration + speed * (speed + 2 * before)
