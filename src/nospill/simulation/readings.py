"""What a gauge at the wall shows of a liquid: its surface, or the contact line, which stays behind the surface.

A camera or a crest detector sees where the liquid meets the wall. That line moves with the surface only as far as the
contact angle lets it: at first by a part of what the surface does, and once it slides it stays behind by a fixed height
of the order of the capillary length (contact-angle hysteresis). Measured runs: docs/slosh-model.md, record 0056.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from nospill.errors import ScenarioError
from nospill.scene.liquids import Liquid
from nospill.scene.surface_tension.meniscus import capillary_length

Model = Literal["surface", "contact-line"]

_PINNED = 0.5
"""Part of a small height by which the line stays behind."""
_LAG = 0.9
"""Capillary lengths by which it stays behind at most; 2.5 mm of water."""


@dataclass(frozen=True, slots=True)
class Reading:
    """How a height above rest is read.

    Attributes:
        modes: liquid modes in each direction where nobody states a number.
        lag: capillary lengths by which the reading stays behind the surface at most.
    """

    modes: int
    lag: float

    def of(self, height: np.ndarray, liquid: Liquid) -> np.ndarray:
        """What is read of heights above rest, m, below rest with their sign: h - sign(h) min(|h|/2, lag)."""
        if self.lag == 0.0:
            return height
        size = np.abs(height)
        return np.sign(height) * (size - np.minimum(_PINNED * size, self.lag * capillary_length(liquid)))


READINGS: dict[Model, Reading] = {"surface": Reading(modes=2, lag=0.0), "contact-line": Reading(modes=20, lag=_LAG)}
"""By the name of the model. The contact line is read of the whole surface, so all modes count."""


def reading_of(model: str) -> Reading:
    """The reading of a model.

    Raises:
        ScenarioError: there is no such model.
    """
    for name in get_args(Model):
        if model == name:
            return READINGS[name]
    raise ScenarioError(f'model = "{model}": "surface" or "contact-line" is needed')
