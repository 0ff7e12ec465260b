"""The scenes of the benchmark: bundled examples with a number changed, and trays with any number of cups."""

from __future__ import annotations

import copy
from typing import Any

import nospill as ns
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene

CHANGES = ("max_slosh_height", "friction", "fill level", "placement")
"""What a cell changes between two cycles."""

_GRID = (8, 4)
_PITCH = 0.055


def example(name: str, *, intervals: int | None = None) -> Scene:
    """A bundled example, on another grid where one is given."""
    table = _table(name)
    if intervals is not None:
        table["planning"]["intervals"] = intervals
    return scene_from_table(table, name=name)


def changed(name: str, change: str) -> Scene:
    """A bundled example with one of `CHANGES` made, the cups as they are otherwise.

    Raises:
        ValueError: another change.
    """
    table = _table(name)
    cargo = table["cargo"]
    if change == "max_slosh_height":
        for cup in cargo:
            cup["max_slosh_height"] = "14 mm"
    elif change == "friction":
        table["tray"]["friction"] = 0.45
    elif change == "fill level":
        for cup in cargo:
            # 2 mm less water in a cup of 35 mm radius is 7.7 g.
            cup["liquid_height"], cup["mass"], cup["centre_of_mass_height"] = "47 mm", "0.1893 kg", "27.3 mm"
    elif change == "placement":
        cargo[0]["at"] = ["-85 mm", "-60 mm"]
    else:
        raise ValueError(f"change {change!r}: one of {', '.join(CHANGES)}")
    return scene_from_table(table, name=f"{name}, {change}")


def tray_of_cups(count: int) -> Scene:
    """The level tray of the liquid example, larger, with `count` small cups of water, at most 32, middle ones first."""
    table = _table("matrix-liquid")
    table["tray"]["size"] = ["480 mm", "260 mm"]
    columns, rows = _GRID
    places = [
        ((column - (columns - 1) / 2) * _PITCH, (row - (rows - 1) / 2) * _PITCH)
        for column in range(columns)
        for row in range(rows)
    ]
    places.sort(key=lambda place: place[0] ** 2 + place[1] ** 2)
    table["cargo"] = [
        {
            "name": f"c{index + 1}",
            "at": [f"{1e3 * x:.2f} mm", f"{1e3 * y:.2f} mm"],
            "shape": "cylinder",
            "radius": "20 mm",
            "height": "60 mm",
            "liquid": "water",
            "liquid_height": "28 mm",
            "max_slosh_height": "10 mm",
            "mass": "0.045 kg",
            "centre_of_mass_height": "16 mm",
        }
        for index, (x, y) in enumerate(places[:count])
    ]
    table["motion"]["end"] = "residual"
    return scene_from_table(table, name=f"{count} cups")


def _table(name: str) -> dict[str, Any]:
    return copy.deepcopy(ns.load(name).source)
