"""How far the numbers of a scenario may be off, and how they are drawn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nospill.errors import ScenarioError
from nospill.scene.cargo import Cargo, Tolerance
from nospill.scene.scene import Scene
from nospill.scene.tolerances import is_uncertain

FACTORS = ("friction", "fill", "damping", "position x", "position y", "mass")
"""What is drawn for every object, in the order of the columns of a draw."""


@dataclass(frozen=True, slots=True)
class Ranges:
    """Ranges about the scenario's numbers; every object is drawn on its own.

    Attributes:
        friction: relative, +-, of the measured coefficient.
        fill: +-, m, of the liquid's height at rest.
        damping: lower and upper factor on the damping ratios; drawn evenly in its logarithm.
        position: +-, m, in x and in y on the tray.
        mass: relative, +-, of the whole mass of an object; what is drawn is added to the container, the liquid's mass
            follows from its height.
    """

    friction: float = 0.1
    fill: float = 2e-3
    damping: tuple[float, float] = (0.5, 2.0)
    position: float = 1e-3
    mass: float = 0.02

    def __post_init__(self) -> None:
        for name, value, below in (
            ("friction", self.friction, 1.0),
            ("fill", self.fill, math.inf),
            ("position", self.position, math.inf),
            ("mass", self.mass, 1.0),
        ):
            if not 0.0 <= value < below:
                allowed = f"from 0 to below {below:g}" if below < math.inf else "a finite value of at least 0"
                raise ScenarioError(f"range of {name} = {value:g}: {allowed} is allowed")
        low, high = self.damping
        if not 0.0 < low <= high < math.inf:
            raise ScenarioError(
                f"range of damping = {low:g}..{high:g}: two factors above 0, the lower first, are needed"
            )

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper end of every column of a draw, (6,) each.

        Friction and mass are relative, fill and position in m, damping is the logarithm of the factor.
        """
        high = np.array([self.friction, self.fill, math.log(self.damping[1]), self.position, self.position, self.mass])
        low = -high
        low[FACTORS.index("damping")] = math.log(self.damping[0])
        return low, high


def draw(ranges: Sequence[Ranges], samples: int, *, seed: int) -> np.ndarray:
    """Even draws, (samples, objects, 6), columns as in `Ranges.bounds`; zeros mean the scenario's own numbers.

    Args:
        ranges: one for each object.
        samples: how many sets of numbers.
        seed: of the draw.
    """
    low, high = (np.array(ends) for ends in zip(*(item.bounds() for item in ranges), strict=True))
    return np.random.default_rng(seed).uniform(low, high, size=(samples, *low.shape))


def scenario_ranges(scene: Scene) -> tuple[Ranges, ...]:
    """Of every object: its tolerance if the scenario states any, else the general ranges.

    A scenario that states tolerances, of objects or joints, is taken at its word: what they do not name is certain.
    """
    if not is_uncertain(scene) and scene.tracking is None:
        return (Ranges(),) * len(scene.cargo)
    return tuple(_of(cargo) for cargo in scene.cargo)


def _of(cargo: Cargo) -> Ranges:
    tolerance = cargo.tolerance or Tolerance()
    return Ranges(
        friction=tolerance.friction,
        fill=tolerance.liquid_height,
        damping=tolerance.damping,
        position=tolerance.position,
        # that of the container alone, as a part of the whole
        mass=tolerance.mass * cargo.empty.mass / cargo.total.mass,
    )
