"""The lowest resonance of its joints that a plan survives: tried from above, then by secants.

Every joint is on an elastic transmission of one frequency (`motion.tracking.Elastic`). The frequency that is said was
replayed and holds, and one at most 4 % lower fails.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.certification.survived import DAMPING, HIGHEST, LOWEST, Survived
from nospill.certification.tracked_rows import Followed, worst_of
from nospill.laws.constraints.base import RowId
from nospill.motion.tracking import elastic

CLOSE = 0.02
"""Part of a size within which one more that holds and one that fails lie, or are expected to."""
_SAMPLES_OF_A_PERIOD, _RATES = 16.0, (250.0, 1000.0)
"""Of an elastic joint, with which it is replayed; and the rates in Hz between which that is kept."""
_STEPS = 1.0 / 2.2, 0.95
"""From one frequency to the next lower one, at most and at least."""
_MOST_OVER = 4.0
"""Ratio of two distances from the limit between which a frequency is interpolated, at most."""
_RING = 0.35
"""s after the end for which an elastic joint is followed."""


def resonance_survived(few: Followed, planned: float) -> Survived:
    """The lowest frequency that is survived, from above; the next one is where what is added would be 1.2 times it.

    Args:
        few: the plan, with few modes of each liquid.
        planned: largest use of its limits where the joints are rigid.
    """
    start, stop = few.span

    def worst(frequency: float) -> tuple[float, RowId]:
        motion = elastic(few.motion, np.full(few.joints, frequency), DAMPING, start, stop + 2.0 * _RING)
        coarse = replace(few, rate=float(np.clip(_SAMPLES_OF_A_PERIOD * frequency, *_RATES)))
        return worst_of(coarse.rows(motion, after=_RING, at_end=False)[0])

    high, frequency = (np.inf, 0.0), HIGHEST
    use, row = worst(frequency)
    while use <= 1.0:
        if frequency <= LOWEST:
            return Survived(None)
        # a stiffer joint is off by less as the square of its frequency
        nearer = 1.1 * np.sqrt(max(use - planned, 0.0) / max(1.0 - planned, 1e-9))
        high, frequency = (frequency, use), max(frequency * float(np.clip(nearer, *_STEPS)), LOWEST)
        use, row = worst(frequency)
    if frequency == HIGHEST:
        return Survived(frequency, row.label)
    low, first = (frequency, use), row.label
    while high[0] > (1.0 + 2.0 * CLOSE) * low[0]:
        middle = _between(low, high)
        use, row = worst(middle)
        low, high, first = ((middle, use), high, row.label) if use > 1.0 else (low, (middle, use), first)
    return Survived(high[0], first)


def _between(low: tuple[float, float], high: tuple[float, float]) -> float:
    """The next frequency: a little above where the chord between one that fails and one that holds meets the limit.

    That one is expected to hold, and the next one, a little lower, to fail. Where an object is hardly pressed, a use is
    beyond all bounds: it counts no more than `_MOST_OVER` times as far over the limit as the other is below it.
    """
    under = max(1.0 - high[1], 1e-9)
    over = min(low[1] - 1.0, _MOST_OVER * under)
    crossing = low[0] + over / (over + under) * (high[0] - low[0])
    return float(np.clip((1.0 + CLOSE) * crossing, (1.0 + CLOSE) * low[0], high[0] / (1.0 + 1.9 * CLOSE)))
