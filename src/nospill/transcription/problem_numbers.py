"""What a problem reads besides the numbers of its scene: the weights of its cost and the direction of a free joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.laws.parameters import Number
from nospill.laws.structure import Structure


@dataclass(frozen=True, slots=True)
class ProblemNumbers:
    """Numbers of the optimiser alone, as floats or SX alike (`core.trees`).

    Attributes:
        path_jerk_weight, tilt_jerk_weight, offset_jerk_weight: of the mean squares of the jerks in the cost.
        self_motion: (n,) direction whose product with q is the free parameter of a seven-joint arm; zero where there is
            none or a motion has not been chosen yet.
    """

    path_jerk_weight: Number
    tilt_jerk_weight: Number
    offset_jerk_weight: Number
    self_motion: Number

    @classmethod
    def blank(cls, structure: Structure) -> ProblemNumbers:
        """Zeros for a structure."""
        return cls(0.0, 0.0, 0.0, np.zeros(len(structure.joints)))
