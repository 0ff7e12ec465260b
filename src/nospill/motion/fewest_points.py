"""Few points, unevenly spaced, between which a quintic per segment is the motion again, within a tolerance.

A motion of minimum time is smooth between instants at which its jerk jumps, and a quintic that meets position, speed
and acceleration at both ends of a segment is off by the sixth power of the segment's length there [Hermite
interpolation]. Long segments between the jumps and short ones about them need far fewer points than equal ones.
"""

from __future__ import annotations

import numpy as np

from nospill.motion.interpolation import QUINTIC_HERMITE, JointSamples

BETWEEN = 2
"""Instants per candidate at which the acceleration is compared: at the candidates, and in the middle between them."""


def part_of(samples: JointSamples, rows: np.ndarray) -> JointSamples:
    """Some of the samples, rows (k,) in ascending order."""
    derivatives = (None if column is None else column[rows] for column in (samples.speed, samples.acceleration))
    return JointSamples(samples.t[rows], samples.position[rows], *derivatives)


def compared_at(samples: JointSamples) -> np.ndarray:
    """The instants (f,), s, at which accelerations are compared."""
    last = len(samples.t) - 1
    return np.interp(np.linspace(0, last, BETWEEN * last + 1), np.arange(last + 1), samples.t)


def fewest_points(samples: JointSamples, tolerance: float | np.ndarray, longest: float = np.inf) -> np.ndarray:
    """The rows of samples that keep the acceleration of every joint within a tolerance, each segment as long as may be.

    Args:
        samples: (m,) candidates, with speeds and accelerations; what is between them is a quintic per segment.
        tolerance: rad/s^2, of what the quintics through the points that are left make of it; (f,) of every instant of
            `compared_at`, or the same for all.
        longest: s, of a segment; one between neighbouring candidates may be longer.

    Returns:
        (k,) rows in ascending order, the first and the last among them.
    """
    last, t = len(samples.t) - 1, compared_at(samples)
    wanted, tolerance = QUINTIC_HERMITE.motion(samples)(t, 2), np.broadcast_to(tolerance, len(t))
    rows = [0]
    while rows[-1] < last:
        rows.append(_farthest(samples, rows[-1], t, wanted, tolerance, longest))
    return np.array(rows)


def _farthest(
    samples: JointSamples, first: int, t: np.ndarray, wanted: np.ndarray, tolerance: np.ndarray, longest: float
) -> int:
    """The end of the longest segment from a row, found by doubling its length and then halving what was added."""

    def holds(end: int) -> bool:
        if end > first + 1 and samples.t[end] - samples.t[first] > longest:
            return False
        within = slice(BETWEEN * first, BETWEEN * end + 1)
        segment = QUINTIC_HERMITE.motion(part_of(samples, np.array([first, end])))
        return bool(np.all(np.abs(segment(t[within], 2) - wanted[within]) <= tolerance[within, None]))

    last = len(samples.t) - 1
    good, step = first + 1, 1
    while good < last and holds(min(good + step, last)):
        good, step = min(good + step, last), 2 * step
    bad = min(good + step, last + 1)
    while bad - good > 1:
        middle = (good + bad) // 2
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good
