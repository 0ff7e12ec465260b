"""How long liquids swing on after a motion until they count as still, which the next motion starts from."""

from __future__ import annotations

import math

from nospill.certification.verdict import APPROACH, Certificate
from nospill.laws.constraints.residual_height import STILL_FRACTION, ResidualHeight
from nospill.scene.scene import Scene

AFTER_APPROACH = APPROACH + ResidualHeight.name
"""The rows about what swings on after a loaded approach."""


def settling_time(scene: Scene, certificate: Certificate, constraint: str = ResidualHeight.name) -> float:
    """Time until every liquid is below 2 % of its `max_slosh_height`, s; 0 where none swings, infinite without damping.

    The bound on what swings falls as exp(-zeta omega t) of the slowest decay, at the worst end of the tolerance.

    Args:
        scene: with the liquids.
        certificate: of the motion.
        constraint: whose rows say how much swings at the beginning: after the motion, or `AFTER_APPROACH`.
    """
    heights: dict[str, float] = {}
    for row in certificate.rows:
        if row.constraint == constraint:
            heights[row.subject] = max(row.worst_value, heights.get(row.subject, 0.0))
    longest = 0.0
    for cargo in scene.cargo:
        if cargo.filling is None:
            continue
        factors = (1.0, 1.0) if cargo.tolerance is None else cargo.tolerance.damping
        modes = cargo.filling.oscillators
        decay = min(_decay(factor * mode.damping) * mode.frequency for factor in factors for mode in modes)
        ratio = heights.get(cargo.name, 0.0) / (STILL_FRACTION * cargo.filling.max_slosh_height)
        if ratio > 1.0:
            longest = max(longest, math.log(ratio) / decay if decay > 0.0 else math.inf)
    return longest


def _decay(ratio: float) -> float:
    """Slowest decay of a mode over its frequency: zeta, and beyond 1, where more damping levels more slowly, less."""
    return ratio if ratio <= 1.0 else 1.0 / (ratio + math.sqrt(ratio**2 - 1.0))
