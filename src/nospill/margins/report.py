"""What is left of a plan when its numbers are off: probabilities with confidence bounds, and which number matters."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from nospill.margins.arms import ArmRanges
from nospill.margins.ranges import Ranges

CONFIDENCE = 0.95
"""Of the bounds of a probability, both together."""

PERCENTILES = (0.0, 1.0, 5.0, 50.0, 95.0, 100.0)
"""Of the worst margin, as reported."""


@dataclass(frozen=True, slots=True)
class Probability:
    """How often something happened in a number of samples, with Clopper and Pearson's 95 % bounds."""

    count: int
    samples: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """Share of the samples."""
        return self.count / self.samples


def probability(happened: np.ndarray) -> Probability:
    """Estimate from m samples, (m,) of bool.

    The exact interval [Clopper and Pearson 1934]: quantiles of beta distributions, (1 - c)/2 outside on either side. It
    never covers less than it says, even where nothing happened.
    """
    from scipy.special import betaincinv

    samples, count, outside = len(happened), int(np.sum(happened)), (1.0 - CONFIDENCE) / 2.0
    low = float(betaincinv(count, samples - count + 1, outside)) if count else 0.0
    high = float(betaincinv(count + 1, samples - count, 1.0 - outside)) if count < samples else 1.0
    return Probability(count, samples, low, high)


@dataclass(frozen=True, slots=True)
class ConstraintRisk:
    """One constraint over all samples and objects: how often it was broken, the largest use of it, and whose."""

    constraint: str
    broken: Probability
    largest_use: float
    subject: str


@dataclass(frozen=True, slots=True)
class Influence:
    """One number swept over its range, that of all objects together, everything else as in the scenario.

    Attributes:
        factor: "friction", "fill", "damping", "position" or "mass".
        measure: "liquid" for the worst margin of the liquids' constraints, "contact" for those of the contacts.
        nominal: that margin with the scenario's numbers, fraction of the limit.
        least, greatest: the same at the worst and the best place of the range.
        least_at: that place, as text.
        greatest_at: likewise.
        limited_by: constraint and object at the worst place.
    """

    factor: str
    measure: str
    nominal: float
    least: float
    greatest: float
    least_at: str
    greatest_at: str
    limited_by: str

    @property
    def swing(self) -> float:
        """How far the number moves the margin."""
        return self.greatest - self.least


@dataclass(frozen=True, slots=True)
class MarginsReport:
    """The study of one plan.

    A margin is 1 - use of a limit (`certificate.limit_use`), against the friction that is really there, without
    reserve; the worst is taken over all objects, all instants and the constraints during the motion.

    Attributes:
        scenario: name.
        ranges: by object.
        samples: number of samples drawn.
        seed: of the generator.
        arm: how far delay and lag of the joints may be off.
        arms: how many arms were drawn: as many as samples, or none.
        nominal: worst margin with the scenario's numbers.
        worst_margin: (m,) of every sample.
        draws: (m, objects, 6), columns as in `Ranges.bounds`.
        spill: the surface, or what it may still rise to after the end, comes over the rim of a cup.
        over_limit: the surface rises above a cup's max_slosh_height.
        slide: an object needs more friction than there is (slip, twist) or loses its contact (lift).
        tip: an object's centre of pressure leaves its footprint.
        any_limit: any constraint of the certificate that depends on these numbers is broken, also those of the end.
        constraints: one by one.
        influences: strongest first; what moves nothing is left out.
    """

    scenario: str
    ranges: dict[str, Ranges]
    samples: int
    seed: int
    arm: ArmRanges
    arms: int
    nominal: float
    worst_margin: np.ndarray
    draws: np.ndarray
    spill: Probability
    over_limit: Probability
    slide: Probability
    tip: Probability
    any_limit: Probability
    constraints: tuple[ConstraintRisk, ...]
    influences: tuple[Influence, ...]

    @property
    def percentiles(self) -> dict[float, float]:
        """`PERCENTILES` of the worst margin."""
        values = np.percentile(self.worst_margin, PERCENTILES)
        return dict(zip(PERCENTILES, values.tolist(), strict=True))

    def to_dict(self) -> dict[str, Any]:
        """For margins.json; without the samples."""
        chances = ("spill", "over_limit", "slide", "tip", "any_limit")
        return {
            "scenario": self.scenario,
            "samples": self.samples,
            "seed": self.seed,
            "ranges": {name: asdict(item) for name, item in self.ranges.items()},
            "arm": {"delay_s": self.arm.delay, "lag_s": self.arm.lag, "drawn": self.arms},
            "nominal_worst_margin": self.nominal,
            "worst_margin_percentiles": {f"{key:g}": value for key, value in self.percentiles.items()},
            "confidence": CONFIDENCE,
            **{name: _chance(getattr(self, name)) for name in chances},
            "constraints": [
                {
                    "constraint": item.constraint,
                    **_chance(item.broken),
                    "largest_use": item.largest_use,
                    "subject": item.subject,
                }
                for item in self.constraints
            ],
            "influences": [asdict(item) for item in self.influences],
        }


def _chance(found: Probability) -> dict[str, float]:
    return {"probability": found.value, "count": found.count, "low": found.low, "high": found.high}
