"""Why a scenario is impossible even standing still, for programs, with the smallest change that makes it possible."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from nospill.core.units import format_quantity
from nospill.errors import REST, Change, Reason
from nospill.robots.robot import Robot
from nospill.scenario.layout import layout_faults, overhang, overlap
from nospill.scene.cargo import Cargo
from nospill.scene.tray import Tray

_STEP, _FARTHEST, _DIRECTIONS = 0.001, 0.4, 32
"""An object is moved by steps of 1 mm in this many directions, at most this far, m."""
_SPARE_MASS = 0.99


def layout_reason(cargo: Sequence[Cargo], tray: Tray) -> Reason:
    """The reason for the first of `layout_faults`, of which there is one: an object over the edge, or two too near."""
    outside = [index for index, item in enumerate(cargo) if layout_faults([item], tray)]
    if outside:
        index = outside[0]
        out = overhang(cargo[index], tray)
        return Reason(REST, "layout", cargo[index].name, excess=out, unit="m", changes=_elsewhere(cargo, tray, index))
    pairs = [(overlap(first, cargo[index]), index) for index in range(len(cargo)) for first in cargo[:index]]
    depth, index = max(pairs)
    return Reason(REST, "layout", cargo[index].name, excess=depth, unit="m", changes=_elsewhere(cargo, tray, index))


def _elsewhere(cargo: Sequence[Cargo], tray: Tray, index: int) -> tuple[Change, ...]:
    """The nearest place where the object stands free, if there is one near enough."""
    item = cargo[index]
    others = [other for position, other in enumerate(cargo) if position != index]
    angles = np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False)
    for distance in np.arange(_STEP, _FARTHEST, _STEP):
        for angle in angles:
            at = np.round(item.position + distance * np.array([np.cos(angle), np.sin(angle)]), 4)
            moved = replace(item, position=at)
            if layout_faults([moved], tray) or any(overlap(moved, other) > 0.0 for other in others):
                continue
            if layout_faults([*others, moved], tray):  # something else is wrong too
                return ()
            new, old = (
                ", ".join(format_quantity(x, "length", digits=4) for x in place) for place in (at, item.position)
            )
            text = f"at ({new}) instead of ({old}) ({item.name})"
            return (Change(f"layout of {item.name}", f"cargo.{item.name}.at", at.tolist(), text),)
    return ()


def payload_reason(robot: Robot, tray: Tray, cargo: Sequence[Cargo], excess: float) -> Reason:
    """The reason for a load that is `excess` kg more than the robot may carry."""
    solids = [item for item in cargo if item.filling is None and item.contents is None and not item.carrier]
    heaviest = max(solids, key=lambda item: item.total.mass, default=None)
    changes: tuple[Change, ...] = ()
    places = [("tray", "tray.mass", tray.mass)]
    if heaviest is not None:
        places.insert(0, (heaviest.name, f"cargo.{heaviest.name}.mass", heaviest.total.mass))
    for name, place, mass in places:
        lighter = _SPARE_MASS * (mass - excess)
        if lighter > 0.0 and not changes:
            new, old = (format_quantity(value, "mass", digits=4) for value in (lighter, mass))
            changes = (Change(f"payload of {robot.name}", place, lighter, f"mass {new} instead of {old} ({name})"),)
    return Reason(REST, "payload", robot.name, excess=excess, unit="kg", changes=changes)


def fill_reason(
    name: str,
    rim: float,
    liquid_height: float,
    max_slosh_height: float | None,
    *,
    heaviest: float = math.inf,
    volume: Callable[[float], float] | None = None,
) -> Reason:
    """The reason for a cup whose liquid, or its allowed rise, is above the rim (lengths in m).

    Args:
        name: of the cup.
        rim: its height.
        liquid_height: at rest.
        max_slosh_height: as stated.
        heaviest: the highest level that the stated mass allows.
        volume: m^3 up to a level; where the volume is stated instead of the level.
    """
    rise = 0.2 * rim if max_slosh_height is None else max_slosh_height
    freeboard = rim - liquid_height
    changes: list[Change] = []

    def offer(key: str, value: float, now: float, dimension: str = "length") -> None:
        new, old = (format_quantity(length, dimension, digits=4) for length in (value, now))
        changes.append(
            Change(f"fill of {name}", f"cargo.{name}.{key}", value, f"{key} {new} instead of {old} ({name})")
        )

    if freeboard > 0.0 and max_slosh_height is not None:
        offer("max_slosh_height", freeboard, max_slosh_height)
    level = min(rim - rise, heaviest)
    if level > 0.0 and volume is None:
        offer("liquid_height", level, liquid_height)
    elif level > 0.0 and volume is not None:
        offer("liquid_volume", volume(level), volume(liquid_height), "volume")
    return Reason(REST, "fill", name, excess=rise - freeboard, unit="m", changes=tuple(changes))
