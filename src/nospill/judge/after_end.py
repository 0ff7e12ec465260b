"""Residual height of a liquid with many modes: played on where the sum of the modes' bounds says too little.

Each mode's bound holds for all time, and so does their sum; but the modes are never all at their highest at once. Where
the sum is above the limit, the free motion is played on in closed form. At any time T after the end two numbers bound
the height for all time together: the highest surface until T, and the sum of the bounds of the state at T, which
decays. The least of their maximum over T is the row's value; at T = 0 it is the sum itself.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.judge.verdict import Trace
from nospill.scene.cargo import Cargo

_STEP = 1e-3
"""s; a mode at 20 Hz reaches 0.2 % more than its highest sample, and is a small part of the height."""
_LONGEST = 6.0
"""s; a swing of a cup has lost half of its height by then."""
AFTER = _STEP * np.arange(round(_LONGEST / _STEP) + 1)
"""(m,) s after the end at which the surface is looked at."""
EVERY = 50
"""Of these instants, every how many the sum of the bounds is."""


def played_on(trace: Trace, cargo: Cargo, displacement: np.ndarray, bound: np.ndarray) -> Trace:
    """The row of the residual height of one object from its free motion.

    Args:
        trace: of the sum of the bounds at the end of the motion, one instant.
        cargo: the object.
        displacement: (m, k) its slosh coordinates at `AFTER`, m.
        bound: (b,) m, the sum of the bounds at every `EVERY`-th of these instants.
    """
    highest = np.maximum.accumulate(free_heights(cargo, displacement))[::EVERY]
    value = np.array([np.min(np.maximum(highest, bound))])
    return replace(trace, value=value, margin=trace.limit - value)


def free_heights(cargo: Cargo, displacement: np.ndarray) -> np.ndarray:
    """Crest round the wall (m,) m of an object at rest and level, from its slosh coordinates (m, k)."""
    eta, column = np.zeros((2, len(displacement))), 0
    for mode in cargo.oscillators:
        for direction in mode.directions:
            eta["xy".index(direction)] += mode.surface_gain * displacement[:, column]
            column += 1
    vectors = cargo.container.footprint.crest_vectors(eta)
    return np.max([np.linalg.norm(np.atleast_2d(vector), axis=0) for vector in vectors], axis=0)
