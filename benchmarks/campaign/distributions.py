"""Distributions that every part of a random scenario is drawn from."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from nospill.robots.description.catalog import ROBOTS


@dataclass(frozen=True, slots=True)
class Spread:
    """A number between two bounds, evenly or evenly in its logarithm; `unit` for the table of distributions."""

    low: float
    high: float
    unit: str = ""
    logarithmic: bool = False

    def draw(self, random: np.random.Generator) -> float:
        """One number, rounded to four digits so that the scenario can be read."""
        if self.logarithmic:
            value = math.exp(random.uniform(math.log(self.low), math.log(self.high)))
        else:
            value = random.uniform(self.low, self.high)
        return float(f"{value:.4g}")

    def __str__(self) -> str:
        """For the table."""
        return f"{'log-' if self.logarithmic else ''}uniform, {self.low:g} to {self.high:g} {self.unit}".rstrip()


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several values by their weights; None: all alike."""

    values: tuple[Any, ...]
    weights: tuple[float, ...] | None = None

    def draw(self, random: np.random.Generator) -> Any:
        """One of them."""
        shares = None if self.weights is None else np.array(self.weights) / sum(self.weights)
        return self.values[int(random.choice(len(self.values), p=shares))]

    def __str__(self) -> str:
        """For the table."""
        if self.weights is None:
            return "any of " + ", ".join(map(str, self.values))
        pairs = zip(self.values, self.weights, strict=True)
        return ", ".join(f"{value} ({weight / sum(self.weights):.0%})" for value, weight in pairs)


@dataclass(frozen=True, slots=True)
class Distributions:
    """What every part of a scenario is drawn from."""

    robot: Choice = Choice(tuple(ROBOTS))
    mounting: Choice = Choice((0.0, 90.0, 180.0), (0.6, 0.15, 0.25))
    unreachable: Choice = Choice((False, True), (0.95, 0.05))
    limits_applied: Choice = Choice(("all", "position and speed"), (0.4, 0.6))
    speed_scale: Choice = Choice((None, 0.8, 0.5, 0.25), (0.7, 0.1, 0.1, 0.1))
    path: Choice = Choice(("line", "arc", "waypoints", "bspline", "preset"), (0.2, 0.2, 0.25, 0.15, 0.2))
    path_length: Spread = Spread(0.1, 2.0, "m")
    yaw_change: Spread = Spread(-180.0, 180.0, "deg")
    yaw_values: Choice = Choice((2, 3, 4), (0.7, 0.2, 0.1))
    objects: Choice = Choice(tuple(range(1, 9)), (0.26, 0.24, 0.18, 0.12, 0.08, 0.05, 0.04, 0.03))
    kind: Choice = Choice(("cup", "box of liquid", "box", "bottle"), (0.5, 0.15, 0.15, 0.2))
    liquid: Choice = Choice(("water", "milk", "ethanol", "glycerol-50", "light-oil", "own"), (0.5, *[0.1] * 5))
    """A list of its own: with another one a recorded seed would be another scenario."""
    radius: Spread = Spread(0.02, 0.05, "m")
    side: Spread = Spread(0.03, 0.11, "m")
    height: Spread = Spread(0.05, 0.2, "m")
    fill: Spread = Spread(0.3, 0.85, "of the height")
    slosh_share: Spread = Spread(0.1, 1.0, "of the room to the rim", logarithmic=True)
    empty_mass: Spread = Spread(0.02, 0.25, "kg", logarithmic=True)
    solid_mass: Spread = Spread(0.05, 0.8, "kg", logarithmic=True)
    centre_height: Spread = Spread(0.3, 0.6, "of the height")
    tray_side: Spread = Spread(0.2, 0.45, "m")
    tray_mass: Spread = Spread(0.1, 0.8, "kg")
    tray_offset: Spread = Spread(0.02, 0.15, "m")
    friction: Spread = Spread(0.15, 0.8)
    friction_reserve: Spread = Spread(0.0, 0.3)
    footprint_reserve: Choice = Choice((0.05, 0.1, 0.2), (0.6, 0.3, 0.1))
    tilt: Choice = Choice(("fixed", "free"), (0.6, 0.4))
    max_tilt: Spread = Spread(3.0, 40.0, "deg", logarithmic=True)
    end: Choice = Choice(("residual", "published", "still"), (0.8, 0.1, 0.1))
    residual_fraction: Spread = Spread(0.02, 1.0, "of max_slosh_height", logarithmic=True)
    max_duration: Choice = Choice((20.0, 10.0, 40.0), (0.6, 0.2, 0.2))
    slosh_modes: Choice = Choice((1, 2), (0.95, 0.05))
    rate: Choice = Choice((500.0, 125.0, 250.0, 1000.0), (0.7, 0.1, 0.1, 0.1))

    def rows(self) -> list[tuple[str, str]]:
        """Name and distribution of every part, for the report."""
        return [(field.name.replace("_", " "), str(getattr(self, field.name))) for field in fields(self)]


DISTRIBUTIONS = Distributions()
"""Those of the campaign."""

FIRST_WITH_VESSELS = 10_000
"""The first seed whose objects are drawn with vessels: those before stay the scenarios that they were."""

WITH_VESSELS = replace(
    DISTRIBUTIONS,
    kind=Choice(("cup", "box of liquid", "box", "bottle", "vessel", "vials"), (0.1, 0.05, 0.05, 0.1, 0.6, 0.1)),
)
"""Those of the seeds from `FIRST_WITH_VESSELS` on."""


FIRST_WITH_RACKS = 20_000
"""Likewise, of racks of vials among the others."""

WITH_RACKS = replace(DISTRIBUTIONS, kind=Choice(("cup", "box", "vessel", "rack"), (0.2, 0.1, 0.2, 0.5)))
"""Those of the seeds from `FIRST_WITH_RACKS` on."""


FIRST_COMBINED = 30_000
"""The first seed whose scenario has three features at once (`benchmarks.campaign.combined`)."""

FIRST_WITH_NEWER = 31_000
"""Likewise, with one feature at least of those that came later."""

COMBINED = replace(
    DISTRIBUTIONS,
    unreachable=Choice((False,)),
    speed_scale=Choice((None,)),
    objects=Choice((1, 2, 3), (0.3, 0.4, 0.3)),
    path=Choice(("line", "arc", "waypoints"), (0.5, 0.25, 0.25)),
    path_length=Spread(0.1, 1.0, "m"),
    friction=Spread(0.3, 0.8),
    slosh_share=Spread(0.2, 1.0, "of the room to the rim", logarithmic=True),
    residual_fraction=Spread(0.1, 1.0, "of max_slosh_height", logarithmic=True),
    end=Choice(("residual",)),
    slosh_modes=Choice((3,)),
    rate=Choice((500.0,)),
)
"""Those of the seeds from `FIRST_COMBINED` on, but for the kinds of objects."""


def distributions_of(seed: int) -> Distributions:
    """What the scenario of a seed below `FIRST_COMBINED` is drawn from."""
    if seed < FIRST_WITH_VESSELS:
        return DISTRIBUTIONS
    return WITH_VESSELS if seed < FIRST_WITH_RACKS else WITH_RACKS
