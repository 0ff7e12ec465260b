"""The scenes of the benchmark: bundled examples with a number changed, and trays with any number of cups.

Examples have the whole physics, twenty modes of each liquid and heights of second order, or the published one: one mode
and linear heights. Trays of cups have the published one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import nospill as ns
from nospill.path_search.free_path import paths_along
from nospill.robots.joint_paths.search import preferred_path
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene

CHANGES = ("max_slosh_height", "friction", "fill level", "placement")
"""What a cell changes between two cycles."""
LARGER_CHANGES = ("friction 0.4", "max_slosh_height 12 mm", "placement of all", "mirror branch")
"""What it changes less often, of the cups on one arm: the last is the arm with its wrist turned over."""
_HEIGHTS = {"max_slosh_height": 14 / 15, "max_slosh_height 12 mm": 12 / 15}
_FRICTIONS = {"friction": 0.45 / 0.466308, "friction 0.4": 0.4 / 0.466308}
_FILL = 47 / 49
_ASIDE = 11.0
"""mm along x; by which the first object is put aside."""

_GRID = (8, 4)
_PITCH = 0.055


def example(name: str, *, intervals: int | None = None) -> Scene:
    """A bundled example with the published physics, on another grid where one is given."""
    table = _table(name)
    if intervals is not None:
        table["planning"]["intervals"] = intervals
    return scene_from_table(table, name=name)


def whole_example(name: str) -> Scene:
    """A bundled example with the whole physics."""
    return scene_from_table(_whole_table(name), name=name)


def changed(name: str, change: str) -> Scene:
    """`example` with one of `CHANGES` or `LARGER_CHANGES` made, the objects as they are otherwise.

    Raises:
        ValueError: another change.
    """
    if change != "mirror branch":
        return scene_from_table(_changed(_table(name), change), name=f"{name}, {change}")
    table, scene = _table(name), example(name)
    start = preferred_path(paths_along(scene), scene.robot, scene.start_near).q[0]
    mirrored = start + np.array([0.0, 0.0, 0.0, -np.pi, -2.0 * start[4], np.pi])
    table["robot"]["home"] = [f"{angle} rad" for angle in mirrored]
    return scene_from_table(table, name=f"{name}, {change}")


def whole_changed(name: str, change: str) -> Scene:
    """`whole_example` with one of `CHANGES` made.

    Raises:
        ValueError: another change.
    """
    return scene_from_table(_changed(_whole_table(name), change), name=f"{name}, {change}")


def _changed(table: dict[str, Any], change: str) -> dict[str, Any]:
    """A table with a change made in it."""
    cargo = table["cargo"]
    if change in _HEIGHTS:
        for item in cargo:
            if "max_slosh_height" in item:
                item["max_slosh_height"] = _times(item["max_slosh_height"], _HEIGHTS[change])
    elif change in _FRICTIONS:
        table["tray"]["friction"] = round(table["tray"]["friction"] * _FRICTIONS[change], 6)
    elif change == "fill level":
        for item in cargo:
            for key in {"liquid_height", "liquid_volume"} & item.keys():
                item[key] = _times(item[key], _FILL)
            if "liquid" in item and "mass" in item:
                # 2 mm less water in a cup of 35 mm radius is 7.7 g
                item["mass"], item["centre_of_mass_height"] = "0.1893 kg", "27.3 mm"
    elif change == "placement":
        cargo[0]["at"] = _aside(cargo[0]["at"], _ASIDE)
    elif change == "placement of all":
        for item in cargo:
            item["at"] = _aside(item["at"], 20.0)
    else:
        raise ValueError(f"change {change!r}: one of {', '.join((*CHANGES, *LARGER_CHANGES))}")
    return table


def _times(quantity: str, factor: float) -> str:
    number, unit = quantity.split()
    return f"{float(number) * factor:.6g} {unit}"


def _aside(place: list[str], step: float) -> list[str]:
    """A place on the tray, put that far away along x, mm."""
    return [f"{float(place[0].removesuffix('mm')) + step:g} mm", place[1]]


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


def different_cups(count: int) -> Scene:
    """The level tray of the liquid example with `count` cups of water, at most 64, no two alike, middle ones first."""
    table = _table("matrix-liquid")
    table["tray"]["size"] = ["340 mm", "340 mm"]
    places = sorted(((column - 3.5) * 40.0, (row - 3.5) * 40.0, column, row) for column in range(8) for row in range(8))
    places.sort(key=lambda place: place[0] ** 2 + place[1] ** 2)
    table["cargo"] = [
        {
            "name": f"c{index + 1}",
            "at": [f"{x} mm", f"{y} mm"],
            "shape": "cylinder",
            "radius": f"{15.0 + 0.05 * index:.2f} mm",
            "height": "45 mm",
            "liquid": "water",
            "liquid_height": f"{20.0 + 0.07 * ((5 * column + 3 * row) % 8) + 0.01 * index:.2f} mm",
            "max_slosh_height": f"{7.0 + 0.1 * ((3 * column + row) % 8):.1f} mm",
            "mass": f"{0.020 + 0.0001 * index:.4f} kg",
            "centre_of_mass_height": "12 mm",
        }
        for index, (x, y, column, row) in enumerate(places[:count])
    ]
    table["motion"]["end"] = "residual"
    return scene_from_table(table, name=f"{count} different cups")


def wells_and_vials(count: int) -> Scene:
    """The liquid example with a plate of fixed wells and free vials for its cups, fills all different.

    132 are a plate of 96 wells and 36 vials, 500 a plate of 464 and the same vials; at most 500.
    """
    table = _table("matrix-liquid")
    vials, rows = 36, 8 if count <= 132 else 22
    kinds = {
        "well": {"radius": "3.4 mm", "height": "11 mm", "max_slosh_height": "2 mm", "empty_mass": "0.5 g"},
        "vial": {"radius": "8 mm", "height": "45 mm", "max_slosh_height": "5 mm", "empty_mass": "6 g"},
    }
    fills = {"well": lambda n: 5.0 + 3.0 * (37 * n % 509) / 509, "vial": lambda n: 18.0 + 14.0 * (53 * n % 97) / 97}
    table["cargo"] = [
        {"name": f"{kind}-{n + 1}", "at": place, "shape": "cylinder", "liquid": "water", **kinds[kind]}
        | {"liquid_height": f"{fills[kind](n):.3f} mm", "fixed": kind == "well"}
        for kind, n, place in (
            *(
                ("well", n, [f"{9 * (n // rows) - 150} mm", f"{9 * (n % rows) - 4.5 * (rows - 1)} mm"])
                for n in range(count - vials)
            ),
            *(("vial", n, [f"{146 - 20 * (n // 9)} mm", f"{20 * (n % 9) - 80} mm"]) for n in range(vials)),
        )
    ]
    return scene_from_table(table, name=f"{count} wells and vials")


UNSEEN = ("three cups", "seven joints")
"""Structures that no example has."""


def unseen(name: str) -> Scene:
    """A structure that no example has: other numbers of objects, another path, another arm.

    Raises:
        ValueError: none of `UNSEEN`.
    """
    table = _table("matrix-liquid-tilt")
    if name == "three cups":
        table["cargo"] = table["cargo"][:3]
        table["path"] = _table("pp-two-cups")["path"]
    elif name == "seven joints":
        table["robot"] = {"model": "franka-fr3", "base_position": ["0 m", "0 m", "0.6 m"]}
        table["cargo"] = table["cargo"][:2]
    else:
        raise ValueError(f"structure {name!r}: one of {', '.join(UNSEEN)}")
    return scene_from_table(table, name=name)


def _whole_table(name: str) -> dict[str, Any]:
    """As the example stands; those that stand as published with full fidelity."""
    table: Any = ns.load(name).source
    return table | {"fidelity": "full"}


def _table(name: str) -> dict[str, Any]:
    """As in the published problem: one mode, and linear heights."""
    table: Any = ns.load(name).source
    table.setdefault("planning", {})["slosh_modes"] = 1
    table.setdefault("motion", {})["slosh_height"] = "linear"
    return table
