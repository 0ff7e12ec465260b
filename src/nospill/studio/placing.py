"""Where objects stand on the tray while it is laid out: footprints, what is off the tray, what overlaps, snapping."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from pydantic import ValidationError

from nospill.core.units import quantity
from nospill.errors import ScenarioError
from nospill.robots.tool import Tool
from nospill.scenario.cargo_entries import CARGO_TABLES
from nospill.scenario.cargo_reader import read_cargo
from nospill.scenario.layout import footprint_core, overhang, overlap
from nospill.scene.cargo import Cargo
from nospill.scene.containers import CONTAINERS
from nospill.scene.tray import Tray
from nospill.studio.draft import label_of

GRID = 0.005
"""m; distance of the points that objects snap to, counted from the tray's centre."""

_SEARCH, _MOST_STEPS = 2 * GRID, 60
_TOUCHING = 1e-9


@dataclass(frozen=True, slots=True)
class Placed:
    """An object as the plan of the tray shows it.

    Attributes:
        index: of its entry.
        label: its name.
        position: (2,) m on the tray.
        radius: of a disc, m, or None.
        reach: how far it reaches beyond its footprint higher up, as a factor on it.
        corners: (4, 2) of a box, m, on the tray, or None.
        filled: whether it holds a liquid.
        off_tray: how far it stands over the edge, m; 0 where it does not.
        overlaps: labels of what it reaches into.
    """

    index: int
    label: str
    position: np.ndarray
    radius: float | None
    reach: float
    corners: np.ndarray | None
    filled: bool
    off_tray: float
    overlaps: tuple[str, ...]

    @property
    def fits(self) -> bool:
        """Whether it stands on the tray and apart from the others."""
        return self.off_tray == 0.0 and not self.overlaps


def snapped(x: float, y: float, *, grid: float | None) -> tuple[float, float]:
    """The nearest point of the grid, m; the point itself without one."""
    if grid is None:
        return x, y
    return round(x / grid) * grid + 0.0, round(y / grid) * grid + 0.0


def tray_size(table: Mapping[str, Any]) -> tuple[float, float] | None:
    """Side lengths of the tray, m; None while they cannot be read."""
    try:
        x, y = (quantity(side, "length") for side in table["tray"]["size"])
    except (ScenarioError, KeyError, TypeError, ValueError):
        return None
    return (x, y) if 0.0 < x < 100.0 and 0.0 < y < 100.0 else None


def place_objects(table: Mapping[str, Any]) -> list[Placed]:
    """Every object whose place and sides can be read, whatever else is wrong with it."""
    size = tray_size(table)
    tray = None if size is None else Tray(np.array(size), Tool())
    bodies = _bodies(table)
    names = [label_of(entry, index) for index, entry in enumerate(table.get("cargo", []))]
    met: dict[int, list[str]] = {index: [] for index in bodies}
    for first, second in combinations(bodies, 2):
        if overlap(bodies[first], bodies[second]) > _TOUCHING:
            met[first].append(names[second])
            met[second].append(names[first])
    placed = []
    for index, body in bodies.items():
        out = overhang(body, tray) if tray is not None and not body.carrier else 0.0
        radius = body.container.footprint.rounding
        placed.append(
            Placed(
                index=index,
                label=names[index],
                position=body.position,
                radius=radius or None,
                reach=float(np.max(body.container.outside[:, 0])),
                corners=None if radius else footprint_core(body),
                filled=table["cargo"][index].get("liquid") is not None,
                off_tray=out if out > _TOUCHING else 0.0,
                overlaps=tuple(met[index]),
            )
        )
    return placed


def free_place(table: Mapping[str, Any], entry: Mapping[str, Any]) -> tuple[float, float]:
    """The place on the grid nearest to the tray's centre where one more object fits, m; the centre if there is none."""
    size, body = tray_size(table), _body({**entry, "at": [0.0, 0.0]})
    others = list(_bodies(table).values())
    if size is None or body is None:
        return 0.0, 0.0
    tray = Tray(np.array(size), Tool())
    most = [min(int(side / 2 / _SEARCH), _MOST_STEPS) for side in size]
    places = [
        (_SEARCH * column, _SEARCH * row)
        for column in range(-most[0], most[0] + 1)
        for row in range(-most[1], most[1] + 1)
    ]
    for place in sorted(places, key=lambda place: math.hypot(*place)):
        there = replace(body, position=np.array(place))
        if overhang(there, tray) <= 0.0 and all(overlap(there, other) <= 0.0 for other in others):
            return place
    return 0.0, 0.0


def at_of_entry(table: Mapping[str, Any], index: int, place: tuple[float, float]) -> tuple[float, float]:
    """What `at` of an entry has to say for a place on the tray, m: it counts from the middle of a carrier."""
    carrier = _carrier(table, table["cargo"][index])
    if carrier is None:
        return place
    away = _turn(-carrier.yaw) @ (np.array(place) - carrier.position)
    return float(away[0]), float(away[1])


def _bodies(table: Mapping[str, Any]) -> dict[int, Cargo]:
    """The bodies of all entries that can be read, by their index, those in carriers at their places on the tray."""
    bodies = {index: body for index, entry in enumerate(table.get("cargo", [])) if (body := _body(entry)) is not None}
    for index, body in bodies.items():
        entry = table["cargo"][index]
        carrier = _carrier(table, entry)
        if carrier is not None:
            place = carrier.position + _turn(carrier.yaw) @ body.position
            seat = quantity(entry["seat_height"], "length") if _readable(entry.get("seat_height")) else 0.0
            yaw = carrier.yaw + body.yaw
            bodies[index] = replace(body, position=place, yaw=yaw, carrier=carrier.name, seat=seat)
        # whose carrier is meant is told by its name
        bodies[index] = replace(bodies[index], name=str(entry.get("name", index)))
    return bodies


def _carrier(table: Mapping[str, Any], entry: Mapping[str, Any]) -> Cargo | None:
    """The body in which an entry stands, under its name; None where it stands on the tray."""
    named = [item for item in table.get("cargo", []) if item.get("name") == entry.get("carrier") and item is not entry]
    body = _body(named[0]) if entry.get("carrier") is not None and named else None
    return None if body is None else replace(body, name=str(entry["carrier"]))


def _turn(angle: float) -> np.ndarray:
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


def _body(entry: Mapping[str, Any]) -> Cargo | None:
    """A solid body of the entry's sides at its place, read by the same reader; None while they are wrong."""
    shape = entry.get("shape")
    if shape not in CARGO_TABLES:
        return None
    sizes = {key: entry[key] for key in size_keys(shape) if key in entry}
    # A height that is being typed hardly matters seen from above.
    if not _readable(sizes.get("height")):
        sizes["height"] = 0.1
    sides = {"name": "body", "shape": shape, "at": entry.get("at"), "yaw": entry.get("yaw", 0.0), "mass": 1.0}
    try:
        read = CARGO_TABLES[shape].model_validate(sides | sizes)
        return read_cargo(
            read, friction=1.0, friction_reserve=0.0, footprint_reserve=0.0, fidelity="full", slosh_modes=1
        )
    except (ValidationError, ScenarioError):
        return None


def _readable(height: object) -> bool:
    try:
        return quantity(height, "length") > 0.0
    except ScenarioError:
        return False


def size_keys(shape: object) -> list[str]:
    """The keys of a shape's sizes."""
    known = CONTAINERS.get(str(shape))
    return [side.name for side in dataclasses.fields(known) if side.init] if known else []
