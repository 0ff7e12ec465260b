"""Objects that stand in others: whether they may, and both as the scene has them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.units import as_written, format_quantity, listed
from nospill.errors import ScenarioError
from nospill.scenario.cargo_entries import CargoTable
from nospill.scene.cargo import Cargo, Tolerance
from nospill.scene.carriers import carrying

_OF_CARRIER = ("friction", "friction_reserve", "footprint_reserve")
_ROUNDING = 1e-9
LEAST_WALL = 1e-3
"""m; lower walls are an edge over which an object slides as it stands."""


def check_carrier(entry: CargoTable, entries: Mapping[str, CargoTable]) -> None:
    """Refuse an entry that stands in what carries nothing, or states what its carrier does.

    Args:
        entry: of the object.
        entries: all of them, by name.

    Raises:
        ScenarioError: starts with the key.
    """
    if entry.carrier is None:
        if entry.seat_height is not None:
            raise ScenarioError("seat_height is given but carrier is not; objects on the tray stand at its surface")
        return
    carrier = entries.get(entry.carrier)
    if carrier is None or carrier is entry:
        others = [name for name, other in entries.items() if other.liquid is None and other.carrier is None]
        choice = f"choose {listed(others)}" if others else "add a [[cargo]] entry for it"
        raise ScenarioError(f"carrier {as_written(entry.carrier)} is no other object of the scenario; {choice}")
    if carrier.liquid is not None:
        raise ScenarioError(f"carrier {as_written(entry.carrier)} holds a liquid itself; only a solid carries others")
    if carrier.carrier is not None:
        raise ScenarioError(
            f"carrier {as_written(entry.carrier)} stands in {as_written(carrier.carrier)} itself; name that one"
        )
    if entry.initial_swing is not None and not carrier.fixed:  # of what is fixed no row reads what its liquids do to it
        raise ScenarioError(
            f"initial_swing is given to what stands in {as_written(entry.carrier)}; a carrier that is not fixed feels "
            "its liquids from rest only: wait until they are at rest, or place them on the tray"
        )
    for key in _OF_CARRIER:
        if getattr(entry, key) is not None:
            raise ScenarioError(f"{key} is given, but it stands in {as_written(entry.carrier)}; give that one the key")
    for key in ("friction", "position", "mass") if entry.tolerance is not None else ():
        if getattr(entry.tolerance, key) is not None:
            raise ScenarioError(
                f"tolerance.{key} is given, but it stands in {as_written(entry.carrier)}; give that one the key"
            )


def seated(item: Cargo, entry: CargoTable, carrier: Cargo) -> Cargo:
    """An object at its place in its carrier, whose friction it has.

    Args:
        item: as read, its place counted from the middle of the carrier, along its axes.
        entry: its keys.
        carrier: in which it stands, on the tray.

    Raises:
        ScenarioError: it stands higher than the carrier's top, on it, or over its edge; starts with the key.
    """
    seat = entry.seat_height or 0.0
    if seat > carrier.container.height * (1.0 + _ROUNDING):
        raise ScenarioError(
            f"seat_height {_mm(seat)} is above the top of its carrier {as_written(carrier.name)} "
            f"(height {_mm(carrier.container.height)}); at most that is allowed"
        )
    out = _overhang(item, seat, carrier)
    if out > _ROUNDING:
        at = ", ".join(map(_mm, item.position))
        sides = " x ".join(map(_mm, carrier.container.footprint.sides))
        raise ScenarioError(
            f"at ({at}) stands {_mm(out)} over the edge of its carrier {as_written(carrier.name)} (size {sides}); "
            "move it in or use a larger one"
        )
    wall = carrier.container.height - seat
    if wall < LEAST_WALL - _ROUNDING:
        raise ScenarioError(
            f"seat_height {_mm(seat)} puts it on top of its carrier {as_written(carrier.name)} (height "
            f"{_mm(carrier.container.height)}), where no wall keeps it from sliding; lower seat_height to at most "
            f"{_mm(carrier.container.height - LEAST_WALL)}, or make both one solid"
        )
    cosine, sine = math.cos(carrier.yaw), math.sin(carrier.yaw)
    turned = np.array([[cosine, -sine], [sine, cosine]]) @ item.position
    tolerance, moved = item.tolerance or Tolerance(), carrier.tolerance or Tolerance()
    tolerance = replace(tolerance, friction=0.0, mass=0.0, position=moved.position)
    return replace(
        item,
        # twelve decimals hide the rounding of the turn
        position=read_only(np.round(carrier.position + turned, 12) + 0.0),
        yaw=carrier.yaw + item.yaw,
        friction=carrier.friction,
        friction_reserve=carrier.friction_reserve,
        footprint_reserve=carrier.footprint_reserve,
        carrier=carrier.name,
        seat=seat,
        wall=wall,
        tolerance=None if tolerance == Tolerance() else tolerance,
    )


def loaded(carrier: Cargo, content: Sequence[Cargo]) -> Cargo:
    """A carrier with all that stands in it, its tolerance with those of its liquids.

    Raises:
        ScenarioError: the sides of a box with liquid are not parallel to the carrier's.
    """
    full = carrying(carrier, content)
    known = [item.tolerance for item in content if item.tolerance is not None and item.filling is not None]
    if not known:
        return full
    stated = carrier.tolerance or Tolerance()
    tolerance = replace(
        stated,
        liquid_height=max(item.liquid_height for item in known),
        damping=(min(item.damping[0] for item in known), max(item.damping[1] for item in known)),
        pinned=any(item.pinned for item in known),
        contact_angle=max(item.contact_angle for item in known),
        frequency=max(item.frequency for item in known),
    )
    return replace(full, tolerance=None if tolerance == Tolerance() else tolerance)


def _overhang(item: Cargo, seat: float, carrier: Cargo) -> float:
    """How far the part of an object below its carrier's top sticks out of the carrier, m; negative: the gap."""
    outside, top = item.container.outside, carrier.container.height - seat
    inside = outside[outside[:, 1] <= top + _ROUNDING, 0]
    share = max(float(np.max(inside)), float(np.interp(top, outside[:, 1], outside[:, 0])))
    footprint = item.container.footprint
    cosine, sine = math.cos(item.yaw), math.sin(item.yaw)
    corners = item.position + share * footprint.core @ np.array([[cosine, sine], [-sine, cosine]])
    return max(carrier.container.footprint.gap(corner) for corner in corners) + share * footprint.rounding


def _mm(length: float) -> str:
    return format_quantity(length, "length", digits=4)
