"""Relaxation of a limit: one key of a scenario, wider by a share, and the words for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from nospill.core.units import format_quantity
from nospill.errors import Change
from nospill.laws.constraints.base import RowId
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene

MOST = 50.0
"""No limit grows by more than this many times its size."""
_MAIN = 0.7
"""A subject with this part of the sensitivity of its constraint is tried alone."""

Sensitivities = Mapping[RowId, float]
"""How strongly every subject of every constraint holds the motion back; any positive measure."""


@dataclass(frozen=True, slots=True)
class Relaxation:
    """One key of a scenario, relaxed by a share: 0 leaves it as it is, at 0.2 the limit is a fifth wider.

    Attributes:
        constraint: name of the constraint that it relaxes.
        subject: subject that needs it most.
        most: largest share that the key's bounds, the robot or the rim allow.
        change: share -> change of the scenario.
        scene: share -> scene of the changed scenario.
    """

    constraint: str
    subject: str
    most: float
    change: Callable[[float], Change]
    scene: Callable[[float], Scene]


def with_cargo(scene: Scene, indices: Sequence[int], changed: Callable[[Cargo], Cargo]) -> Scene:
    """The scene with some of its objects changed."""
    return replace(
        scene, cargo=tuple(changed(item) if index in indices else item for index, item in enumerate(scene.cargo))
    )


def instead_text(what: str, value: float, now: float, dimension: str, whose: str = "") -> str:
    """A change in words: "friction 0.3 instead of 0.2 (c1)"."""
    new, old = (format_quantity(number, dimension, digits=3) for number in (value, now))
    return f"{what} {new} instead of {old}" + (f" ({whose})" if whose else "")


def entry_of(scene: Scene, name: str) -> dict[str, Any]:
    """The entry of an object in the scenario as it was read."""
    entries = scene.source.get("cargo")
    assert isinstance(entries, list)
    return next((entry for entry in entries if entry.get("name") == name), {})


def is_main(subject: str, constraint: str, sensitivities: Sensitivities) -> bool:
    """Whether one subject has most of the sensitivity of its constraint."""
    total = sum(max(sensitivity, 0.0) for (name, _), sensitivity in sensitivities.items() if name == constraint)
    return sensitivities.get(RowId(constraint, subject), 0.0) >= _MAIN * total
