"""How far below its rim every liquid stays, where the surface meets the wall."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from nospill.certification.verdict import Row
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.scene.containers.leaning import Edge, edge_of_plane
from nospill.scene.scene import Scene

_NAMED = 4
"""Liquids that the line names."""


@dataclass(frozen=True, slots=True)
class RimDistance:
    """The highest edge of a liquid: `subject`, and where the plane of its certified crest meets the wall.

    The level is the highest of its tolerance; see `nospill.scene.containers.leaning.edge_of_plane`.
    """

    subject: str
    edge: Edge

    @property
    def left(self) -> float:
        """Upright distance to the rim in mm, rounded down to tenths; negative where the edge is over it."""
        return _tenths(self.edge.below_rim)

    @property
    def words(self) -> str:
        """The distance in words: "6.2 mm (7.0 along the wall)" where both differ, "0.3 mm over it"."""
        if self.left < 0.0:
            return f"{-self.left:.1f} mm over it"
        slanting = _tenths(self.edge.along_wall)
        return f"{self.left:.1f} mm" + (f" ({slanting:.1f} along the wall)" if slanting != self.left else "")


def rim_distances(scene: Scene, rows: Iterable[Row]) -> tuple[RimDistance, ...]:
    """Of every liquid with a row on its height, the nearest to its rim first."""
    crests: dict[str, float] = {}
    for row in rows:
        if row.constraint == SloshHeight.name and math.isfinite(row.worst_value):
            crests[row.subject] = max(row.worst_value, crests.get(row.subject, 0.0))
    return rims_below(scene, crests)


def rims_below(scene: Scene, crests: Mapping[str, float]) -> tuple[RimDistance, ...]:
    """The same from crests, m, by object."""
    found = []
    for cargo in scene.cargo:
        if cargo.filling is not None and cargo.name in crests:
            more = cargo.tolerance.liquid_height if cargo.tolerance is not None else 0.0
            edge = edge_of_plane(cargo.container, cargo.filling.liquid_height + more, crests[cargo.name])
            found.append(RimDistance(cargo.name, edge))
    return tuple(sorted(found, key=lambda item: item.edge.below_rim))


def rim_line(distances: tuple[RimDistance, ...]) -> str:
    """The nearest liquids in one line, "below the rim: c1 6.2 mm (7.0 along the wall), c2 7.1 mm"; empty without."""
    named = [f"{item.subject} {item.words}" for item in distances[:_NAMED]]
    rest = len(distances) - len(named)
    return f"below the rim: {', '.join(named)}{f' and {rest} more' if rest else ''}" if named else ""


def _tenths(length: float) -> float:
    """In mm, rounded down; a ten-thousandth of a millimetre is rounding."""
    return math.floor(1e4 * length + 1e-3) / 10
