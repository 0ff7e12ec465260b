"""Obstacles in the studio: their fields, where they stand, what a new one is and what another shape changes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from nospill.core.units import quantity
from nospill.errors import ScenarioError
from nospill.paths.path import Path
from nospill.scenario.obstacle_entries import OBSTACLE_TABLES, MeshObstacle, ObstacleTable
from nospill.studio.draft import Draft, Key, millimetres
from nospill.studio.fields import Field, field_of

_TABLES = {shape: table for shape, table in OBSTACLE_TABLES.items() if table is not MeshObstacle}
"""Shapes whose sizes have fields; a mesh keeps its keys as they are."""
_SIZES: dict[str, Any] = {"size": ["100 mm", "100 mm", "100 mm"], "radius": "50 mm", "height": "200 mm"}
"""Of a new obstacle, and of one that takes another shape."""
_BELOW = 0.3
"""m below the middle of the path, where a new obstacle stands."""
_NOWHERE = (0.6, 0.0, 0.2)
"""m; where it stands while there is no path."""


def obstacle_fields(draft: Draft, index: int) -> list[Field]:
    """The fields of one obstacle, none where there is none; which ones depends on its shape."""
    if not 0 <= index < len(draft.obstacles):
        return []
    shape = str(draft.obstacles[index].get("shape"))

    def at(key: str) -> Key:
        return ("obstacle", index, key)

    place = "of its centre, for example 0.86, 0, 0.45 or 860 mm, ..."
    return [
        field_of(at("name"), "text", hint="letters, digits, - and _"),
        field_of(at("shape"), "choice", tuple(_TABLES) if shape in _TABLES else (*_TABLES, shape)),
        field_of(at("at"), "list", hint=place, sides="x, y, z"),
        *[field_of(at(key), "list" if key == "size" else "quantity", hint="100 mm") for key in _size_keys(shape)],
        *([] if shape == "sphere" else [field_of(at("yaw"), hint="turn about z, 30 deg")]),
        field_of(at("clearance"), hint="distance that arm, tray and cargo keep from it, 10 mm"),
    ]


def _size_keys(shape: str) -> list[str]:
    table = _TABLES.get(shape)
    return [] if table is None else [key for key in table.model_fields if key not in ObstacleTable.model_fields]


def new_obstacle(shape: str, path: Path | None) -> dict[str, Any]:
    """An entry of a shape below the middle of a path.

    Args:
        shape: one of those that have fields.
        path: of the tray's centre; None while there is none.
    """
    place = np.array(_NOWHERE) if path is None else path.at(0.5)[0, :3] - [0.0, 0.0, _BELOW]
    at = [millimetres(round(float(value), 3)) for value in place]
    return {"name": shape, "shape": shape, "at": at} | {key: _SIZES[key] for key in _size_keys(shape)}


def choose_shape(draft: Draft, index: int, shape: str) -> dict[Key, Any]:
    """What another shape of an obstacle changes: the sizes of the old one go, those it shares stay."""
    entry = draft.obstacles[index]
    if shape == entry.get("shape") or shape not in _TABLES:
        return {}
    gone = entry.keys() - ObstacleTable.model_fields.keys()
    sizes = {key: entry.get(key, _SIZES[key]) for key in _size_keys(shape)}
    return {("obstacle", index, key): value for key, value in {**dict.fromkeys(gone), **sizes, "shape": shape}.items()}


def place_of(entry: Mapping[str, Any]) -> np.ndarray | None:
    """Where an entry says that it stands, (3,) m; None while that cannot be read."""
    try:
        place = np.array([quantity(value, "length") for value in entry["at"]])
    except (ScenarioError, KeyError, TypeError, ValueError):
        return None
    return place if place.shape == (3,) else None
