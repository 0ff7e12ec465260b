"""Room between the objects of a layout and to the edge of the tray, with its derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from nospill.layouts.variables import Variables, cargo_of
from nospill.planning.varied import Varied
from nospill.scenario.layout import overhang, overlap
from nospill.scene.cargo import Cargo

_STEP = 1e-6
"""m, of the derivatives: distances are linear but at corners."""


class Spacing:
    """Distances that a layout must keep: of each object that moves to the edge, and to every other one beside it."""

    def __init__(self, base: Varied, variables: Variables) -> None:
        self._tray, self._variables = base.scenes[0].tray, variables
        self._cargo = {name: item for name, item in cargo_of(base).items() if not item.carrier}
        together = [{item.name for item in scene.cargo} for scene in base.scenes]
        self._moving = [name for name in self._cargo if name in variables.places]
        self._pairs = [
            pair
            for pair in combinations(self._cargo, 2)
            if any(name in self._moving for name in pair) and any(names.issuperset(pair) for names in together)
        ]  # what stands in a carrier goes with it

    def distances(self, values: np.ndarray) -> np.ndarray:
        """(m,) m, negative where objects overlap or stand over the edge."""
        placed = self._placed(values)
        edges = [-overhang(placed[name], self._tray) - _slack(placed[name]) for name in self._moving]
        return np.array([*edges, *(-overlap(placed[first], placed[second]) for first, second in self._pairs)])

    def slopes(self, values: np.ndarray) -> np.ndarray:
        """(m, n) their derivatives, m per unit of each number."""
        columns = []
        for index, name in enumerate(self._variables.places):
            step = np.zeros(len(values))
            step[index] = _STEP if name else 0.0
            columns.append((self.distances(values + step) - self.distances(values - step)) / (2 * _STEP))
        return np.array(columns).T

    def _placed(self, values: np.ndarray) -> Mapping[str, Cargo]:
        at: dict[str, list[float]] = {}
        for name, value in zip(self._variables.places, values, strict=True):
            if name:
                at.setdefault(name, []).append(float(value))
        moved = {name: replace(self._cargo[name], position=np.array(place)) for name, place in at.items()}
        return {**self._cargo, **moved}


def _slack(item: Cargo) -> float:
    return item.tolerance.position if item.tolerance is not None else 0.0
